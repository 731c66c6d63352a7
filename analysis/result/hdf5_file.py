"""Files of the analysis: HDF5 written atomically, groups of ``result.h5`` with their units, and
rows by id.

HDF5 crashes the program if it cannot write data that it holds in memory. Failing writes are
therefore hidden from it, and their error is raised after HDF5 has closed the file.
"""

from __future__ import annotations

import contextlib
import io
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.lammps_inputs.deck.columns import CONTACTS, LEDGER, MOVING_WALL, WALL_CONTACTS
from granwave.lammps_inputs.files import naming, replacing
from granwave.lammps_inputs.interrupts import held_back
from granwave.lammps_inputs.planning.cost import ANALYSED_AT_ONCE


@contextlib.contextmanager
def new_hdf5(path: Path, **options: Any) -> Iterator[h5py.File]:
    """Provide a new HDF5 file that replaces ``path`` when complete; on an error the old file
    remains.

    Parameters
    ----------
    options
        Options of `h5py.File`.

    Raises
    ------
    OSError
        The file cannot be written; the error names it.
    """
    with (
        replacing(path) as scratch,
        held_back(),  # HDF5 crashes if a write function that it called raises
        unfailing(scratch) as stream,
        h5py.File(stream, "w", **options) as file,
    ):
        yield file


@contextlib.contextmanager
def unfailing(path: Path) -> Iterator[io.FileIO]:
    """Provide a new file in which writing never fails; at the end, the first error is raised."""
    with naming(path), _Unfailing(path, "w+") as stream:
        try:
            yield stream
        finally:
            if stream.error is not None:
                raise stream.error


class _Unfailing(io.FileIO):
    error: OSError | None = None

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        done = 0
        while self.error is None and done < len(view):
            try:
                done += super().write(view[done:])
            except OSError as error:
                self.error = error
        self.seek(len(view) - done, io.SEEK_CUR)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return self.tell() if size is None else size


COMPRESSION: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
ROWS_IN_CHUNK = 32_768
AT_ONCE = ANALYSED_AT_ONCE  # rows of a table that are held at once; a multiple of ROWS_IN_CHUNK
_COMPRESSED_FROM = 4096  # values; smaller data sets are not compressed

_DERIVED = {
    "m": "initial_overlap position radius distance displacement yield_overlap effective_radius",
    "N": "initial_force force_sums lateral_force peak_force_with_walls",
    "J": "elastic_energy dissipated_energy dissipated_energy_wall friction_energy viscous_energy stored bar "
    "incident_bar",
    "s": "arrival peak_time width",
    "m s-1": "velocity peak_speed largest_speed",
    "rad s-1": "angular_velocity",
    "kg": "mass",
    "N s": "impulse",
}
_UNITS = {one.name: one.unit for one in (*LEDGER, *MOVING_WALL, *WALL_CONTACTS, *CONTACTS)}
for _unit, _names in _DERIVED.items():
    _UNITS |= dict.fromkeys(_names.split(), _unit)
_PRESSED_WALL_UNITS = {"moved": "m", "force": "N"}  # of /prestage, by the beginning of the column
_PROBE_UNITS = {"u": "m", "v": "m s-1", "f": "N"}

# pieces of a column: first row, and a whole chunk or values
Pieces = list[tuple[int, bytes | NDArray]]


class Encoded(NamedTuple):
    """Rows of a column in the form of the file, made by any process."""

    dtype: np.dtype
    tail: tuple[int, ...]  # shape of a row
    pieces: Pieces


def encoded(values: NDArray, first: int, n_chunk: int = ROWS_IN_CHUNK) -> Encoded:
    """Encode values for the rows from ``first`` on of a column with a given number of rows in a
    chunk.

    Whole chunks are compressed by `COMPRESSION`; HDF5 compresses the other rows.
    """
    pieces: Pieces = []
    at = 0
    stop = len(values)
    while at < stop:
        n = min(n_chunk - (first + at) % n_chunk, stop - at)
        rows = values[at : at + n]
        if n == n_chunk:
            planes = (
                np.ascontiguousarray(rows).view(np.uint8).reshape(-1, values.dtype.itemsize).T
            )  # bytes shuffled
            pieces.append(
                (first + at, zlib.compress(planes.tobytes(), COMPRESSION["compression_opts"]))
            )
        else:
            pieces.append((first + at, rows))
        at += n
    return Encoded(values.dtype, values.shape[1:], pieces)


def encoded_columns(columns: Mapping[str, NDArray], first: int) -> dict[str, Encoded]:
    """Encode the rows of a table from ``first`` on."""
    return {name: encoded(values, first) for name, values in columns.items()}


def store(dataset: h5py.Dataset, pieces: Pieces, *before: int) -> None:
    """Write encoded rows; ``before`` are the indices before the index of rows."""
    for first, content in pieces:
        if isinstance(content, bytes):
            place = (*before, first)
            dataset.id.write_direct_chunk((*place, *[0] * (dataset.ndim - len(place))), content)
        else:
            dataset[(*before, slice(first, first + len(content)))] = content


def append_columns(file: h5py.File, name: str, columns: Mapping[str, Encoded], n_rows: int) -> None:
    """Write the next rows of a group that is made in parts; ``n_rows`` is the number of all rows so
    far.
    """
    group = file.require_group(name)
    for column, (dtype, tail, pieces) in columns.items():
        if column not in group:
            options: dict[str, Any] = {
                "maxshape": (None, *tail),
                "chunks": (ROWS_IN_CHUNK, *tail),
                **COMPRESSION,
            }
            group.create_dataset(column, (0, *tail), dtype, **options).attrs["unit"] = unit_of(
                name, column
            )
        group[column].resize(n_rows, axis=0)
        store(group[column], pieces)


def write_group(file: h5py.File, name: str, columns: Mapping[str, NDArray]) -> None:
    """Write columns as data sets of one group, each with its unit."""
    group = file.create_group(name)
    for column, values in columns.items():
        options: dict[str, Any] = dict(COMPRESSION) if values.size >= _COMPRESSED_FROM else {}
        if values.dtype == object:
            options["dtype"] = h5py.string_dtype()
        group.create_dataset(column, data=values, **options).attrs["unit"] = unit_of(name, column)


def unit_of(group: str, column: str) -> str:
    """Return the unit of a column of a group."""
    if group == "chain" or group.startswith("bars/"):
        return _UNITS.get(column.removeprefix("contact_"), "1")
    if group == "probes" and column not in ("step", "time"):
        quantity = column.rsplit("_", 1)[1]
        return _UNITS.get(quantity) or _PROBE_UNITS[quantity[0]]
    if group == "prestage" and column.startswith(("moved_", "force_")):
        return _PRESSED_WALL_UNITS[column.partition("_")[0]]
    return _UNITS.get(column, "1")


def rows_of(ids: NDArray[np.int64], wanted: ArrayLike) -> NDArray[np.int64]:
    """Return the rows of spheres (ids of any shape) in a table of rising ids (n,): id - 1 unless
    spheres are missing.

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
        raise KeyError(
            f"there is no sphere {wanted[~found].flat[0]} among the {n_spheres} of the packing"
        )


def sorted_once(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return sorted keys, each once; much faster than np.unique if the keys consist of sorted
    sequences.
    """
    keys = np.sort(keys.astype(np.int64), kind="stable")
    return keys[np.concatenate([[True], keys[1:] != keys[:-1]])] if len(keys) else keys
