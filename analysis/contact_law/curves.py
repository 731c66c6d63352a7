"""Force-overlap curves of a contact law, and its coefficient of restitution, as tables and as
figures.

A collision of effective mass m loads the contact until the work of loading W(a_max) equals m v^2 /
2; this work is returned except for the dissipated energy D(a_max):  e = sqrt(1 - D / W). Runs give
the same curves, see test_curves.py.

Measured force-overlap curves, read from CSV, with the branch and the largest overlap of every row.

There are two forms. With a column ``branch`` (loading, unloading_N, reloading_N), such as in the
output of `granwave law -o x.csv`, all rows of one N lie below the same largest overlap. Otherwise
the rows are in the order of measurement, and the branches follow from the turning points of the
overlap.
"""

from __future__ import annotations

import dataclasses
import logging
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave._contact_laws import ContactLaw
from granwave.analysis.contact_law.curve_table import read_curve_rows
from granwave.analysis.figures.series import legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, Drawing, save_as
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError, first_errors
from granwave.lammps_inputs.files import read_number

_LOG = logging.getLogger("granwave")
_TURNS = (0.25, 0.5, 0.75, 1.0)  # overlap at the start of unloading / largest overlap
_COLOURS = (GREEN, ORANGE, PURPLE, BLUE)
_POINTS = 400
_COLUMNS_ABOVE = 2  # columns of the legend
_JUMP = 0.2  # step of a measured overlap over its range beyond which rows may be out of order,
_FAR = 20.0  # if it is so many times the median step, too
_MAX_OVERLAP = 200.0
_UNIT_WITHOUT_YIELD = 1e-4  # unit of overlaps / R* for laws without alpha_y
_MICRO = 1e6  # micrometres in a metre
_LINES = ((BLUE, "-"), (ORANGE, "--"), (GREEN, ":"), (PURPLE, "-."))
_STEPS = 2000  # steps of a collision with a yield strength that depends on the rate
_SLOWEST = 0.3  # overlap of the slowest impact / overlap at first yield

Table = dict[str, NDArray]


def law_table(law: ContactLaw, max_overlap: float = _MAX_OVERLAP, velocity: float = 0.0) -> Table:
    """Compute the branches of the force-overlap curve.

    Parameters
    ----------
    max_overlap
        Largest overlap, in units of alpha_y; of 1e-4 R* for materials without a yield strength.
    velocity
        Velocity of approach and of separation, m/s, on which the yield strength of some materials
        depends; 0: quasi-static.

    Returns
    -------
    dict
        ``branch`` (loading, then unloading_N and reloading_N for each of four turning points),
        ``overlap_m``, ``force_N``, ``overlap_normalised`` (by alpha_y), ``force_normalised`` (by
        F_y); the last two are NaN for materials without a yield strength. ``force_error_N``, the
        error bar of the law, if it has one for slow contacts; NaN beyond its range.

    Raises
    ------
    ValueError
        The largest overlap is not positive.
    InputError
        Forces are too small or too large for double precision.
    """
    if not 0 < max_overlap < math.inf:
        raise ValueError(f"max_overlap: found {max_overlap}, expected a positive number")
    check_forces(law)
    yields = math.isfinite(law.yield_overlap)
    largest = max_overlap * (
        law.yield_overlap if yields else _UNIT_WITHOUT_YIELD * law.effective_radius
    )
    grid = np.linspace(0.0, 1.0, _POINTS)
    first = np.linspace(0.0, largest, _POINTS)
    if law.yield_overlap < largest:
        first = np.union1d(first, [law.yield_overlap])
    branches = [
        ("loading", first, _path(law, first, velocity) if velocity else law.loading_force(first))
    ]
    for n, share in enumerate(_TURNS, start=1):
        peak = share * largest
        residual = float(law.residual_overlap(np.array([peak]))[0])
        overlap = np.concatenate([[0.0], residual + (peak - residual) * grid])
        if law.neck_length:
            overlap = -law.neck_length + (peak + law.neck_length) * np.concatenate(
                [[-1e-9], grid[:1] + 1e-9, grid[1:]]
            )
        force = law.force(overlap, np.full_like(overlap, peak))
        if velocity:
            overlap = peak * grid
            force = _path(law, np.concatenate([first[first < peak], overlap[::-1]]), velocity)[
                -_POINTS:
            ][::-1]
        branches += [
            (f"unloading_{n}", overlap[::-1], force[::-1]),
            (f"reloading_{n}", overlap, force),
        ]
    bars = {}
    if law.entry.states_error and not law.rate_sensitivity and not law.pull_off_force:
        peaks = [values if name == "loading" else values.max() for name, values, _ in branches]
        bars["force_error_N"] = np.concatenate(
            [
                law.force_error(values, np.broadcast_to(peak, values.shape))
                for (_, values, _), peak in zip(branches, peaks, strict=True)
            ]
        )
    overlap = np.concatenate([branch[1] for branch in branches])
    force = np.concatenate([branch[2] for branch in branches])
    if not np.all(np.isfinite(force)):
        raise InputError(
            f"--max-overlap: found {max_overlap:g}, for which forces overflow; use a smaller value"
        )
    return {
        "branch": np.concatenate([np.full(len(values), name) for name, values, _ in branches]),
        "overlap_m": overlap,
        "force_N": force,
        "overlap_normalised": overlap / law.yield_overlap
        if yields
        else np.full_like(overlap, np.nan),
        "force_normalised": force / law.yield_force if yields else np.full_like(force, np.nan),
        **bars,
    }


