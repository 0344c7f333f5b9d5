"""Linear elastic stress in a solid from a STEP file: gmsh's tetrahedra of ten nodes (C3D10 of CalculiX), solved by ccx. mm, N, MPa.

`solve` runs a case; `patch_test` runs a box whose answer is known. Meshing is a process of its own (`fea.py --mesh`), with a limit, as ccx is.
"""

from __future__ import annotations

import json
import re
import resource
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import timebox

MODULUS, POISSON = 210000.0, 0.3
MESH_SECONDS, SOLVE_SECONDS = 120, 240  # CPU
GROWTH = 0.4  # of the element size, per length: away from the surface and from the refined box
QUALITY = 0.1  # least minSICN of a curved element; below it, its edges are made straight
INSIDE, AMONG = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20  # barycentric coordinates of the four integration points of C3D10


class NoAnswer(Exception):
    pass


@dataclass
class Sizes:
    """Element sizes: `coarse`, but `fine` on the surface within the box `low` to `high`."""
    coarse: float
    fine: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]


@dataclass
class Mesh:
    points: np.ndarray  # (n, 3)
    tetrahedra: np.ndarray  # (m, 10) rows of points, in the order of C3D10
    skin: np.ndarray  # (k, 3) corners of the triangles on the surface, counter-clockwise seen from outside
    quality: np.ndarray  # (m) minSICN of the curved elements: 1 regular, below 0 inverted
    straightened: np.ndarray  # (m) whether its edges were made straight


@dataclass
class Answer:
    stress: np.ndarray  # (elements, 4, 6) at the integration points: xx, yy, zz, xy, xz, yz
    reaction: np.ndarray  # (3) sum over the nodes asked for
    cpu_s: float


# --- mesh -------------------------------------------------------------------------------------------------------------------------


def to_c3d10(tetrahedra: np.ndarray) -> np.ndarray:
    """gmsh has the nodes of the edges 3-4 and 2-4 the other way round; the same the way back."""
    return tetrahedra[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]


def refine(gmsh, sizes: Sizes) -> None:
    field = gmsh.model.mesh.field
    reach = (sizes.coarse - sizes.fine) / GROWTH
    depth, by_depth, box, both = (field.add(kind) for kind in ("Distance", "Threshold", "Box", "Max"))
    field.setNumbers(depth, "SurfacesList", [tag for _, tag in gmsh.model.getEntities(2)])
    field.setNumber(depth, "Sampling", 40)
    for name, value in {"InField": depth, "SizeMin": sizes.fine, "SizeMax": sizes.coarse, "DistMin": sizes.fine, "DistMax": sizes.fine + reach}.items():
        field.setNumber(by_depth, name, value)
    for axis, low, high in zip("XYZ", sizes.low, sizes.high):
        field.setNumber(box, axis + "Min", low)
        field.setNumber(box, axis + "Max", high)
    for name, value in {"VIn": sizes.fine, "VOut": sizes.coarse, "Thickness": reach}.items():
        field.setNumber(box, name, value)
    field.setNumbers(both, "FieldsList", [by_depth, box])
    field.setAsBackgroundMesh(both)


def straighten(gmsh, ids: np.ndarray, tags: np.ndarray) -> np.ndarray:
    """Puts the nodes on the edges of bad elements half-way between the corners until none is bad: ccx accepts inverted ones without a word. Returns which."""
    done = np.zeros(len(ids), bool)
    while True:
        bad = ~done & (gmsh.model.mesh.getElementQualities(ids, "minSICN") < QUALITY)
        if not bad.any():
            return done
        done |= bad
        for nodes in to_c3d10(tags[bad]):
            for middle, (a, b) in zip(nodes[4:], ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))):
                half = (gmsh.model.mesh.getNode(nodes[a])[0] + gmsh.model.mesh.getNode(nodes[b])[0]) / 2
                gmsh.model.mesh.setNode(middle, half, [])


def mesh_here(step: str, sizes: Sizes, to: str) -> None:
    import gmsh

    from checks.meshable import TEN_NODES, as_it_is

    gmsh.initialize(interruptible=False)
    as_it_is(gmsh)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
    gmsh.model.occ.importShapes(step)
    gmsh.model.occ.synchronize()
    refine(gmsh, sizes)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    ids, tags = gmsh.model.mesh.getElementsByType(TEN_NODES)
    tags = tags.reshape(-1, 10)
    straightened = straighten(gmsh, ids, tags)
    names, points, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(names)
    rank = lambda these: np.searchsorted(names[order], these)  # noqa: E731
    skin = gmsh.model.mesh.getElementsByType(9)[1].reshape(-1, 6)[:, :3]
    np.savez(to, points=points.reshape(-1, 3)[order], tetrahedra=to_c3d10(rank(tags)), skin=rank(skin),
             quality=gmsh.model.mesh.getElementQualities(ids, "minSICN"), straightened=straightened)


def mesh(step: Path, sizes: Sizes) -> Mesh:
    to = step.with_suffix(".npz")
    done = timebox.run([sys.executable, __file__, "--mesh", str(step), json.dumps(asdict(sizes)), str(to)], MESH_SECONDS)
    if done is None or done.returncode:
        raise NoAnswer(f"gmsh, {step.name}: " + (f"no mesh in {MESH_SECONDS} CPU s" if done is None else (done.stderr or done.stdout).strip()[-300:]))
    found = Mesh(**np.load(to))
    if not found.quality.min() > 0:
        raise NoAnswer(f"gmsh, {step.name}: elements of quality {found.quality.min():.3g}, their edges straight")
    return found


