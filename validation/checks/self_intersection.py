"""Does the surface cut itself? OCC 8's BOPAlgo_ArgumentAnalyzer, in a forked process with a time limit.

Its cost grows faster than the faces (400 faces: 3 s; 3,500: 150 s), so it is for small cases.
`expected["self_intersection_seconds"]`: the limit in CPU seconds (120); a limit reached is a failure, 0 skips the check.
`expected["self_intersection_faces"]`: more faces than this, and the check is skipped (no bound if not given).
"""

from __future__ import annotations

import os
import signal

from OCP.BOPAlgo import BOPAlgo_ArgumentAnalyzer

import timebox
from checks import main, verdict
from model import load


def analyse(shape) -> bool:
    analyzer = BOPAlgo_ArgumentAnalyzer()
    analyzer.SetShape1(shape)
    analyzer.ArgumentTypeMode = True
    analyzer.SelfInterMode = True
    analyzer.SmallEdgeMode = True
    analyzer.Perform()
    return analyzer.HasFaulty()


def check(model_or_path, expected: dict) -> dict:
    seconds = int(expected.get("self_intersection_seconds", 120))
    if not seconds:
        return verdict([], skipped=True)
    model = load(model_or_path)
    if len(model.faces) > expected.get("self_intersection_faces", len(model.faces)):
        return verdict([], skipped=True)
    child = os.fork()
    if child == 0:
        timebox.limit_cpu(seconds)
        code = 3
        try:
            code = 1 if analyse(model.shape) else 0
        finally:
            os._exit(code)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    why = {0: [], 1: ["the shape cuts itself or has edges too small to tell"], -signal.SIGXCPU: [f"no answer in {seconds} CPU s"]}.get(
        status, [f"the analyser died with status {status}"])
    return verdict(why)


if __name__ == "__main__":
    main(check)
