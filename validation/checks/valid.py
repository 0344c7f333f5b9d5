"""Is the shape valid? BRepCheck in OCC 8 (build123d), and `isValid` and `check(True)` in OCC 7.6 (FreeCAD).

Necessary, not sufficient: BRepCheck passes a tube swept through itself, an open shell and two overlapping boxes.
`check(True)` adds OCC's own test for self-intersection and small edges, and grows with the square of crowded faces;
`expected["freecad_seconds"]` (of CPU) boxes it (0 leaves FreeCAD out: then only OCC 8 has judged).
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
from pathlib import Path

from OCP.BRepCheck import BRepCheck_Analyzer

import timebox
from checks import main, verdict
from model import EDGE, FACE, VERTEX, load, unique

HELPER = Path(__file__).resolve().parent.parent / "freecad_check.py"
FREECAD_LIB = "/usr/lib/freecad-python3/lib"  # where Debian keeps FreeCAD's Python modules
DEBIAN_PYTHON = "/usr/bin/python3"
# check(True) takes about 1 MB a face (measured: 11 GB for 12,000 faces), so of large files one at a time.
LARGE_BYTES = 20_000_000
ONE_AT_A_TIME = multiprocessing.get_context("fork").Lock()


def in_occ8(model) -> list[str]:
    analyzer = BRepCheck_Analyzer(model.shape, True)
    if analyzer.IsValid():
        return []
    bad = {name: sum(not analyzer.IsValid(sub) for sub in unique(model.shape, kind))
           for name, kind in (("faces", FACE), ("edges", EDGE), ("vertices", VERTEX))}
    return [f"OCC 8: BRepCheck finds the shape invalid ({', '.join(f'{n} {k}' for k, n in bad.items())})"]


def in_freecad(path: Path, seconds: float, deep: bool) -> dict:
    """FreeCAD's answer, or {'error': ...}."""
    command = [DEBIAN_PYTHON, str(HELPER), "--deep" if deep else "--shallow", str(path)]
    environment = {**os.environ, "PYTHONPATH": FREECAD_LIB}
    environment.pop("PYTHONHOME", None)
    done = timebox.run(command, seconds, env=environment)
    if done is None:
        return {"error": f"no answer in {seconds:g} CPU s, or killed for want of memory"}
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines:
        return {"error": f"exit code {done.returncode}: {(done.stderr or done.stdout).strip()[-300:]}"}
    return json.loads(lines[-1])


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    why = in_occ8(model)
    seconds = expected.get("freecad_seconds", 600)
    figures = {"occ8": not why}
    if seconds:
        deep = expected.get("freecad_deep", True)
        with ONE_AT_A_TIME if deep and model.path.stat().st_size > LARGE_BYTES else contextlib.nullcontext():
            answer = in_freecad(model.path, seconds, deep)
        figures["freecad"] = answer
        if "error" in answer:
            why.append(f"FreeCAD: {answer['error']}")
        else:
            if not answer["valid"]:
                why.append("FreeCAD: isValid says no")
            for fault in answer["faults"]:
                why.append(f"FreeCAD: check(True): {fault}")
            solids = expected.get("components", 1)
            if answer["solids"] != solids or answer["loose_faces"]:
                why.append(f"FreeCAD: {answer['solids']} solids and {answer['loose_faces']} loose faces, wanted {solids} and 0")
    return verdict(why, **figures)


if __name__ == "__main__":
    main(check)
