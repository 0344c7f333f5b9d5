"""Does every patch face away from its node? A film is star-shaped about its node, so the outward normal and the ray from the node
agree everywhere; a patch that folds back on itself keeps a valid B-rep but turns its normal against the ray.

The node is found from the axes of the struts around the skin (`skins.py`), not taken from us. Each patch is sampled on a grid.
Fails at a normal at 90 degrees or more from its ray. A skin without struts cannot be judged and is a fault.
"""

from __future__ import annotations

import math

from OCP.BRepTools import BRepTools
from OCP.gp import gp_Pnt, gp_Vec

from checks import main, verdict
from checks.continuity import FLAT
from model import load
from skins import skins

GRID = 9


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    worst, place, folded, blind, homeless = 1.0, None, 0, 0, 0
    p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    for skin in skins(model):
        node = skin.node
        if node is None:
            homeless += 1
            continue
        nx, ny, nz = map(float, node)
        for patch in skin.patches:
            u0, u1, v0, v1 = BRepTools.UVBounds_s(patch.face)
            lowest = 1.0
            for i in range(GRID):
                for j in range(GRID):
                    patch.surface.D1(u0 + (u1 - u0) * i / (GRID - 1), v0 + (v1 - v0) * j / (GRID - 1), p, du, dv)
                    normal = du.Crossed(dv)
                    size = normal.Magnitude()
                    rx, ry, rz = p.X() - nx, p.Y() - ny, p.Z() - nz
                    a, b = sorted((du.Magnitude(), dv.Magnitude()))
                    if a <= FLAT * b or size <= FLAT * a * b:
                        blind += 1
                        continue
                    cosine = patch.sign * (normal.X() * rx + normal.Y() * ry + normal.Z() * rz) / (size * math.sqrt(rx * rx + ry * ry + rz * rz))
                    if cosine < lowest:
                        lowest = cosine
                    if cosine < worst:
                        worst, place = cosine, (p.X(), p.Y(), p.Z())
            folded += lowest <= 0.0
    why = []
    if folded:
        at = ", ".join(f"{x:.4g}" for x in place)
        why.append(f"{folded} patches turn against the ray from their node, worst cosine {worst:.3g} at ({at})")
    if blind:
        why.append(f"{blind} samples where a patch has no normal")
    if homeless:
        why.append(f"{homeless} skins touch no strut")
    return verdict(why, lowest_cosine=float(worst), folded=int(folded))


if __name__ == "__main__":
    main(check)
