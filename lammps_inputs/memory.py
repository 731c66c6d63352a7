"""Available memory, and refusal of work that does not fit into it."""

from __future__ import annotations

import os
from pathlib import Path

from granwave.lammps_inputs.errors import InputError


def refuse_too_large(what: str, memory: float, remedy: str, available: float | None = None) -> None:
    """Raise InputError if ``what`` needs more ``memory`` than ``available``, bytes (default: that of the machine)."""
    available = available_memory() if available is None else available
    if memory > available:
        raise InputError(
            f"{what} need about {memory / 2**30:.1f} GiB of memory, there is {available / 2**30:.1f} GiB; "
            f"{remedy} or change machine"
        )


def available_memory() -> float:
    """Return the memory that is available to a new program on this machine, bytes."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024
    except OSError:
        pass  # not Linux: fall back on the total memory
    return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
