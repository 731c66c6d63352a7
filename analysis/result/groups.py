"""Groups of ``result.h5``: columns with their units, written whole or part by part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.deck.columns import (
    ABSORBED,
    CONTACTS,
    FREE_PLATE,
    HOLDER,
    LEDGER,
    MOVING_WALL,
    ROTATION,
    SUPPORT,
    TANGENTIAL,
    TIMESTEP,
    VISCOUS,
    WALL_CONTACTS,
)
from granwave.lammps_inputs.planning.cost import ANALYSED_AT_ONCE

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
ROWS_IN_CHUNK = 32_768
AT_ONCE = ANALYSED_AT_ONCE  # spheres of a part, or rows of a table; a multiple of ROWS_IN_CHUNK
_COMPRESSED_FROM = 4096  # values; smaller data sets are not compressed

# units of columns that LAMMPS writes, and of derived ones
_UNITS = {
    column.name: column.unit
    for column in (
        *LEDGER,
        *TIMESTEP,
        *SUPPORT,
        *ROTATION,
        *TANGENTIAL,
        *HOLDER,
        *ABSORBED,
        *FREE_PLATE,
        *VISCOUS,
        *MOVING_WALL,
        *WALL_CONTACTS,
        *CONTACTS,
    )
} | {
    "initial_overlap": "m",
    "initial_force": "N",
    "position": "m",
    "radius": "m",
    "mass": "kg",
    "elastic_energy": "J",
    "dissipated_energy": "J",
    "dissipated_energy_wall": "J",
    "friction_energy": "J",
    "viscous_energy": "J",
    "stored": "J",
    "impulse": "N s",
    "distance": "m",
    "displacement": "m",
    "velocity": "m s-1",
    "angular_velocity": "rad s-1",
    "force_sums": "N",
    "arrival": "s",
    "peak_speed": "m s-1",
    "largest_speed": "m s-1",
    "peak_time": "s",
    "width": "s",
    "lateral_force": "N",
    "bar": "J",
    "incident_bar": "J",
    "yield_overlap": "m",
    "effective_radius": "m",
}
_PROBE_UNITS = {"u": "m", "v": "m s-1", "f": "N"}


class PartwiseGroup:
    """Group whose columns are written part by part.

    Parameters
    ----------
    n_parts
        Number of parts; a single one is written as `write_group` does.
    """

    def __init__(self, file: h5py.File, name: str, n_parts: int) -> None:
        self._file, self._name, self._n_parts = file, name, n_parts
        self._n_rows = 0

    def append(self, columns: Mapping[str, NDArray], rows: NDArray[np.bool_] | slice = slice(None)) -> None:
        """Write the columns of the next part, or some of their rows."""
        if self._n_parts == 1:
            write_group(self._file, self._name, columns)
            return
        group, stop = self._file.require_group(self._name), self._n_rows
        for column in columns:
            values = columns[column][rows]
            if column not in group:
                tail = values.shape[1:]
                options: dict[str, Any] = {"maxshape": (None, *tail), "chunks": (ROWS_IN_CHUNK, *tail), **COMPRESSION}
                group.create_dataset(column, (0, *tail), values.dtype, **options)
                group[column].attrs["unit"] = unit_of(self._name, column)
            stop = self._n_rows + len(values)
            group[column].resize(stop, axis=0)
            group[column][self._n_rows :] = values
        self._n_rows = stop


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
    return _UNITS.get(column, "1")
