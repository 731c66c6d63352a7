"""Fit of the elasto-plastic law's constants to a force-overlap curve.

Least squares over the rows beyond first yield, of the residuals

    r = (F_law - F) / s,    s = |F|, but at least 0.1 % of the largest force on loading
                                and 5 % of the force at the turn on un- and reloading

so that small overlaps have the same weight as large ones. Residuals above three times the scatter
(a standard deviation from the median of |r|) contribute linearly only (Huber's loss). The standard
uncertainties come from the covariance s^2 (J^T W J)^-1; if residuals of neighbouring rows are
correlated (the law differs in shape from the curve), they are multiplied by sqrt((1 + rho)/(1 -
rho)), with the correlation rho of neighbours.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from pandas import DataFrame
from scipy.optimize import minimize_scalar

from granwave._contact_laws import ContactLaw
from granwave.analysis.contact_law.curves import Curve
from granwave.analysis.errors import did_you_mean
from granwave.extensions.continuum.law_fit.fit_search import Search, uncertainties
from granwave.lammps_inputs.case.contact import LAW_CONSTANTS
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.errors import InputError

YIELD = "yield_strength"

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
    ),  # above residual_slope, so that residual overlaps stay below the largest overlap
    "residual_rate": (1e-4, 1.0),
    "unloading_exponent": (1.0, 3.0),
    YIELD: (0.3, 3.0),  # over the strength that fits best with the published constants
}
RANGES = (
    1.0,
    10.0,
    50.0,
    177.6,
    math.inf,
)  # ranges of the overlap over that at first yield, for misfits

_LOG = logging.getLogger("granwave")
# floors of the scale of residuals
_LEAST_LOADING = 1e-3
_LEAST_TURN = 0.05
_NO_FORCE = 1e-3  # over the force at the turn; smaller forces count as zero
_FEWEST = 5  # fewest rows of loading beyond first yield
# overlap over that at first yield; smaller turns do not determine the residual overlap
_SMALL_TURN = 1.5
# ratio of forces; no material differs so much from the law, so that the unit must be wrong
_UNIT_ERROR = 30.0
_YIELD_SPAN = math.log(
    10.0
)  # range of the search on either side of the given yield strength, logarithmic
_HUGE = 1e3  # residual of an invalid law

# smallest slope of a_R at first yield, and weight of this condition
_LEAST_RISE = 0.01
_STIFF = 100.0

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fit:
    """Result of a fit.

    Attributes
    ----------
    law, published
        Law with the fitted constants, and with the published ones.
    constants
        All constants of the law, by name.
    uncertainty
        Standard uncertainty of each fitted constant, in its own unit; infinite if the curve does
        not determine it.
    at_bound
        Names of the constants that ended at a bound of the search.
    materials, radii
        Materials of the two bodies, with the fitted yield strength, and radii, m.
    correlation
        Correlation of the residuals of neighbouring rows.
    misfit
        Deviations by part of the curve, in columns ``part``, ``rows``, number of rows, and
        ``rms_percent``, ``largest_percent``, ``published_rms_percent``,
        ``published_largest_percent``, of both laws.
    """

    curve: Curve
    law: ContactLaw
    published: ContactLaw
    constants: dict[str, float]
    uncertainty: dict[str, float]
    at_bound: tuple[str, ...]
    materials: tuple[Material, ...]
    radii: tuple[float, ...]
    correlation: float
    misfit: DataFrame

    def value(self, name: str) -> float:
        """Return the value of a constant, or of the yield strength, Pa."""
        return self.law.yield_strength if name == YIELD else self.constants[name]

    def undetermined(self, name: str) -> bool:
        """Return True if the uncertainty of a constant exceeds its value, or if it ended at a
        bound.
        """
        return name in self.at_bound or not self.uncertainty[name] <= abs(self.value(name))


def fit_law(
    curve: Curve,
    materials: Sequence[Material],
    radii: Sequence[float],
    free: Sequence[str] | None = None,
    *,
    fit_yield: bool = False,
) -> Fit:
    """Fit the law to a curve.

    Parameters
    ----------
    materials, radii
        One or two materials and radii (m), which determine force and overlap at first yield.
    free
        Constants to fit; by default those that the curve can determine, and a warning names the
        rest.
    fit_yield
        True to fit the yield strength, too, starting from that of the softer material.

    Raises
    ------
    InputError
        The curve does not suit the contact or is too short, or the law with the fitted constants
        is not passive.
    """
    published = contact_of(materials, radii)
    _refuse(curve, published, radii)
    first = published
    least_peak = 1.0  # of fitted rows, relative to first yield
    if fit_yield:
        yield_strength = _yield_alone(curve, materials, radii)
        first = contact_of(_with_yield(materials, yield_strength), radii)
        least_peak = BOUNDS[YIELD][0]
    rows = bearing(curve) & (curve.peak > least_peak * first.yield_overlap)
    most = max(1, int(np.count_nonzero(rows)) - _FEWEST - fit_yield)
    names = _known(free) if free is not None else _tellable(curve, first, most)
    if fit_yield:
        names.append(YIELD)
    if np.count_nonzero(rows) < len(names) + _FEWEST:
        raise InputError(
            f"{curve.source}: {np.count_nonzero(rows)} rows lie beyond first yield, "
            f"expected at least {len(names) + _FEWEST} to fit {len(names)} values; hold some with --free"
        )
    start = first.constants | {YIELD: first.yield_strength}

    def law_of(x: Array, checked: bool = False) -> ContactLaw:
        constants = {
            name: float(factor * start[name]) for name, factor in zip(names, x, strict=True)
        }
        strength = constants.pop(YIELD, None)
        return contact_of(
            _with_yield(materials, strength), radii, constants=constants, checked=checked
        )

    scale = residual_scale(curve)[rows]

    def residuals(x: Array) -> Array:
        law = law_of(x)
        off = (law.force(curve.overlap[rows], curve.peak[rows]) - curve.force[rows]) / scale
        return np.append(np.nan_to_num(off, nan=_HUGE, posinf=_HUGE, neginf=-_HUGE), _healing(law))

    units = {**start, YIELD: 1.0}  # bounds of the yield strength are relative
    bounds = np.sort([np.array(BOUNDS[name]) / units[name] for name in names], axis=1)
    largest = float(curve.peak.max()) / first.yield_overlap
    search = Search(residuals, bounds, names, np.append(curve.loading[rows], False), largest)
    x = search.best()
    try:
        law = law_of(x, checked=True)
    except ValueError as error:
        raise InputError(
            f"{curve.source}: the constants that fit best make {error}; hold some with --free"
        ) from None
    at_bound = np.any(np.abs(x[:, None] - bounds) < 1e-6 * np.ptp(bounds, axis=1)[:, None], axis=1)
    rho = _neighbours(residuals(x)[:-1], curve.branch[rows])
    spread = uncertainties(search, x, at_bound) * math.sqrt((1 + rho) / (1 - rho))
    of_published = _misfit(curve, published).set_index("part").drop(columns="rows")
    return Fit(
        curve=curve,
        law=law,
        published=published,
        constants=law.constants,
        uncertainty={
            name: float(s * abs(start[name])) for name, s in zip(names, spread, strict=True)
        },
        at_bound=tuple(name for name, at in zip(names, at_bound, strict=True) if at),
        materials=tuple(_with_yield(materials, law.yield_strength if fit_yield else None)),
        radii=tuple(radii),
        correlation=rho,
        misfit=_misfit(curve, law).join(of_published.add_prefix("published_"), on="part"),
    )


def residual_scale(curve: Curve) -> Array:
    """Return the scale s of the residuals: (n,), N."""
    floor = np.maximum(_LEAST_TURN * _turn_force(curve), _LEAST_LOADING * np.abs(curve.force).max())
    return np.maximum(np.abs(curve.force), floor)


def bearing(curve: Curve) -> NDArray[np.bool_]:
    """Return True for fitted rows: all except un- and reloading without force, (n,)."""
    return curve.loading | (np.abs(curve.force) > _NO_FORCE * _turn_force(curve))


def _turn_force(curve: Curve) -> Array:
    """Return the largest force of the rows of the same turn; 0 on loading: (n,), N."""
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
        law = contact_of(_with_yield(materials, yield_strength * math.exp(logarithm)), radii)
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
            f"{curve.source}: overlap_m: found {largest:g} m, more than the radius {min(radii):g} m; "
            "are the overlaps in m, and is --radius right?"
        )
    if largest <= law.yield_overlap:
        raise InputError(
            f"{curve.source}: overlap_m: the largest, {largest:g} m, does not pass first yield at "
            f"{law.yield_overlap:.4g} m, below which the constants do nothing; are --material and --radius right?"
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
            f"{curve.source}: force_N: the forces are {ratio:.3g} times those of the published law; "
            "are they in N, the overlaps in m, and are --material and --radius right?"
        )


def _known(free: Sequence[str]) -> list[str]:
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
        "residual_": f"the curve is unloaded from {turns} overlap{'' if turns == 1 else 's'} only, and three tell all",
        "unloading_": "the curve has no unloading",
    }
    others = [name for name in LAW_CONSTANTS if name not in names]
    for part, reason in reasons.items():
        _warn_of_fixed(curve, [name for name in others if name.startswith(part)], reason)
    reason = f"each constant needs a row beyond first yield, and {_FEWEST} more are needed"
    _warn_of_fixed(curve, names[most:], reason)
    return [name for name in LAW_CONSTANTS if name in names[:most]]


def _warn_of_fixed(curve: Curve, names: Sequence[str], reason: str) -> None:
    """Warn that constants keep their published values."""
    if names:
        listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        verb = "stays" if len(names) == 1 else "stay"
        _LOG.warning("%s: %s %s as published, since %s", curve.source, listed, verb, reason)


def _with_yield(materials: Sequence[Material], strength: float | None) -> list[Material]:
    if strength is None:
        return list(materials)
    return [dataclasses.replace(m, yield_strength=strength, source=None) for m in materials]


def _healing(law: ContactLaw) -> float:
    """Return a penalty against negative residual overlaps: 0 if a_R increases at first yield."""
    slope, offset, rate = (
        law.constants[f"residual_{name}"] for name in ("slope", "offset", "rate")
    )
    return _STIFF * max(0.0, _LEAST_RISE - (slope - rate * (offset - slope)))


def _neighbours(residuals: Array, branch: NDArray[np.str_]) -> float:
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
        "from ": ("un- and reloading", ~curve.loading & bearing(curve)),
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
