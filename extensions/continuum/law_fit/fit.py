"""Fit of the constants of the elasto-plastic law to a force-overlap curve.

Least squares over the rows beyond first yield, of the residuals

    r = (F_law - F) / s,    s = |F|, but at least 0.1 % of the largest force on loading
                                and 5 % of the force at the turn on un- and reloading, so that small
                                overlaps have the same weight as large ones. Residuals above three
                                times the scatter
(a standard deviation from the median of |r|) contribute linearly only (Huber's loss). The standard
uncertainties come from the covariance s^2 (J^T W J)^-1; if residuals of neighbouring rows are
correlated (the law differs in shape from the curve), they are multiplied by sqrt((1 + rho)/(1 -
rho)), with the correlation rho of neighbours.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from pandas import DataFrame
from scipy.optimize import minimize_scalar

from granwave._contact_laws import ContactLaw
from granwave.analysis.contact_law.curves import Curve
from granwave.analysis.errors import did_you_mean
from granwave.extensions.continuum.law_fit.fit_search import Search, uncertainties
from granwave.extensions.continuum.law_fit.fitted_law import YIELD, FittedLaw, place_of_softer
from granwave.extensions.continuum.law_fit.zero import (
    ZERO,
    estimated_zero,
    shifted,
    touching,
    zero_range,
)
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.errors import InputError

#: Bounds of the search for each constant.
BOUNDS = {
    "pressure_limit": (0.3, 20.0),
    "pressure_rate": (1e-3, 5.0),
    "area_switch": (10.0, 2000.0),
    "area_slope": (0.3, 20.0),
    "area_offset": (-500.0, 3000.0),
    "residual_slope": (0.05, 1.0),
    "residual_offset": (
        1.0,
        500.0,
    ),  # above residual_slope, so that residual overlaps remain below the largest overlap
    "residual_rate": (1e-4, 1.0),
    "unloading_exponent": (1.0, 3.0),
    # bounds relative to the strength that fits best with the published constants
    YIELD: (0.3, 3.0),
}
RANGES = (
    1.0,
    10.0,
    50.0,
    177.6,
    math.inf,
)  # ranges of overlap / overlap at first yield, for misfits

_LOG = logging.getLogger("granwave")
_LEAST_LOADING = 1e-3  # smallest scale of residuals / largest force
_LEAST_TURN = 0.05  # smallest scale of residuals / force at the turn
_NO_FORCE = 1e-3  # force / force at the turn below which it counts as zero
_FEWEST = 5  # smallest number of rows of loading beyond first yield
_SMALL_TURN = (
    1.5  # overlap / first yield below which a turn does not determine the residual overlap
)
_UNIT_ERROR = 30.0  # ratio to the law's force above which the unit is probably wrong
_YIELD_SPAN = math.log(10.0)  # range of the search around a yield strength, logarithmic
_HUGE = 1e3  # residual of an invalid law

_BAD = 3.0  # deviation of a fit, rms, per cent, above which another zero of the overlap is tried
# deviation with the fitted zero over deviation without it, below which the zero is reported
_BETTER = 1 / 3
_PART = 3  # fewest rows of a part of the curve that counts here
_MICRO = 1e6  # micrometres in a metre

_LEAST_RISE = 0.01  # smallest slope of a_R at first yield
_STIFF = 100.0  # weight of this condition

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fit(FittedLaw):
    """Law fitted to a force-overlap curve.

    Attributes
    ----------
    curve
        The curve, with the readings of the overlap less the zero.
    zero
        Reading of the overlap at which the bodies touch, m.
    """

    curve: Curve
    zero: float = 0.0

    def value(self, name: str) -> float:
        """Return the value of a constant, of the yield strength, Pa, or of the zero, m."""
        return self.zero if name == ZERO else super().value(name)

    def published_value(self, name: str) -> float:
        """Return the published value of a constant; 0 for the zero of the overlap."""
        return 0.0 if name == ZERO else super().published_value(name)

    def undetermined(self, name: str) -> bool:
        """Return True for a constant that the curve does not determine, see `FittedLaw`.

        The uncertainty of the zero is compared with the largest overlap.
        """
        if name != ZERO:
            return super().undetermined(name)
        return name in self.at_bound or not self.uncertainty[name] <= float(self.curve.peak.max())

    @property
    def notes(self) -> list[str]:
        """Sentence on the zero, if it was fitted."""
        if ZERO not in self.uncertainty:
            return []
        spread = self.uncertainty[ZERO] * _MICRO
        readings = f"Readings of the overlap less {self.zero * _MICRO:.6g} +- {spread:.2g} µm"
        return [f"{readings}: the zero was also fitted."]


def fit_law(
    curve: Curve,
    materials: Sequence[Material],
    radii: Sequence[float],
    free: Sequence[str] | None = None,
    *,
    fit_yield: bool = False,
    fit_zero: bool = False,
) -> Fit:
    """Fit the law to a curve.

    If the fit is poor and would be good with another zero of the overlap, a warning states this
    zero.

    Parameters
    ----------
    materials, radii
        One or two materials and radii (m), which determine force and overlap at first yield.
    free
        Constants to fit; by default the constants that the curve can determine; a warning names the
        others.
    fit_yield
        True to fit the yield strength too, starting from the value of the softer material.
    fit_zero
        True to fit also the reading of the overlap at first contact; otherwise it is 0.

    Raises
    ------
    InputError
        The curve does not match the contact or is too short, or the law with the fitted constants
        is not passive.
    """
    if fit_zero:
        return _fit(curve, materials, radii, free, fit_yield=fit_yield, fit_zero=True)
    try:
        fit = _fit(curve, materials, radii, free, fit_yield=fit_yield, fit_zero=False)
    except InputError as error:
        other = _with_zero(curve, materials, radii, free, fit_yield=fit_yield)
        if other is None or _worst(other) > _BAD:
            raise
        raise InputError(f"{error}; {_zero_said(other)}") from None
    if _worst(fit) > _BAD:
        other = _with_zero(curve, materials, radii, free, fit_yield=fit_yield)
        if other is not None and _worst(other) < _BETTER * _worst(fit):
            _LOG.warning(
                "%s: the rms error in the worst range is %.3g %%; %s",
                curve.source,
                _worst(fit),
                _zero_said(other),
            )
    return fit


def _fit(
    curve: Curve,
    materials: Sequence[Material],
    radii: Sequence[float],
    free: Sequence[str] | None,
    *,
    fit_yield: bool,
    fit_zero: bool,
) -> Fit:
    published = contact_of(materials, radii)
    zero = estimated_zero(curve, published) if fit_zero else 0.0
    reading = curve
    curve = shifted(reading, zero)
    _refuse(curve, published, radii)
    first = published
    least_peak = 1.0  # smallest peak of fitted rows, relative to first yield
    if fit_yield:
        yield_strength = _yield_alone(curve, materials, radii)
        first = contact_of(with_yield(materials, yield_strength), radii)
        least_peak = BOUNDS[YIELD][0]
    rows = bearing(curve) & (curve.peak > least_peak * first.yield_overlap)
    if fit_zero:
        rows = bearing(curve) & touching(curve)
    further = [YIELD] * fit_yield + [ZERO] * fit_zero
    most = max(1, int(np.count_nonzero(rows)) - _FEWEST - len(further))
    names = known_constants(free) if free is not None else _tellable(curve, first, most)
    names += further
    if np.count_nonzero(rows) < len(names) + _FEWEST:
        raise InputError(
            f"{curve.source}: {np.count_nonzero(rows)} rows lie beyond first yield, expected at "
            f"least {len(names) + _FEWEST} to fit {len(names)} values; fix some with --free"
        )
    problem = _Problem(curve, rows, materials, radii, first, names)
    bounds = problem.bounds
    largest = float(curve.peak.max()) / first.yield_overlap
    is_loading = np.append(curve.loading[rows], False)
    search = Search(problem.residuals, bounds, names, is_loading, largest)
    x = search.best()
    try:
        law = problem.law(x, checked=True)
    except ValueError as error:
        raise InputError(
            f"{curve.source}: the best-fit constants give {error}; fix some with --free"
        ) from None
    at_bound = np.any(np.abs(x[:, None] - bounds) < 1e-6 * np.ptp(bounds, axis=1)[:, None], axis=1)
    rho = neighbour_correlation(problem.residuals(x)[:-1], curve.branch[rows])
    spread = uncertainties(search, x, at_bound) * math.sqrt((1 + rho) / (1 - rho))
    zero += problem.shift(x)
    fitted = shifted(reading, zero)
    of_published = _misfit(fitted, published).set_index("part").drop(columns="rows")
    return Fit(
        source=curve.source,
        n_rows=curve.force.size,
        curve=fitted,
        law=law,
        published=published,
        constants=law.constants,
        uncertainty={
            name: float(s * abs(problem.unit(name))) for name, s in zip(names, spread, strict=True)
        },
        at_bound=tuple(name for name, at in zip(names, at_bound, strict=True) if at),
        materials=tuple(with_yield(materials, law.yield_strength if fit_yield else None)),
        softer=place_of_softer(materials),
        radii=tuple(radii),
        correlation=rho,
        misfit=_misfit(fitted, law).join(of_published.add_prefix("published_"), on="part"),
        zero=zero,
    )


def _with_zero(
    curve: Curve,
    materials: Sequence[Material],
    radii: Sequence[float],
    free: Sequence[str] | None,
    *,
    fit_yield: bool,
) -> Fit | None:
    """Return the fit with a fitted zero of the overlap; None if there is none."""
    with _silent():
        try:
            return _fit(curve, materials, radii, free, fit_yield=fit_yield, fit_zero=True)
        except InputError:
            return None


def _zero_said(fit: Fit) -> str:
    """Return a sentence on the fitted zero of the overlap."""
    zero = fit.zero * _MICRO
    spread = fit.uncertainty[ZERO] * _MICRO
    return (
        f"with a zero of {zero:.4g} +- {spread:.2g} µm it would be {_worst(fit):.3g} %: "
        "also fit the zero (--fit-zero)"
    )


def _worst(fit: Fit) -> float:
    """Return the largest rms deviation of a part of the curve, per cent."""
    parts = fit.misfit[fit.misfit.rows >= _PART]
    return float(parts.rms_percent.max())


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Suppress the warnings of a trial fit."""
    _LOG.addFilter(_drop)
    try:
        yield
    finally:
        _LOG.removeFilter(_drop)


