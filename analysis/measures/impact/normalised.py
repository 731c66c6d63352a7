"""Normalised velocity of an impact."""

from __future__ import annotations

import math


def velocity_normalised(velocity: float, modulus: float, density: float, yield_strength: float) -> float:
    """Impact velocity in units that make materials collapse on one curve.

    ``(2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v``; for brass 4 m/s give 37.9.

    Parameters
    ----------
    velocity
        m/s.
    modulus
        E* of two spheres, Pa.
    density
        kg/m^3.
    yield_strength
        Pa.
    """
    scale = 2 / math.sqrt(3) * (2 / (1.6 * math.pi)) ** 2
    return scale * modulus**2 * math.sqrt(density) * yield_strength**-2.5 * velocity
