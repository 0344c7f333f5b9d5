"""Groups a solid's spline faces into skins (spline faces joined by shared edges), and finds each skin's node
as the point nearest to the axes of the struts around it: from the shape alone, without the graph."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from model import STRUT_KINDS, FaceOf, Model


@dataclass
class Skin:
    patches: list[FaceOf] = field(default_factory=list)
    struts: dict[int, FaceOf] = field(default_factory=dict)
    rim_points: list[np.ndarray] = field(default_factory=list)

    @property
    def node(self) -> np.ndarray | None:
        if not self.struts:
            return None
        # The rims' middle, moved as little as needed towards all axes: it also settles a straight node, where any axis point would do.
        middle = np.mean(self.rim_points, axis=0)
        a, b = 1e-9 * np.eye(3), 1e-9 * middle
        for face in self.struts.values():
            point, direction = axis(face)
            across = np.eye(3) - np.outer(direction, direction)
            a, b = a + across, b + across @ point
        return np.linalg.solve(a, b)


def axis(face: FaceOf) -> tuple[np.ndarray, np.ndarray]:
    line = (face.surface.Cylinder() if face.kind == "cylinder" else face.surface.Cone()).Axis()
    p, d = line.Location(), line.Direction()
    return np.array([p.X(), p.Y(), p.Z()]), np.array([d.X(), d.Y(), d.Z()])


def skins(model: Model) -> list[Skin]:
    parent = list(range(len(model.faces)))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for edge in model.edges:
        if len(edge.uses) == 2 and all(face.kind == "spline" for face, _ in edge.uses):
            parent[root(edge.uses[0][0].index)] = root(edge.uses[1][0].index)
    found: dict[int, Skin] = {}
    for face in model.faces:
        if face.kind == "spline":
            found.setdefault(root(face.index), Skin()).patches.append(face)
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    for edge in model.edges:
        kinds = {face.kind: face for face, _ in edge.uses}
        strut = next((kinds[k] for k in STRUT_KINDS if k in kinds), None)
        if "spline" in kinds and strut:
            skin = found[root(kinds["spline"].index)]
            skin.struts[strut.index] = strut
            curve = BRepAdaptor_Curve(edge.edge)
            p = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
            skin.rim_points.append(np.array([p.X(), p.Y(), p.Z()]))
    return list(found.values())
