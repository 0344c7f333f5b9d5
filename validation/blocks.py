"""`export --blocks`: the list of files, each block by itself, and whether OCC 8 (XDE) opens the master with all blocks by its references.

    validation/.venv/bin/python validation/blocks.py GRAPH N       the same for any lattice, with figures
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import time
from pathlib import Path

import assembly
import checks
import program
from model import Model
from result import cost, fell, finish

CELL, REPEAT, COUNT = "bcc", "2x1x1", 3
CLOSE = 1e-9  # volumes, relative
ALONE = ("text", "senses", "valid", "one_solid", "volume_area", "tolerances", "continuity", "fold")  # what a block must pass by itself


def faults_of_list(folder: Path, manifest: dict, volume: float) -> list[str]:
    """What is wrong with the list of files: hashes, sizes, sums."""
    why = []
    for entry in [*manifest["blocks"], manifest["master"]]:
        held = (folder / entry["file"]).read_bytes()
        if (hashlib.sha256(held).hexdigest(), len(held)) != (entry["sha256"], entry["bytes"]):
            why.append(f"{entry['file']}: not the bytes that the list says")
    for name in ("solids", "nodes", "volume_mm3", "area_mm2"):
        total = sum(block[name] for block in manifest["blocks"])
        if abs(total / manifest[name] - 1) > 1e-12:
            why.append(f"{name}: {total} in the blocks, {manifest[name]} in the list")
    if abs(manifest["volume_mm3"] / volume - 1) > CLOSE:
        why.append(f"volume {manifest['volume_mm3']} mm3, wanted {volume}")
    return why


def look(result: dict, graph: Path, count: int, radius: float, out: Path) -> None:
    """Exports a lattice in blocks and as one solid, and runs all checks."""
    master, one = out / "blocks.step", out / "one-solid.step"
    reports = {}
    for step, options in ((master, ["--blocks", count]), (one, [])):
        report = step.with_suffix(".report.json")
        done = program.run("export", graph, "-o", step, "--report", report, *options)
        if not done.ok:
            fell(result, "export", done)
            return
        reports[step] = json.loads(report.read_text())
        result.setdefault("export", cost(done))
    manifest = json.loads((out / "blocks.blocks.json").read_text())
    volume = reports[one]["volume_mm3"]
    result["checks"]["list"] = checks.verdict(faults_of_list(out, manifest, volume))
    for k, block in enumerate(manifest["blocks"], 1):
        model = Model(out / block["file"])
        expected = {"components": block["solids"], "radius_mm": radius, "volume_mm3": block["volume_mm3"], "area_mm2": block["area_mm2"]}
        found = {name: checks.run(name, model, expected) for name in ALONE}
        why = [f"{name}: {w}" for name, answer in found.items() for w in answer["why"]]
        result["checks"][f"block {k}"] = checks.verdict(why, gap_mm=found["continuity"].get("gap_mm"))
    in_occ = assembly.opened(master)
    if "error" in in_occ:
        result["checks"]["xde"] = checks.verdict([in_occ["error"]])
        return
    in_occ["volume off"] = abs(in_occ["volume_mm3"] / volume - 1)
    why = [f"{name} {in_occ[name]}, wanted {count}" for name in ("parts", "instances") if in_occ[name] != count]
    if in_occ["volume off"] > CLOSE:
        why.append(f"volume {in_occ['volume_mm3']} mm3, wanted {volume}")
    result["checks"]["xde"] = checks.verdict(why if in_occ["valid"] else [*why, "not valid"], **in_occ)


def judge(out: Path) -> dict:
    """A few cells in blocks, against the same cells as one solid."""
    result = {"name": f"blocks of {CELL} {REPEAT}", "detail": {}, "checks": {}}
    start = time.monotonic()
    with tempfile.TemporaryDirectory(dir=out) as folder:
        graph = Path(folder) / "graph.json"
        done = program.run("cell", CELL, "--size", "10", "--repeat", REPEAT, "--radius", "0.5", "-o", graph)
        if not done.ok:
            return fell(result, "cell", done)
        look(result, graph, COUNT, 0.5, Path(folder))
    return finish(result, start)


if __name__ == "__main__":
    from graphs import least_radius

    told = {"name": sys.argv[1], "checks": {}}
    with tempfile.TemporaryDirectory() as scratch:
        look(told, Path(sys.argv[1]), int(sys.argv[2]), least_radius(json.loads(Path(sys.argv[1]).read_text())), Path(scratch))
        print((Path(scratch) / "blocks.blocks.json").read_text())
    print(json.dumps(told, indent=1))
