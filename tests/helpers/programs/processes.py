"""Processes that tests start, watch and kill."""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def wait_for(
    condition: Callable[[], Any],
    patience: float = 120,
    *,
    beside: subprocess.Popen[str] | None = None,
) -> Any:
    """Wait until the condition is true, while another process runs; return its value."""
    end = time.monotonic() + patience
    while not (found := condition()):
        if beside is not None:
            assert beside.poll() is None, beside.communicate()
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.02)
    return found


def children(process: int) -> list[int]:
    """Process ids of the children."""
    found: list[int] = []
    for path in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            found += map(int, path.read_text().split())
    return found


def alive(process: int) -> bool:
    """Return True for an existing process that has not ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
