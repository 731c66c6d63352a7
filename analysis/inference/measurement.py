"""Measured grains, from a table (CSV) and the case: one instant, or those of a time series.

Each fault of the table is said with its line.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs
from scipy.spatial import cKDTree

from granwave.analysis.inference.case import FIND, InferCase
from granwave.analysis.inference.grains import TENSOR, TURNS, Array, Grains, stiffness, volume_of
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_csv_rows

_UNIT = re.compile("_(m_s2|rad_s2|rad_s|rad|kg_m3|Pa|m|s|N)$")
_SHOWN = 10  # largest number of faults in a message
UNMEASURED = ("acceleration", "spin", "angular_acceleration", "strain", "stress")  # whose cells may be empty
LARGEST_STRAIN = 1.0
_INSIDE = 0.5  # distance over the sum of the radii below which two rows cannot be two grains
_EVEN = 0.01  # of the interval: frames farther off their time are not evenly spaced

_Motion = dict[float, tuple[Array, ...]]  # accelerations, angular velocities and their rates by time


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
    known = groups(dimension)
    found = {_UNIT.sub("", name): name for names in known.values() for name in names}
    found |= {f"{name}_Pa": name for name in known["stress"]}
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
    where, known, short = f"{source}: line {number}", groups(dimension), aliases(dimension)
    given = [name.strip() for name in header]
    names = [short.get(name, name) for name in given]
    everything = [name for group in known.values() for name in group]
    errors = [
        f"{where}: found a column {show(one)}, expected names among {', '.join(everything)}"
        for name, one in zip(names, given, strict=True)
        if name not in everything
    ]
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        errors.append(f"{where}: found the column {name} {names.count(name)} times, expected it once")
    if missing := [name for name in (*known["position"], "radius_m") if name not in names]:
        errors.append(f"{where}: lacks {', '.join(missing)}; expected {', '.join(known['position'])}, radius_m")
    for group, columns in known.items():
        there = [name for name in columns if name in names]
        if there and len(there) < len(columns) and group not in ("material", "other", "position"):
            errors.append(f"{where}: found {', '.join(there)}, expected all of {', '.join(columns)}, or none")
    strains, stresses = ({*known[group]} & {*names} for group in ("strain", "stress"))
    if len(strains) == len(stresses) == len(known["strain"]):
        errors.append(f"{where}: found strains and stresses, expected one of them")
    if not strains | stresses:
        errors.append(
            f"{where}: lacks strains or stresses; expected {', '.join(known['strain'])}, "
            f"or {', '.join(known['stress'])} (Pa)"
        )
    if {"time_s", "frame"} <= {*names}:
        errors.append(f"{where}: found time_s and frame, expected one of them")
    raise_errors(source, errors)
    lines = [line for line, _ in rows[1:]]
    errors = [
        f"{source}: line {line}: found {len(cells)} values, expected {len(names)}: {', '.join(names)}"
        for line, cells in rows[1:]
        if len(cells) != len(names)
    ]
    raise_errors(source, errors)
    if not lines:
        raise InputError(f"{source}: found no grain, expected a row for each below the line of names")
    texts = pd.DataFrame([cells for _, cells in rows[1:]], lines, names, dtype=str).apply(lambda one: one.str.strip())
    values = texts.apply(pd.to_numeric, errors="coerce").astype(np.float64)
    may_be_empty = texts.columns.isin([name for group in UNMEASURED for name in known[group]])
    for row, column in np.argwhere(~np.isfinite(values) & ~((texts == "") & may_be_empty)):
        empty = "; leave cells empty where nothing was measured" if may_be_empty[column] else ""
        text = show(texts.iloc[row, column])
        errors.append(f"{source}: line {lines[row]}: {names[column]}: found {text}, expected a finite number{empty}")
    raise_errors(source, errors)
    return Table(source, values, known)


@dataclasses.dataclass(frozen=True, eq=False)
class Measurement:
    """Grains at the measured instants.

    Attributes
    ----------
    times
        Instants, s; NaN for a table without times.
    grains
        Grains at each.
    notes
        Assumptions made where something was not measured.
    """

    times: tuple[float, ...]
    grains: tuple[Grains, ...]
    notes: tuple[str, ...]


def read_measurement(path: str | Path, case: InferCase) -> Measurement:
    """Read measured grains.

    Raises
    ------
    InputError
        The table is wrong (with the lines), or the case lacks what it needs.
    """
    table = read_table_of_grains(path, case.dimension)
    _check_rows(table, case)
    _check_modulus(table, case)
    reading = _Reading(table, case)
    times, motion = reading.differences() if len(reading.times) > 1 and not table.has("acceleration") else (
        reading.times, reading.given_motion()
    )  # fmt: skip
    if case.infer.time is not None:
        if not any(map(math.isfinite, times)):
            raise InputError(f"{table.source}: found no column time_s or frame, which infer.time needs")
        times = [times[int(np.argmin(np.abs(np.array(times) - case.infer.time)))]]
    found = tuple(reading.grains(time, motion) for time in times)
    _check_signs(table, case, times, found, reading.notes)
    return Measurement(tuple(times), found, tuple(reading.notes))


def _check_signs(
    table: Table, case: InferCase, times: Sequence[float], found: Sequence[Grains], notes: list[str]
) -> None:
    """Refuse grains that are all stretched, as under the other sign convention; note where most are."""
    what = "strains" if table.has("strain") else "stresses"
    words = "contacts only push, so that grains are compressed, and compression is negative"
    for time, grains in zip(times, found, strict=True):
        mean = grains.stress[grains.has_stress, : case.dimension].sum(axis=1) / case.dimension
        if len(mean) and (mean > 0).all():
            raise InputError(
                f"{table.source}: found {what} that stretch each of the {len(mean)} grains{_at(time)}: {words}; if it "
                "is positive in your table, change the sign of all components"
            )
        if mean.sum() > 0:
            notes.append(f"most of the {what}{_at(time)} stretch the grains: {words}; are the signs right?")


def _at(time: float) -> str:
    return "" if math.isnan(time) else f" at {time:g} s"


def _check_rows(table: Table, case: InferCase) -> None:
    """Raise InputError for values that cannot be, and for partly empty groups of cells."""
    strains = tuple(f"e{pair}" for pair in TENSOR[case.dimension])
    allowed: list[tuple[tuple[str, ...], Callable[[Array], NDArray[np.bool_]], str]] = [
        (("radius_m", "density_kg_m3", "youngs_modulus_Pa"), lambda x: x > 0, "a number above 0"),
        (("poisson_ratio",), lambda x: (x > -1) & (x < 0.5), "a number above -1 and below 0.5"),
        (("id",), lambda x: (x == np.floor(x)) & (x >= 0), "a whole number from 0 up"),
        (("passes_walls",), lambda x: np.isin(x, (0, 1)), "0, or 1 for a striker"),
        (strains, lambda x: ~(np.abs(x) > LARGEST_STRAIN), f"a strain below {LARGEST_STRAIN:g}; 1 % is 0.01"),
    ]
    errors = []
    for names, right, expected in allowed:
        for name in (name for name in names if name in table.columns):
            values, words = table.each(name), f"{name}: found {{:g}}, expected {expected}"
            errors += table.refuse(~right(values), lambda row, values=values, words=words: words.format(values[row]))
    for group in filter(table.has, UNMEASURED):
        empty = np.isnan(table.take(group))
        words = f"found some of {', '.join(table.groups[group])} empty, expected all of them or none"
        partly = np.asarray(empty.any(axis=1) & ~empty.all(axis=1), dtype=bool)
        errors += table.refuse(partly, lambda _, words=words: words)
    raise_errors(table.source, errors)


def _check_modulus(table: Table, case: InferCase) -> None:
    """Raise InputError for strains without a modulus."""
    assert case.material is not None
    known = case.material.youngs_modulus or "youngs_modulus_Pa" in table.columns or case.infer.modulus == FIND
    if not table.has("strain") or known:
        return
    moving = table.has("acceleration") or "time_s" in table.columns or "frame" in table.columns
    way = 'or infer.modulus = "find", which finds it from the accelerations' if moving else (
        "since without accelerations nothing tells it"
    )  # fmt: skip
    raise InputError(
        f"{case.source}: material.youngs_modulus: missing; strains give forces only with a modulus: give it, {way}"
    )


class _Reading:
    """Rows of a table by instant, each in the order of the ids.

    Attributes
    ----------
    times
        Rising; NaN for a table without.
    rows
        Rows of the table at each.
    notes
        As in `Measurement`.
    """

    def __init__(self, table: Table, case: InferCase) -> None:
        self.table, self.case, self.notes = table, case, list[str]()
        self.turns = TURNS[case.dimension]
        times = table.each("time_s")
        if "frame" in table.columns:
            if case.infer.frame_rate is None:
                raise InputError(
                    f"{case.source}: infer.frame_rate: missing; the column frame of {table.source} needs it"
                )
            times = table.each("frame") / case.infer.frame_rate
        ids = table.each("id") if "id" in table.columns else np.arange(1.0, len(table) + 1)
        found = pd.DataFrame({"time": times, "id": ids}).groupby("time", dropna=False)
        if len(found) > 1 and "id" not in table.columns:
            raise InputError(
                f"{table.source}: line {table.columns.index[0]}: lacks id, which tells the grains of a series apart"
            )
        errors: list[str] = []
        self.rows: dict[float, NDArray[np.int64]] = {}
        for time, part in found["id"]:
            rows = part.sort_values(kind="stable").index.to_numpy()
            again = np.zeros(len(table), dtype=bool)
            again[rows] = ids[rows] == np.append(np.nan, ids[rows[:-1]])
            errors += table.refuse(
                again, lambda row, time=time: f"id: found {ids[row]:g} again{_at(time)}, expected each grain once"
            )
            x, radius, lines = table.take("position")[rows], table.each("radius_m")[rows], table.columns.index[rows]
            i, j = cKDTree(x).query_pairs(2 * _INSIDE * float(radius.max()), output_type="ndarray").T
            apart = np.linalg.norm(x[i] - x[j], axis=1)
            deep = apart < _INSIDE * (radius[i] + radius[j])
            errors += [
                f"{table.source}: line {max(lines[a], lines[b])}: lies in the grain of line {min(lines[a], lines[b])}: "
                f"found a distance of {one:.3g} m of centres with radii of {radius[a]:.3g} and {radius[b]:.3g} m; "
                "expected other places or radii (in m), or one row for each grain"
                for a, b, one in zip(i[deep], j[deep], apart[deep], strict=True)
            ]
            self.rows[time] = rows
        raise_errors(table.source, errors)
        self.times = list(self.rows)

    def given_motion(self) -> _Motion:
        """Return accelerations, spins and angular accelerations by time; what was not measured is zero, with a note."""
        table, moving = self.table, self.table.has("acceleration")
        acceleration = table.take("acceleration") if moving else np.zeros((len(table), self.case.dimension))
        if not moving:
            self.notes.append("no accelerations were measured: the grains are taken to be at rest")
        still = np.where(np.isnan(acceleration).any(axis=1), math.nan, 0.0)[:, None].repeat(self.turns, axis=1)
        found = [acceleration]
        for group, word in (("spin", "angular velocities"), ("angular_acceleration", "angular accelerations")):
            found.append(table.take(group) if table.has(group) else still)
            if moving and not table.has(group):
                self.notes.append(f"no {word} were measured: they are taken to be zero")
        return {time: tuple(values[rows] for values in found) for time, rows in self.rows.items()}

    def differences(self) -> tuple[list[float], _Motion]:
        """Return the instants with enough frames around them, with motions by parabolas through these frames."""
        table, window, times = self.table, self.case.infer.window, np.array(self.times)
        step = float(np.median(np.diff(times)))
        uneven = np.flatnonzero(np.abs(np.diff(times) - step) > _EVEN * step)
        if len(uneven):
            first = int(uneven[0])
            raise InputError(
                f"{table.source}: found {times[first + 1] - times[first]:.4g} s from {times[first]:.6g} s to the next, "
                f"elsewhere {step:.4g} s; accelerations by differences need all frames, evenly spaced"
            )
        if len(times) < window:
            raise InputError(
                f"{table.source}: found {len(times)} frames, expected at least {window} (infer.window) to differentiate"
            )
        ids = {time: table.each("id")[rows].tolist() for time, rows in self.rows.items()}
        for time, there in ids.items():
            if there != ids[times[0]]:
                raise InputError(
                    f"{table.source}: the grains at {time:g} s are not those at {times[0]:g} s; expected all in all "
                    "frames"
                )

        def frames(group: str) -> Array:
            return np.stack([table.take(group)[rows] for rows in self.rows.values()])

        first, second = (savgol_coeffs(window, 2, deriv=order, delta=step, use="dot") for order in (1, 2))
        half, position = window // 2, frames("position")
        angle = spin = None
        if table.has("angle"):
            angle = np.unwrap(frames("angle"), axis=0)
        elif table.has("spin"):
            spin = frames("spin")
        else:
            self.notes.append("no rotations were measured: they are taken to be zero")
        still, motion = np.zeros((len(ids[times[0]]), self.turns)), _Motion()
        for number in range(half, len(times) - half):
            part = slice(number - half, number + half + 1)
            rates, turning = still, still
            if angle is not None:
                rates, turning = (np.tensordot(weights, angle[part], axes=1) for weights in (first, second))
            elif spin is not None:
                rates, turning = spin[number], np.tensordot(first, spin[part], axes=1)
            motion[self.times[number]] = np.tensordot(second, position[part], axes=1), rates, turning
        return list(motion), motion

    def grains(self, time: float, motion: _Motion) -> Grains:
        """Make the grains of an instant."""
        table, infer, material = self.table, self.case.infer, self.case.material
        assert material is not None
        rows = self.rows[time]
        radius = table.each("radius_m")[rows]
        volume = volume_of(radius, infer.state, infer.thickness)
        mass = table.each("density_kg_m3", material.density)[rows] * volume
        force = mass[:, None] * np.array(self.case.gravity)
        if table.has("force"):
            force = force + table.take("force")[rows]
        compliance = modulus = None
        if table.has("strain"):
            modulus = table.each("youngs_modulus_Pa", material.youngs_modulus or 1.0)[rows]
            elastic = stiffness(modulus, table.each("poisson_ratio", material.poisson_ratio)[rows], infer.state)
            stress = np.einsum("nij,nj->ni", elastic, table.take("strain")[rows])
            compliance = np.linalg.inv(elastic).astype(np.float64)
        else:
            stress = table.take("stress")[rows]
        acceleration, spin, turning = motion[time]
        return Grains(
            table.each("id")[rows].astype(np.int64) if "id" in table.columns else np.arange(1, len(rows) + 1),
            table.take("position")[rows],
            radius,
            mass,
            volume,
            acceleration,
            spin,
            turning,
            force,
            stress,
            compliance,
            modulus,
            table.each("passes_walls")[rows] == 1 if "passes_walls" in table.columns else None,
        )
