"""The only place that knows the field names of the JSON report which `lattice-brep export --report` writes."""

from __future__ import annotations


def counts(report: dict) -> dict:
    """nodes, struts, cylinders, cones, patches, caps, faces, circles, components, genus: those that the report gives."""
    given = report.get("counts", {})
    names = ("nodes", "struts", "cylinders", "cones", "patches", "caps", "faces", "circles", "components", "genus")
    return {name: given[name] for name in names if name in given}


def volume_mm3(report: dict) -> float:
    return report["volume_mm3"]


def area_mm2(report: dict) -> float:
    return report["area_mm2"]


def centroid_mm(report: dict) -> list[float]:
    return report["centroid_mm"]


def quality(report: dict) -> dict:
    """Our own figures for fit, jumps and gaps, shown beside the kernels'."""
    return report.get("quality", {})


def rungs(report: dict) -> dict[str, int]:
    """How many nodes ended on each rung of the ladder: `soap_film` is a count, the others list their nodes.
    A node that cannot be built at all ends the export with exit code 3, so there is no rung for it."""
    return {name: value if isinstance(value, int) else len(value) for name, value in report.get("rungs", {}).items()}


def on_g0_rung(report: dict) -> int:
    return rungs(report).get("sharp", 0)


def below_first_rung(report: dict) -> int:
    return sum(n for name, n in rungs(report).items() if name != "soap_film")


def lowered(report: dict) -> list[str]:
    """Each node below the first rung with its reasons, one line a node."""
    return [f"node {entry['node']} (degree {entry['degree']}) on `{name}`: {'; '.join(entry['reasons'])}"
            for name, entries in report.get("rungs", {}).items() if isinstance(entries, list) for entry in entries]


def changes(report: dict) -> int:
    """How many changes to the input, or things kept in it, the report tells of."""
    return len(report.get("changes", []))


def shrunk(report: dict) -> dict:
    """How many struts were made thinner, the least factor of a radius, and the volume taken away (mm3)."""
    changed = report.get("cuts", {}).get("shrunk", [])
    factors = [after / before for strut in changed for after, before in zip(strut["after_mm"], strut["before_mm"])]
    return {"struts": len(changed), "least": min(factors, default=1.0), "volume_mm3": report.get("cuts", {}).get("shrunk_volume_mm3", 0.0)}
