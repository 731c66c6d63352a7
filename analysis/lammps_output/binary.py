"""Snapshots of a binary dump of LAMMPS.

A snapshot (``dump custom`` to a file that ends in .bin, in its second form) is a header of integers and the box, the
names of the columns, and a block of float64 from each rank.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import AGAIN, DAMAGED, WHOLE, CutShortError, Frame, Unread

BINARY = ".bin"  # suffix by which LAMMPS is told to write a binary dump
_MAGIC = b"DUMPCUSTOM"
_ENDIAN, _REVISION = 1, 2
_LONGEST_TEXT = 1 << 20  # bytes of the names of columns, far more than any dump has
_AHEAD = 4096  # bytes that are read at once of a header


class _Bytes:
    """Bytes of a binary dump, from ``place`` on in snapshot ``number``.

    The file is open only while some are read, so that the dumps of thousands of ranks can be read side by side.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.size, self.place, self.number = path, path.stat().st_size, 0, 0
        self._ahead, self._from = b"", 0

    def take(self, form: str) -> tuple[Any, ...]:
        """Read values of a header, as `struct` names them."""
        n = struct.calcsize(f"={form}")
        self._check_room(n)
        start = self.place - self._from
        if not 0 <= start <= len(self._ahead) - n:
            with open(self.path, "rb") as file:
                file.seek(self.place)
                self._ahead, self._from, start = file.read(max(n, _AHEAD)), self.place, 0
        self.place += n
        return struct.unpack_from(f"={form}", self._ahead, start)

    def text(self) -> str:
        """Read a text and its length before it."""
        (length,) = self.take("i")
        if not 0 <= length <= _LONGEST_TEXT:
            raise self.damaged(f"found a text of {length} bytes in the header")
        return self.take(f"{length}s")[0].decode("ascii", errors="replace")

    def values(self, n: int) -> tuple[int, int]:
        """Pass over so many values of a block; return the place of the first, and their number."""
        self._check_room(8 * n)
        self.place += 8 * n
        return self.place - 8 * n, n

    def _check_room(self, n: int) -> None:
        if self.place + n > self.size:
            raise CutShortError(self._where(), self.number)

    def damaged(self, fault: str) -> OutputFormatError:
        """Return the error of a damaged file."""
        return OutputFormatError(f"{self._where()}: {fault}; {DAMAGED}")

    def _where(self) -> str:
        return f"{self.path}: byte {self.place} (snapshot {self.number})"

    def header(self) -> tuple[Frame, int, int]:
        """Read all that comes before the rows: the frame without rows, and their number and that of the blocks."""
        (length,) = self.take("q")
        if length != -len(_MAGIC) or self.take(f"{len(_MAGIC)}s")[0] != _MAGIC:
            raise self.damaged("expected the header of a binary dump of LAMMPS")
        endian, revision = self.take("ii")
        if (endian, revision) != (_ENDIAN, _REVISION):
            raise OutputFormatError(
                f"{self._where()}: found byte order {endian} and revision {revision}, expected {_ENDIAN} and "
                f"{_REVISION}: another machine or another LAMMPS wrote it; {AGAIN}"
            )
        step, n_rows, triclinic, *_ = self.take("qq7i")
        box = np.array(self.take("6d")).reshape(3, 2)
        if triclinic:
            self.take("3d")
        (n_columns,) = self.take("i")
        self.text()  # units
        if self.take("b")[0]:
            self.take("d")  # time
        columns = tuple(self.text().split())
        (n_blocks,) = self.take("i")
        if min(step, n_rows, n_blocks) < 0 or n_columns != len(columns):
            raise self.damaged(f"found step {step}, {n_rows} rows, {n_columns} columns ({' '.join(columns)})")
        if not np.all(np.isfinite(box)):
            raise self.damaged("the box is not finite")
        self._check_room(8 * n_rows * len(columns))
        return Frame(step, box, columns, np.empty((0, len(columns)))), n_rows, n_blocks

    def pieces(self, n_blocks: int, n_values: int) -> Iterator[tuple[int, int]]:
        """Iterate over the blocks of a snapshot, each in pieces of at most so many values: place and number."""
        for _ in range(n_blocks):
            (left,) = self.take("i")
            if left < 0:
                raise self.damaged(f"found a block of {left} values")
            while left:
                place, n = self.values(min(left, n_values))
                left -= n
                yield place, n


@dataclasses.dataclass(frozen=True)
class BinaryRows(Unread):
    """Rows of snapshot ``number`` of a binary dump, from row ``first`` on; unread.

    Attributes
    ----------
    pieces
        Place of the first and number of the values of each piece.
    """

    path: Path
    number: int
    first: int
    width: int
    pieces: tuple[tuple[int, int], ...]

    def __len__(self) -> int:
        return sum(n for _, n in self.pieces) // self.width

    def __getitem__(self, rows: slice) -> BinaryRows:
        """Return some of the rows."""
        start, stop, _ = rows.indices(len(self))
        begin, end, at = start * self.width, stop * self.width, 0
        pieces = []
        for place, n in self.pieces:
            low, high = max(begin - at, 0), min(end - at, n)
            if low < high:
                pieces.append((place + 8 * low, high - low))
            at += n
        return dataclasses.replace(self, first=self.first + start, pieces=tuple(pieces))

    def read(self, columns: Sequence[str]) -> NDArray[np.float64]:
        """Read and check the values: (n_rows, n_columns)."""
        found = [np.fromfile(self.path, np.float64, n, offset=place) for place, n in self.pieces]
        values = found[0] if len(found) == 1 else np.concatenate([np.empty(0), *found])
        table = values.reshape(len(self), self.width)
        _check_values(self, table, columns)
        return table


def binary_frames(path: Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the snapshots of a binary dump, in the order of the file, their rows unread.

    Parameters and errors are those of `text_frames`. Dumps of a machine with another order of bytes, or of a LAMMPS
    before 2021, are errors too.
    """
    data = _Bytes(path)
    while data.place < data.size:
        like, n_rows, n_blocks = data.header()
        width = max(1, len(like.columns))
        pieces = list(data.pieces(n_blocks, data.size))
        rows = BinaryRows(path, data.number, 0, width, tuple(pieces))
        found = sum(n for _, n in pieces)
        if found < n_rows * width:
            raise data.damaged(f"found {found // width} of {n_rows} rows")
        if found > n_rows * width:
            raise data.damaged(f"found more than {n_rows} rows")
        data.number += 1
        n = max(1, n_rows if at_once is None else at_once)
        for first in range(0, max(1, n_rows), n):
            yield like.with_rows(rows[first : first + n], more=first + n < n_rows)  # type: ignore[arg-type]


def _check_values(rows: BinaryRows, table: NDArray[np.float64], columns: Sequence[str]) -> None:
    """Check values that were read: finite numbers, and whole ones for ids."""

    def refuse(row: int, column: int, expected: str) -> NoReturn:
        where = f"{rows.path}: byte {rows.pieces[-1][0] + 8 * rows.pieces[-1][1]} (snapshot {rows.number})"
        fault = f"row {rows.first + row}: found {table[row, column]} for {columns[column]}, expected {expected}"
        raise OutputFormatError(f"{where}: {fault}; {DAMAGED}")

    finite = np.isfinite(table)
    if not finite.all():
        row, column = np.argwhere(~finite)[0].tolist()
        refuse(row, column, "a finite number")
    for n, name in enumerate(columns):
        if name in WHOLE and np.any(strange := table[:, n] != np.rint(table[:, n])):
            refuse(int(np.argmax(strange)), n, "a whole number")
