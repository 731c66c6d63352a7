"""Forces that push, within the cone of friction, and fit the equations best; Young's modulus from
the motion.

Strains tell forces up to a factor, accelerations tell them without.

The right-hand side of the stress is proportional to the moduli, that of the motion is not. The
factor of the moduli is the minimum of chi^2, the sum of squares of the errors of strains and
accelerations over their standard deviations, with the forces that are best for each factor. These
forces are not held within the cone of friction here: noise could push those on its border inwards
only, which biases the modulus upwards by as much as its standard error. An additional column of the
least squares, in place of the search, would be biased low: it takes the strains as free of errors.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from scipy import linalg, optimize, sparse

from granwave.extensions.inference.forces.equations import Equations, unknown_columns
from granwave.extensions.inference.forces.grains import NORMAL, Array, MeasuredGrains
from granwave.lammps_inputs.errors import InputError, RunError

#: Number of unknowns beyond which problems in the plane are solved by the conic solver, which uses sparse matrices.
DENSE_UNKNOWNS = 1500
_ROUNDING = 1e-11  # of the largest force: what lies outside the cone by less is on it
_SINGULAR = 1e-12  # ratio of diagonal elements below which forces are not unique
_ACCURACY = 1e-12  # of the conic solver, relative
_SOLVED = (
    "Solved",
    "AlmostSolved",
    "InsufficientProgress",
)  # the last: as near as rounding lets it
_WIDTH = math.log(30.0)  # of the first scan about the first guess, each way
_SCANNED = 9
_WIDENED = 4  # times that a scan is moved if the minimum lies at its end
_OF_FACTOR = 1e-5  # accuracy of the logarithm of the factor
_STEP = 0.02  # of the logarithm, for the curvature


def solve(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Return the forces that minimise |matrix f - data|, with f_n >= 0 and |f_t| <= friction f_n.

    Parameters
    ----------
    matrix
        Weighted equations; columns by contact, in each the normal component first.
    friction
        Coefficients of friction: (n_contacts,).
    dimension
        2 in the plane, 3 in space.

    Returns
    -------
    ndarray
        Normal and tangential components: (n_contacts, dimension), N.
    """
    if matrix.shape[1] > DENSE_UNKNOWNS or (dimension == 3 and friction.any()):
        return solve_conic(matrix, data, friction, dimension)
    # in the plane a force is a sum of two forces along the edges of its cone, both compressive
    rough = friction > 0
    normal = matrix[:, ::dimension].toarray()
    sheared = friction * matrix[:, 1::dimension].toarray()
    edges = np.concatenate([normal + sheared, (normal - sheared)[:, rough]], axis=1)
    factors, _ = optimize.nnls(edges, data, maxiter=20 * edges.shape[1])
    upper = factors[: len(friction)]
    lower = np.zeros(len(friction))
    lower[rough] = factors[len(friction) :]
    force = np.zeros((len(friction), dimension))
    force[:, NORMAL] = upper + lower
    force[:, 1] = friction * (upper - lower)
    return force


def solve_conic(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Solve by second-order cones (Clarabel), unless the solution without cones lies within; see
    `solve`.
    """
    force = _free(matrix, data, friction, dimension)
    if force is not None:
        slack = _ROUNDING * float(np.abs(force).max(initial=0.0))
        size = np.linalg.norm(force[:, 1:], axis=1)
        if (force[:, 0] >= -slack).all() and (size <= friction * force[:, 0] + 4 * slack).all():
            return _onto(force, friction)
    return _by_cones(matrix, data, friction, dimension)


def _free(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array | None:
    """Return the solution without cones; None if it is not unique.

    By orthogonal columns, whose error grows with the condition and not with its square; of a large
    problem by the normal equations. It is corrected once, or twice.
    """
    kept = unknown_columns(friction, dimension)
    matrix = sparse.csr_array(matrix[:, kept])
    if matrix.shape[0] < matrix.shape[1]:
        return None
    if len(kept) <= DENSE_UNKNOWNS:
        columns, triangle = np.linalg.qr(matrix.toarray())
        diagonal = np.abs(triangle.diagonal())
        if diagonal.min(initial=1.0) <= _SINGULAR * diagonal.max(initial=0.0):
            return None
        solution = linalg.solve_triangular(triangle, columns.T @ data)
        solution += linalg.solve_triangular(triangle, columns.T @ (data - matrix @ solution))
    else:
        try:
            factors = sparse.linalg.splu(sparse.csc_array(matrix.T @ matrix))
        except RuntimeError:  # singular
            return None
        solution = factors.solve(matrix.T @ data)
        for _ in range(2):
            solution += factors.solve(matrix.T @ (data - matrix @ solution))
    if not np.isfinite(solution).all():
        return None
    force = np.zeros(len(friction) * dimension)
    force[kept] = solution
    return force.reshape(-1, dimension)


def _onto(force: Array, friction: Array) -> Array:
    """Move forces that rounding put outside their cones onto them."""
    normal = np.maximum(force[:, 0], 0.0)
    size = np.linalg.norm(force[:, 1:], axis=1)
    shrink = np.minimum(
        1.0, np.divide(friction * normal, size, out=np.ones_like(size), where=size > 0)
    )
    return np.concatenate([normal[:, None], shrink[:, None] * force[:, 1:]], axis=1)


def _by_cones(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Minimise 1/2 |r|^2 with r = matrix f - data, in units in which forces and equations are near
    one.

    Raises
    ------
    RunError
        The solver did not converge.
    """
    import clarabel

    kept = unknown_columns(friction, dimension)
    n_rows = matrix.shape[0]
    n_columns = len(kept)
    matrix = sparse.csr_array(matrix[:, kept])
    weight = float(np.sqrt((matrix**2).sum() / n_columns)) or 1.0
    matrix = matrix / weight
    data = data / weight
    size = float(np.sqrt(np.sum(data**2) / n_columns)) or 1.0
    place = np.full(len(friction) * dimension, -1)
    place[kept] = np.arange(n_columns)
    columns = place.reshape(len(friction), dimension)
    rough = np.flatnonzero(friction > 0)
    smooth = np.flatnonzero(friction == 0)
    # s = b - A x: zero for the equations, and in the cones (friction f_n, f_t)
    scale = np.ones((len(rough), dimension))
    scale[:, 0] = friction[rough]
    each = sparse.csr_array(sparse.eye_array(n_columns + n_rows))
    push = -each[columns[smooth, 0]]
    cone = sparse.diags_array(-scale.ravel()) @ each[columns[rough].ravel()]
    equations = sparse.hstack([matrix, -sparse.eye_array(n_rows)])
    constraints = sparse.csc_array(sparse.vstack([equations, push, cone]))
    right = np.concatenate([data / size, np.zeros(constraints.shape[0] - n_rows)])
    cones = [clarabel.ZeroConeT(n_rows), clarabel.NonnegativeConeT(len(smooth))]
    cones += [clarabel.SecondOrderConeT(dimension)] * len(rough)
    squares = sparse.csc_array(
        sparse.diags_array(np.concatenate([np.zeros(n_columns), np.ones(n_rows)]))
    )
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _ACCURACY
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(squares),
        np.zeros(n_columns + n_rows),
        sparse.csc_matrix(constraints),
        right,
        cones,
        settings,
    )
    solution = solver.solve()
    if str(solution.status) not in _SOLVED:
        raise RunError(f"the conic solver did not find the forces: it ended as {solution.status}")
    force = np.zeros(len(friction) * dimension)
    force[kept] = size * np.array(solution.x[:n_columns])
    return _onto(force.reshape(-1, dimension), friction)


