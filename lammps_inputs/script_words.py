"""Words of LAMMPS commands: numbers and lists of them."""

from __future__ import annotations

import sys
from collections.abc import Iterable


def num(value: float) -> str:
    """Format a number with the fewest digits that reproduce it exactly; 0 below the smallest number
    that LAMMPS reads in formulas.
    """
    if 0 < abs(value) < sys.float_info.min:
        return "0"
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def joined(values: Iterable[object]) -> str:
    """Join values with spaces."""
    return " ".join(str(value) for value in values)
