"""Measured grains, from a table and the case: one instant, or those of a time series."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs
from scipy.spatial import cKDTree

from granwave.analysis.inference.case import FIND, InferCase
from granwave.analysis.inference.grains import TENSOR, TURNS, Array, Grains, stiffness, volume_of
from granwave.analysis.inference.table import UNMEASURED, Table, raise_errors, read_table_of_grains
from granwave.lammps_inputs.errors import InputError

LARGEST_STRAIN = 1.0
_INSIDE = 0.5  # distance over the sum of the radii below which two rows cannot be two grains
_EVEN = 0.01  # of the interval: frames farther off their time are not evenly spaced

_Motion = dict[float, tuple[Array, ...]]  # accelerations, angular velocities and their rates by time


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
            errors += self._inside_each_other(rows)
            self.rows[time] = rows
        raise_errors(table.source, errors)
        self.times = list(self.rows)

    def _inside_each_other(self, rows: NDArray[np.int64]) -> list[str]:
        """Return the errors of grains that lie in each other."""
        table = self.table
        x, radius, lines = table.take("position")[rows], table.each("radius_m")[rows], table.columns.index[rows]
        pairs = cKDTree(x).query_pairs(2 * _INSIDE * float(radius.max()), output_type="ndarray")
        distance = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
        deep = distance < _INSIDE * (radius[pairs[:, 0]] + radius[pairs[:, 1]])
        return [
            f"{table.source}: line {max(lines[i], lines[j])}: lies in the grain of line {min(lines[i], lines[j])}: "
            f"found a distance of {apart:.3g} m of centres with radii of {radius[i]:.3g} and {radius[j]:.3g} m; "
            "expected other places or radii (in m), or one row for each grain"
            for (i, j), apart in zip(pairs[deep].tolist(), distance[deep].tolist(), strict=True)
        ]

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
