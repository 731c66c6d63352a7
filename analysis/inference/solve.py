"""Constrained least squares: forces that push, within the cone of friction, and fit the equations best."""

from __future__ import annotations

import numpy as np
from scipy import optimize, sparse

from granwave.analysis.inference.grains import Array

#: Number of unknowns beyond which problems in the plane are solved by the conic solver, which uses sparse matrices.
DENSE_UNKNOWNS = 1500
_ROUNDING = 1e-12  # of the largest force: what lies outside the cone by less is on it
_ACCURACY = 1e-12  # of the conic solver, relative


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
    if dimension == 2 and matrix.shape[1] <= DENSE_UNKNOWNS:
        return _by_edges(matrix, data, friction)
    return solve_conic(matrix, data, friction, dimension)


def _by_edges(matrix: sparse.csr_array, data: Array, friction: Array) -> Array:
    """Solve in the plane, where a force is a sum of the two edges of its cone with non-negative factors."""
    normal, tangent = (matrix[:, part::2].toarray() for part in (0, 1))
    rough = friction > 0
    edges = np.concatenate([normal + friction * tangent, (normal - friction * tangent)[:, rough]], axis=1)
    factors, _ = optimize.nnls(edges, data, maxiter=20 * edges.shape[1])
    upper, lower = factors[: len(friction)], np.zeros(len(friction))
    lower[rough] = factors[len(friction) :]
    return np.stack([upper + lower, friction * (upper - lower)], axis=1)


def solve_conic(matrix: sparse.csr_array, data: Array, friction: Array, dimension: int) -> Array:
    """Solve by second-order cones (Clarabel); see `solve`."""
    force = _free(matrix, data, dimension)
    if force is not None and _within(force, friction):
        return _onto(force, friction)
    return _by_cones(matrix, data, friction, dimension)


def _free(matrix: sparse.csr_array, data: Array, dimension: int) -> Array | None:
    """Return the solution without constraints, which is that with them if it lies within the cones."""
    normal_equations = sparse.csc_array(matrix.T @ matrix)
    try:
        factors = sparse.linalg.splu(normal_equations)
    except RuntimeError:  # singular
        return None
    found = factors.solve(matrix.T @ data)
    for _ in range(2):
        found += factors.solve(matrix.T @ (data - matrix @ found))
    return found.reshape(-1, dimension) if np.isfinite(found).all() else None


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
    """Minimise 1/2 |r|^2 with r = matrix f - data, in units in which forces are near one."""
    import clarabel

    n_rows, n_columns = matrix.shape
    size = float(np.sqrt(np.mean(data**2))) or 1.0
    n_contacts = len(friction)
    rough = np.flatnonzero(friction > 0)
    smooth = np.flatnonzero(friction == 0)
    # s = b - A x: zero for the equations, and in the cones (friction f_n, f_t)
    equations = sparse.hstack([matrix, -sparse.eye_array(n_rows)])
    scale = np.ones((n_contacts, dimension))
    scale[:, 0] = friction
    columns = np.arange(n_columns).reshape(n_contacts, dimension)
    cone = _selection(columns[rough].ravel(), -scale[rough].ravel(), n_columns + n_rows)
    push = _selection(columns[smooth, 0], -np.ones(len(smooth)), n_columns + n_rows)
    none = _selection(columns[smooth, 1:].ravel(), np.ones(len(smooth) * (dimension - 1)), n_columns + n_rows)
    constraints = sparse.csc_array(sparse.vstack([equations, none, push, cone]))
    right = np.concatenate([data / size, np.zeros(constraints.shape[0] - n_rows)])
    cones = [clarabel.ZeroConeT(n_rows + none.shape[0]), clarabel.NonnegativeConeT(len(smooth))]
    cones += [clarabel.SecondOrderConeT(dimension)] * len(rough)
    squares = sparse.csc_array(sparse.diags_array(np.concatenate([np.zeros(n_columns), np.ones(n_rows)])))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _ACCURACY
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(squares), np.zeros(n_columns + n_rows), sparse.csc_matrix(constraints), right, cones, settings
    )
    found = solver.solve()
    return _onto(size * np.array(found.x[:n_columns]).reshape(n_contacts, dimension), friction)


def _selection(columns: Array, values: Array, n_columns: int) -> sparse.csr_array:
    """Return a matrix with one value in each row."""
    return sparse.csr_array((values, (np.arange(len(columns)), columns)), shape=(len(columns), n_columns))
