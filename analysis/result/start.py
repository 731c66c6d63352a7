"""Particles at the start of a run, and its contacts, in parts that each fit into memory.

A part is a range of ids. Ids of a lattice are counted by layers, so that a part is a slab. A single
part is kept in memory, several parts in scratch files.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dumps import DATA_COLUMNS, ContactDump, read_data, refuse_ids
from granwave.analysis.lammps_output.frame import DAMAGED, Frame
from granwave.analysis.result.hdf5_file import rows_of, rows_of_all, sorted_once
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.processes import Processes
from granwave.lammps_inputs.run_directory import DATA_FILE

_MARGIN = 1e-3  # margin of the search around a part, for rounding


def periodic(case: Case) -> tuple[bool, bool, bool]:
    """Return True for the periodic axes of a packing."""
    sides = case.boundary.periodic
    return sides, sides, False


class Start:
    """Particles of ``data.granwave``: spheres by id, then nodes of bars.

    Parameters
    ----------
    directory
        Directory of the run.
    at_once
        Largest number of spheres in a part.
    scratch
        Name for a scratch file.
    processes
        Processes that read the file.

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

    def __init__(self, directory: Path, at_once: int, scratch: Path, processes: Processes) -> None:
        self.path = directory / DATA_FILE
        self.at_once = at_once
        self._scratch = scratch
        self._ids: NDArray[np.int64] | None = None  # None: ids are 1, 2, ...
        self._bounds: list[
            tuple[NDArray[np.float64], NDArray[np.float64], float]
        ] = []  # coordinates of the parts; largest radius
        self._values: NDArray[np.float64] | None = None  # None: in the scratch file
        self.n_particles = self.n_spheres = last = 0
        with contextlib.ExitStack() as stack:
            file = None
            for frame in read_data(directory, at_once, processes):
                if self.n_particles or frame.more:
                    file = file or stack.enter_context(open(scratch, "wb"))
                    frame.values.tofile(file)
                else:
                    self._values = frame.sorted_by("id").values
                ids = frame["id"].astype(np.int64)
                if np.any(np.diff(ids, prepend=last) < 1):
                    raise OutputFormatError(
                        f"{self.path}: the rows are not in the order of their ids; {DAMAGED}"
                    )
                last = int(ids[-1])
                if self._ids is not None or last != self.n_particles + len(ids):
                    self._ids = np.concatenate([self.ids(0, self.n_particles), ids])
                self.n_particles = self.n_particles + len(ids)
                self.box = frame.box
                spheres = frame["diameter"] > 0  # nodes of bars come after the spheres
                self.n_spheres += int(np.count_nonzero(spheres))
                if spheres.any():
                    places = frame.vector("x", "y", "z")[spheres]
                    self._bounds.append(
                        (places.min(axis=0), places.max(axis=0), float(frame["diameter"].max()) / 2)
                    )
        self.low = np.min([low for low, _, _ in self._bounds], axis=0)

    @property
    def n_parts(self) -> int:
        """Number of parts."""
        return len(self._bounds)

    @property
    def last_sphere(self) -> int:
        """Largest id of a sphere."""
        return int(self.ids(self.n_spheres - 1, self.n_spheres)[0])

    def range(self, part: int) -> tuple[int, int]:
        """Return the first row of a part, and the row after its last row."""
        return part * self.at_once, min((part + 1) * self.at_once, self.n_spheres)

    def read(self, rows: slice | NDArray[np.int64] = slice(None)) -> Frame:
        """Return particles by their rows."""
        values = self._values
        if values is None:  # paged in as it is needed
            values = np.memmap(
                self._scratch, np.float64, "r", shape=(self.n_particles, len(DATA_COLUMNS))
            )
        return Frame(0, self.box, DATA_COLUMNS, np.asarray(values[rows]))

    def ids(self, first: int, stop: int) -> NDArray[np.int64]:
        """Return the ids of a range of rows."""
        return np.arange(first + 1, stop + 1) if self._ids is None else self._ids[first:stop]

    def rows(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the rows of particles; raise KeyError for ids without a particle."""
        return rows_of_all(self.n_particles, ids) if self._ids is None else rows_of(self._ids, ids)

    def check_ids(self, path: Path, frame: Frame) -> None:
        """Raise OutputFormatError if a dump names a particle that does not exist."""
        for name in ("i", "j", "id"):
            if name in frame.columns:
                ids = frame[name]
                refuse_ids(path, ids[~self._exists(ids)])

    def _exists(self, ids: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return True for ids of particles."""
        if self._ids is None:
            return (ids >= 1) & (ids <= self.n_particles)
        row = np.minimum(np.searchsorted(self._ids, ids), len(self._ids) - 1)
        return np.asarray(self._ids[row] == ids)

    def around(
        self, part: int, further: NDArray[np.int64], gap: float, periodic: tuple[bool, bool, bool]
    ) -> Frame:
        """Return the spheres of a part, spheres of other parts that may touch them, and further
        spheres, sorted by id.

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
            return self.read(slice(self.n_spheres))
        low, high, radius = self._bounds[part]
        reach = (1 + _MARGIN) * (radius + max(largest for _, _, largest in self._bounds) + gap)
        free = ~np.array(periodic)
        low = (low - reach)[free]
        high = (high + reach)[free]
        rows = [np.arange(*self.range(part)), self.rows(further)]
        for other, (its_low, its_high, _) in enumerate(self._bounds):
            if other != part and np.all((its_low[free] <= high) & (its_high[free] >= low)):
                places = self.read(slice(*self.range(other))).vector("x", "y", "z")[:, free]
                near = np.all((places >= low) & (places <= high), axis=1)
                rows.append(self.range(other)[0] + np.flatnonzero(near))
        return self.read(sorted_once(np.concatenate(rows)))


class DentRecord:
    """Contacts at one instant of a run, by the parts of the spheres, in scratch files.

    Attributes
    ----------
    at_bars
        Contacts of spheres with the faces of bars.
    """

    def __init__(
        self, start: Start, dump: ContactDump, scratch: Callable[[], Path], processes: Processes
    ) -> None:
        like, rows, expected = dump.unread(start.at_once)
        self._parts = RowsByPart(like)
        n_rows = 0
        at_bars = [like.values]
        tasks = ((frame, scratch()) for frame in rows)
        for n_read, others, places in processes.map(partial(_by_part, start, dump.path), tasks):
            n_rows += n_read
            at_bars.append(others)
            self._parts.add(places)
        if n_rows != expected:
            list(dump.frames(start.at_once))
        self.at_bars = like.with_rows(np.concatenate(at_bars))

    def of_part(self, part: int) -> Callable[[], Frame]:
        """Return the reader of the contacts of the spheres of a part with other spheres; any
        process can call it.
        """
        return self._parts.reader(part)


class PlaceOfRows(NamedTuple):
    """Rows of a part in a scratch file: the part, the file, the first byte, and their number."""

    part: int
    path: Path
    byte: int
    n_rows: int


class RowsByPart:
    """Rows in scratch files, by the parts of the spheres.

    Parameters
    ----------
    like
        Frame with the columns of the rows.
    """

    def __init__(self, like: Frame) -> None:
        self._like = like.with_rows(like.values[:0])
        self._places: dict[int, list[PlaceOfRows]] = {}

    def add(self, places: Iterable[PlaceOfRows]) -> None:
        """Add rows of a scratch file."""
        for place in places:
            self._places.setdefault(place.part, []).append(place)

    def reader(self, part: int) -> Callable[[], Frame]:
        """Return the reader of the rows of a part, in the order in which they were added; any
        process can call it.
        """
        return partial(_read_places, self._like, self._places.get(part, []))


def _read_places(like: Frame, places: list[PlaceOfRows]) -> Frame:
    """Read rows of scratch files, in the order in which they were written."""
    values = np.empty((sum(place.n_rows for place in places), len(like.columns)))
    at = 0
    for place in places:
        rows = values[at : at + place.n_rows]
        found = np.fromfile(place.path, np.float64, rows.size, offset=place.byte)
        rows[:] = found.reshape(rows.shape)
        at += place.n_rows
    return like.with_rows(values)


def write_by_part(
    path: Path, values: NDArray[np.float64], *parts: NDArray[np.int64]
) -> list[PlaceOfRows]:
    """Write rows to a scratch file, part by part.

    Parameters
    ----------
    values
        Rows: (n_rows, n_columns).
    parts
        Part of each row, (n_rows,); of contacts two, the parts of both spheres.
    """
    places = []
    with open(path, "wb") as file:
        for part in np.unique(np.concatenate(parts)).tolist():
            here = np.logical_or.reduce([numbers == part for numbers in parts])
            rows = values if here.all() else values[here]
            places.append(PlaceOfRows(part, path, file.tell(), len(rows)))
            rows.tofile(file)
    return places


def _by_part(
    start: Start, source: Path, task: tuple[Frame, Path]
) -> tuple[int, NDArray[np.float64], list[PlaceOfRows]]:
    """Write contacts to a scratch file by part; return the number of all contacts, the contacts
    with bars, and the position of each part.
    """
    frame = task[0].read()
    path = task[1]
    start.check_ids(source, frame)
    pairs = frame.vector("i", "j").astype(np.int64)
    between = pairs.max(axis=1, initial=0) <= start.last_sphere
    values = frame.values if between.all() else frame.values[between]
    first, second = (start.rows(ids) // start.at_once for ids in pairs[between].T)
    return len(frame), frame.values[~between], write_by_part(path, values, first, second)
