"""Trajectory of a run in the H5MD format (version 1.1, P. de Buyl et al.,
doi:10.1016/j.cpc.2014.01.018).

``/particles/spheres`` holds ``position``, ``displacement``, ``velocity``, ``contact_force``
(largest present force of a single contact), ``peak_force``, ``dissipated_energy`` (by yielding,
friction and viscous losses), ``elastic_energy`` (half the energy stored in each contact with
another sphere; NaN if it was not recorded) and, with friction, ``friction_energy``, with viscous
losses ``viscous_energy``, each as ``value``, ``step`` and ``time`` of every snapshot; ``id``,
``species``, ``radius`` and ``mass`` are constant. Positions are initial positions, in
the coordinates of the case, plus displacements, not wrapped into periodic boxes. All values are float64; overlaps should be computed
from displacements, which have 17 digits independently of the distance from the origin.
"""

from __future__ import annotations

import getpass
import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import AGAIN, Frame
from granwave.analysis.result.hdf5_file import COMPRESSION, ROWS_IN_CHUNK, Encoded, encoded, store
from granwave.analysis.result.start import (
    PlaceOfRows,
    RowsByPart,
    Start,
    periodic,
    write_by_part,
)
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.files import discard
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.run_directory import shown_dump

GROUP = "particles/spheres"
_VECTORS = {"position": "m", "displacement": "m", "velocity": "m s-1"}
# added columns of the dump, and the unit
_SCALARS = {
    "contact_force": (("force",), "N"),
    "peak_force": (("peak_force",), "N"),
    "dissipated_energy": (("dissipated", "friction", "viscous"), "J"),
    "elastic_energy": (("elastic", "elastic_tangential"), "J"),
    "friction_energy": (("friction",), "J"),
    "viscous_energy": (("viscous",), "J"),
}
_FIXED = {
    "id": (np.int64, "1"),
    "species": (np.int32, "1"),
    "radius": (np.float64, "m"),
    "mass": (np.float64, "kg"),
}
_INSTANTS = {"step": (np.int64, "1"), "time": (np.float64, "s")}
_OF_BOX = "m"  # unit of the data sets of the box
QUANTITIES = (*_VECTORS, *_SCALARS)


def unit_of_snapshots(name: str) -> str:
    """Return the unit of a data set by its path below `GROUP`, such as ``velocity/value``."""
    quantity, _, part = name.partition("/")
    if quantity == "box":
        return _OF_BOX
    if part in _INSTANTS:
        return _INSTANTS[part][1]
    if not part:
        return _FIXED[quantity][1]
    if quantity in _VECTORS:
        return _VECTORS[quantity]
    return _SCALARS[quantity][1]


def write_metadata(file: h5py.File, version: str) -> None:
    """Write the group ``/h5md``: version of the format, author and program."""
    group = file.create_group("h5md")
    group.attrs["version"] = np.array([1, 1], dtype=np.int32)
    try:
        user = getpass.getuser()
    except (KeyError, OSError):
        user = "unknown"
    group.create_group("author").attrs["name"] = user
    group.create_group("creator").attrs.update({"name": "granwave", "version": version})


def write_trajectory(
    file: h5py.File,
    assembly: Assembly,
    start: Start,
    frames: Iterable[Frame],
    timestep: float,
    source: Path,
    processes: Processes = ALONE,
    scratch: Callable[[], Path] | None = None,
) -> int:
    """Write ``/particles/spheres``, one snapshot at a time, or a part of one.

    Parameters
    ----------
    start
        Spheres at the start.
    frames
        Snapshots from `granwave.analysis.lammps_output.dumps.read_frames`.
    timestep
        Timestep, s.
    source
        File of the snapshots, for messages.
    processes
        Processes that read and compress.
    scratch
        Name for a scratch file, where the rows of a snapshot are not in the order of their ids:
        they are first sorted by the parts of the spheres. None: they are in this order.

    Returns
    -------
    int
        Step of the last snapshot.

    Raises
    ------
    OutputFormatError
        A snapshot has other spheres than the data file.
    """
    group = file.create_group(GROUP)
    origin = assembly.deck_origin
    n_chunk = min(start.n_spheres, ROWS_IN_CHUNK)
    _write_box(group, assembly, start)
    for name, (dtype, unit) in _FIXED.items():
        data = group.create_dataset(name, start.n_spheres, dtype, chunks=(n_chunk,), **COMPRESSION)
        data.attrs["unit"] = unit
    for columns in processes.map(partial(_fixed, start, n_chunk), range(start.n_parts)):
        for name, column in columns.items():
            store(group[name], column.pieces)

    scalars = _scalars_of(assembly.case)
    elements = {}
    for name in (*_VECTORS, *scalars):  # all share the step and the time of the first
        elements[name] = _create_element(group, name, start.n_spheres, n_chunk)
    steps: list[int] = []
    encode = partial(_encoded_block, start, scalars, source, n_chunk, origin)
    batches: Iterable[Iterable[_Block]]
    if scratch is None:
        batches = [_blocks(start, frames, source, steps)]
    else:
        batches = _sorted_blocks(start, frames, source, steps, processes, scratch)
    for blocks in batches:
        for number, columns in processes.map(encode, blocks):
            for name, element in elements.items():
                element.resize(number + 1, axis=0)
                store(element, columns[name].pieces, number)
    for name, values in (("step", steps), ("time", np.array(steps) * timestep)):
        group["position"][name].resize(len(steps), axis=0)
        group["position"][name][:] = values
    return steps[-1]


