"""Peak stress at the node of a BCC cell under compression: our solid beside the sharp union of the same struts, on finer and finer meshes.

    validation/setup --stress                                 installs CalculiX
    validation/.venv/bin/python validation/stress.py          writes docs/stress.md and docs/pictures/stress.png

The chain, gmsh and CalculiX, is fea.py.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import fea
import figures
import generated
import peers
import pictures
import program
from graphs import degrees
from markdown import small, table

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs" / "stress.md"
RADIUS = 1.0  # mm, in a cell of generated.SIZE_MM
BLEND = 0.3
COARSE = RADIUS / 2  # element size away from the box
SIZES = [RADIUS / n for n in (8, 16, 32, 64, 128, 256)]  # in the box; the first one is around the whole node
WHOLE, FIRST, WIDE = 2 * RADIUS, RADIUS / 2, 12  # half of the box's side: around the whole node, then this, but at most so many elements
ZONE = 2.5 * RADIUS  # stress is read where no coordinate is farther from the node
PRESSED = 0.1  # mm
PATCH_LIMIT = 1e-6  # of the patch test: ccx prints seven digits
SHOWN = SIZES[2]  # of the picture
MOST = 12.0  # of the picture's colours
LINES = ((31, 119, 180), (23, 160, 134), (192, 57, 43))

HEAD = ["solid", "size", "elements", "of them in the box", "least quality, all", "in the box", "made straight, all", "in the box", "stiffness, kN/mm",
        "peak at integration points", "change", "peak at corners", "change", "where, mm from the node", "CPU of ccx, s"]


@dataclass
class Run:
    size: float
    mesh: fea.Mesh
    answer: fea.Answer
    is_fine: np.ndarray  # which elements lie in the refined box
    nominal: float  # MPa: the force over the sections of the four upper struts
    stiffness: float  # kN/mm
    peak: float  # of the von Mises stress at the integration points in the zone, over nominal
    peak_at_corners: float  # of the same of the stress extrapolated to corners, mean of the elements there
    at: np.ndarray  # middle of the element with the peak, from the node


# --- solids -----------------------------------------------------------------------------------------------------------------------


def solids(out: Path) -> tuple[dict, dict[str, Path], dict[str, str]]:
    """The graph; name to STEP file, name to what it is."""
    from build123d import export_step

    graph = out / "stress.json"
    made = program.run("cell", "bcc", "--size", f"{generated.SIZE_MM:g}", "--radius", f"{RADIUS:g}", "-o", graph)
    files, words = {}, {}
    for name, options in (("ours", []), (f"ours, --blend {BLEND:g}", ["--blend", f"{BLEND:g}"])):
        files[name] = out / f"stress-{len(files)}.step"
        report = files[name].with_suffix(".report.json")
        if not made.ok or not (made := program.run("export", graph, "-q", "-o", files[name], "--report", report, *options)).ok:
            raise fea.NoAnswer(f"{made.command}: {made.last_words}")
        valley = json.loads(report.read_text())["concave_radius_mm"]["value"]
        words[name] = f"`lattice-brep {' '.join(['export', *options])}`; the tightest valley has a radius of {valley / RADIUS:.3f} r."
    lattice = json.loads(graph.read_text())
    files["sharp union"] = out / "stress-sharp.step"
    export_step(peers.fused(lattice), str(files["sharp union"]))
    words["sharp union"] = "cylinders and a node sphere of the struts' radius, one boolean union by build123d (OCC 8): the paper's original node."
    return lattice, files, words


# --- runs -------------------------------------------------------------------------------------------------------------------------


def press(step: Path, size: float, middle: np.ndarray, half: float, lattice: dict) -> Run:
    """Lower ends held, upper ends pushed down, neither free to move sideways."""
    points, hub = np.array(lattice["nodes"]), int(degrees(lattice).argmax())
    node, ends = points[hub], np.delete(points, hub, 0)
    mesh = fea.mesh(step, fea.Sizes(COARSE, size, tuple(middle - half), tuple(middle + half)))
    fixed, pulled = [], []
    for end in ends:
        length = np.linalg.norm(end - node)
        cap = np.flatnonzero((mesh.points - node) @ (end - node) / length > length - 1e-6)
        is_upper = end[2] > node[2]
        fixed += [(cap, 0, 0.0), (cap, 1, 0.0), (cap, 2, -PRESSED if is_upper else 0.0)]
        pulled += cap.tolist() if is_upper else []
    answer = fea.solve(mesh, fixed, np.array(pulled))
    middles = mesh.points[mesh.tetrahedra[:, :4]].mean(axis=1) - node
    is_near, is_fine = (np.abs(middles) < ZONE).all(axis=1), (np.abs(middles + node - middle) < half).all(axis=1)
    force = -answer.reaction[2]
    nominal = force / (4 * math.pi * RADIUS**2)
    stress = np.where(is_near, fea.von_mises(answer.stress).max(axis=1), 0)
    corners = np.unique(mesh.tetrahedra[is_near, :4])
    return Run(size, mesh, answer, is_fine, nominal, force / PRESSED / 1e3, stress.max() / nominal,
               fea.at_nodes(mesh, answer.stress)[corners].max() / nominal, middles[stress.argmax()])


def series(name: str, step: Path, lattice: dict) -> list[Run]:
    """The first run refines the whole node; each of the others a box around the last one's peak."""
    node = np.array(lattice["nodes"])[degrees(lattice).argmax()]
    runs = []
    for size in SIZES:
        middle, half = (node + runs[-1].at, min(FIRST, WIDE * size)) if runs else (node, WHOLE)
        runs.append(press(step, size, middle, half, lattice))
        print(*row(name, runs), sep="  ", flush=True)
    return runs


