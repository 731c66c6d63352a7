"""Readers of the text and binary dumps of LAMMPS, and of lines of text files with their numbers for messages.

A snapshot of a binary dump (``dump custom`` to a file that ends in .bin, in its second form) is a header of integers
and the box, the names of the columns, and a block of float64 from each rank.
"""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import AGAIN, DAMAGED, WHOLE, CutShortError, Frame, read_rows, whole_number

_COUNTS = {"TIMESTEP": "timestep", "NUMBER OF": "number of rows"}  # in the header of a snapshot
BINARY = ".bin"  # suffix by which LAMMPS is told to write a binary dump
_MAGIC = b"DUMPCUSTOM"
_ENDIAN, _REVISION = 1, 2
_LONGEST_TEXT = 1 << 20  # bytes of the names of columns, far more than any dump has


class Lines:
    """Lines of a text file, counted for messages."""

    def __init__(self, path: Path) -> None:
        self.path, self.n_read = path, 0

    def __enter__(self) -> Lines:
        self._file = open(self.path, encoding="ascii", errors="replace")  # other bytes give an error with their line
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def take(self, n: int | None) -> list[str]:
        """Return the next n lines, or those that are left; all of them if n is None."""
        found = list(itertools.islice(self._file, n))
        self.n_read += len(found)
        return found

    def place(self, back: int = 0) -> str:
        """Return the file and the number of the last line read, or of one ``back`` lines before it."""
        return f"{self.path}: line {self.n_read - back}"


