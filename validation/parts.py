"""Nine simple parts for Table 2: their surfaces as triangles (gmsh's OCC kernel), and tetrahedral meshes of them (Debian's TetGen). mm."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path
from typing import Callable

import numpy as np

QUALITY = "2"  # TetGen's bound on a tetrahedron's circumradius over its shortest edge
MOST_OFF = 0.05  # of the edges wanted
MOST_TRIES = 12
GROWTH = 2.5  # edges grow with the size's inverse to about this power: between a surface's and a volume's


class NoTetGen(Exception):
    pass


def box(solids, at, size):
    return [(3, solids.addBox(*at, *size))]


def rod(solids, at, along, radius):
    return [(3, solids.addCylinder(*at, *along, radius))]


def fused(solids, *shapes):
    return solids.fuse(shapes[0], [tag for shape in shapes[1:] for tag in shape])[0]


def without(solids, body, *shapes):
    return solids.cut(body, [tag for shape in shapes for tag in shape])[0]


def around(count: int, radius: float):
    return [(radius * math.cos(2 * math.pi * k / count), radius * math.sin(2 * math.pi * k / count)) for k in range(count)]


def turned(solids, shape, angle: float):
    solids.rotate(shape, 0, 0, 0, 0, 0, 1, angle)
    return shape


def heat_exchanger(s):
    return without(s, box(s, (0, 0, 0), (36, 96, 56)), *[rod(s, (0, y, 28), (36, 0, 0), 12) for y in (28, 68)])


def lever_arm(s):
    arm = fused(s, rod(s, (0, 0, 0), (0, 0, 24), 20), rod(s, (90, 0, 0), (0, 0, 20), 14), box(s, (0, -9, 4), (90, 18, 12)))
    return without(s, arm, rod(s, (0, 0, 0), (0, 0, 24), 11), rod(s, (90, 0, 0), (0, 0, 20), 7))


def mounting_bracket(s):
    angle = fused(s, box(s, (0, 0, 0), (80, 60, 10)), box(s, (0, 0, 0), (10, 60, 60)), box(s, (0, 26, 0), (45, 8, 45)))
    bores = [rod(s, (60, y, 0), (0, 0, 10), 5) for y in (15, 45)] + [rod(s, (0, y, 45), (10, 0, 0), 5) for y in (15, 45)]
    return without(s, angle, *bores)


def surfacing_mold(s):
    cavity = [(3, s.addSphere(50, 35, 55, 40))]
    pins = [rod(s, (x, y, 0), (0, 0, 35), 4) for x in (10, 90) for y in (10, 60)]
    return without(s, box(s, (0, 0, 0), (100, 70, 35)), cavity, *pins)


def engine_bracket(s):
    lugs = [box(s, (30, y, 0), (40, 12, 45)) for y in (14, 44)]
    body = fused(s, box(s, (0, 0, 0), (100, 70, 10)), *lugs)
    bolts = [rod(s, (x, y, 0), (0, 0, 10), 6) for x in (12, 88) for y in (12, 58)]
    return without(s, body, rod(s, (50, 0, 32), (0, 70, 0), 9), *bolts)


def bevel_gear(s):
    cone = [(3, s.addCone(0, 0, 0, 0, 0, 25, 40, 25))]
    hub = rod(s, (0, 0, -12), (0, 0, 12), 18)
    teeth = [turned(s, box(s, (20, -3, 2), (25, 6, 12)), 2 * math.pi * k / 16) for k in range(16)]
    return without(s, fused(s, cone, hub, *teeth), rod(s, (0, 0, -12), (0, 0, 37), 9))


def pipe_holder(s):
    clamps = [rod(s, (x, 0, 30), (0, 60, 0), 19) for x in (30, 80)]
    body = fused(s, box(s, (0, 0, 0), (110, 60, 14)), *clamps)
    bolts = [rod(s, (x, y, 0), (0, 0, 14), 3.5) for x in (6, 55, 104) for y in (10, 50)]
    return without(s, body, *[rod(s, (x, 0, 30), (0, 60, 0), 13) for x in (30, 80)], *bolts)


def impeller(s):
    hub, disc = rod(s, (0, 0, 0), (0, 0, 35), 13), rod(s, (0, 0, 0), (0, 0, 6), 48)
    blades = [turned(s, box(s, (8, -2.5, 3), (38, 5, 24)), 2 * math.pi * k / 8) for k in range(8)]
    return without(s, fused(s, hub, disc, *blades), rod(s, (0, 0, 0), (0, 0, 35), 6))


def gear_box(s):
    body = without(s, fused(s, box(s, (0, 0, 0), (120, 80, 70)), box(s, (-12, -12, 0), (144, 104, 8))), box(s, (9, 9, 9), (102, 62, 61)))
    bores = [rod(s, (x, 0, 40), (0, 80, 0), r) for x, r in ((38, 16), (84, 11))]
    bolts = [rod(s, (x, y, 0), (0, 0, 8), 4) for x in (-5, 125) for y in (-5, 40, 85)]
    return without(s, body, *bores, *bolts)


Mesh = tuple[np.ndarray, np.ndarray]  # places, and the places' numbers in triangles or tetrahedra


def surface(part: Callable, size_mm: float) -> Mesh:
    """The part's surface in triangles of about this size."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size_mm)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size_mm)
        part(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(2)
    finally:
        gmsh.finalize()
    order = np.argsort(tags)
    corners = np.searchsorted(tags[order], corners).reshape(-1, 3)
    used, corners = np.unique(corners, return_inverse=True)
    return points.reshape(-1, 3)[order][used], corners.reshape(-1, 3)


def smesh(points: np.ndarray, triangles: np.ndarray) -> str:
    """TetGen's form of a surface."""
    lines = [f"{len(points)} 3 0 0", *(f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(points.tolist()))]
    lines += [f"{len(triangles)} 0", *(f"3 {a} {b} {c}" for a, b, c in triangles.tolist()), "0", "0"]
    return "\n".join(lines) + "\n"


def volume_bound(size_mm: float) -> float:
    """Of tetrahedra: that of a regular one of this edge."""
    return size_mm**3 / (6 * math.sqrt(2))


def tetgen(points: np.ndarray, triangles: np.ndarray, size_mm: float, to: Path) -> Mesh:
    """Leaves TO.node and TO.ele."""
    to.with_suffix(".smesh").write_text(smesh(points, triangles))
    try:
        done = subprocess.run(["tetgen", f"-pq{QUALITY}a{volume_bound(size_mm):.9f}QF", to.with_suffix(".smesh")], capture_output=True, text=True)
    except FileNotFoundError:
        raise NoTetGen("no program tetgen: `apt-get install tetgen` (Debian)") from None
    if done.returncode:
        raise RuntimeError(f"tetgen: {(done.stdout + done.stderr).strip()[-400:]}")
    for kind in ("node", "ele"):
        to.with_suffix(f".1.{kind}").replace(to.with_suffix(f".{kind}"))
    for left in (".smesh", ".1.face", ".1.edge", ".1.smesh"):
        to.with_suffix(left).unlink(missing_ok=True)
    return read(to)


def read(at: Path) -> Mesh:
    """AT.node and AT.ele."""
    rows = [[line.split() for line in at.with_suffix(kind).read_text().splitlines() if line and line[0] != "#"][1:] for kind in (".node", ".ele")]
    return np.array([row[1:4] for row in rows[0]], float), np.array([row[1:5] for row in rows[1]], int)


def edges(tetrahedra: np.ndarray) -> np.ndarray:
    """Each once, the smaller number first."""
    return np.unique(np.sort(np.concatenate([tetrahedra[:, [i, j]] for i in range(4) for j in range(i)]), axis=1), axis=0)


def tuned(count: Callable[[float], int], wanted: int, size: float) -> tuple[float, int]:
    """The size at which `count`, which falls with it, is near what is wanted, and the count."""
    too_small, too_large = 0.0, math.inf
    for _ in range(MOST_TRIES):
        found = count(size)
        if abs(found / wanted - 1) < MOST_OFF:
            return size, found
        too_small, too_large = (size, too_large) if found > wanted else (too_small, size)
        size *= (found / wanted) ** (1 / GROWTH)
        if not too_small < size < too_large:
            size = 0.5 * (too_small + too_large)
    raise RuntimeError(f"no size at which there are {wanted} edges: {found} at {size:g} mm")


def bowed(points: np.ndarray, pairs: np.ndarray, pieces: int, rise: float) -> Mesh:
    """Each edge a bow of so many straight pieces, which rises in its middle by this part of its length. Points, and the pieces' ends."""
    a, b = points[pairs[:, 0]], points[pairs[:, 1]]
    along = b - a
    away = np.eye(3)[np.abs(along).argmin(axis=1)]
    away = np.cross(along, away)
    away /= np.linalg.norm(away, axis=1)[:, None]
    length = np.linalg.norm(along, axis=1)[:, None]
    inner = []
    for k in range(1, pieces):
        t = k / pieces
        inner.append(a + t * along + 4 * t * (1 - t) * rise * length * away)
    first = len(points) + np.arange(len(pairs))
    chain = [pairs[:, 0], *(first + k * len(pairs) for k in range(pieces - 1)), pairs[:, 1]]
    return np.concatenate([points, *inner]), np.concatenate([np.stack(ends, axis=1) for ends in zip(chain, chain[1:])])
