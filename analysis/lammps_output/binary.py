"""Snapshots of a binary dump of LAMMPS.

A snapshot (``dump custom`` to a file that ends in .bin, in its second form) is a header of integers
and the box, the names of the columns, and a block of float64 from each rank.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import AGAIN, DAMAGED, WHOLE, CutShortError, Frame

BINARY = ".bin"  # suffix that makes LAMMPS write a binary dump
_MAGIC = b"DUMPCUSTOM"
_ENDIAN = 1
_REVISION = 2
_LONGEST_TEXT = 1 << 20  # most bytes of the names of columns
_AHEAD = 4096  # bytes of a header that are read at a time


class _Bytes:
    """Bytes of a binary dump, from ``place`` on, in snapshot ``number``. The file is open only
    during a read, so that the dumps of thousands of ranks can be read in turn.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.size = path.stat().st_size
        self.place = 0
        self.number = 0
        self._ahead = np.empty(0, np.uint8)
        self._from = 0

    def take(self, form: str) -> tuple[Any, ...]:
        """Read values of a header, in a format of `struct`."""
        n = self.check_room(struct.calcsize(f"={form}"))
        if not 0 <= self.place - self._from <= len(self._ahead) - n:
            self._ahead = np.fromfile(self.path, np.uint8, max(n, _AHEAD), offset=self.place)
            self._from = self.place
        values = struct.unpack_from(f"={form}", self._ahead.data, self.place - self._from)
        self.place += n
        return values

    def text(self) -> str:
        """Read a text, which is preceded by its length."""
        (length,) = self.take("i")
        if not 0 <= length <= _LONGEST_TEXT:
            raise self.damaged(f"found a text of {length} bytes in the header")
        return self.take(f"{length}s")[0].decode("ascii", errors="replace")

    def check_room(self, n: int) -> int:
        """Return a number of bytes; raise CutShortError if there are fewer."""
        if self.place + n > self.size:
            raise CutShortError(self.where(), self.number)
        return n

    def where(self) -> str:
        """Return the file and the position in it."""
        return f"{self.path}: byte {self.place} (snapshot {self.number})"

    def damaged(self, fault: str) -> OutputFormatError:
        """Return the error of a damaged file."""
        return OutputFormatError(f"{self.where()}: {fault}; {DAMAGED}")


@dataclasses.dataclass(frozen=True)
class BinaryRows:
    """Rows of snapshot ``number`` of a binary dump, from row ``first`` on; unread.

    Attributes
    ----------
    pieces
        Position of the first value, and number of values, of each piece.
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
        begin = start * self.width
        end = stop * self.width
        at = 0
        pieces = []
        for place, n in self.pieces:
            low = max(begin - at, 0)
            high = min(end - at, n)
            if low < high:
                pieces.append((place + 8 * low, high - low))
            at += n
        return dataclasses.replace(self, first=self.first + start, pieces=tuple(pieces))

    def read(self, columns: Sequence[str]) -> NDArray[np.float64]:
        """Read the values, (n_rows, n_columns); check that they are finite, and that ids are whole."""
        found = [np.fromfile(self.path, np.float64, n, offset=place) for place, n in self.pieces]
        values = found[0] if len(found) == 1 else np.concatenate([np.empty(0), *found])
        table = values.reshape(len(self), self.width)
        whole = np.isin(columns, WHOLE)
        strange = np.zeros(table.shape, dtype=bool)
        strange[:, whole] = table[:, whole] != np.rint(table[:, whole])
        for faults, expected in (
            (~np.isfinite(table), "a finite number"),
            (strange, "a whole number"),
        ):
            for row, column in np.argwhere(faults)[:1].tolist():
                raise OutputFormatError(
                    f"{self.path}: byte {self.pieces[-1][0] + 8 * self.pieces[-1][1]} (snapshot {self.number}): row "
                    f"{self.first + row}: found {table[row, column]} for {columns[column]}, expected {expected}; "
                    f"{DAMAGED}"
                )
        return table


def binary_frames(path: Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the snapshots of a binary dump, in the order of the file, their rows unread.

    See `text_frames` for parameters and errors. Dumps of a machine with another byte order, and of
    LAMMPS before 2021, are also errors.
    """
    data = _Bytes(path)
    while data.place < data.size:
        like, n_rows, n_blocks = _header(data)
        width = max(1, len(like.columns))
        pieces = []
        for _ in range(n_blocks):
            (n,) = data.take("i")
            if n < 0:
                raise data.damaged(f"found a block of {n} values")
            pieces.append((data.place, n))
            data.place += data.check_room(8 * n)
        found = sum(n for _, n in pieces)
        if found != n_rows * width:
            n_found = f"{found // width} of" if found < n_rows * width else "more than"
            raise data.damaged(f"found {n_found} {n_rows} rows")
        rows = BinaryRows(path, data.number, 0, width, tuple(pieces))
        data.number += 1
        n = max(1, n_rows if at_once is None else at_once)
        for first in range(0, max(1, n_rows), n):
            yield like.with_rows(rows[first : first + n], more=first + n < n_rows)  # type: ignore[arg-type]


def _header(data: _Bytes) -> tuple[Frame, int, int]:
    """Read the header of a snapshot: the frame without rows, the number of rows, and the number of
    blocks.
    """
    (length,) = data.take("q")
    if length != -len(_MAGIC) or data.take(f"{len(_MAGIC)}s")[0] != _MAGIC:
        raise data.damaged("expected the header of a binary dump of LAMMPS")
    endian, revision = data.take("ii")
    if (endian, revision) != (_ENDIAN, _REVISION):
        raise OutputFormatError(
            f"{data.where()}: found byte order {endian} and revision {revision}, expected "
            f"{_ENDIAN} and {_REVISION}: the file was written on another machine or by another "
            f"LAMMPS; {AGAIN}"
        )
    step, n_rows, triclinic, *_ = data.take("qq7i")
    box = np.array(data.take("6d")).reshape(3, 2)
    if triclinic:
        data.take("3d")
    (n_columns,) = data.take("i")
    data.text()  # units
    if data.take("b")[0]:
        data.take("d")  # time
    columns = tuple(data.text().split())
    (n_blocks,) = data.take("i")
    if min(step, n_rows, n_blocks) < 0 or n_columns != len(columns):
        raise data.damaged(
            f"found step {step}, {n_rows} rows, {n_columns} columns ({' '.join(columns)})"
        )
    if not np.all(np.isfinite(box)):
        raise data.damaged("the box is not finite")
    data.check_room(8 * n_rows * len(columns))
    return Frame(step, box, columns, np.empty((0, len(columns)))), n_rows, n_blocks