def _write_box(group: h5py.Group, assembly: Assembly, start: Start) -> None:
    """Write the box: its boundaries, edges and lower corner, m."""
    box = group.create_group("box")
    box.attrs["dimension"] = 3
    sides = periodic(assembly.case)
    box.attrs["boundary"] = ["periodic" if repeats else "none" for repeats in sides]
    # lower is an extension of the standard, whose boxes start at 0
    low, high = start.box.T
    for name, data in (("edges", high - low), ("lower", low + assembly.deck_origin)):
        box.create_dataset(name, data=data).attrs["unit"] = _OF_BOX


def _scalars_of(case: Case) -> dict[str, tuple[str, ...]]:
    """Return the columns of each scalar that the snapshots of a case have."""
    left_out = {"friction_energy": not case.has_friction, "viscous_energy": not case.has_loss}
    return {name: columns for name, (columns, _) in _SCALARS.items() if not left_out.get(name)}


def _create_element(group: h5py.Group, name: str, n_spheres: int, n_chunk: int) -> h5py.Dataset:
    """Create the group of a vector or scalar of each sphere, and return its data set of values.

    The group of positions has the steps and times, to which the others link.
    """
    vector = name in _VECTORS
    shape = (n_spheres, 3) if vector else (n_spheres,)
    element = group.create_group(name)
    values: h5py.Dataset = element.create_dataset(
        "value",
        (0, *shape),
        np.float64,
        maxshape=(None, *shape),
        chunks=(1, n_chunk, *shape[1:]),
        **COMPRESSION,
    )
    values.attrs["unit"] = unit_of_snapshots(f"{name}/value")
    for instant, (dtype, unit) in _INSTANTS.items():
        if name == "position":
            data = element.create_dataset(instant, (0,), dtype, maxshape=(None,))
            data.attrs["unit"] = unit
        else:
            element[instant] = group["position"][instant]
    return values


def _fixed(start: Start, n_chunk: int, part: int) -> dict[str, Encoded]:
    """Encode the time-independent values of the spheres of a part."""
    first, stop = start.range(part)
    spheres = start.read(slice(first, stop))
    values = {
        "id": spheres["id"],
        "species": spheres["type"],
        "radius": spheres["diameter"] / 2,
        "mass": spheres["density"] * np.pi / 6 * spheres["diameter"] ** 3,
    }
    return {
        name: encoded(values[name].astype(dtype), first, n_chunk)
        for name, (dtype, _) in _FIXED.items()
    }


class _Block(NamedTuple):
    """Rows of a snapshot, from row ``first`` on, by their reader, which any process can call."""

    number: int
    step: int
    first: int
    read: Callable[[], Frame]


def _blocks(
    start: Start, frames: Iterable[Frame], source: Path, steps: list[int]
) -> Iterator[_Block]:
    """Iterate over the snapshots in blocks of ``start.at_once`` spheres; note the step of each
    snapshot.
    """
    first = stop = 0
    held: list[Frame] = []
    for piece in frames:
        frame = _spheres_of(start, piece)
        stop = stop + len(frame)
        number = len(steps)
        at = 0
        if stop > start.n_spheres or (stop < start.n_spheres and not piece.more):
            raise _strange(source, number, piece.step, stop, start)
        while at < len(frame) or not piece.more:
            n = min(len(frame) - at, start.at_once - sum(map(len, held)))
            held.append(frame.with_rows(frame.values[at : at + n]))
            at += n
            whole = at == len(frame) and not piece.more
            if whole or sum(map(len, held)) == start.at_once:
                yield _Block(number, piece.step, first, partial(_rows_of, held))
                first = first + sum(map(len, held))
                held = []
            if whole:
                steps.append(piece.step)
                first = stop = 0
                break


