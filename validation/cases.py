"""The set of lattices that validation exports: unit cells, seeded random nodes, and real lattices where a folder is given."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import report_fields
from graphs import degrees, least_radius, summary

CELLS = ("cubic", "bcc", "bcc-edges", "fcc", "octet", "diamond", "kelvin")
MESHED = ("bcc", "octet")  # 2x2x2 of these go through gmsh
SIZE_MM, CELL_RADIUS_MM = 10.0, 0.5

RANDOM_SEED = 2025
RANDOM_NODES, QUICK_NODES = 200, 20
MIXED_NODES, QUICK_MIXED = 60, 6
LEAST_RADIUS_MM = 0.2  # of mixed nodes; the largest is 1
SMALLEST_ANGLE_DEG = 25.0
DEGREES = range(3, 21)
MIXED_DEGREES = range(2, 13)
STAR_LENGTH_MM = 10.0  # the cut of two struts of radius 1 at 25 degrees is 1.3 / tan(12.5 deg) = 5.9


@dataclass
class Case:
    name: str
    graph: Path | None = None  # where the lattice is, or will be written by `cell`
    cell: tuple[str, str] | None = None  # (name, repeat): made by the program
    crop: str | None = None
    options: tuple[str, ...] = ()  # more arguments of `export`
    radius_mm: float = 1.0
    skip: tuple[str, ...] = ()  # checks left out
    limits: dict = field(default_factory=dict)  # more entries for `expected`
    detail: dict = field(default_factory=dict)  # shown in the report


def cells(repeat: str, quick: bool) -> list[Case]:
    out = []
    for name in CELLS:
        mesh = name in MESHED and repeat == "2x2x2"
        out.append(Case(f"{name} {repeat}", cell=(name, repeat), radius_mm=CELL_RADIUS_MM,
                        skip=() if mesh else ("meshable",),
                        limits={"freecad_seconds": 600 if quick else 3600, "self_intersection_seconds": 600, "mesh_seconds": 900,
                                # OCC 8's own search is left to FreeCAD's check(True), the same search, on anything large.
                                "self_intersection_faces": 400}))
    return out


def hub(ends: list[list[float]]) -> dict:
    """One node at the origin, and struts of radius 1 to these ends."""
    return {"units": "mm", "nodes": [[0.0, 0.0, 0.0], *ends], "struts": [{"a": 0, "b": i + 1, "ra": 1.0, "rb": 1.0} for i in range(len(ends))]}


def star(degree: int, seed: int) -> dict:
    """One node at the origin, `degree` struts of radius 1 whose directions are drawn until none is too near another."""
    draw = np.random.default_rng([RANDOM_SEED, seed])
    nearest = np.cos(np.radians(SMALLEST_ANGLE_DEG))
    while True:
        directions: list[np.ndarray] = []
        for _ in range(10_000):
            d = draw.normal(size=3)
            d /= np.linalg.norm(d)
            if all(d @ e <= nearest for e in directions):
                directions.append(d)
                if len(directions) == degree:
                    return hub([(STAR_LENGTH_MM * d).tolist() for d in directions])


def curved_node(folder: Path) -> list[Case]:
    """One node of BCC for meshes of second order: with sectors of 120° in place of halves, 5e-4 of the elements were inside out, else 1e-4 and less."""
    path = folder / "curved-node.json"
    path.write_text(json.dumps(hub([[x, y, z] for x in (-4, 4) for y in (-4, 4) for z in (-4, 4)])))
    return [Case("bcc node, curved", graph=path, limits={"most_inverted": 2e-4})]


def random_nodes(number: int, folder: Path) -> list[Case]:
    out = []
    for i in range(number):
        degree = DEGREES[i % len(DEGREES)]
        path = folder / f"random-{i:03d}.json"
        path.write_text(json.dumps(star(degree, i)))
        out.append(Case(f"random {i:03d}, degree {degree}", graph=path, detail={"degree": degree},
                        skip=("meshable",), limits={"freecad_seconds": 0, "self_intersection_seconds": 120, "g0_allowed": 0}))
    return out


def mixed_nodes(number: int, folder: Path) -> list[Case]:
    """Stars as above whose struts have radii of their own; every second star tapers."""
    out = []
    for i in range(number):
        degree = MIXED_DEGREES[i % len(MIXED_DEGREES)]
        graph = star(degree, 1000 + i)
        draw = np.random.default_rng([RANDOM_SEED, 2000 + i])
        for strut in graph["struts"]:
            strut["ra"] = float(draw.uniform(LEAST_RADIUS_MM, 1.0))
            strut["rb"] = float(draw.uniform(LEAST_RADIUS_MM, 1.0)) if i % 2 else strut["ra"]
        graph["nodes"] = [[4 * x for x in p] for p in graph["nodes"]]
        path = folder / f"mixed-{i:03d}.json"
        path.write_text(json.dumps(graph))
        out.append(Case(f"mixed {i:03d}, degree {degree}", graph=path, detail={"degree": degree},
                        skip=("meshable",), limits={"freecad_seconds": 600, "self_intersection_seconds": 120, "g0_allowed": 0}))
    return out


def samples(folder: Path) -> list[Case]:
    """Small lattices as `lattice-brep bench --keep` writes them, those that were accepted: judged in OCC 8. Angles go down to 3°: a node may be on the
    last rung, if the report names it."""
    out = []
    for path in sorted(folder.glob("*.accepted.json")):
        graph = json.loads(path.read_text())
        out.append(Case(f"sample {path.name.removesuffix('.accepted.json')}", graph=path, detail={"degree": int(degrees(graph).max())},
                        options=("--on-conflict", "shrink"), radius_mm=least_radius(graph),
                        skip=("meshable", "volume_bound"),
                        limits={"freecad_seconds": 0, "self_intersection_seconds": 600, "self_intersection_faces": 60, "g0_allowed": 1}))
    return out


def middle_box(graph: dict, struts: int) -> str:
    """A box about the middle of the lattice that touches about so many struts, as `--crop` wants it."""
    nodes = np.array(graph["nodes"], float)
    a, b = (nodes[[s[end] for s in graph["struts"]]] for end in "ab")
    centre = np.median((a + b) / 2, axis=0)
    half = np.maximum(np.ptp(nodes, axis=0) / 2, 1e-9)
    # How far the box must grow to touch each strut, from points along it.
    reach = np.min([np.max(np.abs(a + t * (b - a) - centre) / half, axis=1) for t in np.linspace(0, 1, 9)], axis=0)
    scale = np.sort(reach)[min(struts, len(reach)) - 1]
    # No wall of the box close to a node: just inside it, the node's struts would be cut where they still overlap.
    walls = np.abs(nodes - centre) / half
    choices = scale * np.linspace(0.9, 1.05, 301)
    clear = [np.min(np.abs(walls - c) * half) for c in choices]
    scale = choices[int(np.argmax(clear))]
    low, high = centre - scale * half, centre + scale * half
    return ":".join(",".join(f"{x:.6g}" for x in corner) for corner in (low, high))


def expected(case: Case, graph: dict | None, report: dict) -> dict:
    """All that the checks are told: from the graph where we have it, else from the report."""
    counts = report_fields.counts(report)
    out = {**case.limits, "radius_mm": case.radius_mm, "report": report, "report_counts": counts,
           "volume_mm3": report_fields.volume_mm3(report), "area_mm2": report_fields.area_mm2(report),
           "centroid_mm": report_fields.centroid_mm(report)}
    for name in ("nodes", "struts", "cylinders", "cones", "patches", "caps", "faces", "circles"):
        if name in counts:
            out[name] = counts[name]
    out["components"] = counts.get("components", 1)
    if report_fields.on_g0_rung(report):
        out["inside_limit_deg"] = 180.0  # sharp, and told so: the check `report` counts such nodes
    if graph is not None:
        out["lattice"] = graph
    if graph is not None and case.crop is None:
        out["graph"] = graph
        out["graph_counts"] = summary(graph)
        out["components"] = out["graph_counts"]["components"]
        ends = int((degrees(graph) == 1).sum())
        if "nodes" in out:
            out["skins"] = out["nodes"] - ends
        out.setdefault("caps", ends)
    return out
