"""Table of a scan with a row for each point, as CSV and HDF5, and its reader for scripts and
notebooks.

Columns: varied keys, status of the point, and all values of its ``summary.json``. If
``packing.seed`` varies, a second table has the means over points that differ only in it, with 95 %
confidence intervals and standard deviations.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.model import is_number
from granwave.analysis.formatting.values import unit_of
from granwave.analysis.measures.zone_size import bounds_in_words
from granwave.analysis.quantities import quantity
from granwave.analysis.result.hdf5_file import new_hdf5
from granwave.analysis.scans.result import SEED, PointResult, ScanResult
from granwave.analysis.statistics import Estimate, estimate
from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.files import replacing, write_csv_rows
from granwave.lammps_inputs.run_directory import SCAN_DATA, SCAN_MEANS, SCAN_TABLE

if TYPE_CHECKING:
    import pandas
    import xarray

MEAN_GROUP = "mean"
#: Prefixes of keys that have no physical meaning if other keys determine them.
TIMES = ("run.", "output.")
MEAN = ".mean"
DEVIATION = ".std"
CONFIDENCE = ".ci95"
COUNT = "n"

_INT64 = range(-(2**63), 2**63)

Columns = dict[str, list[Any]]


def scan_table(result: ScanResult) -> Columns:
    """Return the scan as columns of equal length, a row for each point in order; None for missing
    values.

    Returns
    -------
    dict
        Varied keys; ``status``, ``reason``, ``directory`` (relative to the directory of the scan;
        empty if there is none), ``attempts``; all values of the summaries, in their order and SI
        units. Versions are ``versions.NAME``; lists are text, ``none`` if empty. A summary value
        with the name of another column is ``summary.NAME``.
    """
    points = result.points
    table: Columns = labels_of(points, result.varied)
    table["status"] = [point.status for point in points]
    table["reason"] = [point.reason for point in points]
    places = [point.directory for point in points]
    table["directory"] = [
        "" if place is None else os.path.relpath(place, result.directory) for place in places
    ]
    table["attempts"] = [point.attempts for point in points]
    return table | _summaries(points, taken=table)


def labels_of(points: Sequence[PointResult], keys: Iterable[str]) -> dict[str, list[Any]]:
    """Return the labels of points by key."""
    columns = {}
    for key in keys:
        columns[key] = [point.labels.get(key) for point in points]
    return columns


def scan_statistics(result: ScanResult) -> Columns:
    """Return means, standard deviations and confidence intervals over seeds, with a row for each
    set of points that differ only in the seed.

    Returns
    -------
    dict
        Other varied keys; ``n``, the number of finished points of the set; for each numeric summary
        value ``NAME.mean``, ``NAME.std`` (over n - 1) and ``NAME.ci95``, the half-width of the 95 %
        confidence interval of the mean (both None for fewer than two). Empty if the seed does not
        vary.
    """
    if SEED not in result.varied:
        return {}
    keys = [key for key in result.varied if key != SEED]
    points = result.points
    groups: dict[tuple[Any, ...], list[int]] = {}
    for row, point in enumerate(points):
        labels = tuple(point.labels.get(key) for key in keys)
        groups.setdefault(labels, []).append(row)
    table: Columns = {}
    for n, key in enumerate(keys):
        table[key] = [labels[n] for labels in groups]
    table[COUNT] = []
    for rows in groups.values():
        table[COUNT].append(sum(points[row].status == "done" for row in rows))
    for name, column in _summaries(points, taken=()).items():
        if not _is_numeric(column):
            continue
        estimates = [_estimate_of(column, rows) for rows in groups.values()]
        spreads = [mean if mean and mean.n > 1 else None for mean in estimates]
        table[name + MEAN] = [mean.mean if mean else None for mean in estimates]
        table[name + DEVIATION] = [mean.deviation if mean else None for mean in spreads]
        table[name + CONFIDENCE] = [mean.half_width if mean else None for mean in spreads]
    return table


def _estimate_of(column: Sequence[Any], rows: Sequence[int]) -> Estimate | None:
    """Estimate the mean of some rows of a column; None without values."""
    values = [column[row] for row in rows if column[row] is not None]
    return estimate(values) if values else None


def write_scan_table(scan: str | Path | ScanResult) -> Path:
    """Write ``scan.csv`` and ``scan.h5``, and ``scan_mean.csv`` if the seed varies, each
    atomically.

    In ``scan.h5`` every column is a data set with its unit ("1" if dimensionless): numbers as
    float64 (NaN if missing), or int64 if all are integers and none is missing; other values as
    UTF-8 text. The means are in the group ``/mean``.

    Parameters
    ----------
    scan
        Directory of the scan, or the scan itself, whose summaries are cached if the table is
        written repeatedly.

    Returns
    -------
    Path
        Path of scan.csv.

    Raises
    ------
    MissingOutputError
        There is no scan in the directory.
    OutputFormatError
        The index of the scan is damaged.
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    result = scan if isinstance(scan, ScanResult) else ScanResult(scan)
    table = scan_table(result)
    means = scan_statistics(result)
    result.results.claim([SCAN_TABLE, SCAN_DATA, *([SCAN_MEANS] if means else [])])
    _write_csv(table, result.directory / SCAN_TABLE)
    if means:
        _write_csv(means, result.directory / SCAN_MEANS)
    else:
        result.results.clear([SCAN_MEANS])
    with new_hdf5(result.directory / SCAN_DATA) as file:
        file.attrs["name"] = result.name
        file.attrs["case"] = result.case_name
        file.attrs["versions"] = json.dumps(versions_of(()))
        _write_group(file, table, result.units)
        if means:
            _write_group(file.create_group(MEAN_GROUP), means, result.units)
    return result.directory / SCAN_TABLE


