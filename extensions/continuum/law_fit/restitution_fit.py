"""Fit of the elasto-plastic law to measured coefficients of restitution.

An impact of effective mass m at the velocity v loads the contact until the work of loading W is
m v^2/2, and dissipates D:  e = sqrt(1 - D/W). With given constants of the law, e depends on the
velocity divided by the velocity at first yield, which is proportional to the power 5/2 of the yield
strength: restitution determines the yield strength best. For each other constant the fit states the
uncertainty that these measurements would give if the constant were fitted together with the yield
strength.

Least squares of e_law - e, with Huber's loss beyond three times the scatter; uncertainties as in
fits to curves.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pandas import DataFrame
from scipy.optimize import least_squares

from granwave._contact_laws import ContactLaw
from granwave.extensions.continuum.law_fit.fit import (
    BOUNDS,
    known_constants,
    neighbour_correlation,
    with_yield,
)
from granwave.extensions.continuum.law_fit.fitted_law import YIELD, FittedLaw, place_of_softer
from granwave.extensions.continuum.law_fit.rebounds import Rebounds
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS
from granwave.lammps_inputs.case.material import Material, sphere_mass
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.errors import InputError

_LOG = logging.getLogger("granwave")
_STRENGTHS = (1e-5, 0.1)  # range of the search for the yield strength over Young's modulus
_TRIALS = 120  # most trials of the search
_OF_VELOCITY = 2.5  # power of the yield strength to which velocities are proportional
_YIELD_RANGE = (0.03, 30.0)  # bounds of the yield strength relative to the result of the search
_POINTS = 400  # overlaps from first yield to R* between which velocities are interpolated
_END_OF_FIT = 0.2  # largest overlap / R* in the fit of the law
_ENOUGH = 5  # fewest elastic impacts whose loss is tested
_FEWEST = 3  # smallest number of rows beyond the number of fitted values
_STEP = 1e-4  # relative step of derivatives
_OUTLIER = 3.0  # residual in standard deviations beyond which the loss is linear
_SURE = 4.0  # mean loss of slow impacts in its standard deviations that is significant
_NARROWEST = 1e-6  # smallest width of the quadratic loss
_SINGULAR = 1e-10  # relative size of singular values that count as zero
_TOLD = 0.2  # relative uncertainty below which the measurements determine a constant

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RestitutionFit(FittedLaw):
    """Law fitted to coefficients of restitution.

    Attributes
    ----------
    rebounds
        The measurements.
    mass
        Effective mass of the two bodies, kg.
    told
        Relative uncertainty of each fixed constant if it were fitted together with the yield
        strength; infinite if the measurements do not determine it.
    """

    rebounds: Rebounds
    mass: float
    told: dict[str, float]

    def state(self, name: str) -> str:
        """Describe how a value was obtained, and how well impacts would determine a fixed value."""
        if name in self.uncertainty:
            return super().state(name)
        spread = self.told[name]
        if not math.isfinite(spread):
            return "fixed: not determined by restitution"
        percent = f"{float(f'{100 * spread:.2g}'):g} %"
        if spread <= _TOLD:
            return f"fixed: --free {name} would determine it to {percent}"
        return f"fixed: not determined by restitution (+- {percent})"

    @property
    def scale(self) -> str:
        """Sentence on the velocity at first yield."""
        work = float(self.law.loading_work(np.array([self.law.yield_overlap]))[0])
        return f"contacts yield from {math.sqrt(2 * work / self.mass):.4g} m/s on"


def fit_restitution(
    rebounds: Rebounds,
    materials: Sequence[Material],
    radii: Sequence[float],
    free: Sequence[str] = (),
) -> RestitutionFit:
    """Fit the yield strength of the softer body, and further constants, to measured restitution.

    Parameters
    ----------
    materials, radii
        One or two materials and radii (m; the second may be infinite, a plane). Their yield
        strengths are not used.
    free
        Constants to fit in addition to the yield strength.

    Raises
    ------
    InputError
        There are too few measurements, or the law with the fitted constants is not passive.
    """
    names = [YIELD, *(known_constants(free) if free else [])]
    least = len(names) + _FEWEST - 1
    if rebounds.velocity.size < least:
        raise InputError(
            f"{rebounds.source}: found {rebounds.velocity.size} impacts, expected at least {least} "
            f"to fit {len(names)} value{'s' if len(names) > 1 else ''}"
        )
    _refuse_rates(materials)
    problem = _Problem(rebounds, materials, radii, names)
    x = problem.best()
    try:
        law = problem.law(x, checked=True)
    except ValueError as error:
        raise InputError(
            f"{rebounds.source}: the best-fit constants give {error}; fit fewer with --free"
        ) from None
    residuals = problem.residuals(x)
    rho = neighbour_correlation(residuals, np.full(residuals.size, "", dtype=np.str_))
    wider = math.sqrt((1 + rho) / (1 - rho))
    at_bound = tuple(np.array(names)[problem.is_at_bound(x)])
    slopes = problem.slopes(x)
    fitted = [slopes[name] for name in names]
    spread = wider * _spread(residuals, fitted)
    published = problem.published(law)
    fit = RestitutionFit(
        source=rebounds.source,
        n_rows=rebounds.velocity.size,
        rebounds=rebounds,
        mass=problem.mass,
        law=law,
        published=published,
        constants=law.constants,
        uncertainty={
            name: float(s * problem.start[name]) for name, s in zip(names, spread, strict=True)
        },
        at_bound=at_bound,
        materials=tuple(with_yield(materials, law.yield_strength)),
        softer=place_of_softer(materials),
        radii=tuple(radii),
        correlation=rho,
        misfit=_misfit(rebounds, problem.mass, law, published),
        told={
            name: float(wider * _spread(residuals, [*fitted, slopes[name]])[-1])
            for name in LAW_CONSTANTS
            if name not in names
        },
    )
    _warn(fit)
    return fit


def restitution_at(law: ContactLaw, mass: float, velocity: Array) -> Array:
    """Return the coefficients of restitution at impact velocities, m/s, of any shape.

    Parameters
    ----------
    mass
        Effective mass of the two bodies, kg.
    """
    peak = _overlaps(law)
    work = law.loading_work(peak)
    kept = np.clip(1 - law.dissipated_energy(peak) / work, 0, 1)
    return np.sqrt(np.interp(np.log(0.5 * mass * velocity**2), np.log(work), kept))


def overlap_at(law: ContactLaw, mass: float, velocity: Array) -> Array:
    """Return the largest overlaps of impacts at velocities, m/s; overlaps of elastic impacts are at
    most the overlap at first yield: (n,), m.
    """
    peak = _overlaps(law)
    return np.interp(0.5 * mass * velocity**2, law.loading_work(peak), peak)


def _overlaps(law: ContactLaw) -> Array:
    """Return overlaps from first yield to R*, m."""
    first = min(law.yield_overlap, 0.5 * law.effective_radius)
    return np.geomspace(first, law.effective_radius, _POINTS)


def effective_mass(materials: Sequence[Material], radii: Sequence[float]) -> float:
    """Return the effective mass of two spheres, or of a sphere on a plane (infinite radius), kg."""
    first = sphere_mass(materials[0], radii[0])
    if math.isinf(radii[-1]):
        return first
    second = sphere_mass(materials[-1], radii[-1])
    return first * second / (first + second)


@dataclasses.dataclass(frozen=True, eq=False)
class _Problem:
    """Least-squares problem; its variables are the values relative to their start."""

    rebounds: Rebounds
    materials: Sequence[Material]
    radii: Sequence[float]
    names: Sequence[str]

    @cached_property
    def mass(self) -> float:
        """Effective mass, kg."""
        return effective_mass(self.materials, self.radii)

    @cached_property
    def start(self) -> dict[str, float]:
        """Values at the start by name: the yield strength that fits best, published constants."""
        modulus = min(solid.youngs_modulus for solid in self.materials)
        strengths = modulus * np.geomspace(*_STRENGTHS, _TRIALS)
        law = self._law_of({YIELD: strengths[0]})
        # the weakest material at velocities that compensate for its strength
        factors = (strengths[0] / strengths) ** _OF_VELOCITY
        tried = restitution_at(law, self.mass, np.outer(factors, self.rebounds.velocity))
        off = np.sum(np.abs(tried - self._measured), axis=1)
        return {**LAW_CONSTANTS, YIELD: float(strengths[int(np.argmin(off))])}

    @cached_property
    def bounds(self) -> Array:
        """Bounds of the variables: (n_values, 2)."""
        limits = BOUNDS | {YIELD: tuple(self.start[YIELD] * np.array(_YIELD_RANGE))}
        return np.array([np.array(limits[name]) / self.start[name] for name in self.names])

    @property
    def _measured(self) -> Array:
        return self.rebounds.restitution

    def _law_of(self, values: dict[str, float], *, checked: bool = False) -> ContactLaw:
        constants = {name: value for name, value in values.items() if name != YIELD}
        solids = with_yield(self.materials, values[YIELD])
        return contact_of(solids, self.radii, constants=constants, checked=checked)

    def _of_law(self, law: ContactLaw) -> Array:
        return restitution_at(law, self.mass, self.rebounds.velocity)

    def law(self, x: Array, *, checked: bool = False) -> ContactLaw:
        """Return the law with these variables; with ``checked``, ValueError if it
        is not passive.
        """
        fitted = {
            name: float(factor * self.start[name])
            for name, factor in zip(self.names, x, strict=True)
        }
        return self._law_of(fitted, checked=checked)

    def published(self, law: ContactLaw) -> ContactLaw:
        """Return the law with the published constants, and with the materials' yield strength if
        given.
        """
        if any(solid.yield_strength is None for solid in self.materials):
            return self._law_of({YIELD: law.yield_strength})
        return contact_of(self.materials, self.radii)

    def residuals(self, x: Array) -> Array:
        """Return e_law - e: (n_rows,)."""
        return np.nan_to_num(self._of_law(self.law(x)) - self._measured, nan=1.0)

    def best(self) -> Array:
        """Find the best values."""
        x = np.ones(len(self.names))
        width = 1.0
        for _ in range(3):
            solution = least_squares(
                self.residuals,
                x,
                bounds=self.bounds.T,
                loss="huber",
                f_scale=width,
                x_scale="jac",
                diff_step=_STEP,
            )
            x = solution.x
            scatter = 1.4826 * float(np.median(np.abs(self.residuals(x))))
            width = max(_OUTLIER * scatter, _NARROWEST)
        return x

    def is_at_bound(self, x: Array) -> NDArray[np.bool_]:
        """Return True for values at a bound of the search: (n_values,)."""
        near = 1e-6 * np.ptp(self.bounds, axis=1)
        return np.any(np.abs(x[:, None] - self.bounds) < near[:, None], axis=1)

    def slopes(self, x: Array) -> dict[str, Array]:
        """Return the derivatives of e by each fitted value and each other constant relative to its
        start, by name: (n_rows,) each.
        """
        fitted = zip(self.names, x, strict=True)
        values = self.start | {name: float(factor * self.start[name]) for name, factor in fitted}
        return {name: self._slope(values, name) for name in values}

    def _slope(self, values: dict[str, float], name: str) -> Array:
        """Return the derivative of e by a value relative to its start: (n_rows,)."""
        step = _STEP * values[name]
        high = self._of_law(self._law_of({**values, name: values[name] + step}))
        low = self._of_law(self._law_of({**values, name: values[name] - step}))
        return (high - low) / (2 * step) * self.start[name]


def _spread(residuals: Array, slopes: Sequence[Array]) -> Array:
    """Return the standard uncertainties of values, given the derivatives by them; infinite if
    undetermined: (n_values,).
    """
    jacobian = np.column_stack(slopes)
    scatter = max(1.4826 * float(np.median(np.abs(residuals))), _NARROWEST)
    weight = np.minimum(1.0, _OUTLIER * scatter / np.maximum(np.abs(residuals), _NARROWEST))
    freedom = max(residuals.size - len(slopes), 1)
    variance = float(np.sum(weight * residuals**2)) / freedom
    weighted = np.sqrt(weight)[:, None] * jacobian
    _, singular, rows = np.linalg.svd(weighted, full_matrices=False)
    told = singular > _SINGULAR * max(singular.max(initial=0.0), _SINGULAR)
    covariance = (rows[told].T / singular[told] ** 2) @ rows[told]
    lost = np.any(np.abs(rows[~told]) > 1e-3, axis=0)
    return np.where(lost, np.inf, np.sqrt(variance * np.diag(covariance)))


def _refuse_rates(materials: Sequence[Material]) -> None:
    for solid in materials:
        if solid.rate_sensitivity:
            raise InputError(
                f"material {solid.name}: rate_sensitivity: found {solid.rate_sensitivity:g}, but "
                "restitution is fitted with a rate-independent yield strength; take it out"
            )


def _misfit(rebounds: Rebounds, mass: float, law: ContactLaw, published: ContactLaw) -> DataFrame:
    """Return the deviations of both laws by part of the measurements, per cent."""
    off = 100 * np.abs(restitution_at(law, mass, rebounds.velocity) - rebounds.restitution)
    other = 100 * np.abs(restitution_at(published, mass, rebounds.velocity) - rebounds.restitution)
    yields = overlap_at(law, mass, rebounds.velocity) > law.yield_overlap
    rows = []
    for part, chosen in (("impacts without yield", ~yields), ("impacts beyond it", yields)):
        if chosen.any():
            errors: list[float] = []
            for values in (off[chosen], other[chosen]):
                errors.extend((float(np.sqrt(np.mean(values**2))), float(values.max())))
            rows.append((part, int(np.count_nonzero(chosen)), *errors))
    columns = [
        "part",
        "rows",
        "rms_percent",
        "largest_percent",
        "published_rms_percent",
        "published_largest_percent",
    ]
    return DataFrame(rows, columns=columns)


def _warn(fit: RestitutionFit) -> None:
    """Warn of impacts beyond the range of the law, of elastic impacts that lose energy, and of a
    yield strength that restitution does not determine.
    """
    rebounds = fit.rebounds
    overlap = overlap_at(fit.law, fit.mass, rebounds.velocity)
    beyond = overlap > _END_OF_FIT * fit.law.effective_radius
    if beyond.any():
        _LOG.warning(
            "%s: %d impacts, from %.4g m/s on, compress the contact beyond %g R*, the limit of "
            "the law",
            fit.source,
            np.count_nonzero(beyond),
            rebounds.velocity[beyond].min(),
            _END_OF_FIT,
        )
    if fit.undetermined(YIELD):
        _LOG.warning(
            "%s: the yield strength is not determined: expected impacts that dissipate energy by "
            "yielding, at increasing velocities",
            fit.source,
        )
    elastic = overlap <= fit.law.yield_overlap
    lost = 1 - rebounds.restitution[elastic]
    residuals = restitution_at(fit.law, fit.mass, rebounds.velocity) - rebounds.restitution
    scatter = 1.4826 * float(np.median(np.abs(residuals - np.median(residuals))))
    if lost.size >= _ENOUGH and lost.mean() > _SURE * scatter / math.sqrt(lost.size):
        _LOG.warning(
            "%s: impacts too slow to yield rebound with %.3f of their velocity, not 1: the "
            "contact has another source of dissipation (contact.loss), which increases the error "
            "of the fit",
            fit.source,
            1 - lost.mean(),
        )