def _drop(record: logging.LogRecord) -> bool:
    return False


@dataclasses.dataclass(frozen=True, eq=False)
class _Problem:
    """Least-squares problem of a fit; its variables are the values relative to their start.

    Attributes
    ----------
    rows
        True for the fitted rows of the curve: (n,).
    first
        Law at the start.
    names
        Names of the fitted values: constants of the law, `YIELD` and `ZERO`.
    """

    curve: Curve
    rows: NDArray[np.bool_]
    materials: Sequence[Material]
    radii: Sequence[float]
    first: ContactLaw
    names: Sequence[str]

    @cached_property
    def start(self) -> dict[str, float]:
        """Values at the start by name."""
        return self.first.constants | {YIELD: self.first.yield_strength}

    def unit(self, name: str) -> float:
        """Return the change of a value when its variable grows by 1; m for the zero."""
        return float(self.curve.peak.max()) if name == ZERO else self.start[name]

    @cached_property
    def bounds(self) -> Array:
        """Bounds of the variables: (n_values, 2)."""
        units = {**self.start, YIELD: 1.0}  # bounds of the yield strength are relative
        zeros = 1 + np.array(zero_range(self.curve)) / self.unit(ZERO)
        return np.sort(
            [
                zeros if name == ZERO else np.array(BOUNDS[name]) / units[name]
                for name in self.names
            ],
            axis=1,
        )

    def shift(self, x: Array) -> float:
        """Return the reading at first contact minus the initial estimate, m."""
        if ZERO not in self.names:
            return 0.0
        return float(x[self.names.index(ZERO)] - 1) * self.unit(ZERO)

    @cached_property
    def scale(self) -> Array:
        """Scale of the residuals of the fitted rows, N."""
        return residual_scale(self.curve)[self.rows]

    def law(self, x: Array, *, checked: bool = False) -> ContactLaw:
        """Return the law with these variables; with ``checked``, ValueError if it
        is not passive.
        """
        constants = {
            name: float(factor * self.start[name])
            for name, factor in zip(self.names, x, strict=True)
            if name != ZERO
        }
        materials = with_yield(self.materials, constants.pop(YIELD, None))
        return contact_of(materials, self.radii, constants=constants, checked=checked)

    def residuals(self, x: Array) -> Array:
        """Return the scaled residuals of the fitted rows, and the penalty of `_healing`."""
        law = self.law(x)
        curve = shifted(self.curve, self.shift(x))
        force = law.force(curve.overlap[self.rows], curve.peak[self.rows])
        residuals = (force - curve.force[self.rows]) / self.scale
        finite = np.nan_to_num(residuals, nan=_HUGE, posinf=_HUGE, neginf=-_HUGE)
        return np.append(finite, _healing(law))


