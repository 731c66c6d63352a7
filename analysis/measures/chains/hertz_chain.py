"""Scales and waves of Hertz's chain of like beads.

Hertz's chain has no length or force of its own, so every result is a curve in the units E* R*^2 (force),
tau = sqrt(pi rho R*^2/(4 E*)) (time; thesis 2.24) and R* (length).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from granwave.analysis.measures.signals import Array, width
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact

IMPULSE_COEFFICIENT = 0.719  # (4.5)
DISCRETE_COEFFICIENT = 0.7176  # of the same, of the discrete chain, by our second solver (tests/chain_twin.py)
IMPULSE_LIMIT = IMPULSE_COEFFICIENT * (3 / 128) ** 0.6  # F_peak/I^(6/5), in the units of the chain
_REACH = 5  # diameters ahead and behind of the travelling wave
_NESTERENKO = 0.6802  # V = 0.6802 (2 E/(D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6); composite source 4, D the diameter


class ChainScales:
    """Units and closed forms of a chain of like beads.

    Parameters
    ----------
    case
        Case of the chain.

    Attributes
    ----------
    diameter
        Of a bead, m.
    force, time, velocity, impulse
        E* R*^2, N; tau (thesis 2.24), s; R*/tau, m/s; E* R*^2 tau, N s.
    """

    def __init__(self, case: Case) -> None:
        law = sphere_contact(case)
        self.diameter, self._mass, self._density = case.packing.diameter, case.sphere_mass, case.material.density
        self._modulus, self._radius = law.effective_modulus, law.effective_radius
        self.force = self._modulus * self._radius**2
        self.time = math.sqrt(math.pi * self._density * self._radius**2 / (4 * self._modulus))
        self.velocity, self.impulse = self._radius / self.time, self.force * self.time

    def overlap(self, force: Array) -> Array:
        """Hertz's, m, at forces in N."""
        return (force / (4 / 3 * self._modulus * math.sqrt(self._radius))) ** (2 / 3)

    def impulse_force(self, impulse: float) -> float:
        """(E*^2 R* I^6/m^3)^(1/5), to which the peak force of an impulse I is proportional (thesis 4.5), N."""
        return (self._modulus**2 * self._radius * impulse**6 / self._mass**3) ** 0.2

    def nesterenko(self, force: float) -> float:
        """Speed of Nesterenko's wave of that peak force, m/s."""
        return self._speed_at_one_newton * force ** (1 / 6)

    def force_at_speed(self, speed: float) -> float:
        """Peak force of Nesterenko's wave of that speed, N."""
        return (speed / self._speed_at_one_newton) ** 6

    @property
    def _speed_at_one_newton(self) -> float:
        return _NESTERENKO * (4 * self._modulus / (self.diameter * self._density**1.5)) ** (1 / 3)


@cache
def discrete_speed() -> float:
    """Speed of the travelling wave of the discrete Hertz chain over Nesterenko's at the same force: 1.01246."""
    # V = D sqrt(factor/m) k^(1/3) F^(1/6), with k = E sqrt(D)/(3 (1 - nu^2)) and m = pi rho D^3/6
    return math.sqrt(6 * _discrete_wave()[2] / math.pi) / 6 ** (1 / 3) / _NESTERENKO


@cache
def discrete_width() -> float:
    """Full width at half maximum of the bead velocity in the travelling wave of the discrete chain: 1.579 diameters."""
    x, wave, _ = _discrete_wave()
    per_diameter = round(1 / (x[1] - x[0]))
    rate = np.gradient(wave, x)  # of the overlap ahead of a bead: the difference of two velocities
    velocity = np.zeros_like(wave)
    for k in range(2 * _REACH):
        shift = k * per_diameter + per_diameter // 2
        velocity[: len(x) - shift] -= rate[shift:]
    return width(x, velocity)


@cache
def _discrete_wave() -> tuple[Array, Array, float]:
    """Places in diameters and overlaps, at most 1, of the travelling wave, and the factor that fixes its speed.

    The overlap of a wave of speed V obeys ``delta = (k D^2/(m V^2)) L * delta^1.5`` with L the triangle of height 1 and
    base 2 D; its solution, of height 1, is found by iteration (English and Pego, Proc. AMS 133, 2005).
    """
    per_diameter, reach = 200, _REACH
    n = reach * per_diameter
    x = np.arange(-n, n + 1) / per_diameter
    triangle = np.clip(1 - np.abs(x[n - per_diameter : n + per_diameter + 1]), 0, None) / per_diameter
    wave, factor = np.exp(-(x**2)), 1.0
    for _ in range(60):
        wave = np.convolve(wave**1.5, triangle, mode="same")
        factor = float(wave.max())
        wave /= factor
    return x, wave, factor
