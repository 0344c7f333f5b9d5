"""How far did the kernel have to stretch its tolerances to accept the file?

A reader that finds a gap widens the edge's or vertex's tolerance over it and then calls the shape valid.
Limit: 1e-6 of the radius, but never below OCC's own smallest tolerance of 1e-7 mm.
`expected["radius_mm"]` (1 if not given).
"""

from __future__ import annotations

from OCP.BRep import BRep_Tool

from checks import main, verdict
from model import load

LIMIT_OF_RADIUS = 1e-6
OCC_SMALLEST_MM = 1e-7  # Precision::Confusion, which every edge gets


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    limit = max(LIMIT_OF_RADIUS * expected.get("radius_mm", 1.0), OCC_SMALLEST_MM) * 1.001
    figures = {
        "edge_mm": max((BRep_Tool.Tolerance_s(e.edge) for e in model.edges), default=0.0),
        "vertex_mm": max((BRep_Tool.Tolerance_s(v) for v in model.vertices), default=0.0),
        "face_mm": max((BRep_Tool.Tolerance_s(f.face) for f in model.faces), default=0.0),
    }
    why = [f"largest {name[:-3]} tolerance {value:.3g} mm, allowed {limit:.3g}" for name, value in figures.items() if value > limit]
    return verdict(why, limit_mm=limit, **figures)


if __name__ == "__main__":
    main(check)