def column_unit(name: str, units: Mapping[str, str]) -> str:
    """Return the unit of a column of the table of a scan with these units of keys, "1" if
    dimensionless.
    """
    if unit := units.get(name) or unit_of(name):
        return unit
    name = (
        name.removeprefix("summary.")
        .removesuffix(MEAN)
        .removesuffix(DEVIATION)
        .removesuffix(CONFIDENCE)
    )
    return "1" if "." in name else quantity(name).unit or "1"


@dataclasses.dataclass(frozen=True, eq=False)
class ScanData(Mapping[str, NDArray]):
    """Table of a scan as numpy arrays by column: ``data["dissipated_fraction"]``.

    Numbers are float64 (NaN if missing) or int64, other values are text, empty if missing.

    Attributes
    ----------
    name, case_name
        Names of the scan and of its case.
    varied
        Varied keys.
    columns
        Arrays (n_points,) by name.
    units
        SI units of the varied keys that have one.
    """

    name: str
    case_name: str
    varied: tuple[str, ...]
    columns: dict[str, NDArray]
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def __getitem__(self, name: str) -> NDArray:
        try:
            return self.columns[name]
        except KeyError:
            raise KeyError(
                f"scan {self.name} has no column {name}; it has {', '.join(self.columns)}"
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.columns["status"])

    def unit(self, name: str) -> str:
        """Return the SI unit of a column, "1" if dimensionless.

        Raises
        ------
        KeyError
            There is no such column.
        """
        self[name]
        return column_unit(name, self.units)

    def where(self, status: str = "done", **values: Any) -> ScanData:
        """Select the points with a status and given values.

        Parameters
        ----------
        status
            ``done``, ``failed`` or ``missing``.
        values
            Required values of further columns, ``material="brass"``; dotted names through
            ``**{"load.velocity": 5}``.
        """
        chosen = self["status"] == status
        for name, value in values.items():
            chosen &= self[name] == value
        return dataclasses.replace(
            self, columns={name: column[chosen] for name, column in self.columns.items()}
        )

    def to_pandas(self) -> pandas.DataFrame:
        """Convert the table to a DataFrame, with the unit of every column in ``attrs["units"]``."""
        import pandas

        table = pandas.DataFrame(self.columns)
        table.attrs["units"] = {name: column_unit(name, self.units) for name in self.columns}
        return table

    def to_xarray(self) -> xarray.Dataset:
        """Convert the table to a Dataset with a dimension for each independent key.

        A key that another key determines is a coordinate along the dimension of this key.

        Raises
        ------
        ValueError
            The points do not fill a grid with one point at each position.
        """
        import xarray

        labels = {key: self[key].tolist() for key in self.varied}
        axes = independent_keys(labels)
        codes = {}
        sizes = {}
        for key in axes:
            values = list(dict.fromkeys(labels[key]))
            codes[key] = [values.index(label) for label in labels[key]]
            sizes[key] = len(values)
        shape = tuple(sizes.values())
        flat = np.zeros(self.n_points, dtype=np.int64)  # position of each point in the grid
        if axes:
            flat = np.ravel_multi_index(tuple(codes.values()), shape)
        if self.n_points != math.prod(shape) or len(np.unique(flat)) != self.n_points:
            size = " × ".join(map(str, shape)) or "1"
            raise ValueError(
                f"scan {self.name}: found {self.n_points} points at {len(np.unique(flat))} "
                f"positions of a grid of {size} ({', '.join(axes)}), expected one at each; use "
                "to_pandas, or select some of the points"
            )
        order = np.argsort(flat)
        variables = {}
        for name, column in self.columns.items():
            if name not in self.varied:
                attributes = {"units": column_unit(name, self.units)}
                variables[name] = (tuple(axes), column[order].reshape(shape), attributes)
        coordinates = {}
        for key in self.varied:
            axis = key
            if key not in axes:
                axis = next(name for name in axes if determines(labels[name], labels[key]))
            value_at = dict(zip(labels[axis], labels[key], strict=True))
            attributes = {"units": column_unit(key, self.units)}
            coordinates[key] = (axis, list(value_at.values()), attributes)
        return xarray.Dataset(variables, coordinates, {"name": self.name, "case": self.case_name})


