"""A STEP file as the checks see it: its text, and its shape in build123d (OCC 8) with the few maps that every check needs.

A check takes a `Model` or a path; `load` accepts both, so that a check can be used alone:
    .venv/bin/python -m checks.valid FILE.step
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import build123d
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_Orientation
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape
# OCC 8 renamed its collections; before, this was TopTools.TopTools_IndexedMapOfShape.
from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as ShapeMap

from step_text import StepText

KIND = {
    GeomAbs_SurfaceType.GeomAbs_Plane: "plane",
    GeomAbs_SurfaceType.GeomAbs_Cylinder: "cylinder",
    GeomAbs_SurfaceType.GeomAbs_Cone: "cone",
    GeomAbs_SurfaceType.GeomAbs_Sphere: "sphere",
    GeomAbs_SurfaceType.GeomAbs_BSplineSurface: "spline",
    GeomAbs_SurfaceType.GeomAbs_BezierSurface: "spline",
}
STRUT_KINDS = ("cylinder", "cone")

FACE, EDGE, VERTEX = TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_VERTEX
SHELL, SOLID = TopAbs_ShapeEnum.TopAbs_SHELL, TopAbs_ShapeEnum.TopAbs_SOLID


def explore(shape: TopoDS_Shape, kind, avoid=None):
    explorer = TopExp_Explorer(shape, kind) if avoid is None else TopExp_Explorer(shape, kind, avoid)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def unique(shape: TopoDS_Shape, kind) -> list[TopoDS_Shape]:
    """Each sub-shape once, whatever its orientation."""
    found = ShapeMap()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(i) for i in range(1, found.Extent() + 1)]


@dataclass
class EdgeUse:
    """One edge and the faces that use it: (face, the edge as oriented in that face)."""

    edge: TopoDS_Edge
    uses: list[tuple["FaceOf", TopoDS_Edge]] = field(default_factory=list)

    @property
    def degenerate(self) -> bool:
        return BRep_Tool.Degenerated_s(self.edge)


@dataclass
class FaceOf:
    index: int
    face: TopoDS_Face
    surface: BRepAdaptor_Surface
    kind: str
    sign: float  # -1 where the face is used against its surface's normal


class Model:
    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.text = StepText(self.path)

    @cached_property
    def shape(self) -> TopoDS_Shape:
        return build123d.import_step(str(self.path)).wrapped

    @cached_property
    def solids(self):
        return list(explore(self.shape, SOLID))

    @cached_property
    def faces(self) -> list[FaceOf]:
        out = []
        for i, raw in enumerate(explore(self.shape, FACE)):
            face = TopoDS.Face(raw)
            surface = BRepAdaptor_Surface(face, False)
            sign = -1.0 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
            out.append(FaceOf(i, face, surface, KIND.get(surface.GetType(), "other"), sign))
        return out

    @cached_property
    def edges(self) -> list[EdgeUse]:
        index, table = ShapeMap(), []
        for f in self.faces:
            for raw in explore(f.face, EDGE):
                i = index.Add(raw)  # the same number for the same edge in either orientation
                edge = TopoDS.Edge(raw)
                if i > len(table):
                    table.append(EdgeUse(edge))
                table[i - 1].uses.append((f, edge))
        return table

    @cached_property
    def vertices(self) -> list[TopoDS_Shape]:
        return [TopoDS.Vertex(v) for v in unique(self.shape, VERTEX)]


def load(model_or_path) -> Model:
    return model_or_path if isinstance(model_or_path, Model) else Model(model_or_path)
