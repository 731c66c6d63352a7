"""Compressive forces within the friction cone that fit the equations best; Young's modulus from the
motion.

Strains determine the forces up to a factor; accelerations determine the factor.

The right-hand side of the stress is proportional to the moduli, the right-hand side of the motion
does not depend on them. The factor of the moduli is at the minimum of chi^2, the sum of squares of
the errors of strains and accelerations divided by their standard deviations, with the best forces
for each factor. These forces are not confined to the cone of friction: noise could push forces on
the cone inwards only, and bias the modulus upwards by as much as its standard error. An additional
column of the least squares instead of the search would bias the modulus downwards, because it
assumes that the strains have no errors.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from scipy import linalg, optimize, sparse

from granwave.extensions.inference.forces.equations import Equations, unknown_columns
from granwave.extensions.inference.forces.grains import NORMAL, TANGENTIAL, Array, MeasuredGrains
from granwave.lammps_inputs.errors import InputError, RunError

#: Number of unknowns above which problems in the plane use the conic solver with sparse matrices.
DENSE_UNKNOWNS = 1500
_ROUNDING = 1e-11  # distance outside the cone / largest force that is rounding
_SINGULAR = 1e-12  # ratio of diagonal elements below which forces are not unique
_ACCURACY = 1e-12  # relative accuracy of the conic solver
_SOLVED = (
    "Solved",
    "AlmostSolved",
    "InsufficientProgress",
)  # the last: as accurate as rounding allows
_WIDTH = math.log(30.0)  # half-width of the first scan, logarithm of the factor
_SCANNED = 9  # factors in a scan
_WIDENED = 4  # largest number of scans, each around the end of the last
_OF_FACTOR = 1e-5  # accuracy of the logarithm of the factor
_STEP = 0.02  # step of the logarithm for the curvature


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
        size = np.linalg.norm(force[:, TANGENTIAL], axis=1)
        if (force[:, NORMAL] >= -slack).all() and (
            size <= friction * force[:, NORMAL] + 4 * slack
        ).all():
            return _onto(force, friction)
    return _by_cones(matrix, data, friction, dimension)


def _free(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array | None:
    """Return the solution without cones; None if it is not unique.

    The solution is found by orthogonal columns, whose error grows with the condition and not with
    its square, or for a large problem by the normal equations. It is then corrected once or twice.
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
    """Move forces that lie outside their cones by rounding onto the cones."""
    normal = np.maximum(force[:, NORMAL], 0.0)
    size = np.linalg.norm(force[:, TANGENTIAL], axis=1)
    shrink = np.minimum(
        1.0, np.divide(friction * normal, size, out=np.ones_like(size), where=size > 0)
    )
    return np.concatenate([normal[:, None], shrink[:, None] * force[:, TANGENTIAL]], axis=1)


def _by_cones(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Minimise 1/2 |r|^2 with r = matrix f - data, in units in which forces and equations are of
    order one.

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
        raise RunError(f"the conic solver did not converge (status {solution.status})")
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
    """Return the least |matrix f - data|^2 of all forces f, also outside the cone."""
    augmented = np.concatenate([matrix.toarray(), data[:, None]], axis=1)
    triangle = np.asarray(np.linalg.qr(augmented, mode="r"))
    return float(triangle[-1, -1] ** 2) if augmented.shape[0] >= augmented.shape[1] else 0.0


def refuse_unknowable(grains: MeasuredGrains, equations: Equations) -> None:
    """Raise InputError if the modulus cannot be found: with measured stresses,
    or without motion.
    """
    if grains.compliance is None:
        raise InputError(
            'infer.modulus: found "find" with measured stresses, which require no modulus; '
            "expected strains"
        )
    if not np.any(equations.motion_data):
        raise InputError(
            'infer.modulus: found "find", but the data do not determine it: strains give forces '
            "only up to a factor; expected nonzero accelerations (or gravity, infer.gravity), or "
            "material.youngs_modulus"
        )


def find_modulus(
    equations: Equations, chi2: Callable[[float], float], n_more: int | None
) -> ModulusSearch:
    """Find the factor of the moduli with the least chi^2.

    Parameters
    ----------
    n_more
        Number of equations minus number of unknowns, including the factor, which gives an unknown
        noise from the least chi^2; None for a known noise.

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
            'infer.modulus: found "find", but chi^2 decreases to the end of the search: motion '
            "and strains are inconsistent; check the units of strains, accelerations and density, "
            "or set material.youngs_modulus"
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
    """Return the best factor near another one; their logarithms differ by at most ``width``."""
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
