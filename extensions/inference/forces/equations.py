"""Equations of measured grains: contact forces that give their motion and their average stress.

For each grain, with r from its centre to a contact and f the force there,

    sum f                = m a - known forces
    sum r x f            = I alpha
    sum sym(r f)         = V stress + m R^2/4 (w w - w^2 1)        (spheres: m R^2/5)

The last two are divided by R, and shear components are multiplied by sqrt(2): all rows are in
newtons, and the sum of their squares does not depend on the axes. Their weights follow from the
standard deviations of the measured quantities. Undetermined forces are an error, or are kept small
by a ridge.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.extensions.inference.forces.grains import (
    PAIRS,
    SCALES,
    Array,
    CandidateContacts,
    MeasuredGrains,
)
from granwave.lammps_inputs.errors import InputError

Weights = Literal["equal", "white", "correlated"]
WEIGHTS: tuple[Weights, ...] = ("equal", "white", "correlated")
_DENSE = 4000  # unknowns up to which singular values are computed
_SINGULAR = 1e-10  # ratio of singular values below which forces are undetermined


@dataclasses.dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations for the contact forces.

    Attributes
    ----------
    motion, stress
        Matrices of the equations of motion and of the average stress: rows by grain, columns by
        contact and component (normal first). Sparse.
    motion_data
        Right-hand side of the first, N.
    stress_data
        Right-hand side of the second that is proportional to the moduli, N.
    spin_data
        Right-hand side of the second that is not, N.
    motion_grain, stress_grain
        Rows of the grains that the equations belong to.
    """

    motion: sparse.csr_array
    stress: sparse.csr_array
    motion_data: Array
    stress_data: Array
    spin_data: Array
    motion_grain: NDArray[np.int64]
    stress_grain: NDArray[np.int64]

    @property
    def n_equations(self) -> int:
        """Number of equations."""
        return len(self.motion_grain) + len(self.stress_grain)

    @property
    def matrix(self) -> sparse.csr_array:
        """Both matrices, concatenated by rows."""
        return sparse.csr_array(sparse.vstack([self.motion, self.stress]))

    def data(self, factor: float = 1.0) -> Array:
        """Return both right-hand sides, with all moduli multiplied by a factor, N."""
        return np.concatenate([self.motion_data, factor * self.stress_data + self.spin_data])


def make_equations(grains: MeasuredGrains, contacts: CandidateContacts) -> Equations:
    """Set up the equations of all grains whose motion or stress was measured."""
    d = grains.dimension
    n = len(grains)
    pairs = PAIRS[grains.dimension]
    turns = grains.spin.shape[1]
    between_grains = contacts.second >= 0
    of = np.concatenate([contacts.first, contacts.second[between_grains]])
    which = np.concatenate([np.arange(len(contacts)), np.flatnonzero(between_grains)])
    arm = (
        np.concatenate([contacts.arm, contacts.partner_arm[between_grains]])
        / grains.radius[of, None]
    )
    force = np.concatenate([contacts.basis, -contacts.basis[between_grains]])
    columns = which[:, None] * d + np.arange(d)

    def matrix(values: Array, n_rows: int) -> sparse.csr_array:
        """Sum blocks of (rows of a grain) x (components of a contact)."""
        rows = of[:, None] * n_rows + np.arange(n_rows)
        places = np.broadcast_arrays(rows[:, :, None], columns[:, None, :])
        shape = (n * n_rows, len(contacts) * d)
        return sparse.csr_array(
            (values.ravel(), (places[0].ravel(), places[1].ravel())), shape=shape
        )

    if d == 3:
        moment = np.cross(arm[:, :, None], force, axis=1)
    else:
        in_plane = arm[:, 0, None] * force[:, 1] - arm[:, 1, None] * force[:, 0]
        moment = in_plane[:, None]
    dyads = [
        0.5 * (arm[:, a, None] * force[:, b] + arm[:, b, None] * force[:, a]) for a, b in pairs
    ]
    motion = matrix(np.concatenate([force, moment], axis=1), d + turns)
    stress = matrix(SCALES[d][:, None] * np.stack(dyads, axis=1), len(pairs))
    forces = grains.mass[:, None] * grains.acceleration - grains.known_force
    torques = (grains.inertia / grains.radius)[:, None] * grains.angular_acceleration
    per_length = SCALES[d] / grains.radius[:, None]
    stress_data = per_length * grains.volume[:, None] * grains.stress
    spin_data = per_length * grains.spin_stress
    moving = grains.has_motion
    strained = grains.has_stress
    rows_moving = np.repeat(moving, d + turns)
    rows_strained = np.repeat(strained, len(pairs))
    return Equations(
        motion[np.flatnonzero(rows_moving)],
        stress[np.flatnonzero(rows_strained)],
        np.concatenate([forces, torques], axis=1)[moving].ravel(),
        stress_data[strained].ravel(),
        spin_data[strained].ravel(),
        np.repeat(np.flatnonzero(moving), d + turns),
        np.repeat(np.flatnonzero(strained), len(pairs)),
    )


