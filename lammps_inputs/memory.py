"""Memory of this machine, and the refusal of what does not fit into it."""

from __future__ import annotations

import os
from pathlib import Path

from granwave.lammps_inputs.errors import InputError


def refuse_too_large(what: str, memory: float, remedy: str, available: float | None = None) -> None:
    """Raise InputError where ``what`` needs more ``memory`` than is ``available``, bytes; by default what is free."""
    available = available_memory() if available is None else available
    if memory > available:
        raise InputError(
            f"{what} need about {memory / 2**30:.1f} GiB of memory, there is {available / 2**30:.1f} GiB; "
            f"{remedy} or change machine"
        )


def available_memory() -> float:
    """Bytes of memory that this machine could still give to a program."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024
    except OSError:
        pass  # not Linux: fall back on the memory that the machine has
    return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
