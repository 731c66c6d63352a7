"""Snapshots of a dump of LAMMPS (step, box, and a table of values), and rows of numbers in text files.

Errors of rows name file, line and column.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave._number_reader import read_numbers
from granwave.analysis.errors import OutputFormatError

AGAIN = "run the case again with --force"
DAMAGED = f"the file is damaged, {AGAIN}"
CUT = f"the file was cut, {AGAIN}"
WHOLE = ("step", "id", "type", "i", "j")  # columns of integers


def read_rows(rows: Sequence[str], columns: Sequence[str], place: Callable[[int], str]) -> NDArray[np.float64]:
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
        A row has more or fewer values, a value is not a finite number, or an id or a step is not an integer.
    """
    shape = len(rows), len(columns)
    values = read_numbers(" ".join(rows))
    if values is not None and values.size == shape[0] * shape[1]:
        table = values.reshape(shape)
        whole = [n for n, name in enumerate(columns) if name in WHOLE]
        if np.array_equal(table[:, whole], np.rint(table[:, whole])):
            return table
    for n, row in enumerate(rows):
        if fault := _fault(row.split(), columns):
            raise OutputFormatError(f"{place(n)}: {fault}; {DAMAGED}")
    raise OutputFormatError(f"{place(0)}: expected {shape[0]} rows of {shape[1]} numbers; {DAMAGED}")


def whole_number(text: str, name: str, place: str) -> int:
    """Read a count in a header, at least 0; raise as `read_rows`."""
    try:
        value = int(text)
    except ValueError:
        value = -1
    if value < 0:
        raise OutputFormatError(f"{place}: found {text.strip()!r}, expected the {name}, a whole number; {DAMAGED}")
    return value


def _fault(words: Sequence[str], columns: Sequence[str]) -> str:
    """Describe the fault in the values of a row; empty if there is none."""
    if len(words) != len(columns):
        return f"found {len(words)} values, expected {len(columns)} ({' '.join(columns)})"
    for word, name in zip(words, columns, strict=True):
        try:
            value = float(word)
        except ValueError:
            return f"found {word!r} for {name}, expected a number"
        if not math.isfinite(value):
            return f"found {word} for {name}, expected a finite number"
        if name in WHOLE and value != round(value):
            return f"found {word} for {name}, expected a whole number"
    return ""


@dataclasses.dataclass(frozen=True, eq=False)
class Frame:
    """One snapshot of a dump.

    Attributes
    ----------
    step
        Timestep.
    box
        Lower and upper bound along x, y, z: (3, 2), m.
    columns
        Names of the columns.
    values
        Rows: (n_rows, n_columns).
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
        """Ids of the two particles of each contact, the lower one first: (n_rows, 2)."""
        return np.sort(self.vector("i", "j").astype(np.int64), axis=1)

    def with_rows(self, values: NDArray[np.float64], *, more: bool = False) -> Frame:
        """Return the frame with other rows."""
        return dataclasses.replace(self, values=values, more=more)

    def up_to(self, number: int) -> Frame:
        """Return the rows with ids up to ``number`` of a frame sorted by id."""
        return self.with_rows(self.values[: np.searchsorted(self["id"], number, side="right")], more=self.more)

    def sorted_by(self, name: str) -> Frame:
        """Return the frame with its rows sorted by a column; they are moved in place."""
        key = self[name]
        if np.any(key[1:] < key[:-1]):
            self.values[:] = self.values[np.argsort(key, kind="stable")]
        return self


def joined(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Join the rows of each snapshot that come in several frames."""
    parts: list[NDArray[np.float64]] = []
    for frame in frames:
        parts.append(frame.values)
        if not frame.more:
            yield frame.with_rows(parts[0] if len(parts) == 1 else np.concatenate(parts))
            parts = []


def rows_of(ids: NDArray[np.int64], wanted: ArrayLike) -> NDArray[np.int64]:
    """Return the rows of spheres in a table sorted by id: id - 1 unless spheres are missing.

    Parameters
    ----------
    ids
        Ids in the table, rising: (n,).
    wanted
        Ids of the spheres, of any shape.

    Raises
    ------
    KeyError
        There is no such sphere, for instance at a vacancy.
    """
    wanted = np.asarray(wanted, dtype=np.int64)
    if not len(ids) or ids[-1] == len(ids):
        return rows_of_all(len(ids), wanted)
    rows = np.minimum(np.searchsorted(ids, wanted), len(ids) - 1)
    _refuse_unknown(wanted, ids[rows] == wanted, len(ids))
    return rows


def rows_of_all(n_spheres: int, wanted: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the rows of spheres in a table in which none is missing; raise as `rows_of`."""
    _refuse_unknown(wanted, (wanted >= 1) & (wanted <= n_spheres), n_spheres)
    return wanted - 1


def _refuse_unknown(wanted: NDArray[np.int64], found: NDArray[np.bool_], n_spheres: int) -> None:
    if not np.all(found):
        raise KeyError(f"there is no sphere {wanted[~found].flat[0]} among the {n_spheres} of the packing")


class CutShortError(Exception):
    """Error of a dump that ends within snapshot ``number``, counted from 0; ``place`` is the file and place in it."""

    def __init__(self, place: str, number: int) -> None:
        super().__init__(f"{place}: snapshot {number} is cut short")
