"""The only place that knows the field names of the JSON report which `lattice-brep export --report` writes."""

from __future__ import annotations


def counts(report: dict) -> dict:
    """nodes, struts, cylinders, patches, caps, faces, circles, components, genus: those that the report gives."""
    given = report.get("counts", {})
    names = ("nodes", "struts", "cylinders", "patches", "caps", "faces", "circles", "components", "genus")
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
    """How many nodes ended on each rung of the ladder; a rung may list its nodes instead of counting them."""
    given = report.get("rungs", {})
    if isinstance(given, list):  # [{"rung": name, "nodes": [...] or count}, ...]
        given = {entry.get("rung", entry.get("name")): entry.get("count", entry.get("nodes", 0)) for entry in given}
    return {name: value if isinstance(value, int) else len(value) for name, value in given.items()}


def on_g0_rung(report: dict) -> int:
    return sum(n for name, n in rungs(report).items() if "g0" in name.lower())


def refused(report: dict) -> int:
    return sum(n for name, n in rungs(report).items() if "refused" in name.lower())
