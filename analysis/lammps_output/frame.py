"""Snapshots of a dump of LAMMPS (step, box, and a table of values), text dumps, and rows of numbers
in text files.

Errors of rows name file, line and column.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave._number_reader import read_numbers
from granwave.analysis.errors import OutputFormatError
from granwave.lammps_inputs.files import read_number, read_whole
from granwave.lammps_inputs.message_words import counted

AGAIN = "run the case again with force=True"
DAMAGED = f"the file is damaged, {AGAIN}"
CUT = f"the file is truncated, {AGAIN}"
WHOLE = ("step", "id", "type", "i", "j")  # columns of integers
# number of atoms in the header of a snapshot
_COUNTS = {"TIMESTEP": "timestep", "NUMBER OF": "number of rows"}
_BLOCK = 1 << 20  # bytes that are read at a time to count lines


def read_rows(
    rows: Sequence[str], columns: Sequence[str], place: Callable[[int], str]
) -> NDArray[np.float64]:
    """Read finite numbers from rows of text: (n_rows, n_columns).

    Parameters
    ----------
    rows
        Lines of the file.
    columns
        Names of the columns.
    place
        Function that returns file and line of a row, counted from 0, for messages.

    Raises
    ------
    OutputFormatError
        A row has more or fewer values, a value is not a finite number, or an id or a step is not an
        integer.
    """
    shape = len(rows), len(columns)
    values = read_numbers(" ".join(rows))
    if values is not None and values.size == shape[0] * shape[1]:
        table = values.reshape(shape)
        whole = [n for n, name in enumerate(columns) if name in WHOLE]
        if np.array_equal(table[:, whole], np.rint(table[:, whole])):
            return table
    for n, row in enumerate(rows):
        words = row.split()
        if len(words) != len(columns):
            found = counted(len(words), "value")
            faults = [f"found {found}, expected {len(columns)} ({' '.join(columns)})"]
        else:
            faults = list(filter(None, map(_fault, words, columns)))
        if faults:
            raise OutputFormatError(f"{place(n)}: {faults[0]}; {DAMAGED}")
    raise OutputFormatError(
        f"{place(0)}: expected {shape[0]} rows of {shape[1]} numbers; {DAMAGED}"
    )


def whole_number(text: str, name: str, place: str) -> int:
    """Read a count in a header, at least 0; raise as `read_rows`."""
    try:
        value = read_whole(text)
    except ValueError:
        value = -1
    if value < 0:
        raise OutputFormatError(
            f"{place}: found {text.strip()!r}, expected the {name}, a whole number; {DAMAGED}"
        )
    return value


def _fault(word: str, name: str) -> str:
    """Describe the fault in a value of a column; empty if there is none."""
    try:
        value = read_number(word)
    except ValueError:
        return f"found {word!r} for {name}, expected a number"
    if not math.isfinite(value):
        return f"found {word} for {name}, expected a finite number"
    return (
        f"found {word} for {name}, expected a whole number"
        if name in WHOLE and value != round(value)
        else ""
    )


@dataclasses.dataclass(frozen=True, eq=False)
class Frame:
    """One snapshot of a dump, or some of its rows.

    Attributes
    ----------
    step
        Timestep.
    box
        Lower and upper bound along x, y, z: (3, 2), m.
    columns
        Names of the columns.
    values
        Rows: (n_rows, n_columns); or the position of rows that were not read yet, see `read`.
    more
        True if further rows of the snapshot follow in another frame.
    """

    step: int
    box: NDArray[np.float64]
    columns: tuple[str, ...]
    values: NDArray[np.float64]
    more: bool = False

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return one column: (n_rows,)."""
        return self.values[:, self.columns.index(name)]

    def get(self, name: str) -> NDArray[np.float64]:
        """Return one column, or zeros if it was not recorded: (n_rows,)."""
        return self[name] if name in self.columns else np.zeros(len(self))

    def vector(self, *names: str) -> NDArray[np.float64]:
        """Return several columns: (n_rows, len(names))."""
        return self.values[:, [self.columns.index(name) for name in names]]

    @property
    def pairs(self) -> NDArray[np.int64]:
        """Ids of the two particles of each contact, the lower id first: (n_rows, 2)."""
        return np.sort(self.vector("i", "j").astype(np.int64), axis=1)

    def with_rows(self, values: NDArray[np.float64], *, more: bool = False) -> Frame:
        """Return the frame with other rows."""
        return dataclasses.replace(self, values=values, more=more)

    def read(self) -> Frame:
        """Return the frame with its rows, which are read from the file if necessary; raise as
        `text_frames`.
        """
        rows: Any = self.values
        return (
            self
            if isinstance(rows, np.ndarray)
            else self.with_rows(rows.read(self.columns), more=self.more)
        )

    def up_to(self, number: int) -> Frame:
        """Return the rows with ids up to ``number`` of a frame sorted by id."""
        return self.with_rows(
            self.values[: np.searchsorted(self["id"], number, side="right")], more=self.more
        )

    def sorted_by(self, name: str) -> Frame:
        """Return the frame with its rows sorted by a column; they are moved in place."""
        key = self[name]
        if np.any(key[1:] < key[:-1]):
            self.values[:] = self.values[np.argsort(key, kind="stable")]
        return self


