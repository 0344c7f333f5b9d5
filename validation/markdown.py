"""Writes validation/report.md: every figure that was measured, the worst as well as the middle."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def table(head: list[str], rows: list[list]) -> list[str]:
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)] + ["| " + " | ".join(str(x) for x in row) + " |" for row in rows] + [""]


def small(x) -> str:
    return "" if x is None else f"{x:.1e}" if isinstance(x, float) and (abs(x) < 0.01 or abs(x) >= 1e5) and x else f"{x:.3g}" if isinstance(x, float) else str(x)


def get(result: dict, check: str, figure: str):
    return result["checks"].get(check, {}).get(figure)


def word(result: dict, check: str) -> str:
    found = result["checks"].get(check)
    return "" if found is None or found.get("skipped") else "yes" if found["ok"] else "**no**"


def freecad(result: dict) -> dict:
    return get(result, "valid", "freecad") or {}


def off(result: dict):
    return max((v for k, v in result["checks"].get("volume_area", {}).items() if k.endswith(" off")), default=None)


def solids(results: list[dict]) -> list[str]:
    rows = []
    for r in results:
        f, c = freecad(r), r.get("counts", {})
        occ8 = get(r, "valid", "occ8")
        clean = "yes" if f.get("valid") and not f.get("faults") else "**no**" if f else ""
        rows.append([r["name"], c.get("nodes", ""), c.get("struts", ""), c.get("patches", ""), c.get("faces", ""),
                     "" if occ8 is None else "yes" if occ8 else "**no**", clean, word(r, "one_solid"), word(r, "senses"), word(r, "counts"),
                     small(get(r, "counts", "euler")), small(off(r)), small(get(r, "tolerances", "edge_mm")),
                     small(get(r, "continuity", "gap_mm")), "all passed" if r["ok"] else "**failed**"])
    return table(["case", "nodes", "struts", "patches", "faces", "OCC 8 valid", "FreeCAD `check(True)` clean", "one closed solid", "senses as written",
                  "counts", "V - E + F", "volume, area, centre: worst off", "largest edge tolerance, mm", "largest gap, mm", "all checks"], rows)


def smoothness(results: list[dict]) -> list[str]:
    rows = []
    for r in results:
        k = r["checks"].get("continuity", {})
        rows.append([r["name"]] + [small(k.get(f"{s}_{q}_deg")) for s in ("rim", "inside") for q in ("max", "p99", "median")]
                    + [small(get(r, "fold", "lowest_cosine")), small(get(r, "volume_bound", "above_union")), small(get(r, "volume_bound", "in_zones")),
                       small(r.get("export", {}).get("wall_s")), small(r.get("export", {}).get("peak_mb")),
                       f"{r.get('bytes', 0) / 1e6:.2f}", small(freecad(r).get("check_cpu_s"))])
    return table(["case", "rims max, °", "p99", "median", "inside max, °", "p99", "median", "lowest cosine to the ray", "volume above the struts' union", "same, of the nodes' zones",
                  "export, s", "peak, MB", "file, MB", "FreeCAD's check, CPU s"], rows)


BANDS = [(3, 5), (6, 8), (9, 11), (12, 14), (15, 17), (18, 20)]


def distribution(results: list[dict], bands: list[tuple[int, int]] = BANDS) -> list[str]:
    def row(name: str, some: list[dict]) -> list:
        rim = [j for r in some for j in r["checks"].get("continuity", {}).get("jumps", {}).get("rim", [])]
        inside = [j for r in some for j in r["checks"].get("continuity", {}).get("jumps", {}).get("inside", [])]
        cosine = [get(r, "fold", "lowest_cosine") for r in some if get(r, "fold", "lowest_cosine") is not None]
        gaps = [get(r, "continuity", "gap_mm") for r in some if get(r, "continuity", "gap_mm") is not None]
        zones = [get(r, "volume_bound", "in_zones") for r in some if get(r, "volume_bound", "in_zones") is not None]
        edges = [get(r, "tolerances", "edge_mm") for r in some if get(r, "tolerances", "edge_mm") is not None]

        def three(values: list[float]) -> list[str]:
            return [small(float(x)) for x in (np.max(values), np.percentile(values, 99), np.median(values))] if values else ["", "", ""]

        return [name, len(some), sum(r["ok"] for r in some), *three(rim), *three(inside), small(min(cosine, default=None)),
                small(min(zones, default=None)), small(max(gaps, default=None)),
                small(max(edges, default=None))]

    rows = [row(f"degree {a} to {b}", [r for r in results if a <= r["detail"].get("degree", 0) <= b]) for a, b in bands]
    rows.append(row("all", results))
    rungs: dict[str, int] = {}
    for r in results:
        for name, n in r.get("rungs", {}).items():
            rungs[name] = rungs.get(name, 0) + n
    return table(["nodes", "number", "passed all checks", "rims max, °", "p99", "median", "inside max, °", "p99", "median", "lowest cosine to the ray",
                  "least volume above the struts' union, of the zone", "largest gap, mm", "largest edge tolerance, mm"], rows) + [
        "The jumps are the largest on each edge; p99 and median are taken over all edges of all the nodes in the row.", "",
        "Rungs of the ladder: " + (", ".join(f"{name}: {n}" for name, n in sorted(rungs.items())) or "not reported") + ".", ""]


def ladder(results: list[dict]) -> list[str]:
    """Every node below the first rung, with its reason; of a long list the first ones."""
    lines = [f"- {r['name']}: {line}" for r in results for line in r.get("lowered", [])]
    return ["", f"Nodes below the first rung: {len(lines)}.", "", *lines[:40], *([f"- ... and {len(lines) - 40} more"] if len(lines) > 40 else []), ""]


def failures(results: list[dict]) -> list[str]:
    lines = []
    for r in results:
        for check, found in r["checks"].items():
            if not found["ok"] and not r.get("refused"):
                lines.append(f"- {r['name']}, `{check}`: " + "; ".join(found["why"][:4]).replace("|", "/"))
    return ["## What failed", "", *(lines or ["Nothing."]), ""]


def write(path: Path, results: list[dict]) -> None:
    random = [r for r in results if r["name"].startswith("random")]
    mixed = [r for r in results if r["name"].startswith("mixed")]
    samples = [r for r in results if r["name"].startswith("sample")]
    blocks = [r for r in results if r["name"].endswith(" block")]
    whole = [r for r in results if r["name"].endswith((" whole", " whole, shrunk"))]
    apart = [id(r) for r in random + mixed + samples + blocks + whole]
    other = [r for r in results if id(r) not in apart and r["name"] != "determinism"]
    version = next((freecad(r)["version"] for r in results if "version" in freecad(r)), "FreeCAD")
    lines = [
        "# Validation report", "",
        f"Written by `validation/run`. Judges: build123d (OCC 8), {version}, gmsh (its own OCC), manifold3d for the bound on "
        "the volume. No commercial CAD has been run. Angles are measured from the files by sampling both faces of every edge, not taken from us.", "",
        "## Unit cells", "", f"Size {10} mm, radius 0.5 mm.", "", *solids(other), *smoothness(other),
    ]
    meshed = [r for r in other if "meshable" in r["checks"]]
    lines += ["## Tetrahedra by gmsh, without repair", "",
              *table(["case", "elements", "smallest quality (minSICN)", "mesh volume / solid volume", "meshed"],
                     [[r["name"], get(r, "meshable", "elements"), small(get(r, "meshable", "min_quality")),
                       small((get(r, "meshable", "mesh_mm3") or 0) / (get(r, "meshable", "exact_mm3") or 1)), word(r, "meshable")] for r in meshed])]
    lines += ["## Random nodes", "",
              f"{len(random)} seeded stars of radius 1 mm, degree 3 to 20, smallest angle 25°; judged in OCC 8, with its search for self-intersections.", "",
              *distribution(random)]
    if mixed:
        lines += ["## Nodes of mixed radii", "",
                  f"{len(mixed)} seeded stars whose struts have radii from 0.2 to 1 mm, every second one tapered; judged in both kernels. The check `radii` compares "
                  "the radius of each cylinder or cone at both rims, and its half-angle, with the graph (1e-9).", "", *distribution(mixed)]
    if samples:
        lines += ["## Samples of the bench", "",
                  f"{len(samples)} lattices that `lattice-brep bench` had accepted (`--keep`), of all its kinds: radii up to ten to one, tapers, angles down to 3°; "
                  "judged in OCC 8. By their largest degree.", "", *distribution(samples, [(1, 2), (3, 5), (6, 8), (9, 12), (13, 20), (21, 45)])]
    if whole:
        lines += ["## Real lattices", "", "Each as it is, and with `--on-conflict shrink`.", "",
                  *table(["lattice", "nodes", "struts", "faces", "struts shrunk", "least factor", "volume taken, mm³", "export, s", "CPU s", "peak, MB", "file, MB", "notes", "rungs",
                          "Rust reader", "result"],
                         [[r["name"], r.get("counts", {}).get("nodes", ""), r.get("counts", {}).get("struts", ""), r.get("counts", {}).get("faces", ""),
                           r.get("shrunk", {}).get("struts", ""), small(r.get("shrunk", {}).get("least")), small(r.get("shrunk", {}).get("volume_mm3")),
                           *(small(r.get("export", {}).get(k)) for k in ("wall_s", "cpu_s", "peak_mb")), f"{r.get('bytes', 0) / 1e6:.0f}", r.get("changes", ""),
                           ", ".join(f"{k}: {v}" for k, v in r.get("rungs", {}).items()), word(r, "rust_reader"),
                           "passed" if r["ok"] else "refused with reasons" if r.get("refused") else "**failed**"] for r in whole])]
    if blocks:
        lines += ["## Blocks of real lattices", "", "About 400 struts each, with `--on-conflict shrink`, in both kernels.", "", *solids(blocks), *smoothness(blocks)]
    same = next((r for r in results if r["name"] == "determinism"), None)
    if same:
        lines += ["## Determinism", "", "octet 2x2x2 with 1, 2, 8 and again 1 threads: " + ("same bytes." if same["ok"] else "**different bytes.**"), ""]
    lines += ["## Down the ladder", *ladder(results)]
    lines += failures(results)
    path.write_text("\n".join(lines))
