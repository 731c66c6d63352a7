"""Inference of contact forces: candidates, equations, weights, solution, residuals, modulus and errors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.analysis.inference.case import Infer
from granwave.analysis.inference.equations import (
    Covariance,
    Equations,
    Noise,
    Weights,
    add_ridge,
    covariance,
    make_equations,
    refuse_undetermined,
    unknown_columns,
    weighting,
)
from granwave.analysis.inference.grains import Array, Contacts, Grains, Wall, find_contacts
from granwave.analysis.inference.solve import (
    ModulusSearch,
    find_modulus,
    free_misfit,
    refuse_unknowable,
    search_near,
    solve,
)
from granwave.analysis.progress_bar import progress_bar
from granwave.lammps_inputs.errors import InputError

_ROUNDING = 1e-6  # rate of rotation times radius over the acceleration
_SHOWN = 5  # ids in a message
NEAR = 5.0  # standard errors of the modulus within which repetitions search


@dataclasses.dataclass(frozen=True, eq=False)
class Inference:
    """Inferred forces.

    Attributes
    ----------
    force
        Normal and tangential components on the first grain: (m, d), N.
    spread
        Their standard errors; None without known noise: (m, d), N.
    n_unknowns
        Number of components of forces.
    residual
        Equations of motion and of stress, left side minus right: (n_rows,), N.
    factor
        Factor by which the moduli were multiplied.
    weights
        Weights in use.
    chi2
        Weighted sum of squares of the residuals; in units of the noise unless weights are equal.
    search
        Search for the modulus, if there was one.
    condition
        Ratio of the extreme singular values of the equations; None for large problems.
    """

    grains: Grains
    contacts: Contacts
    equations: Equations
    settings: Infer
    force: Array
    spread: Array | None
    residual: Array
    n_unknowns: int
    factor: float
    weights: Weights
    chi2: float
    search: ModulusSearch | None
    condition: float | None

    @property
    def relative_residual(self) -> float:
        """Root of the sum of squares of the residuals over that of the right-hand sides."""
        size = float(np.linalg.norm(self.equations.data(self.factor)))
        return float(np.linalg.norm(self.residual)) / size if size > 0 else 0.0

    @property
    def errors(self) -> tuple[Array, Array]:
        """Standard errors of the normal forces, and of each component of the tangential ones: (m,) each, N."""
        assert self.spread is not None
        shear = np.linalg.norm(self.spread[:, 1:], axis=1) / math.sqrt(self.spread.shape[1] - 1)
        return self.spread[:, 0], np.asarray(shear)

    @property
    def n_free(self) -> int:
        """Number of equations minus that of components of forces that differ from zero."""
        return self.equations.n_equations - int(np.count_nonzero(self.force))

    def residual_of_grains(self) -> tuple[Array, Array]:
        """Return the sizes of the residuals of motion and of stress by grain; NaN where not measured: (n,), N."""
        n_motion = len(self.equations.motion_grain)
        found = []
        for rows, values in (
            (self.equations.motion_grain, self.residual[:n_motion]),
            (self.equations.stress_grain, self.residual[n_motion:]),
        ):
            squares = np.bincount(rows, values**2, minlength=len(self.grains))
            known = np.bincount(rows, minlength=len(self.grains)) > 0
            found.append(np.where(known, np.sqrt(squares), np.nan))
        return found[0], found[1]


def infer(grains: Grains, walls: Mapping[str, Wall], settings: Infer, *, progress: bool = False) -> Inference:
    """Infer the contact forces of grains at one instant.

    Parameters
    ----------
    progress
        Show a bar of the repetitions on a terminal.

    Raises
    ------
    InputError
        A grain touches nothing, the equations do not determine the forces, or nothing tells the modulus.
    """
    contacts = find_contacts(grains, walls, settings.contact_tolerance)
    refuse_behind(grains, walls)
    refuse_lonely(grains, contacts, settings.contact_tolerance)
    equations = make_equations(grains, contacts)
    if settings.finds_modulus:
        refuse_unknowable(grains, equations)
    friction = settings.friction_of(contacts)
    kept = unknown_columns(friction, grains.dimension)
    condition = refuse_undetermined(equations, friction, settings.ridge)
    kind, spread = _weights(grains, settings)
    weighed = weighting(equations, spread, kind)

    def solution(factor: float, data: Array, rows: sparse.csr_array | None = None) -> tuple[Array, float]:
        rows = weighed(factor) if rows is None else rows
        matrix, right = add_ridge(rows @ equations.matrix, rows @ data, settings.ridge)
        force = solve(matrix, right, friction, grains.dimension)
        return force, float(((matrix @ force.ravel() - right) ** 2).sum())

    exact = weighting(equations, spread, "correlated") if settings.finds_modulus else weighed

    def misfit(factor: float, data: Array) -> float:
        rows = exact(factor)
        if condition is None:
            return solution(factor, data, rows)[1]
        return free_misfit((rows @ equations.matrix)[:, kept], rows @ data)

    search, factor, known = None, 1.0, settings.deviations.complete(grains)
    if settings.finds_modulus:
        search = find_modulus(equations, lambda trial: misfit(trial, equations.data(trial)))
        factor = search.factor
        n_more = max(equations.n_equations - len(kept), 1)
        search = search.with_error(1.0 if known else float(search.chi2.min()) / n_more)
    force, chi2 = solution(factor, equations.data(factor))
    residual = equations.matrix @ force.ravel() - equations.data(factor)
    errors = None
    if settings.repetitions > 1 and known:
        errors = _repeat(equations, spread, settings, force, factor, solution, misfit, search, progress)
    return Inference(
        grains, contacts, equations, settings, force, errors, residual, len(kept), factor, kind, chi2, search, condition
    )


def refuse_behind(grains: Grains, walls: Mapping[str, Wall]) -> None:
    """Raise InputError for each wall that has centres of grains behind it, but for those that pass walls."""
    errors = []
    for name, wall in walls.items():
        behind = ((grains.position - np.array(wall.point)) @ np.array(wall.normal) <= 0) & grains.at_walls
        if behind.any():
            errors.append(
                f"grain {_few(grains.ids[behind])}: lies behind the wall {name}; check infer.walls.{name} and the "
                "places, both in m"
            )
    if errors:
        raise InputError(errors)


def _few(ids: NDArray[np.int64]) -> str:
    return ", ".join(map(str, ids[:_SHOWN].tolist())) + (", ..." if len(ids) > _SHOWN else "")


def refuse_lonely(grains: Grains, contacts: Contacts, tolerance: float) -> None:
    """Raise InputError if a grain touches nothing."""
    touched = contacts.touched(len(grains))
    if not touched.all():
        raise InputError(
            f"grain {_few(grains.ids[~touched])}: touches nothing: no grain or wall lies within a relative gap of "
            f"{tolerance:g}; give the walls in infer.walls, raise infer.contact_tolerance, or leave the row out"
        )


def _weights(grains: Grains, settings: Infer) -> tuple[Weights, Covariance]:
    """Return the weights in use, and the covariance they follow from; unknown noise counts as a share of the data."""
    known = settings.deviations.complete(grains)
    kind: Weights = settings.weights or ("white" if known or settings.finds_modulus else "equal")
    if settings.weights in ("white", "correlated") and not known and not settings.finds_modulus:
        raise InputError(
            f'infer.weights: found "{settings.weights}" without the standard deviations that it takes; expected '
            "infer.noise of all that was measured"
        )
    if known:
        return kind, covariance(grains, settings.deviations)
    return kind, covariance(grains, relative_noise(grains, 1.0))


def relative_noise(grains: Grains, share: float) -> Noise:
    """Return noise that is a share of the root mean squares of strains (or stresses) and of accelerations."""

    def size(values: Array) -> float | None:
        found = values[np.isfinite(values)]
        return share * float(np.sqrt(np.mean(found**2))) or None if len(found) else None

    turning, motion = size(grains.angular_acceleration), size(grains.acceleration)
    if turning and motion and turning * float(grains.radius.mean()) < _ROUNDING * motion:
        turning = None  # grains that do not turn: what is left is rounding
    if grains.compliance is None:
        return Noise(None, size(grains.stress), motion, turning)
    return Noise(size(grains.strain), None, motion, turning)


def _repeat(
    equations: Equations,
    spread: Covariance,
    settings: Infer,
    force: Array,
    factor: float,
    solution: Callable[[float, Array], tuple[Array, float]],
    misfit: Callable[[float, Array], float],
    search: ModulusSearch | None,
    progress: bool,
) -> Array:
    """Return standard errors of the forces: deviations of solutions whose data are the fitted ones with new noise."""
    rng = np.random.default_rng(settings.seed)
    fitted = equations.matrix @ force.ravel()
    found = []
    bar = progress_bar(progress, iterable=range(settings.repetitions), desc="repetitions with noise", leave=False)
    for _ in bar:
        data = fitted + spread.draw(rng, factor)
        if search is None or not search.error:
            found.append(solution(factor, data)[0])
            continue
        n_motion = len(equations.motion_data)
        spin = np.concatenate([np.zeros(n_motion), equations.spin_data])
        strained = np.concatenate([np.zeros(n_motion), (data - spin)[n_motion:] / factor])
        rest = np.concatenate([data[:n_motion], equations.spin_data])

        def again(trial: float, rest: Array = rest, strained: Array = strained) -> float:
            return misfit(trial, rest + trial * strained)

        best = search_near(again, factor, NEAR * search.error)
        found.append(solution(best, rest + best * strained)[0])
    return np.sqrt(((np.array(found) - force) ** 2).sum(axis=0) / (len(found) - 1))
