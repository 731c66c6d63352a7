"""Reader of the text dumps of LAMMPS, and of lines of text files with their numbers for messages."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import CutShortError, Frame
from granwave.analysis.lammps_output.number_rows import DAMAGED, read_rows, whole_number

_COUNTS = {"TIMESTEP": "timestep", "NUMBER OF": "number of rows"}  # in the header of a snapshot


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
            yield from _frames(lines, header, number, at_once)


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
            yield _frame(lines, rows, dataclasses.replace(like, more=True), 0)


def _frames(lines: Lines, header: dict[str, list[str]], number: int, at_once: int | None) -> Iterator[Frame]:
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
        frame = _frame(lines, rows, dataclasses.replace(frame, more=left > 0), number)
        yield frame


def _frame(lines: Lines, rows: list[str], like: Frame, number: int) -> Frame:
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
