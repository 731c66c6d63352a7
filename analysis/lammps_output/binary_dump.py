"""Reader of the binary dumps of LAMMPS (``dump custom`` to a file that ends in .bin), in their second form.

A snapshot is a header of integers and the box, the names of the columns, and a block of float64 from each rank.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import CutShortError, Frame
from granwave.analysis.lammps_output.number_rows import AGAIN, DAMAGED, WHOLE

BINARY = ".bin"  # suffix by which LAMMPS is told to write a binary dump
_MAGIC = b"DUMPCUSTOM"
_ENDIAN, _REVISION = 1, 2
_LONGEST_TEXT = 1 << 20  # bytes of the names of columns, far more than any dump has


def binary_frames(path: Path) -> Iterator[Frame]:
    """Iterate over the snapshots of a binary dump, in the order of the file.

    Raises
    ------
    CutShortError
        The file ends within a snapshot.
    OutputFormatError
        It is damaged, or was written on a machine with another order of bytes, or by a LAMMPS before 2021.
    """
    with open(path, "rb") as file:
        size, number = os.fstat(file.fileno()).st_size, 0
        while file.tell() < size:
            yield _Snapshot(path, file, size, number).read()
            number += 1


class _Snapshot:
    """One snapshot at the present place of a file."""

    def __init__(self, path: Path, file: BinaryIO, size: int, number: int) -> None:
        self.path, self.file, self.size, self.number = path, file, size, number

    def read(self) -> Frame:
        (length,) = self._values("q")
        if length != -len(_MAGIC) or self._bytes(len(_MAGIC)) != _MAGIC:
            raise self._damaged("expected the header of a binary dump of LAMMPS")
        endian, revision = self._values("ii")
        if (endian, revision) != (_ENDIAN, _REVISION):
            raise OutputFormatError(
                f"{self._place()}: found byte order {endian} and revision {revision}, expected {_ENDIAN} and "
                f"{_REVISION}: another machine or another LAMMPS wrote it; {AGAIN}"
            )
        step, n_rows = self._values("qq")
        triclinic, *_ = self._values("7i")
        box = np.array(self._values("6d")).reshape(3, 2)
        if triclinic:
            self._values("3d")
        (n_columns,) = self._values("i")
        self._text()  # units
        if self._values("b")[0]:
            self._values("d")  # time
        columns = tuple(self._text().split())
        (n_blocks,) = self._values("i")
        if min(step, n_rows, n_blocks) < 0 or n_columns != len(columns):
            raise self._damaged(f"found step {step}, {n_rows} rows, {n_columns} columns ({' '.join(columns)})")
        if not np.all(np.isfinite(box)):
            raise self._damaged("the box is not finite")
        return Frame(step, box, columns, self._rows(n_rows, columns, n_blocks))

    def _rows(self, n_rows: int, columns: tuple[str, ...], n_blocks: int) -> NDArray[np.float64]:
        n_values = n_rows * len(columns)
        self._check_room(8 * n_values)
        values, done = np.empty(n_values), 0
        for _ in range(n_blocks):
            (n,) = self._values("i")
            if n < 0 or done + n > n_values:
                raise self._damaged(f"found more than {n_rows} rows")
            self._check_room(8 * n)
            done += self.file.readinto(values[done : done + n]) // 8  # type: ignore[attr-defined]
        if done != n_values:
            raise self._damaged(f"found {done // max(1, len(columns))} of {n_rows} rows")
        table = values.reshape(n_rows, len(columns))
        self._check_values(table, columns)
        return table

    def _check_values(self, table: NDArray[np.float64], columns: tuple[str, ...]) -> None:
        finite = np.isfinite(table)
        if not finite.all():
            row, column = np.argwhere(~finite)[0]
            raise self._damaged(
                f"row {row}: found {table[row, column]} for {columns[column]}, expected a finite number"
            )
        for n, name in enumerate(columns):
            if name in WHOLE and np.any(strange := table[:, n] != np.rint(table[:, n])):
                row = int(np.argmax(strange))
                raise self._damaged(f"row {row}: found {table[row, n]} for {name}, expected a whole number")

    def _text(self) -> str:
        (length,) = self._values("i")
        if not 0 <= length <= _LONGEST_TEXT:
            raise self._damaged(f"found a text of {length} bytes in the header")
        return self._bytes(length).decode("ascii", errors="replace")

    def _values(self, form: str) -> tuple[int, ...]:
        return struct.unpack(f"={form}", self._bytes(struct.calcsize(f"={form}")))

    def _bytes(self, n: int) -> bytes:
        self._check_room(n)
        return self.file.read(n)

    def _check_room(self, n: int) -> None:
        """Raise CutShortError if the file ends within the next n bytes."""
        if self.file.tell() + n > self.size:
            raise CutShortError(self._place(), self.number)

    def _damaged(self, fault: str) -> OutputFormatError:
        return OutputFormatError(f"{self._place()}: {fault}; {DAMAGED}")

    def _place(self) -> str:
        return f"{self.path}: byte {self.file.tell()} (snapshot {self.number})"
