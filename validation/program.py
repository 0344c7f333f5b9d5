"""Finds and runs the release binary, and measures what it costs."""

from __future__ import annotations

import functools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


class NotBuilt(Exception):
    pass


@functools.cache  # judged once, not at each run of the program
def binary() -> Path:
    if "LATTICE_BREP" in os.environ:
        found = Path(os.environ["LATTICE_BREP"])
    else:
        found = Path(os.environ.get("CARGO_TARGET_DIR", "target"))
        found = (found if found.is_absolute() else ROOT / found) / "release" / "lattice-brep"
    if not os.access(found, os.X_OK):
        raise NotBuilt(f"no program at {found}: run `cargo build --release`, or set LATTICE_BREP")
    if "LATTICE_BREP" not in os.environ:
        sources = [path for folder in ("src", "step_templates") for path in (ROOT / folder).rglob("*.*")]
        newer = [path for path in sources if path.stat().st_mtime > found.stat().st_mtime]
        if newer:
            raise NotBuilt(f"{found} is older than {newer[0].relative_to(ROOT)}: run `cargo build --release`, or set LATTICE_BREP")
    return found


@dataclass
class Ran:
    command: str
    code: int
    said: str
    wall_s: float
    cpu_s: float
    peak_mb: float

    @property
    def ok(self) -> bool:
        return self.code == 0

    @property
    def last_words(self) -> str:
        return self.said.strip()[-400:]


# Started between us and the program, so that the peak memory is the program's own: a child counts the size of the process it was forked
# from, and ours holds two kernels.
WATCH = """
import json, os, resource, signal, subprocess, sys
done = subprocess.run(sys.argv[3:], stdin=subprocess.DEVNULL, stdout=open(sys.argv[2], "w"), stderr=subprocess.STDOUT)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
json.dump([done.returncode, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024], open(sys.argv[1], "w"))
"""


def run(*arguments: str | Path, seconds: float = 3600) -> Ran:
    command = [str(binary()), *map(str, arguments)]
    shown = " ".join(["lattice-brep", *map(str, arguments)])
    with tempfile.TemporaryDirectory() as folder:
        used, said = Path(folder) / "used", Path(folder) / "said"
        start = time.monotonic()
        watcher = subprocess.Popen([sys.executable, "-I", "-S", "-c", WATCH, str(used), str(said), *command], start_new_session=True)
        try:
            watcher.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(watcher.pid, signal.SIGKILL)
            watcher.wait()
            return Ran(shown, -signal.SIGKILL, f"stopped after {seconds:g} s", seconds, 0.0, 0.0)
        wall = time.monotonic() - start
        code, cpu, peak = json.loads(used.read_text())
        return Ran(shown, code, said.read_text(errors="replace"), wall, cpu, peak)
