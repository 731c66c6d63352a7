"""Inference of contact forces: candidates, equations, weights, solution, residuals, modulus and
errors.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.analysis.progress_bar import progress_bar
from granwave.extensions.inference.forces import equations as eq
from granwave.extensions.inference.forces.case import Infer
from granwave.extensions.inference.forces.equations import Equations, Noise, Weights
from granwave.extensions.inference.forces.freedom import expected_misfit, freedom, root_of
from granwave.extensions.inference.forces.grains import (
    NORMAL,
    TANGENTIAL,
    Array,
    CandidateContacts,
    MeasuredGrains,
    StraightWall,
    find_contacts,
)
from granwave.extensions.inference.forces.solve import (
    ModulusSearch,
    find_modulus,
    free_misfit,
    refuse_unknowable,
    search_near,
    solve,
)
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
        Weighted sum of squares of the residuals, without the ridge; in units of the noise unless
        weights are equal.
    search
        Search for the modulus, if there was one.
    condition
        Ratio of the extreme singular values of the equations; None for large problems.
    """

    grains: MeasuredGrains
    contacts: CandidateContacts
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
        """Norm of the residuals divided by the norm of the right-hand sides."""
        size = float(np.linalg.norm(self.equations.data(self.factor)))
        return float(np.linalg.norm(self.residual)) / size if size > 0 else 0.0

    @property
    def errors(self) -> tuple[Array, Array]:
        """Standard errors of the normal forces, and of each component of the tangential forces:
        (m,) each, N.
        """
        assert self.spread is not None
        shear = np.linalg.norm(self.spread[:, TANGENTIAL], axis=1) / math.sqrt(
            self.spread.shape[1] - 1
        )
        return self.spread[:, NORMAL], np.asarray(shear)

    @cached_property
    def n_free(self) -> float:
        """Mean of chi^2 over noise: the number of equations minus the number of free components of
        forces, with weights that whiten the noise; see `freedom`. A fitted modulus counts as one
        more free component.
        """
        settings = self.settings
        noise = settings.deviations
        if not noise.complete(self.grains):
            noise = relative_noise(self.grains, 1.0)
        spread = eq.covariance(self.grains, noise)
        weights = spread.weighting(self.weights)(self.factor)
        matrix = sparse.csr_array(weights @ self.equations.matrix)
        ridge = eq.ridge_weight(matrix, settings.ridge)
        residual = weights @ self.residual
        gradient = (matrix.T @ residual).reshape(self.force.shape) + ridge**2 * self.force
        free = freedom(self.force, settings.friction_of(self.contacts), gradient)
        root = sparse.csr_array(weights @ root_of(spread, self.factor))
        return expected_misfit(matrix, free, root, ridge) - (self.search is not None)

    def residual_of_grains(self) -> tuple[Array, Array]:
        """Return the norms of the residuals of motion and of stress for each grain; NaN if not
        measured: (n,), N.
        """
        n_motion = len(self.equations.motion_grain)
        motion, stress = np.split(self.residual, [n_motion])
        return (
            self._sizes(self.equations.motion_grain, motion),
            self._sizes(self.equations.stress_grain, stress),
        )

    def _sizes(self, grain: NDArray[np.int64], residual: Array) -> Array:
        """Return the norm of the residuals of each grain, given the grain of each residual."""
        n = len(self.grains)
        squares = np.bincount(grain, residual**2, minlength=n)
        counts = np.bincount(grain, minlength=n)
        return np.where(counts > 0, np.sqrt(squares), np.nan)


