"""Our signed distance from the original node against OCC's: the union of half cylinders and sphere by OCC's boolean, the least distance to its
faces, edges and vertices by BRepExtrema, the side by its solid classifier.

    validation/.venv/bin/python validation/deviation.py [POINTS]     default 10,000 points a node

One regular node and one irregular one; half of the points from our patches, half from Savio's film, which lies deep inside. Exit code 1 if
any point is off by more than 1e-6 mm.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere
from OCP.collections import List_TopoDS_Shape as ShapeList
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.TopAbs import TopAbs_IN, TopAbs_ON, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer

import ply
import program

NODES = ("regular-6", "irregular-6")
SURFACES = ("ours-patches", "savio-mesh")
MOST_OFF = 1e-6  # mm
BEYOND = 4.0  # mm that cylinders go on beyond the farthest point, so that their ends are never nearest


def union(axes: np.ndarray, length: float):
    """The original node: one solid, and its shell (distances to a solid count its inside as 0)."""
    tools = ShapeList()
    for axis in axes:
        tools.Append(BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(*axis)), 1.0, length).Shape())
    arguments = ShapeList()
    arguments.Append(BRepPrimAPI_MakeSphere(1.0).Shape())
    fuse = BRepAlgoAPI_Fuse()
    fuse.SetArguments(arguments)
    fuse.SetTools(tools)
    fuse.Build()
    parts = {}
    for kind in (TopAbs_SOLID, TopAbs_SHELL):
        found = TopExp_Explorer(fuse.Shape(), kind)
        parts[kind] = found.Current()
        found.Next()
        if found.More():
            raise RuntimeError("OCC's union is not one solid with one shell")
    return parts[TopAbs_SOLID], parts[TopAbs_SHELL]


def compare(axes: np.ndarray, points: np.ndarray, distances: np.ndarray) -> dict:
    """Largest difference, points off by more than MOST_OFF, and points that are on the wrong side."""
    solid, shell = union(axes, float(np.linalg.norm(points, axis=1).max()) + BEYOND)
    classify = BRepClass3d_SolidClassifier(solid)
    extrema = BRepExtrema_DistShapeShape()
    extrema.LoadS1(shell)
    off, wrong = np.zeros(len(points)), 0
    for k, (point, ours) in enumerate(zip(points, distances)):
        at = gp_Pnt(*point)
        extrema.LoadS2(BRepBuilderAPI_MakeVertex(at).Vertex())
        if not extrema.Perform():
            raise RuntimeError(f"OCC finds no distance to {point}")
        off[k] = abs(extrema.Value() - abs(ours))
        classify.Perform(at, 1e-9)
        inside = classify.State() == TopAbs_IN
        wrong += inside != (ours < 0) and classify.State() != TopAbs_ON and abs(ours) > MOST_OFF
    return {"largest": off.max(), "median": float(np.median(off)), "off": int((off > MOST_OFF).sum()), "wrong side": int(wrong), "where": points[off.argmax()]}


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        done = program.run("evaluate", "nodes", "--sets", ",".join(NODES), "--count", 1, "--samples", 1, "--surfaces", folder)
        if not done.ok:
            print(done.last_words, file=sys.stderr)
            return 1
        for node in NODES:
            for name in SURFACES:
                surface = ply.read(Path(folder) / f"{node}-{name}.ply")
                pick = np.linspace(0, len(surface.points) - 1, count // len(SURFACES)).astype(int)
                found = compare(surface.axes, surface.points[pick], surface.distances[pick])
                ours = surface.distances[pick]
                print(f"{node} {name}: {len(pick)} points, from {ours.min():.4f} to {ours.max():.4f} mm: largest difference {found['largest']:.1e} mm, "
                      f"median {found['median']:.1e}; {found['off']} off by more than {MOST_OFF:g}, {found['wrong side']} on the wrong side", flush=True)
                failed += found["off"] + found["wrong side"]
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
