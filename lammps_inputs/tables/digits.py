"""Digits with which the numbers of a column were written.

A number in a file represents all numbers that round to it: its error is up to half a unit of its
last digit. Trailing zeros may be missing (``%g``), so that the last place follows from all
coordinates together: either all numbers have as many decimals, or the longest has all its
significant digits. For a few short numbers typed by hand, the error is not reliable.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_NUMBER = re.compile(r"[-+]?([0-9]*)[.,]?([0-9]*)(?:[eE]([-+]?[0-9]+))?")
_SAMPLE = 2000  # most numbers that are checked


def half_units(texts: Sequence[str], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return half a unit of the last digit of each number, in its unit, in the shape of the values.

    Parameters
    ----------
    texts
        Some of the numbers, as they were written.
    values
        All numbers.
    """
    decimals: set[int] = set()
    significant = 1
    for text in texts:
        match = _NUMBER.fullmatch(text.strip())
        if match is None:
            continue
        whole, fraction, exponent = match.groups()
        figures = len((whole + fraction).lstrip("0"))
        if not figures:
            continue  # only the decimals of a zero are known
        decimals.add(len(fraction) - int(exponent or 0))
        significant = max(significant, figures)
    if len(decimals) == 1:
        return np.full(values.shape, 0.5 * 10.0 ** -decimals.pop())
    return significant_half_units(values, significant)


def significant_half_units(values: NDArray[np.float64], significant: int) -> NDArray[np.float64]:
    """Return half a unit of the last significant digit of each value, given the number of
    digits.
    """
    size = np.abs(values)
    filled = size > 0
    smallest = size[filled].min() if filled.any() else 1.0
    exponent = np.floor(np.log10(np.where(filled, size, smallest)))
    half: NDArray[np.float64] = 0.5 * 10.0 ** (exponent - significant + 1)
    return half


def sample_of(n: int) -> NDArray[np.int64]:
    """Return the rows of a table of ``n`` rows that are checked, in order."""
    return np.unique(np.linspace(0, max(n - 1, 0), min(n, _SAMPLE)).astype(np.int64))