def unknown_columns(friction: Array, dimension: int) -> NDArray[np.int64]:
    """Return the columns of the unknowns: normal components, and tangential components of contacts
    with friction.
    """
    columns = np.arange(len(friction) * dimension).reshape(len(friction), dimension)
    return np.sort(np.concatenate([columns[:, 0], columns[friction > 0, 1:].ravel()]))


@dataclasses.dataclass(frozen=True)
class Noise:
    """Standard deviations of each component of the measured quantities; None if not known.

    Attributes
    ----------
    strain
        Standard deviation of strains.
    stress
        Standard deviation of stresses, Pa.
    acceleration
        m/s^2.
    angular_acceleration
        rad/s^2; by default twice the standard deviation of the acceleration divided by the radius,
        so that both have equal weight.
    """

    strain: float | None = None
    stress: float | None = None
    acceleration: float | None = None
    angular_acceleration: float | None = None

    def of_tensor(self, grains: MeasuredGrains) -> float | None:
        """Return the standard deviation of strains or of stresses, whichever were measured."""
        return self.stress if grains.compliance is None else self.strain

    def complete(self, grains: MeasuredGrains) -> bool:
        """Return True if the standard deviations of all measured quantities are known."""
        return not self.missing(grains)

    def missing(self, grains: MeasuredGrains) -> tuple[str, ...]:
        """Return the names of measured quantities whose standard deviations are not known."""
        tensor = "stress" if grains.compliance is None else "strain"
        needed = {tensor: self.of_tensor(grains)} if grains.has_stress.any() else {}
        needed |= {"acceleration": self.acceleration} if grains.has_motion.any() else {}
        return tuple(name for name, size in needed.items() if not size)