def residual_scale(curve: Curve) -> Array:
    """Return the scale s of the residuals: (n,), N."""
    floor = np.maximum(_LEAST_TURN * _turn_force(curve), _LEAST_LOADING * np.abs(curve.force).max())
    return np.maximum(np.abs(curve.force), floor)


def bearing(curve: Curve) -> NDArray[np.bool_]:
    """Return True for the fitted rows: all except rows of un- and reloading without
    a force, (n,).
    """
    return curve.loading | (np.abs(curve.force) > _NO_FORCE * _turn_force(curve))


def _turn_force(curve: Curve) -> Array:
    """Return the largest force among the rows with the same turn; 0 on loading: (n,), N."""
    largest = np.zeros(curve.force.size)
    for turn in curve.turns:
        rows = ~curve.loading & (curve.peak == turn)
        largest[rows] = np.abs(curve.force[rows]).max()
    return largest


def deviation(curve: Curve, law: ContactLaw) -> Array:
    """Return the deviations of a law from the curve: (n,), per cent."""
    return 100 * (law.force(curve.overlap, curve.peak) - curve.force) / residual_scale(curve)


def _yield_alone(curve: Curve, materials: Sequence[Material], radii: Sequence[float]) -> float:
    """Return the yield strength that fits best with the published constants, the start of the
    search, Pa.
    """
    yield_strength = contact_of(materials, radii).yield_strength
    rows = curve.overlap > 0
    scale = residual_scale(curve)

    def off(logarithm: float) -> float:
        law = contact_of(with_yield(materials, yield_strength * math.exp(logarithm)), radii)
        return float(
            np.sum(np.abs((law.force(curve.overlap, curve.peak) - curve.force) / scale)[rows])
        )

    grid = np.linspace(-_YIELD_SPAN, _YIELD_SPAN, 41)
    best = int(np.argmin([off(x) for x in grid]))
    around = (grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)])
    return yield_strength * math.exp(minimize_scalar(off, bounds=around, method="bounded").x)


