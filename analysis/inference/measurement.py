"""Measured grains, from a table and the case: one instant, or those of a time series."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs
from scipy.spatial import cKDTree

from granwave.analysis.inference.case import FIND, InferCase
from granwave.analysis.inference.grains import TENSOR, Array, Grains, stiffness, volume_of
from granwave.analysis.inference.table import Table, groups, raise_errors, read_table_of_grains
from granwave.lammps_inputs.errors import InputError

LARGEST_STRAIN = 1.0
_INSIDE = 0.5  # distance over the sum of the radii below which two rows cannot be two grains
_EVEN = 0.01  # of the interval: frames farther off their time are not evenly spaced


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
    notes: list[str] = []
    instants = _instants(table, case)
    if len(instants) > 1 and not table.has(groups(case.dimension)["acceleration"]):
        times, found = _differentiated(table, case, instants, notes)
    else:
        times = tuple(time for time, _ in instants)
        motion = _given_motion(table, case, notes)
        found = tuple(_grains(table, case, rows, tuple(values[rows] for values in motion)) for _, rows in instants)
    if case.infer.time is not None:
        if not any(map(math.isfinite, times)):
            raise InputError(f"{table.source}: found no column time_s or frame, which infer.time needs")
        nearest = int(np.argmin(np.abs(np.array(times) - case.infer.time)))
        times, found = (times[nearest],), (found[nearest],)
    _check_signs(table, case, times, found, notes)
    return Measurement(times, found, tuple(notes))


def _check_signs(
    table: Table, case: InferCase, times: tuple[float, ...], found: tuple[Grains, ...], notes: list[str]
) -> None:
    """Refuse grains that are all stretched, as under the other sign convention; note where most are."""
    what = "strains" if table.has(groups(case.dimension)["strain"]) else "stresses"
    for time, grains in zip(times, found, strict=True):
        mean = grains.stress[grains.has_stress, : case.dimension].sum(axis=1) / case.dimension
        at = "" if math.isnan(time) else f" at {time:g} s"
        words = "contacts only push, so that grains are compressed, and compression is negative"
        if len(mean) and (mean > 0).all():
            raise InputError(
                f"{table.source}: found {what} that stretch each of the {len(mean)} grains{at}: {words}; if it is "
                "positive in your table, change the sign of all components"
            )
        if mean.sum() > 0:
            notes.append(f"most of the {what}{at} stretch the grains: {words}; are the signs right?")


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
        for name, values in ((name, table.columns[name]) for name in names if name in table.columns):
            errors += table.refuse(
                ~right(values),
                lambda row, name=name, values=values, expected=expected: (
                    f"{name}: found {values[row]:g}, expected {expected}"
                ),
            )
    for name in ("acceleration", "spin", "angular_acceleration", "strain", "stress"):
        names = groups(case.dimension)[name]
        if table.has(names):
            empty = np.isnan(table.take(names))
            errors += table.refuse(
                np.asarray(empty.any(axis=1) & ~empty.all(axis=1), dtype=bool),
                lambda row, names=names: f"found some of {', '.join(names)} empty, expected all of them or none",
            )
    raise_errors(table.source, errors)


def _check_modulus(table: Table, case: InferCase) -> None:
    """Raise InputError for strains without a modulus."""
    known = groups(case.dimension)
    assert case.material is not None
    if not table.has(known["strain"]) or case.material.youngs_modulus or "youngs_modulus_Pa" in table.columns:
        return
    if case.infer.modulus == FIND:
        return
    moving = table.has(known["acceleration"]) or "time_s" in table.columns or "frame" in table.columns
    way = 'or infer.modulus = "find", which finds it from the accelerations' if moving else (
        "since without accelerations nothing tells it"
    )  # fmt: skip
    raise InputError(
        f"{case.source}: material.youngs_modulus: missing; strains give forces only with a modulus: give it, {way}"
    )


def _instants(table: Table, case: InferCase) -> list[tuple[float, NDArray[np.int64]]]:
    """Return the times, rising, with the rows of each in the order of the ids."""
    columns, n = table.columns, len(table.lines)
    if "frame" in columns:
        if case.infer.frame_rate is None:
            raise InputError(f"{case.source}: infer.frame_rate: missing; the column frame of {table.source} needs it")
        times = columns["frame"] / case.infer.frame_rate
    else:
        times = columns.get("time_s", np.full(n, math.nan))
    order_of = np.unique(times, return_inverse=True, equal_nan=True)[1]
    ids = columns.get("id")
    if ids is None:
        if order_of.any():
            raise InputError(
                f"{table.source}: line {table.lines[0]}: lacks id, which tells the grains of a series apart"
            )
        ids = np.arange(1.0, n + 1)
    errors, found = [], []
    for number in range(order_of.max() + 1):
        rows = np.flatnonzero(order_of == number)
        rows = rows[np.argsort(ids[rows], kind="stable")]
        again = np.zeros(n, dtype=bool)
        again[rows[1:]] = ids[rows[1:]] == ids[rows[:-1]]
        at = "" if math.isnan(times[rows[0]]) else f" at {times[rows[0]]:g} s"
        errors += table.refuse(again, lambda row, at=at: f"id: found {ids[row]:g} again{at}, expected each grain once")
        errors += _inside_each_other(table, case, rows)
        found.append((float(times[rows[0]]), rows))
    raise_errors(table.source, errors)
    return found


def _inside_each_other(table: Table, case: InferCase, rows: NDArray[np.int64]) -> list[str]:
    """Return the errors of grains that lie in each other."""
    x, radius = table.take(groups(case.dimension)["position"])[rows], table.columns["radius_m"][rows]
    if len(rows) < 2:
        return []
    pairs = cKDTree(x).query_pairs(2 * _INSIDE * float(radius.max()), output_type="ndarray")
    distance = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
    deep = distance < _INSIDE * (radius[pairs[:, 0]] + radius[pairs[:, 1]])
    return [
        f"{table.source}: line {table.lines[max(rows[i], rows[j])]}: lies in the grain of line "
        f"{table.lines[min(rows[i], rows[j])]}: found a distance of {apart:.3g} m of centres with radii of "
        f"{radius[i]:.3g} and {radius[j]:.3g} m; expected other places or radii (in m), or one row for each grain"
        for (i, j), apart in zip(pairs[deep].tolist(), distance[deep].tolist(), strict=True)
    ]


def _given_motion(table: Table, case: InferCase, notes: list[str]) -> tuple[Array, Array, Array]:
    """Return accelerations, spins and angular accelerations; what was not measured is zero, with a note."""
    known, n, turns = groups(case.dimension), len(table.lines), 1 if case.dimension == 2 else 3
    acceleration = np.zeros((n, case.dimension))
    if table.has(known["acceleration"]):
        acceleration = table.take(known["acceleration"])
    else:
        notes.append("no accelerations were measured: the grains are taken to be at rest")
    still = np.where(np.isnan(acceleration).any(axis=1), math.nan, 0.0)[:, None]
    found = [acceleration]
    for name, word in (("spin", "angular velocities"), ("angular_acceleration", "angular accelerations")):
        if table.has(known[name]):
            found.append(table.take(known[name]))
        else:
            found.append(np.repeat(still, turns, axis=1))
            if table.has(known["acceleration"]):
                notes.append(f"no {word} were measured: they are taken to be zero")
    return found[0], found[1], found[2]


def _differentiated(
    table: Table, case: InferCase, instants: list[tuple[float, NDArray[np.int64]]], notes: list[str]
) -> tuple[tuple[float, ...], tuple[Grains, ...]]:
    """Return the instants that have enough frames around them, with motions by parabolas through these frames."""
    window, half = case.infer.window, case.infer.window // 2
    times = np.array([time for time, _ in instants])
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
    ids = table.columns["id"]
    for time, rows in instants[1:]:
        if not np.array_equal(ids[rows], ids[instants[0][1]]):
            raise InputError(
                f"{table.source}: the grains at {time:g} s are not those at {times[0]:g} s; expected all in all frames"
            )
    known, turns = groups(case.dimension), 1 if case.dimension == 2 else 3
    position = np.stack([table.take(known["position"])[rows] for _, rows in instants])
    first, second = (savgol_coeffs(window, 2, deriv=order, delta=step, use="dot") for order in (1, 2))
    angle = None
    if table.has(known["angle"]):
        angle = np.unwrap(np.stack([table.take(known["angle"])[rows] for _, rows in instants]), axis=0)
    elif not table.has(known["spin"]):
        notes.append("no rotations were measured: they are taken to be zero")
    kept, found = [], []
    for number in range(half, len(times) - half):
        part = slice(number - half, number + half + 1)
        rows = instants[number][1]
        spin, turning = (np.zeros((len(rows), turns)) for _ in range(2))
        if angle is not None:
            spin, turning = (np.tensordot(weights, angle[part], axes=1) for weights in (first, second))
        elif table.has(known["spin"]):
            rates = np.stack([table.take(known["spin"])[instants[k][1]] for k in range(part.start, part.stop)])
            spin, turning = rates[half], np.tensordot(first, rates, axes=1)
        kept.append(float(times[number]))
        found.append(_grains(table, case, rows, (np.tensordot(second, position[part], axes=1), spin, turning)))
    return tuple(kept), tuple(found)


def _grains(table: Table, case: InferCase, rows: NDArray[np.int64], motion: tuple[Array, ...]) -> Grains:
    """Make the grains of some rows."""
    material, known, columns = case.material, groups(case.dimension), table.columns
    assert material is not None
    n = len(rows)

    def each(name: str, default: float) -> Array:
        return columns[name][rows] if name in columns else np.full(n, default)

    radius = columns["radius_m"][rows]
    volume = volume_of(radius, case.infer.state, case.infer.thickness)
    mass = each("density_kg_m3", material.density) * volume
    force = mass[:, None] * np.array(case.gravity)
    if table.has(known["force"]):
        force = force + table.take(known["force"])[rows]
    ids = each("id", math.nan)
    compliance = modulus = None
    if table.has(known["strain"]):
        modulus = each("youngs_modulus_Pa", material.youngs_modulus or 1.0)
        elastic = stiffness(modulus, each("poisson_ratio", material.poisson_ratio), case.infer.state)
        stress = np.einsum("nij,nj->ni", elastic, table.take(known["strain"])[rows])
        compliance = np.linalg.inv(elastic).astype(np.float64)
    else:
        stress = table.take(known["stress"])[rows]
    acceleration, spin, turning = motion
    return Grains(
        np.arange(1, n + 1) if np.isnan(ids).any() else ids.astype(np.int64),
        table.take(known["position"])[rows],
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
        columns["passes_walls"][rows] == 1 if "passes_walls" in columns else None,
    )
