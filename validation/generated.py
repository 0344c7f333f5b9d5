"""Lattices made on the spot: blocks of BCC, the same with moved nodes, and the edges of a part's tetrahedral mesh (gmsh). mm."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import program

SIZE_MM, RADIUS_MM = 10.0, 0.5  # of a cell of BCC and its struts
MOVED = 0.1  # how far nodes are moved along each axis, at most: a part of the cell's size
SEED = 2025
SHARE = 8  # the radius is the shortest edge over this


def bcc(repeat: int, to: Path) -> Path:
    made = program.run("cell", "bcc", "--size", f"{SIZE_MM:g}", "--repeat", "x".join([str(repeat)] * 3), "--radius", f"{RADIUS_MM:g}", "-o", to)
    if not made.ok:
        raise RuntimeError(f"{made.command}: {made.last_words}")
    return to


def jittered(repeat: int, to: Path) -> Path:
    graph = json.loads(bcc(repeat, to).read_text())
    nodes = np.array(graph["nodes"], float)
    nodes += MOVED * SIZE_MM * np.random.default_rng(SEED).uniform(-1, 1, nodes.shape)
    to.write_text(json.dumps({**graph, "nodes": nodes.tolist()}))
    return to


def tetrahedral(size_mm: float, to: Path) -> Path:
    """A plate of 80 x 50 x 25 mm with a boss and two bores, meshed by tetrahedra of about this size."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size_mm)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size_mm)
        solids = gmsh.model.occ
        plate, boss = solids.addBox(0, 0, 0, 80, 50, 25), solids.addCylinder(55, 25, 25, 0, 0, 15, 18)
        body, _ = solids.fuse([(3, plate)], [(3, boss)])
        bores = [solids.addCylinder(55, 25, 0, 0, 0, 40, 10), solids.addCylinder(18, 25, 0, 0, 0, 25, 9)]
        solids.cut(body, [(3, bore) for bore in bores])
        solids.synchronize()
        gmsh.model.mesh.generate(3)
        tags, points, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(4)
    finally:
        gmsh.finalize()
    points = points.reshape(-1, 3)[np.argsort(tags)]
    tetrahedra = np.searchsorted(np.sort(tags), corners).reshape(-1, 4)
    pairs = [tetrahedra[:, [i, j]] for i in range(4) for j in range(i)]
    edges = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    used, edges = np.unique(edges, return_inverse=True)
    points, edges = points[used], edges.reshape(-1, 2)
    radius = float(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1).min() / SHARE)
    struts = [{"a": a, "b": b, "ra": radius, "rb": radius} for a, b in edges.tolist()]
    to.write_text(json.dumps({"units": "mm", "nodes": points.tolist(), "struts": struts}))
    return to