def _path(law: ContactLaw, overlap: NDArray[np.float64], velocity: float) -> NDArray[np.float64]:
    """Return the forces along a path of overlaps at a constant speed, N."""
    return law.follow(overlap, np.cumsum(np.abs(np.diff(overlap, prepend=0.0))) / velocity)["force"]


def check_forces(law: ContactLaw) -> None:
    """Raise InputError if the force at a typical overlap is zero or infinite in double precision."""
    overlap = (
        law.yield_overlap
        if math.isfinite(law.yield_overlap)
        else _UNIT_WITHOUT_YIELD * law.effective_radius
    )
    force = float(law.loading_force(np.array([overlap]))[0])
    if not 0 < (abs(force) if law.pull_off_force else force) < math.inf:
        raise InputError(
            f"--radius: found R* = {law.effective_radius:g} m, where forces are {force:g} N as a number; "
            "expected lengths in m"
        )


def law_drawing(
    law: ContactLaw, max_overlap: float = _MAX_OVERLAP, title: str = "", velocity: float = 0.0
) -> Drawing:
    """Draw the curves of `law_table`, with physical axes below and at the left, normalised axes
    above and at the right.
    """
    table = law_table(law, max_overlap, velocity)
    branch = table["branch"]
    overlap = table["overlap_m"] * _MICRO
    force = table["force_N"]
    figure, axes = panels(2.7)
    for n, colour in enumerate(_COLOURS, start=1):
        rows = branch == f"unloading_{n}"
        label = "unloading and reloading" if n == len(_COLOURS) else None
        axes.plot(overlap[rows], force[rows], color=colour, label=label)
    rows = branch == "loading"
    axes.plot(overlap[rows], force[rows], color="black", linestyle="--", label="loading")
    if "force_error_N" in table:
        low, high = (force[rows] + sign * table["force_error_N"][rows] for sign in (-1, 1))
        axes.fill_between(
            overlap[rows], low, high, color="black", alpha=0.15, label="error bar of the law"
        )
    if velocity:
        slow = np.asarray(overlap[rows] / _MICRO)
        axes.plot(
            overlap[rows],
            law.loading_force(slow),
            color=GREY,
            linestyle="-.",
            label="loading, slow",
        )
    corner = (1.02 * float(overlap.min()), 1.05 * float(force.min()))
    limits = {
        "xlim": (corner[0], float(overlap.max())),
        "ylim": (corner[1], 1.05 * float(force.max())),
    }
    axes.set(xlabel="Overlap (µm)", ylabel="Force (N)", **limits)
    if np.all(np.isfinite(table["overlap_normalised"])):
        axes.tick_params(top=False, right=False)
        a_y = law.yield_overlap * _MICRO
        f_y = law.yield_force
        above = axes.secondary_xaxis("top", functions=(lambda x: x / a_y, lambda x: x * a_y))
        above.set_xlabel(r"$\alpha/\alpha_\mathrm{y}$")
        beside = axes.secondary_yaxis("right", functions=(lambda y: y / f_y, lambda y: y * f_y))
        beside.set_ylabel(r"$F/F_\mathrm{y}$")
    limit = 0.2 * law.effective_radius * _MICRO
    if law.entry.fitted and overlap.max() > limit:
        axes.axvline(limit, color=GREY, linestyle=":", label=r"0.2 $R^*$, end of the fit")
    # there is no room for a legend between the axes above
    legend_outside(figure, _COLUMNS_ABOVE, title=f"{title}, {law.name}" if title else law.name)
    return Drawing(figure, table)


