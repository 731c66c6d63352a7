"""Measured grains, from a table (CSV) and the case: one instant, or a time series.

Each fault of the table is reported with its line.
"""

from __future__ import annotations

import itertools
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.signal import savgol_filter
from scipy.spatial import cKDTree

from granwave.extensions.inference.forces.case import FIND, InferCase
from granwave.extensions.inference.forces.grains import (
    TENSOR,
    TURNS,
    Array,
    MeasuredGrains,
    stiffness,
    volume_of,
)
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_number
from granwave.lammps_inputs.tables.layout import read_rows

_UNIT = re.compile("_(m_s2|rad_s2|rad_s|rad|kg_m3|Pa|m|s|N)$")
_SHOWN = 10  # largest number of faults in a message
#: Groups of columns whose cells may be empty.
UNMEASURED = ("acceleration", "spin", "angular_acceleration", "strain", "stress")
_MAY_BE_PARTIAL = ("material", "other", "position")  # groups of which single columns may be missing
LARGEST_STRAIN = 1.0
_INSIDE = 0.5  # distance / (R_i + R_j) below which two rows cannot be two grains
_EVEN = 0.01  # largest deviation of the interval between frames, relative to the median


def groups(dimension: int) -> dict[str, tuple[str, ...]]:
    """Return the names of the columns by group."""
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
    """Return the names of columns by their aliases: without units, stresses also with units."""
    names_by_group = groups(dimension)
    name_of_alias: dict[str, str] = {}
    for names in names_by_group.values():
        name_of_alias |= {_UNIT.sub("", name): name for name in names}
    name_of_alias |= {f"{name}_Pa": name for name in names_by_group["stress"]}
    return {alias: name for alias, name in name_of_alias.items() if alias != name}


def _at(time: float) -> str:
    return "" if math.isnan(time) else f" at {time:g} s"


def _raise(path: str | Path, errors: Sequence[str]) -> None:
    """Raise InputError if there are errors, the first of them in full."""
    if errors:
        more = [f"{path}: and {len(errors) - _SHOWN} more"] if len(errors) > _SHOWN else []
        raise InputError([*errors[:_SHOWN], *more])


def _number(text: str) -> float:
    """Return the number in a cell, NaN without one."""
    try:
        return read_number(text)
    except ValueError:
        return math.nan


def _read_columns(path: str | Path, dimension: int) -> pd.DataFrame:
    """Return the columns of numbers, NaN for empty cells; the index is the line of each row."""
    rows = read_rows(Path(path))
    if not rows:
        raise InputError(
            f"{path}: found nothing, expected a line of names and a row for each grain"
        )
    (number, header), *body = rows
    headings = [heading.strip() for heading in header]
    name_of_alias = aliases(dimension)
    names = [name_of_alias.get(heading, heading) for heading in headings]
    faults = _faults_of_names(headings, names, dimension)
    _raise(path, [f"{path}: line {number}: {fault}" for fault in faults])
    errors = [
        f"{path}: line {line}: found {len(cells)} values, expected {len(names)}: {', '.join(names)}"
        for line, cells in body
        if len(cells) != len(names)
    ]
    _raise(path, errors)
    if not body:
        raise InputError(f"{path}: found no grain, expected a row for each below the line of names")
    lines = [line for line, _ in body]
    texts = pd.DataFrame([cells for _, cells in body], lines, names, dtype=str)
    return _numbers(path, texts.apply(lambda column: column.str.strip()), dimension)


def _faults_of_names(
    headings: Sequence[str], names: Sequence[str], dimension: int
) -> Iterator[str]:
    """Return the faults of the headings of a table, and the quantities that the headings name."""
    names_by_group = groups(dimension)
    allowed = list(itertools.chain.from_iterable(names_by_group.values()))
    for name, heading in zip(names, headings, strict=True):
        if name not in allowed:
            yield f"found a column {show(heading)}, expected names among {', '.join(allowed)}"
    for name, count in Counter(names).items():
        if count > 1:
            yield f"found the column {name} {count} times, expected it once"
    places = names_by_group["position"]
    missing = [name for name in (*places, "radius_m") if name not in names]
    if missing:
        yield f"lacks {', '.join(missing)}; expected {', '.join(places)}, radius_m"
    for group, columns in names_by_group.items():
        present = [name for name in columns if name in names]
        if present and len(present) < len(columns) and group not in _MAY_BE_PARTIAL:
            yield f"found {', '.join(present)}, expected all of {', '.join(columns)}, or none"
    yield from _faults_of_deformation(names, names_by_group)
    if {"time_s", "frame"} <= {*names}:
        yield "found time_s and frame, expected one of them"