def _refuse(curve: Curve, law: ContactLaw, radii: Sequence[float]) -> None:
    loading = curve.loading
    largest = float(curve.overlap.max(initial=0.0))
    if largest > min(radii):
        raise InputError(
            f"{curve.source}: overlap_m: found {largest:g} m, more than the radius {min(radii):g} "
            "m; check that the overlaps are in m, and check --radius"
        )
    if largest <= law.yield_overlap:
        raise InputError(
            f"{curve.source}: overlap_m: the largest, {largest:g} m, is below first yield at "
            f"{law.yield_overlap:.4g} m, where the constants have no effect; check --material and "
            "--radius"
        )
    beyond = loading & (curve.overlap > law.yield_overlap)
    if np.count_nonzero(beyond) < _FEWEST:
        raise InputError(
            f"{curve.source}: {np.count_nonzero(beyond)} rows of loading lie beyond first yield at "
            f"{law.yield_overlap:.4g} m, expected {_FEWEST} or more"
        )
    ratio = float(np.median(curve.force[beyond] / law.loading_force(curve.overlap[beyond])))
    if not 1 / _UNIT_ERROR < ratio < _UNIT_ERROR:
        raise InputError(
            f"{curve.source}: force_N: the forces are {ratio:.3g} times the forces of the "
            "published law; check that forces are in N and overlaps in m, and check --material "
            "and --radius"
        )


def known_constants(free: Sequence[str]) -> list[str]:
    for name in free:
        if name not in LAW_CONSTANTS:
            hint = did_you_mean(name, LAW_CONSTANTS) or "expected some of " + ", ".join(
                LAW_CONSTANTS
            )
            raise InputError(f"--free: found {name}; {hint}")
    if not free:
        raise InputError("--free: found nothing, expected names of constants")
    return [name for name in LAW_CONSTANTS if name in free]