def write_law(
    law: ContactLaw,
    path: str | Path,
    max_overlap: float = _MAX_OVERLAP,
    title: str = "",
    velocity: float = 0.0,
) -> Path:
    """Write a table (.csv), or a figure with its table (.png or .pdf; both are written).

    Raises
    ------
    ValueError
        The path has another suffix.
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".png", ".pdf"):
        raise ValueError(
            f"{path}: found the suffix {path.suffix or 'none'!r}, expected .png, .pdf or .csv"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    save_as(
        path,
        law_table(law, max_overlap, velocity),
        lambda: law_drawing(law, max_overlap, title, velocity),
    )
    return path


def restitution(
    law: ContactLaw, mass: float, max_overlap: float = 400.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return impact velocities, m/s, and coefficients of restitution: (n,) each.

    Parameters
    ----------
    mass
        Effective mass of the two bodies, kg.
    max_overlap
        Overlap of the fastest impact / overlap at first yield; for the elasto-plastic law at
        most 0.2 R*, the limit of its fit.
    """
    check_forces(law)
    largest = max_overlap * law.yield_overlap
    if law.entry.fitted:
        largest = min(largest, 0.2 * law.effective_radius)
    peak = np.geomspace(_SLOWEST * law.yield_overlap, largest, _POINTS)
    work = law.loading_work(peak)
    velocity = np.sqrt(2 * work / mass)
    if law.rate_sensitivity:
        return velocity, np.array(
            [law.collide(mass, float(one), steps=_STEPS)["restitution"] for one in velocity]
        )
    return velocity, np.sqrt(np.clip(1 - law.dissipated_energy(peak) / work, 0, 1))


def restitution_error(law: ContactLaw, mass: float, velocity: ArrayLike) -> NDArray[np.float64]:
    """Return the error bars of `restitution` at impact velocities that it returned: (n,).

    NaN if the law states none.
    """
    peak = np.geomspace(_SLOWEST * law.yield_overlap, law.effective_radius, _POINTS)
    overlap = np.interp(
        np.asarray(velocity, float), np.sqrt(2 * law.loading_work(peak) / mass), peak
    )
    return np.asarray(law.restitution_error(overlap))


