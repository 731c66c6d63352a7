"""Scratch files of the analysis of packings that are too large for memory; they vanish with the process."""

from __future__ import annotations

from io import FileIO

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.float64]  # (n_rows, n_columns)


class Buckets:
    """Rows of numbers, sorted by the part that they belong to.

    Parameters
    ----------
    file
        Scratch file; None: they are kept in memory.
    """

    def __init__(self, file: FileIO | None) -> None:
        self._file = file
        self._kept: dict[int, list[Rows]] = {}
        self._places: dict[int, list[tuple[int, int]]] = {}  # byte and number of rows of each piece, by part
        self.n_columns = 0

    def add(self, parts: NDArray[np.int64], rows: Rows) -> None:
        """Add rows, and the part of each: (n_rows,)."""
        self.n_columns = rows.shape[1]
        if not len(rows):
            return
        order = np.argsort(parts, kind="stable")
        numbers, starts = np.unique(parts[order], return_index=True)
        for part, chosen in zip(numbers.tolist(), np.split(order, starts[1:]), strict=True):
            if self._file is None:
                self._kept.setdefault(part, []).append(rows if len(chosen) == len(rows) else rows[chosen])
            else:
                self._places.setdefault(part, []).append((self._file.seek(0, 2), len(chosen)))
                np.ascontiguousarray(rows[chosen]).tofile(self._file)

    def rows(self, part: int) -> Rows:
        """Return the rows of a part, in the order in which they were added."""
        pieces = self._kept.get(part, [])
        if self._file is not None:
            pieces = [read_rows(self._file, place, n, self.n_columns) for place, n in self._places.get(part, ())]
        if len(pieces) == 1:
            return pieces[0]
        return np.concatenate([np.empty((0, self.n_columns)), *pieces])


def read_rows(file: FileIO, place: int, n_rows: int, n_columns: int) -> Rows:
    """Read rows from a scratch file, from a byte on: (n_rows, n_columns)."""
    file.seek(place)
    return np.fromfile(file, dtype=np.float64, count=n_rows * n_columns).reshape(n_rows, n_columns)
