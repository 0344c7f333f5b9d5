"""Has every strut the radii that the graph gives it? Each strut's face and both its rims, as OCC 8 reads them, against the lattice JSON.

Each strut has one face: a cylinder if its radii are equal, else a cone. The strut is found by its axis. At each rim the radius of the
circle, and that of the face there, must be the graph's: linear from `ra` at one node to `rb` at the other. The cone's half-angle must be
atan(|rb - ra| / length). Limit: 1e-9 relative; the axis may be 1e-9 radii off, a half-angle 2e-12 rad.
`expected["lattice"]` = {nodes, struts} is required; of a cropped lattice the whole one.
"""

from __future__ import annotations

import math

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.GeomAbs import GeomAbs_CurveType

from checks import main, verdict
from graphs import is_tapered
from model import STRUT_KINDS, load
from skins import axis

LIMIT = 1e-9
OCC_SMALLEST_RAD = 2e-12  # OCC holds no half-angle below 1e-12 and reads a smaller one as that (measured)


class Struts:
    """The graph's struts as arrays."""

    def __init__(self, graph: dict):
        nodes = np.array(graph["nodes"], float)
        self.all = graph["struts"]
        self.a, self.b = (nodes[[s[end] for s in self.all]] for end in "ab")
        self.length = np.linalg.norm(self.b - self.a, axis=1)
        self.along = (self.b - self.a) / self.length[:, None]

    def nearest(self, p: np.ndarray) -> int:
        """The strut whose segment is nearest to a point."""
        t = np.clip(np.einsum("ij,ij->i", p - self.a, self.along), 0, self.length)
        return int(np.argmin(np.linalg.norm(self.a + t[:, None] * self.along - p, axis=1)))

    def radius(self, k: int, p: np.ndarray) -> float:
        """The radius that strut k has beside a point."""
        t = float(np.dot(p - self.a[k], self.along[k])) / self.length[k]
        return self.all[k]["ra"] + t * (self.all[k]["rb"] - self.all[k]["ra"])

    def off_axis(self, k: int, p: np.ndarray) -> float:
        return float(np.linalg.norm(np.cross(p - self.a[k], self.along[k])))


def rims(model) -> dict[int, list]:
    """(centre, radius) of each rim circle of each strut's face, by the face's number; two arcs of a circle are one."""
    out: dict[int, list] = {}
    for use in model.edges:
        struts = [face.index for face, _ in use.uses if face.kind in STRUT_KINDS]
        curve = BRepAdaptor_Curve(use.edge) if struts and not use.degenerate else None
        if curve is None or curve.GetType() != GeomAbs_CurveType.GeomAbs_Circle:
            continue
        circle = curve.Circle()
        c = circle.Location()
        rim = (np.array([c.X(), c.Y(), c.Z()]), circle.Radius())
        for i in struts:
            if not any(r == rim[1] and np.array_equal(p, rim[0]) for p, r in out.setdefault(i, [])):
                out[i].append(rim)
    return out


def check(model_or_path, expected: dict) -> dict:
    if "lattice" not in expected:
        return verdict(["no lattice to compare with"])
    model, struts = load(model_or_path), Struts(expected["lattice"])
    found_rims = rims(model)
    worst = {"rim radius": (0.0, ""), "face radius": (0.0, ""), "half-angle": (0.0, ""), "axis": (0.0, "")}
    why, seen, cones = [], set(), 0

    def compare(what: str, off: float, place: str) -> None:
        if not off <= worst[what][0]:
            worst[what] = (float(off), place)

    for face in (f for f in model.faces if f.kind in STRUT_KINDS):
        ends = found_rims.get(face.index, [])
        if len(ends) != 2:
            why.append(f"a strut's face with {len(ends)} rims")
            continue
        k = struts.nearest((ends[0][0] + ends[1][0]) / 2)
        s = struts.all[k]
        if k in seen:
            why.append(f"two faces for strut {k}")
        seen.add(k)
        if face.kind != ("cone" if is_tapered(s) else "cylinder"):
            why.append(f"strut {k} with radii {s['ra']} and {s['rb']} is a {face.kind}")
            continue
        point, direction = axis(face)
        cone = face.surface.Cone() if face.kind == "cone" else None
        for centre, radius in ends:
            wanted = struts.radius(k, centre)
            own = face.surface.Cylinder().Radius() if cone is None else (
                cone.RefRadius() + math.tan(cone.SemiAngle()) * float(np.dot(centre - point, direction)))
            compare("rim radius", abs(radius / wanted - 1), f"strut {k}")
            compare("face radius", abs(own / wanted - 1), f"strut {k}")
            compare("axis", max(struts.off_axis(k, centre), float(np.linalg.norm(np.cross(centre - point, direction)))) / wanted, f"strut {k}")
        if cone is not None:
            cones += 1
            wanted = math.atan(abs(s["rb"] - s["ra"]) / struts.length[k])
            off = max(abs(abs(cone.SemiAngle()) - wanted) - OCC_SMALLEST_RAD, 0.0)
            compare("half-angle", off / wanted, f"strut {k}")
    why += [f"{what} of {place} off by {off:.2e} of it, allowed {LIMIT}" for what, (off, place) in worst.items() if not off <= LIMIT]
    if not seen:
        why.append("no strut's face")
    return verdict(why, struts=len(seen), cones=cones, **{f"{what} off": off for what, (off, _) in worst.items()})


if __name__ == "__main__":
    main(check)