def joined(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Join the frames of each snapshot."""
    parts: list[NDArray[np.float64]] = []
    for frame in (frame.read() for frame in frames):
        parts.append(frame.values)
        if not frame.more:
            yield frame.with_rows(parts[0] if len(parts) == 1 else np.concatenate(parts))
            parts = []


class CutShortError(Exception):
    """Error of a dump that ends within snapshot ``number``, counted from 0; ``place`` is the file
    and place in it.
    """

    def __init__(self, place: str, number: int) -> None:
        super().__init__(f"{place}: snapshot {number} is truncated")


class Lines:
    """Lines of a text file, counted for messages."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.n_read = 0

    def __enter__(self) -> Lines:
        self._file = open(
            self.path, encoding="ascii", errors="replace"
        )  # other bytes give an error with their line
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def take(self, n: int | None) -> list[str]:
        """Return the next n lines, or all remaining lines if there are fewer or n is None."""
        found = list(itertools.islice(self._file, n))
        self.n_read += len(found)
        return found

    def place(self, back: int = 0) -> str:
        """Return the file and the number of the last line read, or of the line ``back`` lines
        before it.
        """
        return f"{self.path}: line {self.n_read - back}"

    def frame(self, rows: list[str], like: Frame, number: int, *, more: bool) -> Frame:
        """Return the frame of the rows that were taken last, with box and columns
        of another frame.
        """
        if rows and not rows[-1].endswith("\n"):
            raise CutShortError(self.place(), number)
        last = len(rows) - 1
        values = read_rows(
            rows, like.columns, lambda row: f"{self.place(last - row)} (snapshot {number})"
        )
        return like.with_rows(values, more=more)


def text_frames(path: Path, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the snapshots of a text dump, of ``dump custom`` or ``dump local``, in the order
    of the file.

    Parameters
    ----------
    at_once
        Largest number of rows in a frame; None: a frame contains a complete snapshot.

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
            bounds = [" ".join(line.split()[:2]) for line in header["BOX BOUNDS"]]
            box = read_rows(bounds, ("low", "high"), partial(_place_of_box, path, number))
            columns = tuple(header["columns"][0].split()[2:])
            left = int(header["NUMBER OF"][0])
            frame = Frame(
                int(header["TIMESTEP"][0]), box, columns, np.empty((0, len(columns))), more=True
            )
            while frame.more:
                n_rows = left if at_once is None else min(left, at_once)
                rows = lines.take(n_rows)
                left = left - n_rows
                if len(rows) < n_rows:
                    raise CutShortError(lines.place(), number)
                yield (frame := lines.frame(rows, frame, number, more=left > 0))


def rows_without_header(path: Path, like: Frame, at_once: int | None = None) -> Iterator[Frame]:
    """Iterate over the rows of a file without headers, such as all parts of a dump of contacts
    except the first.

    Box and columns are taken from ``like``, a frame of the file with a header; otherwise as
    `text_frames`.
    """
    with Lines(path) as lines:
        while rows := lines.take(at_once):
            yield lines.frame(rows, like, 0, more=True)


@dataclasses.dataclass(frozen=True)
class TextRows:
    """Lines of a text file that hold rows, the first of them at byte ``begin``, the last before
    ``end``; unread.
    """

    path: Path
    begin: int
    end: int
    note: str = " (snapshot 0)"  # follows the position in messages

    def read(self, columns: Sequence[str]) -> NDArray[np.float64]:
        """Read and check the values: (n_rows, n_columns)."""
        with open(self.path, "rb") as file:
            file.seek(self.begin)
            *rows, rest = (
                file.read(self.end - self.begin).decode("ascii", errors="replace").split("\n")
            )
        if rest:
            raise OutputFormatError(f"{CutShortError(self._place(len(rows)), 0)}; {CUT}")
        return read_rows(rows, columns, lambda row: f"{self._place(row)}{self.note}")

    def _place(self, row: int) -> str:
        """Return file and line of a row; the lines before it are counted only on demand."""
        with open(self.path, "rb") as file:
            blocks = iter(lambda: file.read(min(_BLOCK, max(self.begin - file.tell(), 0))), b"")
            before = sum(block.count(b"\n") for block in blocks)
        return f"{self.path}: line {before + row + 1}"


def after_header(path: Path) -> tuple[int, int]:
    """Return the place of the first row of a text dump with a complete header, and the number of
    rows in the header.
    """
    with open(path, "rb") as file:
        n_rows = 0
        line = b""
        while not line.startswith((b"ITEM: ATOMS", b"ITEM: ENTRIES")):
            line = file.readline()
            if line.startswith(b"ITEM: NUMBER OF"):
                n_rows = int(file.readline())
        return file.tell(), n_rows


def text_rows(
    path: Path, begin: int, n_bytes: int, end: int | None = None, **note: str
) -> Iterator[TextRows]:
    """Iterate over the rows of a text file between two bytes, in pieces of about this many bytes,
    unread.
    """
    end = path.stat().st_size if end is None else end
    with open(path, "rb") as file:
        while begin < end:
            file.seek(min(begin + n_bytes, end) - 1)
            file.readline()
            yield TextRows(path, begin, file.tell(), **note)
            begin = file.tell()


def data_rows(path: Path, n_bytes: int) -> list[TextRows]:
    """Return the rows of the section Atoms of a data file in pieces of about this many bytes; empty
    if it was truncated.
    """
    with open(path, "rb") as file:
        while not (line := file.readline()).startswith(b"Atoms"):
            pass
        end = begin = file.tell() + len(file.readline())
        last = b"\n"
        while block := file.read(_BLOCK):
            if (blank := (last + block).find(b"\n\n")) >= 0:
                end += blank
                break
            end = end + len(block)
            last = block[-1:]
    whole = block or last == b"\n"
    return (
        list(text_rows(path, begin, n_bytes, end, note=""))
        if whole and not line.endswith(b"\r\n")
        else []
    )


def _place_of_box(path: Path, snapshot: int, _row: int) -> str:
    return f"{path}: box of snapshot {snapshot}"


def _header(lines: Lines, number: int) -> dict[str, list[str]] | None:
    """Read the header of a snapshot: lines by title, and the title of its rows as ``columns``; None
    at the file's end.
    """
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
            raise OutputFormatError(
                f"{lines.place()}: a second {name} in snapshot {number}; {DAMAGED}"
            )
        header[name] = lines.take(3 if name == "BOX BOUNDS" else 1)
        if name in _COUNTS and header[name]:
            whole_number(header[name][0], _COUNTS[name], lines.place())
    if not header:
        return None
    if "columns" not in header:
        raise CutShortError(lines.place(), number)
    if missing := [name for name in (*_COUNTS, "BOX BOUNDS") if name not in header]:
        raise OutputFormatError(
            f"{lines.place()}: snapshot {number} lacks its {', '.join(missing)}; {DAMAGED}"
        )
    return header