# --- page -------------------------------------------------------------------------------------------------------------------------


def fraction(size: float) -> str:
    return f"r/{RADIUS / size:g}"


def row(name: str, runs: list[Run]) -> list:
    """Of the last run."""
    run, before = runs[-1], runs[-2] if len(runs) > 1 else None
    fine, quality, straight = run.is_fine, run.mesh.quality, run.mesh.straightened
    change = lambda now, then: f"{100 * (now / then - 1):+.0f} %"  # noqa: E731
    return [name, fraction(run.size), len(fine), fine.sum(), small(float(quality.min())), small(float(quality[fine].min())), straight.sum(), straight[fine].sum(),
            f"{run.stiffness:.2f}", f"{run.peak:.2f}", change(run.peak, before.peak) if before else "", f"{run.peak_at_corners:.2f}",
            change(run.peak_at_corners, before.peak_at_corners) if before else "", ", ".join(f"{x:.2f}" for x in run.at.round(2) + 0.0), f"{run.answer.cpu_s:.0f}"]


def growth(angle: float) -> float:
    """Of the stress at the tip of a sharp notch when elements are halved: 2^(1 - k), k the least root of sin(k a) + k sin(a) = 0 for a solid of this angle a (Williams 1952)."""
    low, high = 0.5, 0.6  # angles from 240 to 360 degrees have it in between
    for _ in range(50):
        k = (low + high) / 2
        low, high = (k, high) if math.sin(k * angle) + k * math.sin(angle) > 0 else (low, k)
    return 2 ** (1 - low)


def page(found: dict[str, list[Run]], words: dict[str, str]) -> str:
    angle = 2 * math.asin(math.sqrt(1 / 3))  # between the struts of BCC that are nearest to each other
    last = [f"- {name}: {runs[-1].peak:.2f} at {fraction(runs[-1].size)}, {runs[-1].peak / runs[-2].peak:.2f} times that at {fraction(runs[-2].size)}; "
            f"at corners {runs[-1].peak_at_corners:.2f} and {runs[-1].peak_at_corners / runs[-2].peak_at_corners:.2f} times." for name, runs in found.items()]
    text = f"""# Stress at a node

Written by `validation/.venv/bin/python validation/stress.py`, after `validation/setup --stress` (CalculiX). Not part of the tests.

A BCC cell of {generated.SIZE_MM:g} mm with struts of radius r = {RADIUS:g} mm, its eight struts from the middle to the corners with flat ends. Lower ends are held, upper ends pushed down by {PRESSED:g} mm, all held sideways,
as in a layer of cells bonded between stiff plates. Linear elastic, E = {fea.MODULUS:g} MPa, Poisson's ratio {fea.POISSON:g}. Three solids of the same struts:

""" + "\n".join(f"- **{name}**: {what}" for name, what in words.items()) + f"""

**Peaks** are von Mises stresses within {ZONE / RADIUS:g} r of the node in each coordinate, over the nominal stress: the force over the sections of four struts, F / (4 pi r^2). Bending is not in the nominal stress. Two readings: at the
integration points, which lie inside the elements, and at the elements' corners, extrapolated and averaged over the elements there. Where a stress converges, both tend to the same.

## Result

""" + "\n".join(last) + f"""

In a sharp valley the stress is unbounded: where two struts meet at {math.degrees(angle):.1f}°, by theory (Williams) it grows {growth(2 * math.pi - angle):.2f} times with each halving of small elements, without end.

![Von Mises stress, and its peak against the size of the elements](pictures/stress.png)

Picture: elements of {fraction(SHOWN)}, stress extrapolated to the corners of each element, not averaged, over nominal. Only the valley with the peak has small elements; the others, with {fraction(COARSE)}, are alike but too coarse to show it.

"""
    text += "\n".join(table(HEAD, [row(name, runs[:k + 1]) for name, runs in found.items() for k in range(len(runs))]))
    return text + f"""
- Meshes: gmsh, whole solid as read from STEP, no repair, tetrahedra of ten nodes (C3D10). The size is that on the surface in a box; it grows by {fea.GROWTH:g} per length to {fraction(COARSE)}. The first run refines the whole node, each of the others a
  box of {2 * FIRST / RADIUS:g} r (at most {2 * WIDE} elements) around the peak of the one before.
- Quality: gmsh's minSICN of the curved elements, above 0 everywhere or the run is refused. Elements below {fea.QUALITY:g}, as arise where coarse ones bridge a tight valley, got straight edges first; how many, and how many of them in the box, is in the table.
- Patch test of the chain, in the same run: a box of 10 mm pressed by 1 %, E from the force and from the stress at all points, agrees to the seven digits that ccx prints.
"""


