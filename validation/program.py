"""Finds and runs the release binary, and measures what it costs."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


class NotBuilt(Exception):
    pass


def binary() -> Path:
    if "LATTICE_BREP" in os.environ:
        found = Path(os.environ["LATTICE_BREP"])
    else:
        found = Path(os.environ.get("CARGO_TARGET_DIR", "target"))
        found = (found if found.is_absolute() else ROOT / found) / "release" / "lattice-brep"
    if not os.access(found, os.X_OK):
        raise NotBuilt(f"no program at {found}: run `cargo build --release`, or set LATTICE_BREP")
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


def run(*arguments: str | Path, seconds: float = 3600) -> Ran:
    command = [str(binary()), *map(str, arguments)]
    with tempfile.TemporaryFile("w+") as said:
        start = time.monotonic()
        child = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        timer = None
        if seconds:
            import threading

            timer = threading.Timer(seconds, child.kill)
            timer.start()
        _, status, usage = os.wait4(child.pid, 0)  # unlike `Popen.wait`, it tells what the child used
        if timer:
            timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        wall = time.monotonic() - start
        said.seek(0)
        text = said.read()
    return Ran(" ".join(["lattice-brep", *map(str, arguments)]), child.returncode, text, wall,
               usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)
