"""Material, state of an element and hourglass control, shared by both finite-element programs.

The material is elastic-perfectly-plastic: von Mises yield, associative flow.

    sigma = lambda tr(e_el) 1 + 2 mu e_el        q = sqrt(3/2 s:s) <= sigma_y        de_pl = dgamma s

Backward Euler is then the radial return: the trial deviator s* is scaled by sigma_y/q* if q* >
sigma_y. Its inner loops are in the ``kernels`` of both programs. State of an element, in the last
axis of ``state``: `RR` ... `BULK`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.material import Material

#: stress (Pa), hourglass displacements (elastic part, m), equivalent plastic strain, plastic work (J/m^3) and
#: bulk-viscous stress (Pa)
RR, ZZ, TT, RZ, HOUR_R, HOUR_Z, STRAIN, PLASTIC, BULK = range(9)
N_STATE = 9
LINEAR_VISCOSITY = 0.06
HOURGLASS = 0.1  # fraction of the stiffness in `hourglass_stiffness`


@dataclasses.dataclass(frozen=True)
class Elastoplastic:
    """Constants of the material, SI units; an infinite yield strength makes it elastic."""

    youngs_modulus: float
    poisson_ratio: float
    density: float
    yield_strength: float
    hardening: float = 0.0  # tangent modulus after yield over Young's modulus
    rate_sensitivity: float = 0.0  # C of Johnson and Cook's factor 1 + C ln(rate/reference rate)
    reference_rate: float = 1.0  # 1/s

    @classmethod
    def of(cls, material: Material) -> Elastoplastic:
        """Make it from the material of a case."""
        limit = math.inf if material.yield_strength is None else material.yield_strength
        return cls(
            material.youngs_modulus,
            material.poisson_ratio,
            material.density,
            limit,
            material.hardening or 0.0,
            *material.rate,
        )

    @property
    def hardening_modulus(self) -> float:
        """Derivative of the yield strength with respect to the equivalent plastic strain, Pa."""
        return self.youngs_modulus * self.hardening / (1 - self.hardening)

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
    def longitudinal_speed(self) -> float:
        """Speed of plane longitudinal waves, m/s."""
        return math.sqrt(self.longitudinal_modulus / self.density)

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness matrix, from strain (rr, zz, tt, gamma_rz) to stress (rr, zz, tt, rz): (4, 4),
        Pa.
        """
        lam, mu = self.lame
        matrix = np.zeros((4, 4))
        matrix[:3, :3] = lam
        matrix += np.diag([2 * mu, 2 * mu, 2 * mu, mu])
        return matrix


def compiled(function: Callable) -> Callable:
    """Compile a function at its first call, and cache the code on disk if possible."""
    from numba import njit  # imported on demand: takes a second to load

    options: dict[str, Any] = {
        "fastmath": {"contract", "arcp", "nsz", "reassoc"},
        "error_model": "numpy",
    }
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:  # neither the package's directory nor the user's cache is writable
        return njit(**options)(function)


def hourglass_stiffness(
    volume: NDArray[np.float64], squares: NDArray[np.float64], material: Elastoplastic
) -> NDArray[np.float64]:
    """Return the stiffness (N/m) for the amplitude q of an hourglass mode, u = q xi eta.

    Full integration would give ``(4/3) V [(lambda + 2 mu)/dr^2 + mu/dz^2]`` (r mode); the control
    takes the fraction `HOURGLASS` of ``(16/3) V (lambda + 2 mu) (br^2 + bz^2)`` (Flanagan and
    Belytschko 1981, stiffness form).
    """
    return HOURGLASS * 16 / 3 * volume * material.longitudinal_modulus * squares


def von_mises(state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the von Mises stresses, (...,), Pa, of states of elements, (..., N_STATE)."""
    rr, zz, tt, rz = np.moveaxis(state[..., :4], -1, 0)
    return np.sqrt(0.5 * ((rr - zz) ** 2 + (zz - tt) ** 2 + (tt - rr) ** 2) + 3 * rz**2)