def _spheres_of(start: Start, frame: Frame) -> Frame:
    """Return the rows of spheres of a frame, without the nodes of bars."""
    if start.n_spheres == start.n_particles:
        return frame
    return frame.read().up_to(start.last_sphere)


def _rows_of(frames: Sequence[Frame]) -> Frame:
    """Read frames of one snapshot as one."""
    return frames[0].with_rows(np.concatenate([frame.read().values for frame in frames]))


def _sorted_blocks(
    start: Start,
    frames: Iterable[Frame],
    source: Path,
    steps: list[int],
    processes: Processes,
    scratch: Callable[[], Path],
) -> Iterator[list[_Block]]:
    """Iterate over snapshots whose rows have any order: the blocks of each, one for each part.

    All rows of a snapshot are written to scratch files by part, which are removed when its blocks
    were processed. Steps are noted as by `_blocks`.
    """
    for step, pieces in itertools.groupby(frames, key=attrgetter("step")):
        number = len(steps)
        paths: list[Path] = []
        tasks = _with_paths(start, pieces, paths, scratch)
        sort = partial(_by_part, start, source, number)
        found = list(processes.map(sort, tasks))
        rows = RowsByPart(found[0].like)
        n_rows = 0
        for piece in found:
            rows.add(piece.places)
            n_rows += sum(place.n_rows for place in piece.places)
        if n_rows != start.n_spheres:
            raise _strange(source, number, step, n_rows, start)
        yield [
            _Block(number, step, start.range(part)[0], rows.reader(part))
            for part in range(start.n_parts)
        ]
        steps.append(step)
        for path in paths:
            discard(path)


def _with_paths(
    start: Start, pieces: Iterable[Frame], paths: list[Path], scratch: Callable[[], Path]
) -> Iterator[tuple[Frame, Path]]:
    """Iterate over the pieces of a snapshot with a scratch file for each, whose names are noted."""
    for piece in pieces:
        paths.append(scratch())
        yield _spheres_of(start, piece), paths[-1]


class _SortedPiece(NamedTuple):
    """Rows of a snapshot in a scratch file, by part, and a frame without rows."""

    like: Frame
    places: list[PlaceOfRows]


def _by_part(start: Start, source: Path, number: int, task: tuple[Frame, Path]) -> _SortedPiece:
    """Write rows of a snapshot to a scratch file by the part of the sphere."""
    frame = task[0].read()
    try:
        parts = start.rows(frame["id"].astype(np.int64)) // start.at_once
    except KeyError:
        raise _strange(source, number, frame.step, len(frame), start) from None
    like = frame.with_rows(np.empty((0, len(frame.columns))))
    return _SortedPiece(like, write_by_part(task[1], frame.values, parts))


def _encoded_block(
    start: Start,
    scalars: dict[str, tuple[str, ...]],
    source: Path,
    n_chunk: int,
    origin: NDArray[np.float64],
    block: _Block,
) -> tuple[int, dict[str, Encoded]]:
    """Read a block and encode its values."""
    frame = block.read().sorted_by("id")
    first = block.first
    stop = block.first + len(frame)
    if not np.array_equal(frame["id"], start.ids(first, stop)):
        raise _strange(source, block.number, block.step, stop, start)
    displacement = frame.vector("ux", "uy", "uz")
    unknown = np.full(len(frame), np.nan)
    places = start.read(slice(first, stop)).vector("x", "y", "z") + origin
    values = {"position": places + displacement}
    values |= {"displacement": displacement, "velocity": frame.vector("vx", "vy", "vz")}
    for name, columns in scalars.items():
        there = [frame[column] for column in columns if column in frame.columns]
        values[name] = np.sum(there, axis=0) if there else unknown
    return block.number, {name: encoded(column, first, n_chunk) for name, column in values.items()}


def _strange(
    source: Path, number: int, step: int, n_spheres: int, start: Start
) -> OutputFormatError:
    return OutputFormatError(
        f"{shown_dump(source)}: snapshot {number} (step {step}) holds {n_spheres} spheres that are not the {start.n_spheres} of "
        f"data.granwave: spheres were lost, or the files belong to different runs; {AGAIN}"
    )
