"""Sums of columns that are too long for memory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

_NEVER_HALVED = 128  # values: numpy adds so few without halving them


def pairwise_sum(read: Callable[[slice], NDArray[np.float64]], n_values: int, at_once: int) -> float:
    """Return the sum of values too many for memory, the same to the last bit as numpy's of all of them.

    It halves them as numpy does, until a piece may be read.

    Parameters
    ----------
    read
        Function that returns a range of the values.
    n_values
        Number of values.
    at_once
        Largest number to be read at once, at least 128.
    """

    def of(first: int, n: int) -> float:
        if n <= max(at_once, _NEVER_HALVED):
            return float(np.sum(read(slice(first, first + n))))
        half = n // 2 - n // 2 % 8
        return of(first, half) + of(first + half, n - half)

    return of(0, n_values)
