"""Scales of a chain of like beads, what pushes it, and how far a run of one can be trusted.

Hertz's chain has no length or force of its own, so every result is a curve in the units E* R*^2 (force),
tau = sqrt(pi rho R*^2/(4 E*)) (time; thesis 2.24) and R* (length).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.studies.chains.runs import ChainRun
from granwave.lammps_inputs.case.material import material

IMPULSE_COEFFICIENT = 0.719  # (4.5)
DISCRETE_COEFFICIENT = 0.7176  # of the same, of the discrete chain, by an independent solver (tests/chain_twin.py)
_NESTERENKO = 0.6802  # V = 0.6802 (2 E/(D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6); composite source 4, D the diameter
_UNTOUCHED = 1e-3  # of the largest force, at the last contact
_BRASS = (115e9, 0.30, 8500.0, 9.52e-3)  # E (Pa), nu, rho (kg/m^3), diameter (m) of thesis chapters 2 to 4


class ChainScales:
    """Units and closed forms of the chain of a run; its beads are alike."""

    def __init__(self, run: ChainRun) -> None:
        law, self.diameter = run.law, run.case.packing.diameter
        self._modulus, self._radius = law.effective_modulus, law.effective_radius
        self._density, self._mass = run.case.material.density, run.mass

    @property
    def force(self) -> float:
        """E* R*^2, N."""
        return self._modulus * self._radius**2

    @property
    def time(self) -> float:
        """tau (thesis 2.24), s."""
        return math.sqrt(math.pi * self._density * self._radius**2 / (4 * self._modulus))

    @property
    def velocity(self) -> float:
        """R*/tau, m/s."""
        return self._radius / self.time

    @property
    def impulse(self) -> float:
        """E* R*^2 tau, N s."""
        return self.force * self.time

    def overlap(self, force: NDArray[np.float64]) -> NDArray[np.float64]:
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
    """Speed of the travelling wave of the discrete Hertz chain over Nesterenko's at the same force: 1.01246.

    The overlap of a wave of speed V obeys ``delta = (k D^2/(m V^2)) L * delta^1.5`` with L the triangle of height 1 and
    base 2 D; its solution, of height 1, is found by iteration (English and Pego, Proc. AMS 133, 2005).
    """
    per_diameter, reach = 200, 5
    n = reach * per_diameter
    x = np.arange(-n, n + 1) / per_diameter
    triangle = np.clip(1 - np.abs(x[n - per_diameter : n + per_diameter + 1]), 0, None) / per_diameter
    wave, factor = np.exp(-(x**2)), 1.0
    for _ in range(60):
        wave = np.convolve(wave**1.5, triangle, mode="same")
        factor = float(wave.max())
        wave /= factor
    # V = D sqrt(factor/m) k^(1/3) F^(1/6), with k = E sqrt(D)/(3 (1 - nu^2)) and m = pi rho D^3/6
    return math.sqrt(6 * factor / math.pi) / 6 ** (1 / 3) / _NESTERENKO


def from_thesis(run: ChainRun) -> bool:
    """The beads are those of thesis chapters 2 to 4."""
    own = run.case.material
    ours = (own.youngs_modulus, own.poisson_ratio, own.density, run.case.packing.diameter)
    return all(math.isclose(a, b, rel_tol=1e-3) for a, b in zip(ours, _BRASS, strict=True))


def of_thesis(run: ChainRun) -> bool:
    """The beads are those of thesis chapters 2 to 4, with their yield strength."""
    own, brass = run.case.material.yield_strength or math.inf, material("brass").yield_strength or 0.0
    return from_thesis(run) and math.isclose(own, brass, rel_tol=1e-3)


def impulse_of(run: ChainRun) -> float:
    """What the load gives to the first bead, N s."""
    return run.mass * run.load.velocity if run.load.kind == "impact" else run.load.impulse


def is_pulse(run: ChainRun) -> bool:
    """One bead is hit, or pushed by a force of one sign for a time."""
    if run.load.kind == "impact":
        return run.load.spheres == 1
    return run.load.kind == "force" and run.load.shape in ("rectangle", "half-sine")


def undisturbed(run: ChainRun) -> bool:
    """The front has not come to the far end: the run is that of an endless chain."""
    largest = float(run.force.max(initial=0.0))
    return largest > 0 and float(run.force[:, -1].max()) < _UNTOUCHED * largest


def passed(run: ChainRun) -> int:
    """The last contact, from 1, that the crest of the leading wave has passed; 0: none."""
    crest = run.force.argmax(axis=0)
    over = np.flatnonzero((crest > 0) & (crest < len(run.time) - 2))
    return int(over[-1]) + 1 if len(over) else 0
