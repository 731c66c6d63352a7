"""Expected chi^2 of inferred forces under the noise of the measurement.

A sliding contact keeps its direction within its cone of friction, and an unloaded contact stays
unloaded: near the solution the forces f + T c are free, with a column of T for each free component.
A sliding contact has one free component out of two in the plane, and two out of three in space. In
space the component that turns the tangential force about the normal is resisted by the curvature of
the cone. With the weighted equations A f = d, the covariance C of their noise, and the stiffness S
against c (curvature and ridge), the residuals are the noise outside of A T:

    <chi^2> = |(1 - H) C^(1/2)|^2,   H = A T (T^T A^T A T + S)^(-1) T^T A^T

With weights that whiten the noise, it is the number of equations minus the number of columns of T.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import linalg, sparse

from granwave.extensions.inference.forces.equations import Covariance
from granwave.extensions.inference.forces.grains import NORMAL, TANGENTIAL, Array
from granwave.extensions.inference.forces.solve import DENSE_UNKNOWNS

_LOADED = 1e-8  # fraction of the largest force; smaller forces are errors of the solver
_SLIDING = 1e-6  # fraction of the limit of friction
_SMALL = 1e-12  # fraction of the largest force: tangential forces without direction


class Freedom(NamedTuple):
    """Free components of forces.

    Attributes
    ----------
    directions
        Changes of all components of the forces, contact by contact: (n_contacts * d, n_free).
    held
        Stiffness of the cone against each of them, for a weighted sum of squares: (n_free,), 1/N^2.
    """

    directions: sparse.csr_array
    held: Array


def freedom(force: Array, friction: Array, gradient: Array) -> Freedom:
    """Return the free components of forces within or on their cones.

    Parameters
    ----------
    force
        Normal and tangential components: (n_contacts, d), N.
    friction
        Coefficients: (n_contacts,).
    gradient
        Gradient of half the weighted sum of squares: (n_contacts, d), 1/N.
    """
    dimension = force.shape[1]
    largest = float(np.abs(force).max(initial=0.0))
    size = np.linalg.norm(force[:, TANGENTIAL], axis=1)
    loaded = force[:, NORMAL] > _LOADED * largest
    limit = friction * force[:, NORMAL]
    sliding = loaded & (friction > 0) & (size >= (1 - _SLIDING) * limit) & (size > _SMALL * largest)
    rows = list[int]()
    columns = list[int]()
    values = list[float]()
    stiffnesses = list[float]()

    def add(contact: int, direction: Array, stiffness: float = 0.0) -> None:
        rows.extend(range(contact * dimension, (contact + 1) * dimension))
        columns.extend([len(stiffnesses)] * dimension)
        values.extend(direction.tolist())
        stiffnesses.append(stiffness)

    each = np.eye(dimension)
    for contact in np.flatnonzero(loaded).tolist():
        if not sliding[contact]:
            for direction in each if friction[contact] > 0 else each[:1]:
                add(contact, direction)
            continue
        add(contact, force[contact] / np.linalg.norm(force[contact]))
        if dimension == 3:
            along = force[contact, 1:] / size[contact]
            pulled = max(-float(gradient[contact, 1:] @ along), 0.0)
            add(contact, np.array([0.0, -along[1], along[0]]), pulled / size[contact])
    shape = (force.size, len(stiffnesses))
    directions = sparse.coo_array((values, (rows, columns)), shape=shape).tocsr()
    return Freedom(directions, np.array(stiffnesses))


def expected_misfit(
    matrix: sparse.csr_array, free: Freedom, noise: sparse.csr_array, ridge: float
) -> float:
    """Return the mean of chi^2 over noise; if there are very many forces, the mean over white
    noise.

    Parameters
    ----------
    matrix
        Weighted equations: (n_equations, n_contacts * d).
    noise
        Root of the covariance of their right-hand sides: (n_equations, n_equations).
    ridge
        Weight of the rows that keep forces small, 1/N.
    """
    n_equations = matrix.shape[0]
    n_free = len(free.held)
    if n_free > DENSE_UNKNOWNS:
        return float(max(n_equations - n_free, 0))
    if not n_free:
        return float((noise**2).sum())
    columns = (matrix @ free.directions).toarray()
    holding = np.diag(np.sqrt(free.held + ridge**2))
    triangle = np.linalg.qr(np.concatenate([columns, holding]), mode="r")
    basis = linalg.solve_triangular(triangle, columns.T, trans="T").T
    seen = basis.T @ noise
    overlap = basis.T @ basis
    mean = float(
        (noise**2).sum() - 2 * (seen**2).sum() + np.einsum("ij,ik,jk", overlap, seen, seen)
    )
    return mean if mean > math.sqrt(np.finfo(float).eps) * n_equations else 0.0


def root_of(covariance: Covariance, factor: float) -> sparse.csr_array:
    """Return the root of the covariance of all right-hand sides, N.

    Parameters
    ----------
    factor
        Factor of the moduli.
    """
    n, k = covariance.stress.shape[:2]
    scale = factor if covariance.of_strain else 1.0
    blocks = (scale * covariance.stress, np.arange(n), np.arange(n + 1))
    of_stress = sparse.bsr_array(blocks, shape=(n * k, n * k))
    motion = sparse.diags_array(covariance.motion)
    return sparse.csr_array(sparse.block_diag([motion, of_stress]))
