"""Tables of a run as pandas DataFrames, with the unit of every column in ``attrs["units"]``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.analysis.errors import MissingDataError, did_you_mean
from granwave.analysis.exports.to_csv import TABLES, place_of_column
from granwave.analysis.lammps_output.dumps import read_frame_forces
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs.deck.columns import FORCES_AT_FRAMES

if TYPE_CHECKING:
    import pandas

UNITS = "units"  # key in ``attrs``
_AT_SNAPSHOTS = tuple(column.name for column in FORCES_AT_FRAMES)  # i, j, then forces
_INDEX = {"spheres": "id", "energy": "time", "probes": "time"}  # column that names the rows of a table


def frame_of(columns: Mapping[str, Any], units: Mapping[str, str], index: str = "") -> pandas.DataFrame:
    """Make a DataFrame of columns.

    Parameters
    ----------
    columns
        Values by name: (n_rows,) or (n_rows, 3), which becomes the columns ``NAME_x``, ``NAME_y`` and ``NAME_z``.
    units
        Unit of each of ``columns``, "1" if dimensionless.
    index
        Name of the column that becomes the index; empty for rows that are numbered.
    """
    import pandas

    split: dict[str, Any] = {}
    split_units: dict[str, str] = {}
    for name, values in columns.items():
        parts = {name: values}
        if np.ndim(values) == 2:
            parts = {f"{name}_{axis}": part for axis, part in zip("xyz", np.transpose(values), strict=True)}
        split |= parts
        split_units |= dict.fromkeys(parts, units[name])
    table = pandas.DataFrame(split)
    if index:
        table = table.set_index(index)
    table.attrs[UNITS] = split_units
    return table


def tables_of(result: Result) -> tuple[str, ...]:
    """Return the names of the tables that `table` makes of a result."""
    return tuple(name for name in TABLES if name in result)


def table(result: Result, name: str) -> pandas.DataFrame:
    """Return a group of result.h5 whose data sets are columns, such as ``contacts``.

    Raises
    ------
    MissingDataError
        The run has no such table.
    """
    there = tables_of(result)
    if name not in there:
        near = did_you_mean(str(name), there, 0.7)
        hint = f"{near} " if near else ""
        raise MissingDataError(f"{result.path}: has no table {name}; {hint}it has {', '.join(there)}")
    columns = sorted(result.names(name), key=place_of_column)
    values = {column: result.read(f"{name}/{column}") for column in columns}
    units = {column: result.unit(f"{name}/{column}") for column in columns}
    return frame_of(values, units, _INDEX.get(name, ""))


def walls(result: Result) -> pandas.DataFrame:
    """Return the histories of all walls below each other: ``wall``, ``time`` s, ``force`` N.

    Forces are positive outwards. Bottoms that move have further columns, NaN for other walls.
    """
    import pandas

    units, parts = {"wall": "1", "time": "s", "force": "N"}, []
    for wall in result.names("walls"):
        columns = sorted(result.names(f"walls/{wall}"), key=place_of_column)
        parts.append(pandas.DataFrame({"wall": wall} | {name: result.read(f"walls/{wall}/{name}") for name in columns}))
        units |= {name: result.unit(f"walls/{wall}/{name}") for name in columns}
    found = pandas.concat(parts, ignore_index=True) if parts else pandas.DataFrame({name: [] for name in units})
    found.attrs[UNITS] = {str(name): units[str(name)] for name in found.columns}
    return found


def contact_forces(result: Result) -> pandas.DataFrame:
    """Return the contacts that bear a force at each snapshot: ``time`` s, ``i``, ``j``, ``force`` N, ``tx`` ... N on i.

    Raises
    ------
    MissingDataError
        The run did not record them.
    """
    import pandas

    if not result.case.output.contact_forces:
        raise MissingDataError(
            f"{result.path.parent}: its snapshots hold no contact forces; run the case again with "
            "output.contact_forces = true"
        )
    times = dict(zip(result[f"{GROUP}/position/step"].tolist(), result.frame_times.tolist(), strict=True))
    parts = [
        pandas.DataFrame({"time": times[frame.step]} | {name: frame[name] for name in _AT_SNAPSHOTS})
        for frame in read_frame_forces(result.path.parent)
        if frame.step in times
    ]
    found = pandas.concat(parts, ignore_index=True).astype({"i": np.int64, "j": np.int64})
    found.attrs[UNITS] = {"time": "s", "i": "1", "j": "1"} | dict.fromkeys(_AT_SNAPSHOTS[2:], "N")
    return found
