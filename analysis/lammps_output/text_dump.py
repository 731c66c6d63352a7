"""Reader of the text dumps of LAMMPS, and of lines of text files with their numbers for messages."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

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

    def take(self, n: int) -> list[str]:
        """Return the next n lines, or those that are left."""
        found = list(itertools.islice(self._file, n))
        self.n_read += len(found)
        return found

    def place(self, back: int = 0) -> str:
        """Return the file and the number of the last line read, or of one ``back`` lines before it."""
        return f"{self.path}: line {self.n_read - back}"


def text_frames(path: Path) -> Iterator[Frame]:
    """Iterate over the snapshots of a text dump, of ``dump custom`` or ``dump local``, in the order of the file.

    Raises
    ------
    CutShortError
        The file ends within a snapshot.
    OutputFormatError
        It is damaged.
    """
    with Lines(path) as lines:
        for number in itertools.count():
            if (frame := _next_frame(lines, number)) is None:
                return
            yield frame


def _next_frame(lines: Lines, number: int) -> Frame | None:
    """Read the next snapshot; None at the end of the file."""
    header = _header(lines, number)
    if header is None:
        return None
    columns, n_rows = tuple(header["columns"][0].split()[2:]), int(header["NUMBER OF"][0])
    rows = lines.take(n_rows)
    if len(rows) < n_rows or (rows and not rows[-1].endswith("\n")):
        raise CutShortError(lines.place(), number)
    values = read_rows(rows, columns, lambda row: f"{lines.place(n_rows - 1 - row)} (snapshot {number})")
    bounds = [" ".join(line.split()[:2]) for line in header["BOX BOUNDS"]]
    box = read_rows(bounds, ("low", "high"), lambda _: f"{lines.path}: box of snapshot {number}")
    return Frame(int(header["TIMESTEP"][0]), box, columns, values)


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