def read_scan(directory: str | Path) -> ScanData:
    """Read the present table of a scan, for scripts and notebooks.

    Raises
    ------
    MissingOutputError
        There is no scan in the directory.
    OutputFormatError
        Its index is damaged.
    """
    result = ScanResult(directory)
    columns = {name: _array(column) for name, column in scan_table(result).items()}
    texts = {
        name: np.array(column, dtype=str)
        for name, column in columns.items()
        if column.dtype == object
    }
    return ScanData(result.name, result.case_name, result.varied, columns | texts, result.units)


def independent_keys(labels: Mapping[str, Sequence[Any]]) -> list[str]:
    """Return the independent keys, without constant keys and keys that another key determines
    (zipped keys).

    Among keys that determine each other the first is kept; keys of ``run`` and ``output`` go
    first.
    """
    kept = [key for key, column in labels.items() if len(set(column)) > 1]
    for key in sorted(reversed(kept), key=lambda key: not key.startswith(("run.", "output."))):
        if any(other != key and determines(labels[other], labels[key]) for other in kept):
            kept.remove(key)
    return kept


def determines(leader: Sequence[Any], follower: Sequence[Any]) -> bool:
    """Return True if equal values of ``leader`` always occur with equal values of ``follower``."""
    return len(set(zip(leader, follower, strict=True))) == len(set(leader))


def physical(labels: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
    """Return labels by key without keys such as run times that follow from the other keys."""
    others = [column for name, column in labels.items() if not name.startswith(TIMES)]
    together = list(zip(*others, strict=True))
    return {
        name: column
        for name, column in labels.items()
        if not name.startswith(TIMES) or not others or not determines(together, column)
    }


def _summaries(points: Sequence[PointResult], taken: Any) -> Columns:
    """Return the values of the summaries by column, None for points without the value."""
    rows = [_flat(point.summary) for point in points]
    columns = {}
    for name in dict.fromkeys(itertools.chain.from_iterable(rows)):
        column = f"summary.{name}" if name in taken else name
        columns[column] = [row.get(name) for row in rows]
    return columns


def _flat(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary with the values of its tables as ``TABLE.NAME``, and lists as text."""
    flat: dict[str, Any] = {}
    for name, value in summary.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{part}": inner for part, inner in value.items()}
        else:
            flat[name] = bounds_in_words(value) if isinstance(value, list) else value
    return flat


def _is_numeric(column: Sequence[Any]) -> bool:
    present = [value for value in column if value is not None]
    return bool(present) and all(map(is_number, present))


def _text(value: Any) -> str:
    """Convert a value to text of the table: booleans as in TOML, without characters that UTF-8 or
    HDF5 lack.
    """
    if value is None:
        return ""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return text.replace("\0", "").encode("utf-8", "replace").decode("utf-8")


def _array(column: Sequence[Any]) -> NDArray:
    """Convert a column to an array of float64, int64, or str objects."""
    if not _is_numeric(column):
        return np.array([_text(value) for value in column], dtype=object)
    if all(isinstance(value, int) and value in _INT64 for value in column):
        return np.array(column, dtype=np.int64)
    return np.array([math.nan if value is None else value for value in column], dtype=np.float64)


def _write_csv(table: Columns, path: Path) -> None:
    columns = [map(_csv_cell, column) for column in table.values()]
    with replacing(path) as scratch, open(scratch, "w", encoding="utf-8", newline="") as file:
        write_csv_rows(file, [list(table), *zip(*columns, strict=True)])


def _csv_cell(value: Any) -> Any:
    return value if is_number(value) else _text(value)


def _write_group(group: h5py.Group, table: Columns, units: Mapping[str, str]) -> None:
    for name, column in table.items():
        values = _array(column)
        options = {"dtype": h5py.string_dtype()} if values.dtype == object else {}
        group.create_dataset(name, data=values, **options).attrs["unit"] = column_unit(name, units)
