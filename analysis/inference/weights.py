"""Weights of the equations, from the standard deviations of what was measured."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.analysis.inference.equations import Equations
from granwave.analysis.inference.grains import PAIRS, Array, Grains

Weights = Literal["equal", "white", "correlated"]
WEIGHTS: tuple[Weights, ...] = ("equal", "white", "correlated")


@dataclasses.dataclass(frozen=True)
class Noise:
    """Standard deviations of each component of what was measured; None where they are not known.

    Attributes
    ----------
    strain
        Of strains.
    stress
        Of stresses, Pa.
    acceleration
        m/s^2.
    angular_acceleration
        rad/s^2; by default twice that of the acceleration over the radius, so that both count alike.
    """

    strain: float | None = None
    stress: float | None = None
    acceleration: float | None = None
    angular_acceleration: float | None = None

    def of_tensor(self, grains: Grains) -> float | None:
        """Return the standard deviation of strains or stresses, whichever was measured."""
        return self.stress if grains.compliance is None else self.strain

    def complete(self, grains: Grains) -> bool:
        """Return True if the standard deviations of all that was measured are known."""
        return not self.missing(grains)

    def missing(self, grains: Grains) -> tuple[str, ...]:
        """Return the names of the standard deviations that are not known of what was measured."""
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
        Roots L of the covariances L L^T of the equations of stress, by grain, for strains at moduli that are multiplied
        by 1: (n_grains, k, k), N.
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
        return np.concatenate([self.motion * rng.normal(size=len(self.motion)), scale * errors.ravel()])


def covariance(grains: Grains, noise: Noise) -> Covariance:
    """Return the covariance of the right-hand sides that follows from the noise of the measurement."""
    pairs, moving, strained = PAIRS[grains.dimension], grains.has_motion, grains.has_stress
    of_motion = noise.acceleration or 0.0
    turning = noise.angular_acceleration
    of_turning = 2 * of_motion / grains.radius if turning is None else np.full(len(grains), turning)
    parts = [np.repeat((grains.mass * of_motion)[:, None], grains.dimension, axis=1)]
    parts.append(np.repeat((grains.inertia / grains.radius * of_turning)[:, None], grains.spin.shape[1], axis=1))
    scale = np.array([1.0 if a == b else np.sqrt(2) for a, b in pairs])
    per_length = (grains.volume / grains.radius)[:, None] * scale * (noise.of_tensor(grains) or 0.0)
    roots: NDArray = np.broadcast_to(np.eye(len(pairs)), (len(grains), len(pairs), len(pairs)))
    if grains.compliance is not None:
        roots = np.linalg.inv(grains.compliance)
    return Covariance(
        np.concatenate(parts, axis=1)[moving].ravel(),
        (per_length[:, :, None] * roots)[strained],
        grains.compliance is not None,
    )


@dataclasses.dataclass(frozen=True, eq=False)
class Weighting:
    """Factors of the equations.

    Attributes
    ----------
    motion
        (n_rows,).
    stress
        Matrices by grain: (n_grains, k, k).
    with_modulus
        True if ``stress`` is to be divided by the factor of the moduli.
    """

    motion: Array
    stress: Array
    with_modulus: bool

    def rows(self, factor: float = 1.0) -> sparse.csr_array:
        """Return the factors as a matrix that both equations are multiplied by."""
        blocks = self.stress / (factor if self.with_modulus else 1.0)
        n, k = blocks.shape[:2]
        places = np.arange(n * k).reshape(n, k, 1)
        rows, columns = np.broadcast_arrays(places, places.transpose(0, 2, 1))
        stress = sparse.csr_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n * k, n * k))
        return sparse.csr_array(sparse.block_diag([sparse.diags_array(self.motion), stress]))


def weighting(equations: Equations, spread: Covariance, kind: Weights) -> Weighting:
    """Return the factors: 1 (equal), each row over its standard deviation (white), or full whitening (correlated)."""
    n, k = spread.stress.shape[:2]
    if kind == "equal":
        return Weighting(np.ones(len(equations.motion_data)), np.broadcast_to(np.eye(k), (n, k, k)), False)
    if kind == "white":
        stress: NDArray = np.zeros((n, k, k))
        stress[:, range(k), range(k)] = 1 / np.sqrt((spread.stress**2).sum(axis=2))
    else:
        stress = np.linalg.inv(spread.stress)
    return Weighting(1 / spread.motion, stress, spread.of_strain)
