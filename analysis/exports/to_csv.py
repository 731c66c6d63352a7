"""Tables of a run or a scan as CSV, for pandas and spreadsheets.

    spheres.csv  contacts.csv  wall_contacts.csv  energy.csv  walls_NAME.csv  probes.csv     the tables of result.h5
    snapshots.csv  snapshot_NNNN.csv                when each snapshot was taken, and the spheres in it
    points.csv                                      of a scan: a row a point

The unit stands at the end of a column's name. Numbers are the shortest text that gives the same double back, which
needs up to 17 digits; what has no value is blank. Reading them without a loss::

    pandas.read_csv("spheres.csv")                      # before pandas 3.1 with float_precision="round_trip"
    numpy.genfromtxt("spheres.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.exports.staging import Staging
from granwave.analysis.h5md import GROUP
from granwave.analysis.result import Result
from granwave.analysis.scan_table import ScanData

OUTDATED = r"snapshot_\d{4,}\.csv|walls_(bottom|[xy]lo|[xy]hi)\.csv|probes\.csv"
_TABLES = ("spheres", "contacts", "wall_contacts", "energy", "probes")
#: Columns in this order, and then the others by name.
_FIRST = ("id", "i", "j", "wall", "step", "time", "position", "radius", "mass")
_ROWS = 65_536  # at a time: text takes many times the memory of the numbers


def export_run(result: Result, staging: Staging) -> None:
    """Write the tables of a run."""
    tables = {name: name for name in _TABLES if name in result}
    tables |= {f"walls/{wall}": f"walls_{wall}" for wall in result.names("walls")}
    for group, name in tables.items():
        names = sorted(result.names(group), key=_place)
        columns = {column: result.file[group][column] for column in names}
        _write(staging.path(f"{name}.csv"), columns, {column: result.unit(f"{group}/{column}") for column in columns})
    files = [f"snapshot_{number:04d}.csv" for number in range(result.n_frames)]
    units = {"id": "1"} | {name: result.unit(f"{GROUP}/{name}/value") for name in result.quantities}
    for number, name in enumerate(files):
        values = {quantity: result.frame(number, quantity) for quantity in result.quantities}
        _write(staging.path(name), {"id": result["spheres/id"], **values}, units)
    snapshots = {
        "frame": np.arange(result.n_frames),
        "step": result[f"{GROUP}/position/step"],
        "time": result.frame_times,
        "file_name": np.array(files, dtype=object),
    }
    _write(staging.path("snapshots.csv"), snapshots, {"time": "s"})


def export_scan(scan: ScanData, staging: Staging) -> None:
    """Write the table of a scan; summary values have their units in their names as they are."""
    _write(staging.path("points.csv"), scan.columns, {key: scan.unit(key) for key in scan.varied})


def column_name(name: str, unit: str) -> str:
    """A name with its unit at the end: ``struck_velocity_m_s``."""
    suffix = unit.replace(" s-1", "_s").replace("/", "_").replace("^", "")
    return name if suffix in ("", "1") or name.endswith(f"_{suffix}") else f"{name}_{suffix}"


def _place(column: str) -> int:
    return _FIRST.index(column) if column in _FIRST else len(_FIRST)


def _write(path: Path, columns: Mapping[str, NDArray | h5py.Dataset], units: Mapping[str, str]) -> None:
    """Write columns, (n,) or (n, 3), of one length."""
    header: list[str] = []
    for name, values in columns.items():
        parts = [f"{name}_{axis}" for axis in "xyz"] if values.ndim == 2 else [name]
        header += [column_name(part, units.get(name, "1")) for part in parts]
    n_rows = max((len(values) for values in columns.values()), default=0)
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for start in range(0, n_rows, _ROWS):
            rows = slice(start, start + _ROWS)
            writer.writerows(zip(*(text for values in columns.values() for text in _cells(values, rows)), strict=True))


def _cells(values: NDArray | h5py.Dataset, rows: slice) -> Sequence[list[object]]:
    """One list of cells for each component."""
    if isinstance(values, h5py.Dataset) and h5py.check_string_dtype(values.dtype):
        values = values.asstr()
    part = np.asarray(values[rows])
    return [["" if cell != cell else cell for cell in column] for column in np.atleast_2d(part.T).tolist()]
