"""Tables of measured grains (CSV): columns of numbers, with a line number for each fault."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from granwave.analysis.inference.grains import TENSOR, Array
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_csv_rows

_UNIT = re.compile("_(m_s2|rad_s2|rad_s|rad|kg_m3|Pa|m|s|N)$")
_SHOWN = 10  # largest number of faults in a message
UNMEASURED = ("acceleration", "spin", "angular_acceleration", "strain", "stress")  # whose cells may be empty


def groups(dimension: int) -> dict[str, tuple[str, ...]]:
    """Return the names of the columns by what they tell."""
    axes = "xyz"[:dimension]
    turns = ("",) if dimension == 2 else ("_x", "_y", "_z")
    return {
        "position": tuple(f"{axis}_m" for axis in axes),
        "acceleration": tuple(f"a{axis}_m_s2" for axis in axes),
        "spin": tuple(f"omega{turn}_rad_s" for turn in turns),
        "angular_acceleration": tuple(f"alpha{turn}_rad_s2" for turn in turns),
        "angle": ("angle_rad",) if dimension == 2 else (),
        "force": tuple(f"f{axis}_N" for axis in axes),
        "strain": tuple(f"e{name}" for name in TENSOR[dimension]),
        "stress": tuple(f"s{name}" for name in TENSOR[dimension]),
        "material": ("density_kg_m3", "youngs_modulus_Pa", "poisson_ratio"),
        "other": ("id", "radius_m", "time_s", "frame", "passes_walls"),
    }


def aliases(dimension: int) -> dict[str, str]:
    """Return names without units, and with those of stresses, that columns may have too."""
    found = {}
    for name in (name for names in groups(dimension).values() for name in names):
        found[_UNIT.sub("", name)] = name
        if name[0] == "s" and name[1:] in TENSOR[dimension]:
            found[f"{name}_Pa"] = name
    return {short: name for short, name in found.items() if short != name}


@dataclasses.dataclass(frozen=True, eq=False)
class Table:
    """Table of grains.

    Attributes
    ----------
    source
        Name of the file, for messages.
    columns
        Columns of numbers, NaN where a cell is empty; the index has the line of each row.
    groups
        Names of the columns by what they tell, see `groups`.
    """

    source: str
    columns: pd.DataFrame
    groups: Mapping[str, tuple[str, ...]]

    def __len__(self) -> int:
        return len(self.columns)

    def has(self, group: str) -> bool:
        """Return True if there are all columns of a group."""
        return bool(self.groups[group]) and set(self.groups[group]) <= set(self.columns)

    def take(self, group: str) -> Array:
        """Return the columns of a group side by side: (n_rows, n_names)."""
        return self.columns[list(self.groups[group])].to_numpy()

    def each(self, name: str, default: float = math.nan) -> Array:
        """Return a column, or the default value in each row: (n_rows,)."""
        return self.columns[name].to_numpy() if name in self.columns else np.full(len(self), default)

    def refuse(self, wrong: NDArray[np.bool_], message: Callable[..., str]) -> list[str]:
        """Return an error with its line for each row that is wrong; ``message`` takes the row."""
        lines = self.columns.index
        return [f"{self.source}: line {lines[row]}: {message(row)}" for row in np.flatnonzero(wrong).tolist()]


def raise_errors(source: str, errors: Sequence[str]) -> None:
    """Raise InputError if there are errors, the first of them in full."""
    if errors:
        more = [f"{source}: and {len(errors) - _SHOWN} more"] if len(errors) > _SHOWN else []
        raise InputError([*errors[:_SHOWN], *more])


def read_table_of_grains(path: str | Path, dimension: int) -> Table:
    """Read a table of grains.

    Raises
    ------
    InputError
        The file cannot be read, a column is unknown, twice there or missing, or a cell is no number; the message gives
        the lines.
    """
    source, rows = str(path), read_csv_rows(Path(path))
    if not rows:
        raise InputError(f"{path}: found nothing, expected a line of names and a row for each grain")
    number, header = rows[0]
    errors: list[str] = []
    names = _names([name.strip() for name in header], f"{source}: line {number}", dimension, errors)
    raise_errors(source, errors)
    errors = [
        f"{source}: line {line}: found {len(cells)} values, expected {len(names)}: {', '.join(names)}"
        for line, cells in rows[1:]
        if len(cells) != len(names)
    ]
    raise_errors(source, errors)
    lines = [line for line, _ in rows[1:]]
    if not lines:
        raise InputError(f"{source}: found no grain, expected a row for each below the line of names")
    known = groups(dimension)
    texts = pd.DataFrame([cells for _, cells in rows[1:]], lines, names, dtype=str).apply(lambda one: one.str.strip())
    values = texts.apply(pd.to_numeric, errors="coerce").astype(np.float64)
    may_be_empty = texts.columns.isin([name for group in UNMEASURED for name in known[group]])
    for row, column in np.argwhere(~np.isfinite(values) & ~((texts == "") & may_be_empty)):
        empty = "; leave cells empty where nothing was measured" if may_be_empty[column] else ""
        text = show(texts.iloc[row, column])
        errors.append(f"{source}: line {lines[row]}: {names[column]}: found {text}, expected a finite number{empty}")
    raise_errors(source, errors)
    return Table(source, values, known)


def _names(names: list[str], where: str, dimension: int, errors: list[str]) -> list[str]:
    """Return the full names of the columns; add the errors of their choice."""
    known, short = groups(dimension), aliases(dimension)
    full = [short.get(name, name) for name in names]
    everything = [name for group in known.values() for name in group]
    for name, given in zip(full, names, strict=True):
        if name not in everything:
            errors.append(f"{where}: found a column {show(given)}, expected names among {', '.join(everything)}")
    for name in dict.fromkeys(name for name in full if full.count(name) > 1):
        errors.append(f"{where}: found the column {name} {full.count(name)} times, expected it once")
    missing = [name for name in (*known["position"], "radius_m") if name not in full]
    if missing:
        errors.append(f"{where}: lacks {', '.join(missing)}; expected {', '.join(known['position'])}, radius_m")
    for group, columns in known.items():
        there = [name for name in columns if name in full]
        if there and len(there) < len(columns) and group not in ("material", "other", "position"):
            errors.append(f"{where}: found {', '.join(there)}, expected all of {', '.join(columns)}, or none")
    tensors = [group for group in ("strain", "stress") if set(known[group]) <= set(full)]
    if len(tensors) == 2:
        errors.append(f"{where}: found strains and stresses, expected one of them")
    if not any(name in full for group in ("strain", "stress") for name in known[group]):
        errors.append(
            f"{where}: lacks strains or stresses; expected {', '.join(known['strain'])}, "
            f"or {', '.join(known['stress'])} (Pa)"
        )
    if "time_s" in full and "frame" in full:
        errors.append(f"{where}: found time_s and frame, expected one of them")
    return full
