"""Table 2 of Luo & Zou 2025 on nine own parts of the same sizes, meshed on the spot, and the time of a node by its degree.

    validation/.venv/bin/python validation/table2.py          writes docs/table2.md

Needs gmsh (validation/setup) and Debian's TetGen. Meshes are kept in validation/out/table2: remove it after a change of parts.py.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import parts
import program

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs" / "table2.md"
OUT = HERE / "out" / "table2"
COMMAND = "validation/.venv/bin/python validation/table2.py"

# in the order of the paper's rows: its edges, our part, the size of its surface's triangles in mm
MODELS = {
    "heat-exchanger": (6125, parts.heat_exchanger, 16),
    "lever-arm": (12960, parts.lever_arm, 6.7),
    "mounting-bracket": (24685, parts.mounting_bracket, 5.4),
    "surfacing-mold": (26813, parts.surfacing_mold, 7.7),
    "engine-bracket": (33005, parts.engine_bracket, 4.6),
    "bevel-gear": (38325, parts.bevel_gear, 6.0),
    "pipe-holder": (46331, parts.pipe_holder, 6.0),
    "impeller": (47377, parts.impeller, 4.9),
    "gear-box": (79200, parts.gear_box, 5.4),
}
AT_ONCE = 2  # lattices timed at once, each on one thread
BOWED, PIECES, RISE = "heat-exchanger", 4, 0.02  # of this one each edge is a bow

INTRODUCTION = f"""# Table 2 of the paper, beside ours

`{COMMAND}` writes this page. Other work was running on the machine; two lattices were timed at once. CPU times are noise by up to a factor of two then, the largest more than the averages.

The paper's models are not published. Ours are nine parts of its names, made of boxes, cylinders and cones ([`validation/parts.py`](../validation/parts.py)): their surfaces in triangles of one size by gmsh,
filled by Debian's TetGen (`-pq{parts.QUALITY}a...`), its bound on volumes tuned until there are as many edges as in the paper's row, to {100 * parts.MOST_OFF:g} %. Each edge is a strut; its radius is an eighth of the shortest edge
(`--radius-rule shortest/8`). One run of each node, CPU time of its thread. Struts that overlap away from their nodes, as in sliver tetrahedra, are kept.

The Heat Exchanger has 1.25 edges a node: no tetrahedral mesh. Ours is a mesh of a quarter of the edges, each of them a bow of {PIECES} straight struts that rises by {RISE:g} of its length, which gives both of the paper's counts; nine of ten nodes have
degree 2. The paper's times of this row are those of its other rows all the same, as if all of its nodes had their degrees.

Smoothing is the fairing of the control mesh in both. Construction is the paper's film and its subdivision, without patches, on a 5.2 GHz machine, wall time; ours is all that export does for a node before solids: film, patches, at two degrees
where the first misses the tolerance, and their checks.
"""


def counted(name: str, surface: parts.Mesh, size_mm: float) -> int:
    """Fill the part with tetrahedra of at most this size; how many struts there are."""
    _, tetrahedra = parts.tetgen(*surface, size_mm, OUT / name)
    return len(parts.edges(tetrahedra)) * (PIECES if name == BOWED else 1)


def lattice(name: str) -> Path:
    """The part's lattice, from the cache if it is there."""
    wanted, part, size_mm = MODELS[name]
    to = OUT / f"{name}.obj" if name == BOWED else OUT / f"{name}.ele"
    done = OUT / f"{name}.done"
    if done.exists():
        return to
    surface = parts.surface(part, size_mm)
    size, found = parts.tuned(lambda size: counted(name, surface, size), wanted, size_mm)
    if name == BOWED:
        points, tetrahedra = parts.read(OUT / name)
        to.write_text(obj(*parts.bowed(points, parts.edges(tetrahedra), PIECES, RISE)))
    done.write_text(f"{size} {found}\n")
    print(f"{name}: {found} edges of about {size:.3g} mm, {found / wanted - 1:+.1%}", flush=True)
    return to