# --- solution ---------------------------------------------------------------------------------------------------------------------


def listed(numbers: np.ndarray) -> list[str]:
    return [", ".join(map(str, numbers[k:k + 12].tolist())) for k in range(0, len(numbers), 12)]


def deck(mesh: Mesh, fixed: list[tuple[np.ndarray, int, float]], pulled: np.ndarray) -> str:
    """`fixed`: (nodes, axis 0 to 2, displacement). Printed: the reaction on the nodes `pulled` and all stresses. Nodes count from 0. ccx reads 20 characters of a field."""
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{k}, {x:.12e}, {y:.12e}, {z:.12e}" for k, (x, y, z) in enumerate(mesh.points.tolist(), 1)]
    lines += ["*ELEMENT, TYPE=C3D10, ELSET=SOLID"] + [f"{k}, " + ", ".join(map(str, row)) for k, row in enumerate((mesh.tetrahedra + 1).tolist(), 1)]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{MODULUS}, {POISSON}", "*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL"]
    lines += ["*NSET, NSET=PULLED", *listed(pulled + 1), "*STEP", "*STATIC", "*BOUNDARY"]
    lines += [f"{node + 1}, {axis + 1}, {axis + 1}, {value:.12e}" for nodes, axis, value in fixed for node in nodes.tolist()]
    lines += ["*NODE PRINT, NSET=PULLED, TOTALS=ONLY", "RF", "*EL PRINT, ELSET=SOLID", "S", "*END STEP", ""]
    return "\n".join(lines)


def read(text: str, elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Stress (elements, 4, 6) and total reaction, from what ccx prints into its .dat file."""
    blocks = re.split(r"^ (?=stresses|total force)", text, flags=re.M)
    total = next(b for b in blocks if b.startswith("total force"))
    rows = np.array(next(b for b in blocks if b.startswith("stresses")).partition("\n")[2].split(), float).reshape(-1, 8)
    if not np.array_equal(rows[:, :2], [(k, point) for k in range(1, elements + 1) for point in (1, 2, 3, 4)]):
        raise NoAnswer(f"ccx printed stresses at {len(rows)} points, wanted four of each of {elements} elements in order")
    return rows[:, 2:].reshape(-1, 4, 6), np.array(total.partition("\n")[2].split(), float)


def solve(mesh: Mesh, fixed: list[tuple[np.ndarray, int, float]], pulled: np.ndarray) -> Answer:
    """As in `deck`. Point k of an element is the integration point nearest to its corner k."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        job = Path(folder) / "job"
        job.with_suffix(".inp").write_text(deck(mesh, fixed, pulled))
        done = timebox.run(["ccx", "-i", job.name], SOLVE_SECONDS, cwd=folder)
        if done is None or "Job finished" not in done.stdout:
            raise NoAnswer("ccx: " + (f"not done in {SOLVE_SECONDS} CPU s" if done is None else (done.stdout + done.stderr).strip()[-300:]))
        stress, reaction = read(job.with_suffix(".dat").read_text(), len(mesh.tetrahedra))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return Answer(stress, reaction, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


# --- stress -----------------------------------------------------------------------------------------------------------------------


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Of (..., 6): xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = np.moveaxis(stress, -1, 0)
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + xz**2 + yz**2))


def at_corners(stress: np.ndarray) -> np.ndarray:
    """(elements, 4, 6) at the integration points to the same at the corners: the linear field through the four points."""
    weights = np.linalg.inv(np.full((4, 4), AMONG) + (INSIDE - AMONG) * np.eye(4))
    return np.einsum("ck,ekt->ect", weights, stress)


def at_nodes(mesh: Mesh, stress: np.ndarray) -> np.ndarray:
    """Von Mises stress of the mean over the elements at each node that is a corner; nan at the others."""
    corners = mesh.tetrahedra[:, :4].ravel()
    total = np.zeros((len(mesh.points), 6))
    np.add.at(total, corners, at_corners(stress).reshape(-1, 6))
    count = np.bincount(corners, minlength=len(mesh.points))[:, None]
    return von_mises(np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0))


def patch_test(out: Path) -> float:
    """A box of 10 mm pressed by 1 %, free at the sides: the largest distance from E, over E, of the modulus and of all stresses."""
    from build123d import Box, export_step

    step = out / "box.step"
    export_step(Box(10, 10, 10), str(step))
    box = mesh(step, Sizes(3.0, 1.5, (0, 0, 0), (5, 5, 5)))
    side = lambda axis, at: np.flatnonzero(np.abs(box.points[:, axis] - at) < 1e-6)  # noqa: E731
    top = side(2, 5)
    found = solve(box, [(side(0, -5), 0, 0.0), (side(1, -5), 1, 0.0), (side(2, -5), 2, 0.0), (top, 2, -0.1)], top)
    moduli = [-found.reaction[2] / 100 / 0.01, *(von_mises(found.stress).ravel() / 0.01), *(at_nodes(box, found.stress) / 0.01)]
    return float(np.nanmax(np.abs(np.array(moduli) / MODULUS - 1)))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--mesh"]:
        mesh_here(sys.argv[2], Sizes(**json.loads(sys.argv[3])), sys.argv[4])
