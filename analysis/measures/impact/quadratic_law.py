"""Quadratic law of dissipation against impact velocity."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
class QuadraticLaw:
    """Dissipation as ``D0 + D1 v + D2 v^2``.

    Attributes
    ----------
    constants, deviations
        D0, D1, D2 and their standard deviations: (3,).
    misfit
        Largest |law / dissipation - 1| of what was fitted.
    lowest
        Smallest velocity that was fitted.
    """

    constants: Array
    deviations: Array
    misfit: float
    lowest: float

    def __call__(self, velocity: Array) -> Array:
        """Dissipation at velocities."""
        return np.asarray(np.polynomial.polynomial.polyval(velocity, self.constants), dtype=np.float64)


def quadratic_law(velocity: Array, dissipation: Array) -> QuadraticLaw:
    """Fit the law, every point with the same relative weight; more than three points: (n,) each."""
    matrix = np.stack([np.ones_like(velocity), velocity, velocity**2], axis=1) / dissipation[:, None]
    constants = np.asarray(np.linalg.lstsq(matrix, np.ones_like(velocity))[0], dtype=np.float64)
    residual = matrix @ constants - 1
    scatter = residual @ residual / (len(velocity) - len(constants))
    deviations = np.sqrt(scatter * np.diag(np.linalg.inv(matrix.T @ matrix)))
    return QuadraticLaw(constants, deviations, float(np.abs(residual).max()), float(velocity.min()))
