"""One question a file. Each has `check(model_or_path, expected) -> dict` with `ok`, `why` (what is wrong, empty when ok) and figures.

`expected` is a plain dict; a check takes from it what it needs and skips a comparison whose figure is not there
(except where its docstring says that the figure is required). Lengths in mm, angles in degrees.
"""
from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

ALL = ("report", "text", "senses", "valid", "one_solid", "counts", "radii", "volume_area", "volume_bound", "tolerances", "continuity", "fold",
       "self_intersection", "meshable")


def verdict(why: list[str], **figures) -> dict:
    return {"ok": not why, "why": why, **figures}


def run(name: str, model, expected: dict) -> dict:
    """One check by name; a check that falls over has failed."""
    try:
        return importlib.import_module(f"checks.{name}").check(model, expected)
    except Exception as fault:  # noqa: BLE001 - whatever a kernel throws is a failed check, not the end of the run
        return verdict([f"{type(fault).__name__}: {fault}"])


def main(check) -> None:
    """Command line of a single check: FILE.step [EXPECTED.json]."""
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    expected = json.loads(Path(sys.argv[2]).read_text()) if len(sys.argv) > 2 else {}
    result = check(sys.argv[1], expected)
    print(json.dumps(result, indent=1, default=str))
    sys.exit(0 if result["ok"] else 1)