def _faults_of_deformation(
    names: Sequence[str], names_by_group: dict[str, tuple[str, ...]]
) -> Iterator[str]:
    """Return the faults of the columns of strains and stresses; a table has one or the other."""
    strains = {*names_by_group["strain"]} & {*names}
    stresses = {*names_by_group["stress"]} & {*names}
    if len(strains) == len(stresses) == len(names_by_group["strain"]):
        yield "found strains and stresses, expected one of them"
    if not strains | stresses:
        yield (
            f"lacks strains or stresses; expected {', '.join(names_by_group['strain'])}, or "
            f"{', '.join(names_by_group['stress'])} (Pa)"
        )


def _numbers(path: str | Path, texts: pd.DataFrame, dimension: int) -> pd.DataFrame:
    """Convert the cells of a table to numbers, NaN for empty cells that are allowed."""
    names_by_group = groups(dimension)
    optional = itertools.chain.from_iterable(names_by_group[group] for group in UNMEASURED)
    may_be_empty = texts.columns.isin(list(optional))
    values = texts.map(_number).astype(np.float64)
    errors = []
    for row, column in np.argwhere(~np.isfinite(values) & ~((texts == "") & may_be_empty)):
        empty = "; leave cells without a measurement empty" if may_be_empty[column] else ""
        text = show(texts.iloc[row, column])
        errors.append(
            f"{path}: line {texts.index[row]}: {texts.columns[column]}: found {text}, expected a "
            f"finite number{empty}"
        )
    _raise(path, errors)
    return values


def read_measurement(
    path: str | Path, case: InferCase
) -> tuple[list[float], list[MeasuredGrains], list[str]]:
    """Read measured grains.

    Returns
    -------
    times, grains, notes
        Instants, s, NaN for a table without times; the grains at each; assumptions where something
        was not measured.

    Raises
    ------
    InputError
        The table cannot be read or is invalid (with the lines), or the case lacks a key for it.
    """
    table = _Table(path, case)
    is_series = len(table.rows) > 1 and not table.has("acceleration")
    motion = table.differences() if is_series else table.measured_motion()
    times = list(motion)
    if case.infer.time is not None:
        if not any(map(math.isfinite, times)):
            raise InputError(f"{path}: found no column time_s or frame, which infer.time requires")
        times = [times[int(np.argmin(np.abs(np.array(times) - case.infer.time)))]]
    frames = [table.grains(time, *motion[time]) for time in times]
    # all grains are stretched under the other sign convention
    what = "strains" if table.has("strain") else "stresses"
    words = "contacts are compressive, and compression is negative"
    for time, grains in zip(times, frames, strict=True):
        mean = grains.stress[grains.has_stress, : case.dimension].sum(axis=1) / case.dimension
        if len(mean) and (mean > 0).all():
            raise InputError(
                f"{path}: found {what} that are tensile in each of the {len(mean)} "
                f"grains{_at(time)}: {words}; if compression is positive in your table, change "
                "the sign of all components"
            )
        if mean.sum() > 0:
            table.notes.append(
                f"most of the {what}{_at(time)} are tensile: {words}; check the signs"
            )
    return times, frames, table.notes