@dataclasses.dataclass(frozen=True, eq=False)
class ModulusSearch:
    """Search for the factor of the moduli.

    Attributes
    ----------
    factors, chi2
        All trials, rising factors: (n,).
    factor
        The best.
    error
        Standard error of the logarithm of the factor: chi^2 grows by ``scale`` there (1 for known
        noise).
    """

    factors: Array
    chi2: Array
    factor: float
    error: float


def free_misfit(matrix: sparse.csr_array, data: Array) -> float:
    """Return the least |matrix f - data|^2 of any forces f, within the cone or not."""
    augmented = np.concatenate([matrix.toarray(), data[:, None]], axis=1)
    triangle = np.asarray(np.linalg.qr(augmented, mode="r"))
    return float(triangle[-1, -1] ** 2) if augmented.shape[0] >= augmented.shape[1] else 0.0


def refuse_unknowable(grains: MeasuredGrains, equations: Equations) -> None:
    """Raise InputError if stresses were measured, or no acceleration or weight tells the modulus."""
    if grains.compliance is None:
        raise InputError(
            'infer.modulus: found "find" with measured stresses, which need no modulus; expected strains'
        )
    if not np.any(equations.motion_data):
        raise InputError(
            'infer.modulus: found "find", but nothing to find it from: strains tell forces up to a factor; expected '
            "accelerations other than zero (or a weight, infer.gravity), or material.youngs_modulus"
        )


def find_modulus(
    equations: Equations, chi2: Callable[[float], float], n_more: int | None
) -> ModulusSearch:
    """Find the factor of the moduli with the least chi^2.

    Parameters
    ----------
    n_more
        Number of equations minus that of unknowns, the factor among them, by which the least chi^2 tells a noise that is
        not known; None if it is.

    Raises
    ------
    InputError
        No minimum was found.
    """
    tried: dict[float, float] = {}

    def at(logarithm: float) -> float:
        if logarithm not in tried:
            tried[logarithm] = chi2(math.exp(logarithm))
        return tried[logarithm]

    size = float(np.linalg.norm(equations.stress_data))
    centre = math.log(float(np.linalg.norm(equations.motion_data)) / size) if size > 0 else 0.0
    grid = np.linspace(-_WIDTH, _WIDTH, _SCANNED)
    for _ in range(_WIDENED):
        values = [at(centre + float(shift)) for shift in grid]
        best = int(np.argmin(values))
        if 0 < best < len(grid) - 1:
            break
        centre += float(grid[best])
    else:
        raise InputError(
            'infer.modulus: found "find", but chi^2 falls to the end of the search: motion and strains do not belong '
            "together; check the units of strains, accelerations and density, or give material.youngs_modulus"
        )
    low = centre + float(grid[best - 1])
    high = centre + float(grid[best + 1])
    minimum = optimize.minimize_scalar(
        at, bounds=(low, high), method="bounded", options={"xatol": _OF_FACTOR}
    )
    logarithm = float(minimum.x)
    curvature = (at(logarithm + _STEP) - 2 * at(logarithm) + at(logarithm - _STEP)) / _STEP**2
    factors, least = np.array(sorted(tried.items())).T
    scale = 1.0 if n_more is None else float(least.min()) / max(n_more, 1)
    error = math.sqrt(2 * scale / curvature) if curvature > 0 else math.inf
    return ModulusSearch(np.exp(factors), least, math.exp(logarithm), error)


def search_near(chi2: Callable[[float], float], factor: float, width: float) -> float:
    """Return the best factor near another, within ``width`` of its logarithm each way."""
    centre = math.log(factor)
    width = min(width, _WIDTH)
    bounds = (centre - width, centre + width)
    minimum = optimize.minimize_scalar(
        lambda logarithm: chi2(math.exp(logarithm)),
        bounds=bounds,
        method="bounded",
        options={"xatol": 0.01 * width},
    )
    return math.exp(float(minimum.x))
