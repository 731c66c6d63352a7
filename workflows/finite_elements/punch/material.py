"""Elastic-perfectly-plastic material: von Mises yield, associative flow.

    sigma = lambda tr(e_el) 1 + 2 mu e_el        q = sqrt(3/2 s:s) <= sigma_y        de_pl = dgamma s

Backward Euler is then the radial return: the trial deviator s* is scaled by sigma_y/q* if q* > sigma_y. Its inner
loop is in `granwave.workflows.finite_elements.punch.kernels`.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.material import Material


@dataclasses.dataclass(frozen=True)
class Elastoplastic:
    """Constants of the material, SI units; an infinite yield strength makes it elastic."""

    youngs_modulus: float
    poisson_ratio: float
    density: float
    yield_strength: float

    @classmethod
    def of(cls, material: Material) -> Elastoplastic:
        """Make it from the material of a case."""
        limit = math.inf if material.yield_strength is None else material.yield_strength
        return cls(material.youngs_modulus, material.poisson_ratio, material.density, limit)

    @property
    def lame(self) -> tuple[float, float]:
        """Lame constants lambda and mu, Pa."""
        nu = self.poisson_ratio
        mu = self.youngs_modulus / (2 * (1 + nu))
        return 2 * mu * nu / (1 - 2 * nu), mu

    @property
    def longitudinal_modulus(self) -> float:
        """Longitudinal modulus lambda + 2 mu, Pa."""
        lam, mu = self.lame
        return lam + 2 * mu

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus, Pa."""
        lam, mu = self.lame
        return lam + 2 * mu / 3

    @property
    def longitudinal_speed(self) -> float:
        """Speed of plane longitudinal waves, m/s."""
        return math.sqrt(self.longitudinal_modulus / self.density)

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness matrix of stress (rr, zz, tt, rz) over strain (rr, zz, tt, gamma_rz), (4, 4), Pa."""
        lam, mu = self.lame
        matrix = np.zeros((4, 4))
        matrix[:3, :3] = lam
        matrix += np.diag([2 * mu, 2 * mu, 2 * mu, mu])
        return matrix