# --- picture ----------------------------------------------------------------------------------------------------------------------


def skin_values(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Corner points of all triangles of the surface (3 rows each), and the stress of the triangle's own element there, over nominal."""
    mesh = run.mesh
    values = fea.von_mises(fea.at_corners(run.answer.stress)) / run.nominal
    key = lambda corners: np.sort(corners, axis=1) @ np.array([1, 1 << 20, 1 << 40])  # noqa: E731
    sides = np.concatenate([np.column_stack([np.arange(len(mesh.tetrahedra)), key(np.delete(mesh.tetrahedra[:, :4], k, 1))]) for k in range(4)])
    sides = sides[np.argsort(sides[:, 1])]
    owner = sides[np.searchsorted(sides[:, 1], key(mesh.skin)), 0]
    corner = (mesh.tetrahedra[owner][:, None, :4] == mesh.skin[:, :, None]).argmax(axis=2)
    return mesh.points[mesh.skin].reshape(-1, 3), values[owner[:, None], corner].ravel()


def tile(run: Run, node: np.ndarray, size: int) -> Image.Image:
    """The node from the side of its peak, all struts cut by the picture's border."""
    points, values = skin_values(run)
    side = run.at * np.array([1, 1, 0])
    view = (math.degrees(math.atan2(side[1], side[0])) - 18, 14.0)
    project, axes = pictures.look(node + 1.9 * RADIUS * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]), view, size)
    triangles = np.arange(len(points)).reshape(-1, 3)
    _, owner, weights = pictures.rasterize(project(points), triangles, size)
    a, b, c = points[0::3], points[1::3], points[2::3]
    normals = np.zeros_like(run.mesh.points)
    np.add.at(normals, run.mesh.skin.ravel(), np.repeat(np.cross(b - a, c - a), 3, axis=0))
    colour = pictures.ramp(pictures.interpolate(values, triangles, owner, weights), (0.0, MOST))
    shaded = pictures.shade(pictures.interpolate(normals[run.mesh.skin.ravel()], triangles, owner, weights), axes, colour, 0.8)
    return Image.fromarray((np.where((owner >= 0)[..., None], shaded, 1.0) * 255).astype(np.uint8))


def curves(found: dict[str, list[Run]], size: int) -> Image.Image:
    image = Image.new("RGB", (size * figures.SUPER, size * figures.SUPER), "white")
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=15 * figures.SUPER)
    every = np.array([(run.size / RADIUS, run.peak) for runs in found.values() for run in runs])
    at_x, at_y = figures.frame(draw, (60, 40, size - 20, size - 70), every, ((0.005, 0.01, 0.02, 0.05, 0.1), (5, 7, 10, 15, 20, 30, 50)),
                               ("size of elements, r", "peak of von Mises stress, over nominal"))
    for k, ((name, runs), colour) in enumerate(zip(found.items(), LINES)):
        places = [(at_x(run.size / RADIUS), at_y(run.peak)) for run in runs]
        draw.line(figures.big(*places), fill=colour, width=2 * figures.SUPER)
        for x, y in places:
            draw.ellipse(figures.big((x - 4, y - 4), (x + 4, y + 4)), fill=colour)
        draw.text(figures.big((size - 34, 56 + 22 * k))[0], name, fill=colour, font=font, anchor="ra")
    return image.resize((size, size), Image.Resampling.LANCZOS)


def draw(found: dict[str, list[Run]], node: np.ndarray) -> None:
    size = 480
    image = Image.new("RGB", (2 * size, 2 * size + 100), "white")
    ink, font = ImageDraw.Draw(image), ImageFont.load_default(size=17)
    places = [(0, 0), (size, 0), (0, size)]
    for (name, runs), (x, y) in zip(found.items(), places):
        run = next(run for run in runs if run.size == SHOWN)
        image.paste(tile(run, node, size * figures.SUPER).resize((size, size), Image.Resampling.LANCZOS), (x, y))
        ink.text((x + 12, y + 10), name, fill=figures.INK, font=font)
    image.paste(curves(found, size), (size, size))
    pictures.legend(image, (0.0, MOST), f"von Mises stress over nominal, elements of {fraction(SHOWN)}")
    pictures.save(image, "stress")


def main() -> int:
    if not shutil.which("ccx"):
        raise fea.NoAnswer("no ccx: run `validation/setup --stress`")
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    patch = fea.patch_test(out)
    if not patch < PATCH_LIMIT:
        raise fea.NoAnswer(f"patch test: off by {patch:.1e}, wanted {PATCH_LIMIT:g}")
    lattice, files, words = solids(out)
    found = {name: series(name, step, lattice) for name, step in files.items()}
    PAGE.write_text(page(found, words))
    draw(found, np.array(lattice["nodes"])[degrees(lattice).argmax()])
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (program.NotBuilt, fea.NoAnswer) as fault:
        sys.exit(f"stress: {fault}")
