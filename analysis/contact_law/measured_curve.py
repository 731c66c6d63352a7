"""Measured force-overlap curves, read from CSV, with the branch and the largest overlap of every row.

There are two forms. With a column ``branch`` (loading, unloading_N, reloading_N), as `granwave law -o x.csv` writes it,
all rows of one N lie below the same largest overlap. Otherwise the rows are in the order of measurement, and the
branches follow from the turning points of the overlap.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_csv_rows

_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6}
_COLUMNS = {  # names of columns of overlaps and of forces, with their units in SI units
    "overlap": {f"{name}_{unit}": size for name in ("overlap", "displacement") for unit, size in _LENGTHS.items()},
    "force": {f"force_{unit}": size for unit, size in _FORCES.items()},
}
_EXPECTED = {
    "overlap": "overlap_m, overlap_mm or overlap_um (or displacement_... for overlap_...)",
    "force": "force_N or force_kN",
}
BRANCH = "branch"
LOADING = "loading"
_BRANCHES = re.compile(r"loading|(?:un|re)loading(?:_?\w+)?")
_FAULTS = 5  # largest number in a message
_TURN = 0.01  # reversal over the largest overlap; smaller ones are noise

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
class Curve:
    """Force-overlap curve.

    Attributes
    ----------
    source
        Name of the source, for messages.
    branch
        Names of the branches: loading, unloading_N, reloading_N: (n,).
    overlap
        Overlaps: (n,), m.
    force
        Forces: (n,), N.
    peak
        Largest overlaps so far, on loading the overlaps themselves: (n,), m.
    """

    source: str
    branch: NDArray[np.str_]
    overlap: Array
    force: Array
    peak: Array

    @property
    def loading(self) -> NDArray[np.bool_]:
        """True for rows of first loading: (n,)."""
        return self.branch == LOADING

    @property
    def turns(self) -> Array:
        """Distinct overlaps at which unloading began, rising: (n_turns,), m."""
        return np.unique(self.peak[~self.loading])


def read_curve(path: str | Path) -> Curve:
    """Read a curve from a CSV file with columns of overlaps and forces, and optionally branch; others are ignored.

    The names of the columns hold the units, such as overlap_um, displacement_mm and force_kN.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, or holds a wrong number, a wrong branch or a negative overlap; the
        message gives the line of each fault.
    """
    rows, lines = _rows(Path(path))
    errors: list[str] = []
    names = {what: next(name for name in known if name in lines) for what, known in _COLUMNS.items()}
    columns = {name: [_number(row, name, f"{path}: line {n}", errors) for n, row in rows] for name in names.values()}
    named = BRANCH in lines
    branch = [(row.get(BRANCH) or "").strip() for _, row in rows]
    for (n, row), name, found in zip(rows, branch, columns[names["overlap"]], strict=True):
        if named and not _BRANCHES.fullmatch(name):
            errors.append(
                f"{path}: line {n}: branch: found {show(row.get(BRANCH) or '')}, "
                "expected loading, unloading_N or reloading_N"
            )
        if found < 0:
            errors.append(
                f"{path}: line {n}: {names['overlap']}: found {found:g}, expected none below 0 (compression > 0)"
            )
    if errors:
        raise InputError(errors[:_FAULTS] + [f"{path}: and {len(errors) - _FAULTS} more"] * (len(errors) > _FAULTS))
    overlap, force = (_COLUMNS[what][names[what]] * np.array(columns[names[what]]) for what in ("overlap", "force"))
    return _curve(str(path), overlap, force, branch if named else None)


def curve_of(overlap: ArrayLike, force: ArrayLike, branch: Sequence[str] | None = None) -> Curve:
    """Make a curve from overlaps (m) and forces (N); without ``branch`` in the order of measurement."""
    return _curve("curve", np.asarray(overlap, float), np.asarray(force, float), branch)


def _curve(source: str, overlap: Array, force: Array, branch: Sequence[str] | None) -> Curve:
    if branch is None:
        names, peak = _branches(overlap)
    else:
        names = np.array(branch, dtype=np.str_)
        turn = np.array([re.sub("^(un|re)loading_?", "", name) for name in names])
        peak = overlap.copy()
        for number in np.unique(turn[names != LOADING]):
            rows = (names != LOADING) & (turn == number)
            peak[rows] = overlap[rows].max()
    return Curve(source, names, overlap, force, peak)


def _branches(overlap: Array) -> tuple[NDArray[np.str_], Array]:
    """Return branch and largest overlap of every row of a measured curve, from its turning points."""
    ends = _turning_points(overlap, _TURN * float(overlap.max(initial=0.0)))
    names, peak = np.full(overlap.size, LOADING, dtype="<U20"), overlap.copy()
    number, largest, start = 0, 0.0, 0
    for end in ends:
        rows = slice(start, end + 1)
        if overlap[end] > overlap[max(start - 1, 0)] or start == 0:
            below = overlap[rows] < largest
            names[rows][below] = f"reloading_{number}"
            peak[rows][below] = largest
        else:
            if overlap[start - 1] >= largest:
                number, largest = number + 1, float(overlap[start - 1])
            names[rows] = f"unloading_{number}"
            peak[rows] = largest
        start = end + 1
    return names, peak


def _turning_points(values: Array, least: float) -> list[int]:
    """Return the indices at which a noisy sequence turns by more than ``least``, and its last index."""
    found: list[int] = []
    extreme, rising = 0, True
    for k in range(1, values.size):
        ahead = values[k] - values[extreme] if rising else values[extreme] - values[k]
        if ahead >= 0:
            extreme = k
        elif -ahead > least:
            found.append(extreme)
            extreme, rising = k, not rising
    return [*found, values.size - 1] if values.size else []


def _rows(path: Path) -> tuple[list[tuple[int, dict[str, str]]], list[str]]:
    """Read the rows of a CSV file with their line numbers, and the names of its columns."""
    parsed = read_csv_rows(path)
    columns = [name.strip() for name in parsed[0][1]] if parsed else []
    for what, known in _COLUMNS.items():
        there = [name for name in known if name in columns]
        if len(there) != 1:
            found = " and ".join(there) if there else ", ".join(columns) or "nothing"
            raise InputError(
                f"{path}: found {found}, expected one column {_EXPECTED[what]}: the name of a column holds its unit"
            )
    return [(n, dict(zip(columns, cells, strict=False))) for n, cells in parsed[1:]], columns


def _number(row: dict[str, str], name: str, where: str, errors: list[str]) -> float:
    text = (row.get(name) or "").strip()
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        errors.append(f"{where}: {name}: found {show(text)}, expected a number")
        return 0.0
    return value