class _Table:
    """Table of grains, with the rows of each instant in the order of the ids.

    Attributes
    ----------
    columns
        Columns of numbers, NaN where a cell is empty; the index has the line of each row.
    rows
        Rows of each instant, s; NaN for a table without times.
    notes
        Assumptions where something was not measured.
    """

    def __init__(self, path: str | Path, case: InferCase) -> None:
        self.path = path
        self.case = case
        self.notes = list[str]()
        self.turns = TURNS[case.dimension]
        self.columns = _read_columns(path, case.dimension)
        self.groups = groups(case.dimension)
        self._check_values()
        self._check_modulus()
        times = self.each("time_s")
        if "frame" in self.columns:
            if case.infer.frame_rate is None:
                raise InputError(
                    f"{case.source}: infer.frame_rate: missing; the column frame of {path} "
                    "requires it"
                )
            times = self.each("frame") / case.infer.frame_rate
        ids = self.each("id")
        lines = self.columns.index
        if "id" not in self.columns:
            ids = np.arange(1.0, len(lines) + 1)
        instants = pd.DataFrame({"time": times, "id": ids}).groupby("time", dropna=False)
        if len(instants) > 1 and "id" not in self.columns:
            raise InputError(
                f"{path}: line {lines[0]}: lacks id, which identifies the grains of a series"
            )
        errors: list[str] = []
        self.rows: dict[float, NDArray[np.int64]] = {}
        for time, part in instants["id"]:
            rows = part.sort_values(kind="stable").index.to_numpy()
            self.rows[time] = rows
            errors += self._repeated(time, rows, ids[rows])
            errors += self._inside_others(rows)
        _raise(path, errors)

    def _repeated(self, time: float, rows: NDArray[np.int64], ids: Array) -> Iterator[str]:
        """Yield the faults of rows that repeat an id at an instant; the rows are sorted by id."""
        is_repeated = np.append(False, np.diff(ids) == 0)
        id_of_row = dict(zip(rows[is_repeated].tolist(), ids[is_repeated].tolist(), strict=True))
        for row, number in sorted(id_of_row.items()):
            yield (
                f"{self.path}: line {self.columns.index[row]}: id: found {number:g} "
                f"again{_at(time)}, expected each grain once"
            )

    def _inside_others(self, rows: NDArray[np.int64]) -> Iterator[str]:
        """Yield the faults of grains of an instant that lie inside each other."""
        x = self.take("position")[rows]
        radius = self.each("radius_m")[rows]
        lines = self.columns.index[rows]
        reach = 2 * _INSIDE * float(radius.max())
        for a, b in cKDTree(x).query_pairs(reach, output_type="ndarray"):
            distance = float(np.linalg.norm(x[a] - x[b]))
            if distance < _INSIDE * (radius[a] + radius[b]):
                first, last = sorted((lines[a], lines[b]))
                yield (
                    f"{self.path}: line {last}: lies in the grain of line {first}: found a "
                    f"distance of {distance:.3g} m of centres with radii of {radius[a]:.3g} and "
                    f"{radius[b]:.3g} m; check positions and radii (m), and that each grain has "
                    "one row"
                )

    def has(self, group: str) -> bool:
        """Return True if the table has all columns of a group."""
        return bool(self.groups[group]) and set(self.groups[group]) <= set(self.columns)

    def take(self, group: str) -> Array:
        """Return the columns of a group side by side: (n_rows, n_names)."""
        return self.columns[list(self.groups[group])].to_numpy()

    def each(self, name: str, default: float = math.nan) -> Array:
        """Return a column, or the default value in each row: (n_rows,)."""
        if name in self.columns:
            return self.columns[name].to_numpy()
        return np.full(len(self.columns), default)

    def _check_values(self) -> None:
        """Raise InputError for impossible values, and for groups of which some cells are empty."""
        strains = tuple(f"e{pair}" for pair in TENSOR[self.case.dimension])
        allowed: list[tuple[tuple[str, ...], Callable[[Array], NDArray[np.bool_]], str]] = [
            (
                ("radius_m", "density_kg_m3", "youngs_modulus_Pa"),
                lambda x: x > 0,
                "a number above 0",
            ),
            (("poisson_ratio",), lambda x: (x > -1) & (x < 0.5), "a number above -1 and below 0.5"),
            (("id",), lambda x: (x == np.floor(x)) & (x >= 0), "a whole number from 0 up"),
            (("passes_walls",), lambda x: np.isin(x, (0, 1)), "0, or 1 for a striker"),
            (
                strains,
                lambda x: ~(np.abs(x) > LARGEST_STRAIN),
                f"a strain below {LARGEST_STRAIN:g}; 1 % is 0.01",
            ),
        ]
        errors = []
        lines = self.columns.index
        for names, right, expected in allowed:
            for name in self.columns.columns.intersection(names):
                values = self.each(name)
                errors += [
                    f"{self.path}: line {lines[row]}: {name}: found {values[row]:g}, expected "
                    f"{expected}"
                    for row in np.flatnonzero(~right(values))
                ]
        for group in filter(self.has, UNMEASURED):
            empty = np.isnan(self.take(group))
            words = (
                f"found some of {', '.join(self.groups[group])} empty, expected all of them or none"
            )
            partly = np.flatnonzero(empty.any(axis=1) & ~empty.all(axis=1))
            errors += [f"{self.path}: line {lines[row]}: {words}" for row in partly]
        _raise(self.path, errors)

    def _check_modulus(self) -> None:
        """Raise InputError for strains without a modulus."""
        case = self.case
        assert case.material is not None
        has_modulus = (
            case.material.youngs_modulus
            or "youngs_modulus_Pa" in self.columns
            or case.infer.modulus == FIND
        )
        if self.has("strain") and not has_modulus:
            moving = self.has("acceleration") or not {"time_s", "frame"}.isdisjoint(self.columns)
            reason = "since it cannot be determined without accelerations"
            if moving:
                reason = 'or set infer.modulus = "find" to determine it from the accelerations'
            raise InputError(
                f"{case.source}: material.youngs_modulus: missing; strains require a modulus: set "
                f"it, {reason}"
            )

    def measured_motion(self) -> dict[float, tuple[Array, ...]]:
        """Return accelerations, spins and angular accelerations by time; quantities that were not
        measured are zero, with a note.
        """
        moving = self.has("acceleration")
        if moving:
            acceleration = self.take("acceleration")
        else:
            acceleration = np.zeros((len(self.columns), self.case.dimension))
            self.notes.append("no measured accelerations: the grains are assumed to be at rest")
        still = np.where(np.isnan(acceleration).any(axis=1), math.nan, 0.0)[:, None].repeat(
            self.turns, axis=1
        )
        motions = [acceleration]
        for group, word in (
            ("spin", "angular velocities"),
            ("angular_acceleration", "angular accelerations"),
        ):
            motions.append(self.take(group) if self.has(group) else still)
            if moving and not self.has(group):
                self.notes.append(f"no measured {word}: they are assumed to be zero")
        return {time: _rows_of(motions, rows) for time, rows in self.rows.items()}

    def differences(self) -> dict[float, tuple[Array, ...]]:
        """Return the motions, from parabolas through the frames around each instant that has enough
        frames on both sides.
        """
        window = self.case.infer.window
        times = np.array(list(self.rows))
        path = self.path
        steps = np.diff(times)
        step = float(np.median(steps))
        worst = int(np.abs(steps - step).argmax())
        if abs(steps[worst] - step) > _EVEN * step:
            raise InputError(
                f"{path}: found {steps[worst]:.4g} s from {times[worst]:.6g} s to the next, "
                f"elsewhere {step:.4g} s; accelerations from differences require all frames at a "
                "constant interval"
            )
        if len(times) < window:
            raise InputError(
                f"{path}: found {len(times)} frames, expected at least {window} (infer.window) to "
                "differentiate"
            )
        ids = [self.each("id")[rows].tolist() for rows in self.rows.values()]
        for time, ids_of_frame in zip(times, ids, strict=True):
            if ids_of_frame != ids[0]:
                raise InputError(
                    f"{path}: the grains at {time:g} s are not those at {times[0]:g} s; expected "
                    "all grains in all frames"
                )
        inner = slice(window // 2, len(times) - window // 2)

        def frames(group: str) -> Array:
            return np.stack([self.take(group)[rows] for rows in self.rows.values()])

        def slope(values: Array, order: int) -> Array:
            return np.asarray(
                savgol_filter(values, window, 2, deriv=order, delta=step, axis=0)[inner]
            )

        acceleration = slope(frames("position"), 2)
        rates = turning = np.zeros((*acceleration.shape[:2], self.turns))
        if self.has("angle"):
            angle = np.unwrap(frames("angle"), axis=0)
            rates = slope(angle, 1)
            turning = slope(angle, 2)
        elif self.has("spin"):
            rates = frames("spin")[inner]
            turning = slope(frames("spin"), 1)
        else:
            self.notes.append("no measured rotations: they are assumed to be zero")
        motions = zip(acceleration, rates, turning, strict=True)
        return dict(zip(list(self.rows)[inner], motions, strict=True))

    def grains(
        self, time: float, acceleration: Array, spin: Array, turning: Array
    ) -> MeasuredGrains:
        """Make the grains of an instant from their motions."""
        infer = self.case.infer
        material = self.case.material
        rows = self.rows[time]
        assert material is not None
        radius = self.each("radius_m")[rows]
        volume = volume_of(radius, infer.state, infer.thickness)
        mass = self.each("density_kg_m3", material.density)[rows] * volume
        force = mass[:, None] * np.array(self.case.gravity)
        if self.has("force"):
            force = force + self.take("force")[rows]
        compliance = modulus = None
        if self.has("strain"):
            modulus = self.each("youngs_modulus_Pa", material.youngs_modulus or 1.0)[rows]
            elastic = stiffness(
                modulus, self.each("poisson_ratio", material.poisson_ratio)[rows], infer.state
            )
            stress = np.einsum("nij,nj->ni", elastic, self.take("strain")[rows])
            compliance = np.linalg.inv(elastic).astype(np.float64)
        else:
            stress = self.take("stress")[rows]
        ids = np.arange(1, len(rows) + 1)
        if "id" in self.columns:
            ids = self.each("id")[rows].astype(np.int64)
        passes_walls = None
        if "passes_walls" in self.columns:
            passes_walls = self.each("passes_walls")[rows] == 1
        return MeasuredGrains(
            ids, self.take("position")[rows], radius, mass, volume, acceleration, spin, turning, force, stress,
            compliance, modulus, passes_walls,
        )  # fmt: skip


def _rows_of(columns: Sequence[Array], rows: NDArray[np.int64]) -> tuple[Array, ...]:
    """Return some rows of each array."""
    return tuple(column[rows] for column in columns)
