"""Particles at the start of a run, in parts of so many spheres that one fits into memory.

A part is a range of ids. Those of a lattice are counted by layers, so that a part is a slab. A single part is kept in
memory, several in a scratch file.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import FileIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dumps import DATA_COLUMNS, read_data_in_parts, refuse_ids
from granwave.analysis.lammps_output.frame import DAMAGED, Frame, rows_of, rows_of_all
from granwave.lammps_inputs.run_directory import DATA_FILE

_BLOCK = 4096  # rows that are read for a single one
_MARGIN = 1e-3  # by which a part is searched farther than spheres reach, for rounding
_WIDTH = len(DATA_COLUMNS)
_AXES = ("x", "y", "z")


class Start:
    """Particles of ``data.granwave``: spheres by id, then nodes of bars.

    Parameters
    ----------
    directory
        Directory of the run.
    at_once
        Largest number of spheres in a part.
    scratch
        Scratch file.

    Attributes
    ----------
    box
        Bounds of the box: (3, 2), m.
    n_spheres
        Number of spheres.
    low
        Lowest coordinates of centres: (3,), m.

    Raises
    ------
    MissingOutputError, OutputFormatError
        The file is missing, damaged, or its rows are not in the order of their ids.
    """

    def __init__(self, directory: Path, at_once: int, scratch: FileIO) -> None:
        self.path, self.at_once, self._file = directory / DATA_FILE, at_once, scratch
        self._table: Frame | None = None
        self._ids: NDArray[np.int64] | None = None  # None: they are 1, 2, ...
        self.n_particles = self.n_spheres = 0
        self._bounds: list[tuple[NDArray[np.float64], NDArray[np.float64], float]] = []  # of parts; largest radius
        for frame in read_data_in_parts(directory, at_once):
            if not (self.n_particles or frame.more):
                self._table = frame.sorted_by("id")
            else:
                frame.values.tofile(scratch)
            self._add(frame)
        self.low = np.min([low for low, _, _ in self._bounds], axis=0)

    def _add(self, frame: Frame) -> None:
        """Note ids and bounds of the next rows."""
        ids = frame["id"].astype(np.int64)
        last = self.last_id if self.n_particles else 0
        if np.any(np.diff(ids, prepend=last) < 1):
            raise OutputFormatError(f"{self.path}: the rows are not in the order of their ids; {DAMAGED}")
        n_before, n_after = self.n_particles, self.n_particles + len(ids)
        if self._ids is not None or ids[-1] != n_after:
            before = np.arange(1, n_before + 1) if self._ids is None else self._ids
            self._ids = np.concatenate([before, ids])
        spheres = frame["diameter"] > 0  # nodes of bars come after the spheres
        self.n_particles, self.n_spheres = n_after, self.n_spheres + int(np.count_nonzero(spheres))
        self.box = frame.box
        if spheres.any():
            places = frame.vector(*_AXES)[spheres]
            self._bounds.append((places.min(axis=0), places.max(axis=0), float(frame["diameter"].max()) / 2))

    @property
    def n_parts(self) -> int:
        """Number of parts."""
        return len(self._bounds)

    @property
    def last_id(self) -> int:
        """Largest id of a particle."""
        return self.n_particles if self._ids is None else int(self._ids[-1])

    @property
    def last_sphere(self) -> int:
        """Largest id of a sphere."""
        return self.n_spheres if self._ids is None else int(self._ids[self.n_spheres - 1])

    def range(self, part: int) -> tuple[int, int]:
        """Return the first row of a part, and that after its last."""
        return part * self.at_once, min((part + 1) * self.at_once, self.n_spheres)

    def parts(self) -> Iterator[tuple[slice, Frame]]:
        """Iterate over the rows of the parts, and their spheres."""
        for part in range(self.n_parts):
            rows = self.range(part)
            yield slice(*rows), self.read(*rows)

    def read(self, first: int, stop: int) -> Frame:
        """Return the particles of a range of rows."""
        if self._table is not None:
            values = self._table.values[first:stop]
        else:
            values = read_rows(self._file, 8 * _WIDTH * first, stop - first, _WIDTH)
        return Frame(0, self.box, DATA_COLUMNS, values)

    def ids(self, first: int, stop: int) -> NDArray[np.int64]:
        """Return the ids of a range of rows."""
        return np.arange(first + 1, stop + 1) if self._ids is None else self._ids[first:stop]

    def rows(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the rows of particles.

        Raises
        ------
        KeyError
            There is no such particle.
        """
        if self._ids is not None:
            return rows_of(self._ids, ids)
        return rows_of_all(self.n_particles, ids)

    def part_of(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers of the parts that spheres belong to; raise as `rows`."""
        return self.rows(ids) // self.at_once

    def check_ids(self, path: Path, frame: Frame) -> None:
        """Raise OutputFormatError if a dump names a particle that is not there."""
        for name in [name for name in ("i", "j", "id") if name in frame.columns]:
            found = frame[name]
            if self._ids is None:
                known = (found >= 1) & (found <= self.n_particles)
            else:
                known = self._ids[np.minimum(np.searchsorted(self._ids, found), len(self._ids) - 1)] == found
            refuse_ids(path, found[~known])

    def around(self, part: int, further: NDArray[np.int64], gap: float, periodic: tuple[bool, bool, bool]) -> Frame:
        """Return the spheres of a part, those of other parts that may touch them, and further ones, sorted by id.

        Parameters
        ----------
        further
            Ids of the further spheres.
        gap
            Largest gap of touching spheres, m.
        periodic
            True for periodic axes, along which a sphere may touch any other.
        """
        if self.n_parts == 1:
            return self.read(0, self.n_spheres)
        low, high, radius = self._bounds[part]
        reach = (1 + _MARGIN) * (radius + max(largest for _, _, largest in self._bounds) + gap)
        free = ~np.array(periodic)
        low, high = (low - reach)[free], (high + reach)[free]
        found = {part: self.read(*self.range(part)).values}
        for other, (its_low, its_high, _) in enumerate(self._bounds):
            if other != part and np.all((its_low[free] <= high) & (its_high[free] >= low)):
                frame = self.read(*self.range(other))
                places = frame.vector(*_AXES)[:, free]
                found[other] = frame.values[np.all((places >= low) & (places <= high), axis=1)]
        near = np.concatenate([found[other] for other in sorted(found)])
        lost = np.setdiff1d(further, near[:, 0].astype(np.int64))
        if len(lost):
            near = np.concatenate([near, self._take(self.rows(lost))])
            near = near[np.argsort(near[:, 0], kind="stable")]
        return Frame(0, self.box, DATA_COLUMNS, near)

    def _take(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return single rows, which rise: (n, n_columns)."""
        blocks, starts = np.unique(rows // _BLOCK, return_index=True)
        return np.concatenate(
            [
                self.read(block * _BLOCK, min((block + 1) * _BLOCK, self.n_particles)).values[chosen - block * _BLOCK]
                for block, chosen in zip(blocks.tolist(), np.split(rows, starts[1:]), strict=True)
            ]
        )

    def whole(self) -> Frame:
        """Return all particles."""
        return self.read(0, self.n_particles)


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


class Dents:
    """Contacts at one instant of a run, by the parts of the spheres; those with faces of bars by themselves.

    Parameters
    ----------
    start
        Particles of the run.
    rows
        Contacts by part of either sphere.
    """

    def __init__(self, start: Start, rows: Buckets) -> None:
        self._start, self._rows = start, rows
        self._at_bars: list[NDArray[np.float64]] = []
        self._like: Frame | None = None

    def add(self, frame: Frame) -> None:
        """Add contacts of particles that there are."""
        self._like = frame
        pairs = frame.vector("i", "j").astype(np.int64)
        between = pairs.max(axis=1, initial=0) <= self._start.last_sphere
        self._at_bars.append(frame.values[~between])
        values = frame.values if between.all() else frame.values[between]
        first, second = (self._start.part_of(ids) for ids in pairs[between].T)
        self._rows.add(first, values)
        if np.any(apart := first != second):
            self._rows.add(second[apart], values[apart])

    def of_part(self, part: int) -> Frame:
        """Return the contacts of the spheres of a part with other spheres."""
        return self._frame(self._rows.rows(part))

    def at_bars(self) -> Frame:
        """Return the contacts of spheres with the faces of bars."""
        return self._frame(np.concatenate(self._at_bars))

    def _frame(self, values: NDArray[np.float64]) -> Frame:
        assert self._like is not None
        return Frame(self._like.step, self._like.box, self._like.columns, values)