def obj(points: np.ndarray, pairs: np.ndarray) -> str:
    return "".join([*(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()), *(f"l {a + 1} {b + 1}\n" for a, b in pairs.tolist())])


def tables(printed: str) -> tuple[list[str], list[list[str]], list[list[float]]]:
    """Of what `bench table` has printed: the models' head, the models' rows, and the numbers of the rows by degree."""
    models, degrees = (table.splitlines() for table in printed.strip().split("\n\n"))
    split = [[cell.strip() for cell in line.strip("|").split("|")] for line in models[2:]]
    return models[:2], split, [[float(cell) for cell in line.strip("|").split("|")] for line in degrees[2:]]


def together(rows: list[list[float]]) -> list[float]:
    """Rows of one degree: their nodes, and least, largest and mean of smoothing and of construction."""
    nodes = sum(row[1] for row in rows)
    three = ([min(row[at] for row in rows), max(row[at + 1] for row in rows), sum(row[1] * row[at + 2] for row in rows) / nodes] for at in (2, 5))
    return [rows[0][0], nodes, *(number for numbers in three for number in numbers)]


def page(printed: list[str]) -> str:
    """From what `bench table` has printed of each of the nine lattices, in their order."""
    found = [tables(text) for text in printed]
    head, papers = found[0][0], found[0][1][: len(MODELS)]
    pairs = [row for paper, (_, rows, _) in zip(papers, found) for row in (paper, rows[-1])]
    if [row[0] for row in pairs[1::2]] != list(MODELS) or any(not row[0].startswith("paper: ") for row in pairs[::2]):
        raise ValueError(f"other rows than those of the nine lattices: {pairs}")
    by_degree: dict[float, list[list[float]]] = {}
    for row in (row for _, _, rows in found for row in rows):
        by_degree.setdefault(row[0], []).append(row)
    ratios = {what: [float(paper[at]) / float(own[at]) for paper, own in zip(pairs[::2], pairs[1::2])][1:] for what, at in (("smoothing", 6), ("construction", 9))}
    shown = " and ".join(f"{min(ratio):.0f} to {max(ratio):.0f} times for {what}" for what, ratio in ratios.items())
    degrees = [["degree", "nodes", "smoothing min, ms", "max", "avg", "construction min, ms", "max", "avg"], ["---"] * 8]
    degrees += [[f"{row[0]:.0f}", f"{row[1]:.0f}", *(f"{number:.2f}" for number in row[2:])] for row in (together(by_degree[degree]) for degree in sorted(by_degree))]
    line = "| {} |".format
    return "\n".join([
        INTRODUCTION, *head, *(line(" | ".join(row)) for row in pairs), "",
        f"The paper's averages over ours, all rows but the Heat Exchanger's: {shown}. Neither the machines nor, for construction, the work are the same.", "",
        "## By degree", "", "All nodes of two struts and more of the nine lattices together.", "", *(line(" | ".join(row)) for row in degrees), ""])


def printed(name: str) -> str:
    """What `bench table` prints of the lattice, now or in a run before that did not come to its end."""
    kept = OUT / f"{name}.printed.md"
    if kept.exists():
        return kept.read_text()
    done = program.run("bench", "table", lattice(name), "--radius-rule", "shortest/8")
    if not done.ok:
        raise RuntimeError(f"{done.command}: {done.last_words}")
    print(f"{name}: {done.cpu_s:.0f} s of CPU time", flush=True)
    kept.write_text(done.said)
    return done.said


def main() -> None:
    program.binary()  # there, before anything is meshed
    OUT.mkdir(parents=True, exist_ok=True)
    for name in MODELS:
        lattice(name)
    with ThreadPoolExecutor(AT_ONCE) as pool:
        times = {name: pool.submit(printed, name) for name in reversed(MODELS)}  # the largest first
        PAGE.write_text(page([times[name].result() for name in MODELS]))
    for name in MODELS:
        (OUT / f"{name}.printed.md").unlink()


if __name__ == "__main__":
    try:
        main()
    except (program.NotBuilt, parts.NoTetGen) as missing:
        sys.exit(str(missing))
