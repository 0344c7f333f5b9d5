"""Limits in CPU seconds, so that a busy machine does not turn a sound solid into a failure; the wall clock gets `PATIENCE` times as long."""

from __future__ import annotations

import resource
import signal
import subprocess

PATIENCE = 8


def limit_cpu(seconds: float) -> None:
    """For the process that calls it: the system ends it with SIGXCPU, even inside a kernel's own loops."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 10))


def run(command: list[str], seconds: float, **how) -> subprocess.CompletedProcess | None:
    """The finished process, or None when it ran out of time."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE * seconds, stdin=subprocess.DEVNULL,
                              preexec_fn=lambda: limit_cpu(seconds), **how)
    except subprocess.TimeoutExpired:
        return None
    return None if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL) else done