@dataclasses.dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of the right-hand sides.

    Attributes
    ----------
    motion
        Standard deviations of the equations of motion: (n_rows,), N.
    stress
        Roots L of the covariances L L^T of the equations of stress, by grain, for strains at moduli
        that are multiplied by 1: (n_grains, k, k), N.
    of_strain
        True if strains were measured, so that ``stress`` grows with the moduli.
    """

    motion: Array
    stress: Array
    of_strain: bool

    def draw(self, rng: np.random.Generator, factor: float = 1.0) -> Array:
        """Draw errors of both right-hand sides, N."""
        scale = factor if self.of_strain else 1.0
        errors = np.einsum("gij,gj->gi", self.stress, rng.normal(size=self.stress.shape[:2]))
        return np.concatenate(
            [self.motion * rng.normal(size=len(self.motion)), scale * errors.ravel()]
        )

    def weighting(self, kind: Weights) -> Callable[[float], sparse.csr_array]:
        """Return a function of the factor of the moduli that gives the weights: a matrix to
        multiply all equations by.

        The weights are 1 (equal), divide each row by its standard deviation (white), or whiten the
        rows (correlated).
        """
        n, k = self.stress.shape[:2]
        motion = np.ones(len(self.motion)) if kind == "equal" else 1 / self.motion
        stress: NDArray = np.zeros((n, k, k))
        if kind == "equal":
            stress[:] = np.eye(k)
        elif kind == "white":
            stress[:, range(k), range(k)] = 1 / np.sqrt((self.stress**2).sum(axis=2))
        else:
            stress = np.linalg.inv(self.stress)

        def weights(factor: float) -> sparse.csr_array:
            blocks = stress / (factor if self.of_strain and kind != "equal" else 1.0)
            of_stress = sparse.bsr_array(
                (blocks, np.arange(n), np.arange(n + 1)), shape=(n * k, n * k)
            )
            return sparse.csr_array(sparse.block_diag([sparse.diags_array(motion), of_stress]))

        return weights


def covariance(grains: MeasuredGrains, noise: Noise) -> Covariance:
    """Return the covariance of the right-hand sides that follows from the noise of the measurement."""
    pairs = PAIRS[grains.dimension]
    moving = grains.has_motion
    strained = grains.has_stress
    of_motion = noise.acceleration or 0.0
    turning = noise.angular_acceleration
    of_turning = 2 * of_motion / grains.radius if turning is None else np.full(len(grains), turning)
    parts = [np.repeat((grains.mass * of_motion)[:, None], grains.dimension, axis=1)]
    parts.append(
        np.repeat(
            (grains.inertia / grains.radius * of_turning)[:, None], grains.spin.shape[1], axis=1
        )
    )
    per_length = (
        (grains.volume / grains.radius)[:, None]
        * SCALES[grains.dimension]
        * (noise.of_tensor(grains) or 0.0)
    )
    roots: NDArray = np.broadcast_to(np.eye(len(pairs)), (len(grains), len(pairs), len(pairs)))
    if grains.compliance is not None:
        roots = np.linalg.inv(grains.compliance)
    return Covariance(
        np.concatenate(parts, axis=1)[moving].ravel(),
        (per_length[:, :, None] * roots)[strained],
        grains.compliance is not None,
    )


def refuse_undetermined(equations: Equations, friction: Array, ridge: float) -> float | None:
    """Raise InputError if the equations leave forces undetermined, unless there is a ridge.

    Returns
    -------
    float or None
        Ratio of the extreme singular values; None for problems too large to compute them.
    """
    n_contacts = len(friction)
    keep = unknown_columns(friction, equations.motion.shape[1] // n_contacts)
    unknown = len(keep)
    n_equations = equations.n_equations
    rank = min(unknown, n_equations)
    condition = None
    if unknown <= _DENSE:
        values = np.zeros(1)
        if n_equations:
            values = np.linalg.svd(equations.matrix[:, keep].toarray(), compute_uv=False)
        rank = int(np.count_nonzero(values > _SINGULAR * values[0])) if values[0] > 0 else 0
        condition = float(values[0] / values[-1]) if rank == unknown else None
    if rank < unknown and not ridge:
        fault = "equations that do not determine the forces"
        if n_equations < unknown:
            fault = "fewer equations than unknowns"
        raise InputError(
            f"{fault}: {n_equations} equations of rank {rank} for {unknown} components of the "
            f"forces of {n_contacts} contacts; measure strains and accelerations of more grains, "
            "lower infer.contact_tolerance, set infer.friction = 0 if it is negligible, or set "
            "infer.ridge, which selects the smallest forces that fit"
        )
    return condition


def add_ridge(
    matrix: sparse.csr_array, data: Array, ridge: float
) -> tuple[sparse.csr_array, Array]:
    """Add rows that keep all forces small; their weight is ``ridge`` times the mean weight of the
    other rows.
    """
    if not ridge:
        return sparse.csr_array(matrix), data
    n = matrix.shape[1]
    rows = sparse.diags_array(np.full(n, ridge_weight(matrix, ridge)))
    return sparse.csr_array(sparse.vstack([matrix, rows])), np.concatenate([data, np.zeros(n)])


def ridge_weight(matrix: sparse.csr_array, ridge: float) -> float:
    """Return the weight of the rows of a ridge, ``ridge`` times the mean weight of the others."""
    return ridge * float(np.sqrt((matrix**2).sum() / matrix.shape[1]))