def text_frames(path: Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the snapshots of a text dump, of ``dump custom`` or ``dump local``, in the order of the file.

    Parameters
    ----------
    at_once
        Largest number of rows in a frame; None: a frame holds a whole snapshot.

    Raises
    ------
    CutShortError
        The file ends within a snapshot.
    OutputFormatError
        It is damaged.
    """
    with Lines(path) as lines:
        for number in itertools.count():
            if (header := _header(lines, number)) is None:
                return
            yield from _text_frames(lines, header, number, at_once)


def rows_without_header(path: Path, like: Frame, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the rows of a file of nothing else, as LAMMPS writes for all ranks but the first.

    Parameters
    ----------
    like
        Frame of the file that has a header.
    at_once
        Largest number of rows in a frame.

    Raises
    ------
    CutShortError
        The file ends within a row.
    OutputFormatError
        It is damaged.
    """
    with Lines(path) as lines:
        while rows := lines.take(at_once):
            yield _text_frame(lines, rows, dataclasses.replace(like, more=True), 0)


def _text_frames(lines: Lines, header: dict[str, list[str]], number: int, at_once: int | None) -> Iterator[Frame]:
    """Iterate over the rows of the snapshot of a header."""
    bounds = [" ".join(line.split()[:2]) for line in header["BOX BOUNDS"]]
    box = read_rows(bounds, ("low", "high"), lambda _: f"{lines.path}: box of snapshot {number}")
    columns, left = tuple(header["columns"][0].split()[2:]), int(header["NUMBER OF"][0])
    frame = Frame(int(header["TIMESTEP"][0]), box, columns, np.empty((0, len(columns))), more=True)
    while frame.more:
        n_rows = left if at_once is None else min(left, at_once)
        rows, left = lines.take(n_rows), left - n_rows
        if len(rows) < n_rows:
            raise CutShortError(lines.place(), number)
        frame = _text_frame(lines, rows, dataclasses.replace(frame, more=left > 0), number)
        yield frame


def _text_frame(lines: Lines, rows: list[str], like: Frame, number: int) -> Frame:
    """Return the frame of rows of text that were just read; all but the values is that of another."""
    if rows and not rows[-1].endswith("\n"):
        raise CutShortError(lines.place(), number)
    last = len(rows) - 1
    values = read_rows(rows, like.columns, lambda row: f"{lines.place(last - row)} (snapshot {number})")
    return dataclasses.replace(like, values=values)


def _header(lines: Lines, number: int) -> dict[str, list[str]] | None:
    """Read the header of a snapshot: lines by title, and that of its rows as ``columns``; None at the file's end."""
    header: dict[str, list[str]] = {}
    while titles := lines.take(1):
        title = titles[0]
        if not title.endswith("\n"):
            raise CutShortError(lines.place(), number)
        if not title.startswith("ITEM:"):
            raise OutputFormatError(
                f"{lines.place()}: expected the header of snapshot {number}, found {title.strip()[:60]!r}; {DAMAGED}"
            )
        if title.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            header["columns"] = titles
            break
        name = " ".join(title.split()[1:3])
        if name in header:
            raise OutputFormatError(f"{lines.place()}: a second {name} in snapshot {number}; {DAMAGED}")
        header[name] = lines.take(3 if name == "BOX BOUNDS" else 1)
        if name in _COUNTS and header[name]:
            whole_number(header[name][0], _COUNTS[name], lines.place())
    if not header:
        return None
    if "columns" not in header:
        raise CutShortError(lines.place(), number)
    if missing := [name for name in (*_COUNTS, "BOX BOUNDS") if name not in header]:
        raise OutputFormatError(f"{lines.place()}: snapshot {number} lacks its {', '.join(missing)}; {DAMAGED}")
    return header


def binary_frames(path: Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the snapshots of a binary dump, in the order of the file.

    The file is open only while a frame is read, so that the dumps of thousands of ranks can be read side by side.

    Parameters
    ----------
    at_once
        Largest number of rows in a frame; None: a frame holds a whole snapshot.

    Raises
    ------
    CutShortError
        The file ends within a snapshot.
    OutputFormatError
        It is damaged, or was written on a machine with another order of bytes, or by a LAMMPS before 2021.
    """
    size, place, number = path.stat().st_size, 0, 0
    while place < size:
        snapshot = _Snapshot(path, size, number)
        with snapshot.open_at(place):
            snapshot.read_header()
        while (frame := snapshot.next_frame(at_once)).more:
            yield frame
        place = snapshot.place
        number += 1
        yield frame


class _Snapshot:
    """One snapshot of a file; ``place`` is where the next frame begins."""

    def __init__(self, path: Path, size: int, number: int) -> None:
        self.path, self.size, self.number = path, size, number

    @contextlib.contextmanager
    def open_at(self, place: int) -> Iterator[None]:
        """Open the file at a place, and note at which place it is left."""
        with open(self.path, "rb") as self.file:
            self.file.seek(place)
            yield
            self.place = self.file.tell()

    def read_header(self) -> None:
        """Read all that comes before the rows."""
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
        self.step, self.box, self.columns, self.n_rows = step, box, columns, n_rows
        self.rows_read, self.blocks_left, self.left_in_block = 0, n_blocks, 0
        self._check_room(8 * n_rows * len(columns))

    def next_frame(self, at_once: int | None) -> Frame:
        """Read the next rows, at most so many."""
        n_rows = self.n_rows - self.rows_read
        n_rows = n_rows if at_once is None else min(n_rows, at_once)
        with self.open_at(self.place):
            values = self._read_values(n_rows * len(self.columns))
            last = self.rows_read + n_rows == self.n_rows
            if last:
                self._end_blocks()
        table = values.reshape(n_rows, len(self.columns))
        self._check_values(table, self.columns)
        self.rows_read += n_rows
        return Frame(self.step, self.box, self.columns, table, more=not last)

    def _read_values(self, n_values: int) -> NDArray[np.float64]:
        """Read values from as many blocks as they take."""
        values, done = np.empty(n_values), 0
        while done < n_values:
            if not self.left_in_block and not self._next_block():
                found = self.rows_read + done // max(1, len(self.columns))
                raise self._damaged(f"found {found} of {self.n_rows} rows")
            n = min(self.left_in_block, n_values - done)
            self._check_room(8 * n)
            self.file.readinto(values[done : done + n])  # type: ignore[arg-type]
            done += n
            self.left_in_block -= n
        return values

    def _next_block(self) -> bool:
        """Go on to the next block that is not empty; return False if there is none."""
        while self.blocks_left and not self.left_in_block:
            (self.left_in_block,) = self._values("i")
            if self.left_in_block < 0:
                raise self._damaged(f"found a block of {self.left_in_block} values")
            self.blocks_left -= 1
        return self.left_in_block > 0

    def _end_blocks(self) -> None:
        """Check that the blocks end with the rows."""
        if self.left_in_block or self._next_block():
            raise self._damaged(f"found more than {self.n_rows} rows")

    def _check_values(self, table: NDArray[np.float64], columns: tuple[str, ...]) -> None:
        finite = np.isfinite(table)
        if not finite.all():
            row, column = np.argwhere(~finite)[0]
            found = f"found {table[row, column]} for {columns[column]}"
            raise self._damaged(f"row {self.rows_read + row}: {found}, expected a finite number")
        for n, name in enumerate(columns):
            if name in WHOLE and np.any(strange := table[:, n] != np.rint(table[:, n])):
                row = int(np.argmax(strange))
                raise self._damaged(
                    f"row {self.rows_read + row}: found {table[row, n]} for {name}, expected a whole number"
                )

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
        place = self.place if self.file.closed else self.file.tell()
        return f"{self.path}: byte {place} (snapshot {self.number})"