def write_restitution(
    contacts: Mapping[str, tuple[ContactLaw, float]],
    path: str | Path,
    max_overlap: float = 400.0,
    title: str = "",
) -> Path:
    """Write the curves as a table (.csv) or as a figure with its table (.png or .pdf; both are
    written).

    Raises
    ------
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    path = Path(path)
    curves = {name: restitution(law, mass, max_overlap) for name, (law, mass) in contacts.items()}
    bars = {
        name: restitution_error(law, mass, curves[name][0])
        for name, (law, mass) in contacts.items()
        if law.entry.states_error and not law.rate_sensitivity
    }
    velocity, values = (np.concatenate(parts) for parts in zip(*curves.values(), strict=True))
    table = {
        "contact": np.repeat(list(curves), _POINTS),
        "velocity_m_s": velocity,
        "restitution": values,
    }
    if bars:
        table["restitution_error"] = np.concatenate(list(bars.values()))

    def draw() -> Drawing:
        figure, axes = panels(2.4)
        for (name, curve), (colour, line) in zip(curves.items(), _LINES, strict=False):
            axes.semilogx(*curve, line, color=colour, label=name)
            if name in bars:
                low, high = (curve[1] + sign * bars[name] for sign in (-1, 1))
                axes.fill_between(curve[0], low, high, color=colour, alpha=0.2, linewidth=0)
        axes.set(
            xlabel="Impact velocity (m/s)", ylabel="Coefficient of restitution", ylim=(0, 1.05)
        )
        axes.legend(loc="lower left", title=title or None, alignment="left")
        return Drawing(figure, table)

    save_as(path, table, draw)
    return path


_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6}
_COLUMNS = {  # names of columns of overlaps and of forces, with their units in SI units
    "overlap": {
        **{f"overlap_{unit}": size for unit, size in _LENGTHS.items()},
        **{f"displacement_{unit}": size for unit, size in _LENGTHS.items()},
    },
    "force": {f"force_{unit}": size for unit, size in _FORCES.items()},
}
_EXPECTED = {
    "overlap": "overlap_m, overlap_mm or overlap_um (or displacement_... instead of overlap_...)",
    "force": "force_N or force_kN",
}
BRANCH = "branch"
LOADING = "loading"
_BRANCHES = re.compile(r"loading|(?:un|re)loading(?:_?\w+)?")
_TURN = 0.01  # reversal / largest overlap; smaller ones are noise

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


def read_curve(path: str | Path, *, any_zero: bool = False) -> Curve:
    """Read a curve from a CSV file with columns of overlaps and forces, and optionally branch;
    others are ignored.

    The names of the columns hold the units, such as overlap_um, displacement_mm and force_kN.

    Parameters
    ----------
    any_zero
        True to take overlaps below 0: readings of a gauge whose zero is not at the touch.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, or holds a wrong number, a wrong branch or a
        negative overlap; the message gives the line of each fault.
    """
    rows, lines = _rows(Path(path))
    errors: list[str] = []
    names = {
        what: next(name for name in known if name in lines) for what, known in _COLUMNS.items()
    }
    columns = {
        name: [_number(row, name, f"{path}: line {n}", errors) for n, row in rows]
        for name in names.values()
    }
    named = BRANCH in lines
    branch = [(row.get(BRANCH) or "").strip() for _, row in rows]
    for (n, row), name, found in zip(rows, branch, columns[names["overlap"]], strict=True):
        if named and not _BRANCHES.fullmatch(name):
            errors.append(
                f"{path}: line {n}: branch: found {show(row.get(BRANCH) or '')}, "
                "expected loading, unloading_N or reloading_N"
            )
        if found < 0 and not any_zero:
            errors.append(
                f"{path}: line {n}: {names['overlap']}: found {found:g}, expected no negative "
                "value (compression is positive); an offset of the zero can also be fitted"
            )
    if errors:
        raise InputError(first_errors(path, errors))
    overlap, force = (
        _COLUMNS[what][names[what]] * np.array(columns[names[what]])
        for what in ("overlap", "force")
    )
    return curve_of(overlap, force, branch if named else None, str(path))


def curve_of(
    overlap: ArrayLike, force: ArrayLike, branch: Sequence[str] | None = None, source: str = "curve"
) -> Curve:
    """Make a curve from overlaps (m) and forces (N); without ``branch`` they are in the order of
    measurement.
    """
    overlap = np.asarray(overlap, float)
    force = np.asarray(force, float)
    if branch is None:
        _warn_of_jumps(overlap, source)
        start = min(0.0, float(overlap.min(initial=0.0)))
        names, peak = _branches(overlap - start)
        peak += start
    else:
        names = np.array(branch, dtype=np.str_)
        turn = np.array([re.sub("^(un|re)loading_?", "", name) for name in names])
        peak = overlap.copy()
        for number in np.unique(turn[names != LOADING]):
            rows = (names != LOADING) & (turn == number)
            peak[rows] = overlap[rows].max()
    return Curve(source, names, overlap, force, peak)


def _warn_of_jumps(overlap: Array, source: str) -> None:
    """Warn of a curve without branches whose rows are not in the order of measurement."""
    steps = np.abs(np.diff(overlap))
    if not steps.size:
        return
    row = int(np.argmax(steps))
    is_far = steps[row] > _JUMP * float(np.ptp(overlap))
    if is_far and steps[row] > _FAR * float(np.median(steps)):
        _LOG.warning(
            "%s: the overlap jumps from %.4g to %.4g µm at row %d, but rows must be in the order "
            "of measurement; sort them, or add a column branch (loading, unloading_1, ...)",
            source,
            overlap[row] * _MICRO,
            overlap[row + 1] * _MICRO,
            row + 2,
        )


def _branches(overlap: Array) -> tuple[NDArray[np.str_], Array]:
    """Return branch and largest overlap of every row of a measured curve, from its turning points."""
    ends = _turning_points(overlap, _TURN * float(overlap.max(initial=0.0)))
    names = np.full(overlap.size, LOADING, dtype="<U20")
    peak = overlap.copy()
    number = 0
    largest = 0.0
    start = 0
    for end in ends:
        rows = slice(start, end + 1)
        if overlap[end] > overlap[max(start - 1, 0)] or start == 0:
            below = overlap[rows] < largest
            names[rows][below] = f"reloading_{number}"
            peak[rows][below] = largest
        else:
            if overlap[start - 1] >= largest:
                number = number + 1
                largest = float(overlap[start - 1])
            names[rows] = f"unloading_{number}"
            peak[rows] = largest
        start = end + 1
    return names, peak


def _turning_points(values: Array, least: float) -> list[int]:
    """Return the indices at which a noisy sequence turns by more than ``least``, and its last
    index.
    """
    found: list[int] = []
    extreme = 0
    rising = True
    for k in range(1, values.size):
        ahead = values[k] - values[extreme] if rising else values[extreme] - values[k]
        if ahead >= 0:
            extreme = k
        elif -ahead > least:
            found.append(extreme)
            extreme = k
            rising = not rising
    return [*found, values.size - 1] if values.size else []


def _rows(path: Path) -> tuple[list[tuple[int, dict[str, str]]], list[str]]:
    """Read the rows of a CSV file with their line numbers, and the names of its columns."""
    parsed = read_curve_rows(path)
    columns = parsed[0][1] if parsed else []
    for what, known in _COLUMNS.items():
        there = [name for name in known if name in columns]
        if len(there) != 1:
            found = " and ".join(there) if there else ", ".join(columns) or "nothing"
            raise InputError(
                f"{path}: found {found}, expected one column {_EXPECTED[what]}: the name of a "
                "column must contain its unit"
            )
    return [(n, dict(zip(columns, cells, strict=False))) for n, cells in parsed[1:]], columns


def _number(row: dict[str, str], name: str, where: str, errors: list[str]) -> float:
    text = (row.get(name) or "").strip()
    try:
        value = read_number(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        errors.append(f"{where}: {name}: found {show(text)}, expected a number")
        return 0.0
    return value
