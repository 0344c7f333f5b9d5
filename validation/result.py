"""A case's result: {name, ok, checks: {name: answer}, wall_s, ...}."""

from __future__ import annotations

import time

import checks
import program


def fell(result: dict, stage: str, ran: program.Ran) -> dict:
    result["checks"][stage] = checks.verdict([f"exit code {ran.code} of `{ran.command}`: {ran.last_words}"])
    result["exit_code"] = ran.code
    return finish(result, time.monotonic() - ran.wall_s)


def finish(result: dict, start: float) -> dict:
    result["ok"] = all(found["ok"] for found in result["checks"].values())
    result["wall_s"] = round(time.monotonic() - start, 2)
    return result