def infer(
    grains: MeasuredGrains,
    walls: Mapping[str, StraightWall],
    settings: Infer,
    *,
    progress: bool = False,
) -> Inference:
    """Infer the contact forces of grains at one instant.

    Parameters
    ----------
    progress
        Show a bar of the repetitions on a terminal.

    Raises
    ------
    InputError
        A grain touches nothing, or the equations do not determine the forces or the modulus.
    """
    contacts = find_contacts(grains, walls, settings.contact_tolerance)
    _refuse_misplaced(grains, walls, contacts, settings.contact_tolerance)
    equations = eq.make_equations(grains, contacts)
    if settings.finds_modulus:
        refuse_unknowable(grains, equations)
    friction = settings.friction_of(contacts)
    noise = settings.deviations
    kept = eq.unknown_columns(friction, grains.dimension)
    is_complete = noise.complete(grains)
    condition = eq.refuse_undetermined(equations, friction, settings.ridge)
    kind = _weights(settings, is_complete=is_complete)
    if not is_complete:  # relative to the measured values
        noise = relative_noise(grains, 1.0)
    spread = eq.covariance(grains, noise)
    weighed = spread.weighting(kind)
    exact = spread.weighting("correlated") if settings.finds_modulus else weighed

    def solution(data: Array, rows: sparse.csr_array) -> tuple[Array, float]:
        matrix, right = eq.add_ridge(rows @ equations.matrix, rows @ data, settings.ridge)
        force = solve(matrix, right, friction, grains.dimension)
        return force, float(((matrix @ force.ravel() - right) ** 2).sum())

    def misfit(factor: float, data: Array) -> float:
        rows = exact(factor)
        if condition is None:
            return solution(data, rows)[1]
        return free_misfit((rows @ equations.matrix)[:, kept], rows @ data)

    search = None
    factor = 1.0
    if settings.finds_modulus:
        n_more = None if is_complete else equations.n_equations - len(kept) - 1
        search = find_modulus(equations, lambda trial: misfit(trial, equations.data(trial)), n_more)
        factor = search.factor
    force, _ = solution(equations.data(factor), weighed(factor))
    fitted = equations.matrix @ force.ravel()
    residual = fitted - equations.data(factor)
    chi2 = float(((weighed(factor) @ residual) ** 2).sum())

    def repeated(rng: np.random.Generator) -> Array:
        """Return the forces that follow from the fitted data with new noise."""
        data = fitted + spread.draw(rng, factor)
        n_motion = len(equations.motion_data)
        if search is None or not search.error:
            return solution(data, weighed(factor))[0]
        fixed = np.concatenate([data[:n_motion], equations.spin_data])
        strained = (data - fixed) / factor
        best = search_near(
            lambda trial: misfit(trial, fixed + trial * strained), factor, NEAR * search.error
        )
        return solution(fixed + best * strained, weighed(best))[0]

    errors = None
    if settings.repetitions > 1 and is_complete:
        rng = np.random.default_rng(settings.seed)
        n = settings.repetitions
        bar = progress_bar(progress, iterable=range(n), desc="repetitions with noise", leave=False)
        errors = np.sqrt(
            (np.array([repeated(rng) - force for _ in bar]) ** 2).sum(axis=0) / (n - 1)
        )
    return Inference(
        grains, contacts, equations, settings, force, errors, residual, len(kept), factor, kind,
        chi2, search, condition,
    )  # fmt: skip


def _weights(settings: Infer, *, is_complete: bool) -> Weights:
    """Return the kind of weights, given whether all standard deviations are known."""
    may_whiten = is_complete or settings.finds_modulus
    if settings.weights in ("white", "correlated") and not may_whiten:
        raise InputError(
            f'infer.weights: found "{settings.weights}" without standard deviations; expected '
            "infer.noise for all measured quantities"
        )
    return settings.weights or ("white" if may_whiten else "equal")


def _refuse_misplaced(
    grains: MeasuredGrains,
    walls: Mapping[str, StraightWall],
    contacts: CandidateContacts,
    tolerance: float,
) -> None:
    """Raise InputError for grains on the wrong side of a wall, and for grains
    that touch nothing.
    """
    errors = []
    for name, wall in walls.items():
        distance = (grains.position - np.array(wall.point)) @ np.array(wall.normal)
        behind = (distance <= 0) & grains.at_walls
        if behind.any():
            errors.append(
                f"grain {_first_ids(grains.ids[behind])}: lies behind the wall {name}; check "
                f"infer.walls.{name} and the positions, both in m"
            )
    if errors:
        raise InputError(errors)
    touched = contacts.touched(len(grains))
    if not touched.all():
        raise InputError(
            f"grain {_first_ids(grains.ids[~touched])}: has no contact: no grain or wall lies "
            f"within a relative gap of {tolerance:g}; define the walls in infer.walls, increase "
            "infer.contact_tolerance, or remove the row"
        )


def _first_ids(ids: NDArray[np.int64]) -> str:
    """Return the first ids in words."""
    shown = [*map(str, ids[:_SHOWN].tolist())]
    if len(ids) > _SHOWN:
        shown.append("...")
    return ", ".join(shown)


def relative_noise(grains: MeasuredGrains, share: float) -> Noise:
    """Return noise proportional to the root mean squares of strains (or stresses) and of
    accelerations.
    """

    def size(values: Array) -> float | None:
        finite = values[np.isfinite(values)]
        if not len(finite):
            return None
        return share * float(np.sqrt(np.mean(finite**2))) or None

    turning = size(grains.angular_acceleration)
    motion = size(grains.acceleration)
    if turning and motion and turning * float(grains.radius.mean()) < _ROUNDING * motion:
        turning = None  # grains do not turn, values are rounding
    if grains.compliance is None:
        return Noise(None, size(grains.stress), motion, turning)
    return Noise(size(grains.strain), None, motion, turning)
