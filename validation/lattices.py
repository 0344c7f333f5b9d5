"""Real lattices from a folder: each whole, as it is and with radii shrunk where they must be, and a block of each."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import cases
import checks
import program
from graphs import least_radius
from result import cost, fell, finish, told

READ = (".json", ".3mf")
BLOCK_STRUTS = 400  # FreeCAD takes ten minutes for twice as many
SHRINK = ("--on-conflict", "shrink")  # changes nothing where everything fits
REFUSED = (2, 3)  # exit codes: bad input, cannot be built


def found(folder: Path, out: Path) -> list[Path]:
    """All lattices of the folder, as the program's own JSON in mm."""
    graphs = []
    for path in sorted(p for p in folder.iterdir() if p.suffix in READ):
        graph = out / f"{path.stem}.lattice.json"
        made = program.run("repair", path, "-o", graph)
        if not made.ok:
            raise SystemExit(f"{path}: {made.last_words}")
        graphs.append(graph)
    return graphs


def name(path: Path) -> str:
    return path.name.removesuffix(".lattice.json")


def struts(path: Path) -> int:
    return len(json.loads(path.read_text())["struts"])


def block(path: Path) -> cases.Case:
    """A box cut out of the middle, for the kernels: large lattices cost them minutes and gigabytes."""
    graph = json.loads(path.read_text())
    return cases.Case(f"{name(path)} block", graph=path, crop=cases.middle_box(graph, BLOCK_STRUTS), radius_mm=least_radius(graph), options=SHRINK,
                      skip=("volume_bound", "meshable"), limits={"freecad_seconds": 7200, "self_intersection_faces": 400, "g0_allowed": 0})


def whole(path: Path, case: str, shrink: bool, out: Path) -> dict:
    """A whole lattice, judged by our own checks and the Rust reader. Without `shrink` it may be refused with its reasons."""
    result = {"name": case, "detail": {}, "checks": {}}
    start = time.monotonic()
    step, report_path = out / f"{name(path)}.step", out / f"{name(path)}.report.json"
    done = program.run("export", path, "-o", step, "--report", report_path, *(SHRINK if shrink else ()))
    result["export"] = cost(done)
    if not done.ok:
        result = fell(result, "export", done)
        result["refused"] = done.code in REFUSED and not shrink
        return result
    graph, report = json.loads(path.read_text()), json.loads(report_path.read_text())
    nodes = len(graph["nodes"])
    # at most 1 % of the nodes (rounded up) below the first rung, none with sharp creases
    expected = cases.expected(cases.Case(case, limits={"g0_allowed": 0, "lowered_allowed": math.ceil(nodes / 100)}), graph, report)
    result.update(told(step, report))
    result["checks"]["report"] = checks.run("report", None, expected)
    circles = 0
    with step.open("rb") as lines:
        for line in lines:
            circles += line.count(b"CIRCLE(")
    wanted = 2 * expected["struts"]
    result["checks"]["circles"] = checks.verdict([] if circles == wanted else [f"CIRCLE entities: {circles}, wanted {wanted}"])
    read = program.run("check", step)
    result["checks"]["rust_reader"] = checks.verdict([] if read.ok else [f"exit code {read.code}: {read.last_words}"],
                                                     wall_s=round(read.wall_s, 1), peak_mb=round(read.peak_mb))
    step.unlink()  # hundreds of megabytes
    return finish(result, start)
