"""One lattice by another program, in a process of its own so that its time is its own: `peers.py occ|manifold GRAPH`, or `peers.py judge STEP` for what
OCC's check says of a file. Prints one line of JSON.

The time is that of making the parts (struts from node to node, spheres at nodes) and of their union; reading, judging and writing are not counted.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from graphs import degrees

SEGMENTS = 32  # of manifold3d's struts and spheres


def volume(shape) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    held = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, held)
    return held.Mass()


def told(shape) -> dict:
    """Counts of an OCC shape, and what its check says."""
    from build123d import Shape

    shape = Shape(shape)
    return {"faces": len(shape.faces()), "solids": len(shape.solids()), "valid": bool(shape.is_valid), "volume_mm3": volume(shape.wrapped)}


def fused(graph: dict):
    """One boolean union of all parts by build123d."""
    from build123d import Compound, Plane, Pos, Solid

    nodes, struts, radius = np.array(graph["nodes"]), graph["struts"], graph["struts"][0]["ra"]
    assert all(s["ra"] == s["rb"] == radius for s in struts), "lattices of one radius"
    parts = []
    for s in struts:
        a, b = nodes[s["a"]], nodes[s["b"]]
        parts.append(Solid.make_cylinder(radius, float(np.linalg.norm(b - a)), Plane(tuple(a), z_dir=tuple(b - a))))
    parts += [Pos(*nodes[node]) * Solid.make_sphere(radius) for node in np.flatnonzero(degrees(graph) > 1)]  # a free end has a flat cap
    whole = parts[0].fuse(*parts[1:])
    return whole if hasattr(whole, "wrapped") else Compound(whole)


def occ(graph: dict) -> dict:
    from build123d import export_step

    start = time.process_time()
    whole = fused(graph)
    cpu = time.process_time() - start
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fused.step"
        export_step(whole, str(path))
        size = path.stat().st_size
    return {"cpu_s": cpu, "bytes": size, **told(whole.wrapped)}


def manifold(graph: dict) -> dict:
    """One mesh union of all parts by manifold3d."""
    from checks.volume_bound import bodies, union

    start = time.process_time()
    struts, spheres = bodies(graph, SEGMENTS)
    whole = union(struts + spheres)
    faces, held = whole.num_tri(), whole.volume()  # the union is computed when it is asked for
    cpu = time.process_time() - start
    return {"cpu_s": cpu, "faces": faces, "solids": len(whole.decompose()), "valid": whole.status().name == "NoError", "volume_mm3": held,
            "bytes": 84 + 50 * faces}  # binary STL


def judge(path: Path) -> dict:
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return told(reader.OneShape())


if __name__ == "__main__":
    what, path = sys.argv[1], Path(sys.argv[2])
    print(json.dumps(judge(path) if what == "judge" else {"occ": occ, "manifold": manifold}[what](json.loads(path.read_text()))))
