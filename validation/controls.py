"""Bodies with a known answer, good and bad, made with build123d and OCC: each is what some kernel or exporter really produces.

`make(name, folder)` writes one STEP file and returns its path; `NAMES` lists them. The lattice-like ones are in `synthetic.py`.
"""

from __future__ import annotations

import math
from pathlib import Path

import build123d as b
from OCP.BRep import BRep_Builder
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shell

from model import explore


def cylinder():
    return b.Cylinder(1, 5)


def round_cone():
    """A frustum with a hemisphere on its thin end: an edge of the half-angle, as our round caps have on tapered struts."""
    return b.Cone(2, 1, 5, align=(b.Align.CENTER, b.Align.CENTER, b.Align.MIN)) + b.Pos(0, 0, 5) * b.Sphere(1)


def bulging_cone():
    """The same with a larger ball through the same rim."""
    return b.Cone(2, 1, 5, align=(b.Align.CENTER, b.Align.CENTER, b.Align.MIN)) + b.Pos(0, 0, 5.5) * b.Sphere(1.25**0.5)


def filleted_box():
    """Every edge tangent."""
    box = b.Box(3, 4, 5)
    return b.fillet(box.edges(), 0.7)


def open_shell():
    """A box less one face: BRepCheck calls it valid."""
    shell, build = TopoDS_Shell(), BRep_Builder()
    build.MakeShell(shell)
    for face in list(explore(b.Box(1, 2, 3).wrapped, TopAbs_ShapeEnum.TopAbs_FACE))[:-1]:
        build.Add(shell, face)
    return b.Shell(shell)


def tube_through_itself():
    """A tube swept along a loop that crosses itself: valid, closed, one solid, and it cuts itself."""
    path = b.Spline([(-4, -3, 0), (3, 2, 0), (3, -2, 0), (-4, 3, 0)])
    start = b.Plane(origin=path @ 0, z_dir=path % 0)
    return b.sweep(start * b.Circle(0.6), path=path)


def overlapping_boxes():
    """Two solids in the same place, never fused."""
    both, build = TopoDS_Compound(), BRep_Builder()
    build.MakeCompound(both)
    build.Add(both, b.Box(2, 2, 2).wrapped)
    build.Add(both, (b.Pos(1, 0.5, 0.3) * b.Box(2, 2, 2)).wrapped)
    return b.Compound(both)


def crease_prism():
    """A prism whose one side is bent by 1 degree, as spline faces."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert

    rise = math.tan(math.radians(1.0))
    outline = b.Polyline((-2, 0), (2, 0), (2, 1), (0, 1), (-2, 1 - 2 * rise), close=True)
    body = b.extrude(b.make_face(outline), 1)
    return b.Solid(BRepBuilderAPI_NurbsConvert(body.wrapped if body.wrapped.ShapeType() == TopAbs_ShapeEnum.TopAbs_SOLID
                                               else next(explore(body.wrapped, TopAbs_ShapeEnum.TopAbs_SOLID))).Shape())


def bow_tie_face():
    """A plane face whose border crosses itself: invalid, as a bare OCC shape."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.gp import gp_Pnt

    border = BRepBuilderAPI_MakePolygon()
    for x, y in ((0, 0), (2, 2), (2, 0), (0, 2)):
        border.Add(gp_Pnt(x, y, 0))
    border.Close()
    return BRepBuilderAPI_MakeFace(border.Wire()).Face()


NAMES = {f.__name__: f for f in (cylinder, round_cone, bulging_cone, filleted_box, open_shell, tube_through_itself, overlapping_boxes, crease_prism)}


def make(name: str, folder: Path) -> Path:
    path = Path(folder) / f"{name}.step"
    if not path.exists():
        b.export_step(NAMES[name](), str(path))
    return path
