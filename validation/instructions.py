#!/usr/bin/env python3
"""Counts the instructions (callgrind) that the recorded nodes take, and fails where a count grew by more than a tenth.

`--record` writes the counts of this build to instructions.json. Counts hold for the release profile and for machines with AVX2: vector width is
chosen at run time, so others are not compared. Valgrind shows no AVX-512, so wider machines count the same.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import program

RECORD = Path(__file__).with_suffix(".json")
MOST_GROWTH = 1.1
FALL_TO_TELL = 0.9  # a count this far below its record leaves room for what was gained to be lost again
VECTORS = {"avx2", "fma"}


def lattice_brep(*words: str, before: tuple[str, ...] = ()) -> str:
    """What the program, or valgrind with it, says on its error stream."""
    done = subprocess.run([*before, str(program.binary()), *words], cwd=program.ROOT, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"instructions: `{' '.join(words)}`: exit code {done.returncode}: {done.stderr.strip()[-400:]}")
    return done.stderr


def count(row: dict) -> int:
    with tempfile.TemporaryDirectory() as folder:
        graph = row["graph"]
        if graph.startswith("cell "):
            graph = f"{folder}/graph.json"
            lattice_brep(*row["graph"].split(), "-o", graph)
        words = [word.format(graph=graph, step=f"{folder}/node.step") for word in row["export"].split()]
        said = lattice_brep(*words, before=("valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/counts"))
    return int(re.search(r"Collected : (\d+)", said)[1])


def grown(recorded: dict, counted: dict[str, int]) -> list[str]:
    """Why the counts are not within their record."""
    return [f"{name}: {counted[name]:,} instructions, {counted[name] / row['instructions'] - 1:+.1%} of the record {row['instructions']:,}"
            for name, row in recorded.items() if counted[name] > MOST_GROWTH * row["instructions"]]


def vectors() -> set[str]:
    flags = re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(), re.M)
    return VECTORS & set(flags[1].split() if flags else ())


def main() -> int:
    say = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    say.add_argument("--record", action="store_true", help="write this build's counts to instructions.json")
    args = say.parse_args()
    recorded = json.loads(RECORD.read_text())
    if vectors() != VECTORS:
        print(f"instructions: not compared: the record is of a machine with {' and '.join(sorted(VECTORS))}")
        return 0
    counted = {name: count(row) for name, row in recorded.items()}
    for name, row in recorded.items():
        change = counted[name] / row["instructions"]
        note = ", so far below that --record is due" if change < FALL_TO_TELL else ""
        print(f"instructions: {name} node: {counted[name] / 1e6:.1f} M, {change - 1:+.1%} of the record{note}")
    if args.record:
        RECORD.write_text(json.dumps({name: {**row, "instructions": counted[name]} for name, row in recorded.items()}, indent=2) + "\n")
        return 0
    faults = grown(recorded, counted)
    for fault in faults:
        print(f"instructions: FAIL {fault}", file=sys.stderr)
    if faults:
        print("instructions: if the growth is meant: validation/instructions.py --record, and say why in docs/performance.md", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except program.NotBuilt as fault:
        sys.exit(f"instructions: {fault}")