def _tellable(curve: Curve, law: ContactLaw, most: int) -> list[str]:
    """Return the constants that the curve can determine, at most ``most``; warnings name the
    others.
    """
    overlap = curve.overlap / law.yield_overlap
    switch = law.constants["area_switch"]
    names = ["pressure_limit", "pressure_rate", "area_slope"]
    if np.count_nonzero(curve.loading & (overlap > switch)) >= _FEWEST:
        names += ["area_switch", "area_offset"]
    turns = np.count_nonzero(curve.turns > _SMALL_TURN * law.yield_overlap)
    if turns:
        of_unloading = ["unloading_exponent", "residual_offset", "residual_slope", "residual_rate"]
        names += of_unloading[: turns + 1]
    reasons = {
        "area_": f"fewer than {_FEWEST} rows of loading lie beyond {switch:g} times the overlap of first yield",
        "residual_": f"the curve is unloaded from {turns} overlap{'' if turns == 1 else 's'} "
        "only; at least three are required",
        "unloading_": "the curve has no unloading branch",
    }
    others = [name for name in LAW_CONSTANTS if name not in names]
    for part, reason in reasons.items():
        _warn_of_fixed(curve, [name for name in others if name.startswith(part)], reason)
    reason = f"each constant requires a row beyond first yield, plus {_FEWEST} more"
    _warn_of_fixed(curve, names[most:], reason)
    return [name for name in LAW_CONSTANTS if name in names[:most]]


def _warn_of_fixed(curve: Curve, names: Sequence[str], reason: str) -> None:
    """Warn that constants keep their published values."""
    if names:
        listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        verb = "stays" if len(names) == 1 else "stay"
        _LOG.warning("%s: %s %s as published, since %s", curve.source, listed, verb, reason)


def with_yield(materials: Sequence[Material], strength: float | None) -> list[Material]:
    if strength is None:
        return list(materials)
    return [dataclasses.replace(m, yield_strength=strength, source=None) for m in materials]


def _healing(law: ContactLaw) -> float:
    """Return a penalty against negative residual overlaps: 0 if a_R increases at first yield."""
    slope = law.constants["residual_slope"]
    offset = law.constants["residual_offset"]
    rate = law.constants["residual_rate"]
    return _STIFF * max(0.0, _LEAST_RISE - (slope - rate * (offset - slope)))


def neighbour_correlation(residuals: Array, branch: NDArray[np.str_]) -> float:
    """Return the correlation of residuals of neighbouring rows of a branch; 0 if it is not
    significant.
    """
    same_branch = branch[1:] == branch[:-1]
    power = float(np.mean(residuals**2))
    if not power or np.count_nonzero(same_branch) < 2:
        return 0.0
    rho = float(np.mean(residuals[1:][same_branch] * residuals[:-1][same_branch])) / power
    return min(rho, 0.99) if rho > 2 / math.sqrt(np.count_nonzero(same_branch)) else 0.0


def _misfit(curve: Curve, law: ContactLaw) -> DataFrame:
    """Return the deviations of a law by part of the curve; overlaps are relative to first yield."""
    off = np.abs(deviation(curve, law))
    peak = curve.peak / law.yield_overlap  # on loading the overlap
    branches = {
        "": ("loading beyond it", curve.loading),
        "from ": ("unloading and reloading", ~curve.loading & bearing(curve)),
    }
    parts = {"loading below first yield": curve.loading & (peak <= 1) & (peak > 0)}
    for word, (title, own) in branches.items():
        parts[title] = own & (peak > 1)
        for low, high in pairwise(RANGES):
            ends = f"{low:g} to {high:g}" if math.isfinite(high) else f"beyond {low:g}"
            parts[f"  {word}{ends}"] = own & (peak > low) & (peak <= high)
    rows = []
    for part, chosen in parts.items():
        if chosen.any():
            errors = off[chosen]
            rms = float(np.sqrt(np.mean(errors**2)))
            rows.append((part, len(errors), rms, float(errors.max())))
    return DataFrame(rows, columns=["part", "rows", "rms_percent", "largest_percent"])
