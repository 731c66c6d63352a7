"""Constrained least squares: forces that push, within the cone of friction, and fit the equations best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize, sparse

from granwave.analysis.inference.equations import unknown_columns
from granwave.analysis.inference.grains import Array
from granwave.lammps_inputs.errors import RunError

#: Number of unknowns beyond which problems in the plane are solved by the conic solver, which uses sparse matrices.
DENSE_UNKNOWNS = 1500
_ROUNDING = 1e-11  # of the largest force: what lies outside the cone by less is on it
_SINGULAR = 1e-12  # ratio of diagonal elements below which forces are not unique
_ACCURACY = 1e-12  # of the conic solver, relative
_SOLVED = ("Solved", "AlmostSolved", "InsufficientProgress")  # the last: as near as rounding lets it


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
    if matrix.shape[1] <= DENSE_UNKNOWNS and (dimension == 2 or not friction.any()):
        return _by_edges(matrix, data, friction, dimension)
    return solve_conic(matrix, data, friction, dimension)


def _by_edges(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Solve by non-negative least squares: in the plane a force is a sum of the two edges of its cone.

    In space this holds without friction alone, where a force is a push.
    """
    rough = friction > 0
    edges, tangent = matrix[:, ::dimension].toarray(), matrix[:, 1::dimension].toarray()
    if rough.any():
        edges = np.concatenate([edges + friction * tangent, (edges - friction * tangent)[:, rough]], axis=1)
    factors, _ = optimize.nnls(edges, data, maxiter=20 * edges.shape[1])
    upper, lower = factors[: len(friction)], np.zeros(len(friction))
    lower[rough] = factors[len(friction) :]
    force = np.zeros((len(friction), dimension))
    force[:, 0], force[:, 1] = upper + lower, friction * (upper - lower)
    return force


def solve_conic(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Solve by second-order cones (Clarabel); see `solve`."""
    force = _free(matrix, data, friction, dimension)
    if force is not None and _within(force, friction):
        return _onto(force, friction)
    return _by_cones(matrix, data, friction, dimension)


def _free(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array | None:
    """Return the solution without cones, which is that with them if it lies within; None if it is not unique."""
    kept = unknown_columns(friction, dimension)
    columns = sparse.csr_array(matrix[:, kept])
    if columns.shape[0] < columns.shape[1]:
        return None
    found = _dense(columns, data) if len(kept) <= DENSE_UNKNOWNS else _sparse(columns, data)
    if found is None or not np.isfinite(found).all():
        return None
    force = np.zeros(len(friction) * dimension)
    force[kept] = found
    return force.reshape(-1, dimension)


def _dense(matrix: sparse.csr_array, data: Array) -> Array | None:
    """Solve by orthogonal columns, whose error grows with the condition and not with its square."""
    columns, triangle = np.linalg.qr(matrix.toarray())
    diagonal = np.abs(triangle.diagonal())
    if diagonal.min(initial=1.0) <= _SINGULAR * diagonal.max(initial=0.0):
        return None
    found = linalg.solve_triangular(triangle, columns.T @ data)
    return np.asarray(found + linalg.solve_triangular(triangle, columns.T @ (data - matrix @ found)))


def _sparse(matrix: sparse.csr_array, data: Array) -> Array | None:
    """Solve the normal equations of a large problem, and correct the solution twice."""
    try:
        factors = sparse.linalg.splu(sparse.csc_array(matrix.T @ matrix))
    except RuntimeError:  # singular
        return None
    found = factors.solve(matrix.T @ data)
    for _ in range(2):
        found += factors.solve(matrix.T @ (data - matrix @ found))
    return np.asarray(found)


def _within(force: Array, friction: Array) -> bool:
    slack = _ROUNDING * float(np.abs(force).max(initial=0.0))
    return bool(
        (force[:, 0] >= -slack).all()
        and (np.linalg.norm(force[:, 1:], axis=1) <= friction * force[:, 0] + 4 * slack).all()
    )


def _onto(force: Array, friction: Array) -> Array:
    """Move forces that rounding put outside their cones onto them."""
    normal = np.maximum(force[:, 0], 0.0)
    size = np.linalg.norm(force[:, 1:], axis=1)
    shrink = np.minimum(1.0, np.divide(friction * normal, size, out=np.ones_like(size), where=size > 0))
    return np.concatenate([normal[:, None], shrink[:, None] * force[:, 1:]], axis=1)


def _by_cones(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Minimise 1/2 |r|^2 with r = matrix f - data, in units in which forces and equations are near one.

    Raises
    ------
    RunError
        The solver did not converge.
    """
    import clarabel

    kept = unknown_columns(friction, dimension)
    n_rows, n_columns = matrix.shape[0], len(kept)
    matrix = sparse.csr_array(matrix[:, kept])
    weight = float(np.sqrt((matrix**2).sum() / n_columns)) or 1.0
    matrix, data = matrix / weight, data / weight
    size = float(np.sqrt(np.sum(data**2) / n_columns)) or 1.0
    place = np.full(len(friction) * dimension, -1)
    place[kept] = np.arange(n_columns)
    columns = place.reshape(len(friction), dimension)
    rough, smooth = np.flatnonzero(friction > 0), np.flatnonzero(friction == 0)
    # s = b - A x: zero for the equations, and in the cones (friction f_n, f_t)
    scale = np.ones((len(friction), dimension))
    scale[:, 0] = friction
    push = _selection(columns[smooth, 0], -np.ones(len(smooth)), n_columns + n_rows)
    cone = _selection(columns[rough].ravel(), -scale[rough].ravel(), n_columns + n_rows)
    equations = sparse.hstack([matrix, -sparse.eye_array(n_rows)])
    constraints = sparse.csc_array(sparse.vstack([equations, push, cone]))
    right = np.concatenate([data / size, np.zeros(constraints.shape[0] - n_rows)])
    cones = [clarabel.ZeroConeT(n_rows), clarabel.NonnegativeConeT(len(smooth))]
    cones += [clarabel.SecondOrderConeT(dimension)] * len(rough)
    squares = sparse.csc_array(sparse.diags_array(np.concatenate([np.zeros(n_columns), np.ones(n_rows)])))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _ACCURACY
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(squares), np.zeros(n_columns + n_rows), sparse.csc_matrix(constraints), right, cones, settings
    )
    found = solver.solve()
    if str(found.status) not in _SOLVED:
        raise RunError(f"the conic solver did not find the forces: it ended as {found.status}")
    force = np.zeros(len(friction) * dimension)
    force[kept] = size * np.array(found.x[:n_columns])
    return _onto(force.reshape(-1, dimension), friction)


def _selection(columns: NDArray[np.int64], values: Array, n_columns: int) -> sparse.csr_array:
    """Return a matrix with one value in each row."""
    return sparse.csr_array((values, (np.arange(len(columns)), columns)), shape=(len(columns), n_columns))
