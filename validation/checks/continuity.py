"""How smooth is it? The largest angle between the two faces' normals along every shared edge, and the largest gap between them.

Both faces' own p-curves are evaluated at the same edge parameter, at Chebyshev points from end to end, and the normals are turned by
the faces' senses, so that a face folded back shows as 180 degrees. Sorted into rims (a strut and a patch or a sphere cap), inside (two patches), seams
(a face with itself), caps (a flat cap is a sharp edge by design: not judged) and round ends of cones (a hemisphere meets a cone at
its half-angle: judged by the difference). Any other pairing is a fault.
`jumps` in the answer lists the largest jump of every edge, for distributions.
`expected`: rim_limit_deg (0.05), inside_limit_deg (0.1), radius_mm (1; the gap may be 1e-6 of it).
"""

from __future__ import annotations

import math

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec

from checks import main, verdict
from model import STRUT_KINDS, load

SAMPLES = 9
FRACTIONS = [0.5 - 0.5 * math.cos(math.pi * i / (SAMPLES - 1)) for i in range(SAMPLES)]
SEAM_LIMIT_DEG = 1e-3
ROUND_END_LIMIT_DEG = 1e-3
GAP_LIMIT_OF_RADIUS = 1e-6
OCC_SMALLEST_MM = 1e-7
FLAT = 1e-9  # derivatives this short beside one another, or this near to parallel, span no tangent plane


def sort_of(kinds: list[str], same_face: bool) -> str:
    if same_face:
        return "seam"
    strut = [k in STRUT_KINDS for k in kinds]
    if kinds == ["spline", "spline"]:
        return "inside"
    if "cone" in kinds and "sphere" in kinds:
        return "round end"
    if any(strut) and ("spline" in kinds or "sphere" in kinds):
        return "rim"
    if any(strut) and "plane" in kinds:
        return "cap"
    return "other"


class Side:
    """Points and outward normals of one face along one of its edges."""

    def __init__(self, face, edge):
        self.face, self.curve = face, BRepAdaptor_Curve2d(edge, face.face)
        self.p, self.du, self.dv, self.uv = gp_Pnt(), gp_Vec(), gp_Vec(), gp_Pnt2d()

    def at(self, t: float):
        """Point, outward normal (any length), and whether there is one: a pole or a collapsed side has none to be trusted."""
        self.curve.D0(t, self.uv)
        self.face.surface.D1(self.uv.X(), self.uv.Y(), self.p, self.du, self.dv)
        a, b, p = self.du, self.dv, self.p
        ax, ay, az, bx, by, bz = a.X(), a.Y(), a.Z(), b.X(), b.Y(), b.Z()
        s, point = self.face.sign, (p.X(), p.Y(), p.Z())
        if self.face.kind == "sphere":
            sphere = self.face.surface.Sphere()
            c = sphere.Location()
            s = s if sphere.Direct() else -s
            return point, (s * (point[0] - c.X()), s * (point[1] - c.Y()), s * (point[2] - c.Z())), True
        normal = (s * (ay * bz - az * by), s * (az * bx - ax * bz), s * (ax * by - ay * bx))
        aa, bb = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz
        return point, normal, min(aa, bb) > FLAT**2 * max(aa, bb) and math.hypot(*normal) > FLAT * math.sqrt(aa * bb)


def along(use) -> tuple[float, float, tuple, int]:
    """(largest jump in degrees, largest gap in mm, place of the jump, samples without a normal) of one edge."""
    (fa, ea), (fb, eb) = use.uses
    curve, a, b = BRepAdaptor_Curve(use.edge), Side(fa, ea), Side(fb, eb)
    first, last = curve.FirstParameter(), curve.LastParameter()
    jump, gap, place, blind = -1.0, 0.0, (0.0, 0.0, 0.0), 0
    for f in FRACTIONS:
        t = first + f * (last - first)
        (pa, na, good_a), (pb, nb, good_b) = a.at(t), b.at(t)
        c = curve.Value(t)
        pc = (c.X(), c.Y(), c.Z())
        gap = max(gap, math.dist(pa, pb), math.dist(pa, pc), math.dist(pb, pc))
        if not (good_a and good_b):
            blind += 1
            continue
        cx, cy, cz = na[1] * nb[2] - na[2] * nb[1], na[2] * nb[0] - na[0] * nb[2], na[0] * nb[1] - na[1] * nb[0]
        angle = math.degrees(math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), na[0] * nb[0] + na[1] * nb[1] + na[2] * nb[2]))
        if angle > jump:
            jump, place = angle, pa
    return jump, gap, place, blind


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    limits = {"rim": expected.get("rim_limit_deg", 0.05), "inside": expected.get("inside_limit_deg", 0.1), "seam": SEAM_LIMIT_DEG,
              "round end": ROUND_END_LIMIT_DEG}
    gap_limit = max(GAP_LIMIT_OF_RADIUS * expected.get("radius_mm", 1.0), OCC_SMALLEST_MM) * 1.001
    jumps: dict[str, list[float]] = {}
    worst: dict[str, tuple] = {}
    gap, gap_place, blind, unpaired = 0.0, None, 0, 0
    for use in model.edges:
        if use.degenerate:
            continue
        if len(use.uses) != 2:
            unpaired += 1
            continue
        jump, edge_gap, place, edge_blind = along(use)
        sort = sort_of(sorted((use.uses[0][0].kind, use.uses[1][0].kind), reverse=True), use.uses[0][0] is use.uses[1][0])
        blind += edge_blind
        if sort == "round end":
            cone = next(face for face, _ in use.uses if face.kind == "cone").surface.Cone()
            jump = abs(jump - math.degrees(abs(cone.SemiAngle())))
        if edge_gap > gap:
            gap, gap_place = edge_gap, place
        if jump < 0:
            continue
        if jump > worst.get(sort, (-1.0,))[0]:
            worst[sort] = (jump, place)
        jumps.setdefault(sort, []).append(jump)

    why = [f"{unpaired} edges not used twice"] if unpaired else []
    if blind:
        why.append(f"{blind} samples where a face has no normal")
    if "other" in jumps:
        why.append(f"{len(jumps['other'])} edges between faces that no lattice has side by side, largest jump {max(jumps['other']):.3g} deg")
    for sort, limit in limits.items():
        if sort in worst and worst[sort][0] > limit:
            over = sum(j > limit for j in jumps[sort])
            at = ", ".join(f"{x:.4g}" for x in worst[sort][1])
            why.append(f"{sort}: jump {worst[sort][0]:.3g} deg at ({at}), allowed {limit}; {over} of {len(jumps[sort])} edges over")
    if gap > gap_limit:
        why.append(f"gap {gap:.3g} mm at ({', '.join(f'{x:.4g}' for x in gap_place)}), allowed {gap_limit:.3g}")
    figures = {}
    for sort in ("rim", "inside", "seam"):
        values = np.array(jumps.get(sort, [0.0]))
        figures[f"{sort}_edges"] = len(jumps.get(sort, []))
        figures[f"{sort}_max_deg"], figures[f"{sort}_p99_deg"], figures[f"{sort}_median_deg"] = (
            float(values.max()), float(np.percentile(values, 99)), float(np.median(values)))
        figures[f"{sort}_worst_at"] = worst.get(sort, (0, None))[1]
    return verdict(why, gap_mm=gap, **figures, jumps={sort: jumps.get(sort, []) for sort in ("rim", "inside")})


if __name__ == "__main__":
    main(check)
