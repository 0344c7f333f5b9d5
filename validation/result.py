"""A case's result: {name, ok, checks: {name: answer}, wall_s, ...}."""

from __future__ import annotations

import time
from pathlib import Path

import checks
import program
import report_fields


def cost(ran: program.Ran) -> dict:
    return {"wall_s": round(ran.wall_s, 2), "cpu_s": round(ran.cpu_s, 2), "peak_mb": round(ran.peak_mb)}


def told(step: Path, report: dict) -> dict:
    """What our own report says, for the tables, and the size of the file."""
    return {"bytes": step.stat().st_size, **{name: getattr(report_fields, name)(report) for name in ("counts", "rungs", "shrunk", "quality", "lowered", "changes")}}


def fell(result: dict, stage: str, ran: program.Ran) -> dict:
    result["checks"][stage] = checks.verdict([f"exit code {ran.code} of `{ran.command}`: {ran.last_words}"])
    result["exit_code"] = ran.code
    return finish(result, time.monotonic() - ran.wall_s)


def finish(result: dict, start: float) -> dict:
    result["ok"] = all(found["ok"] for found in result["checks"].values())
    result["wall_s"] = round(time.monotonic() - start, 2)
    return result
