"""The solitary wave of an elastic chain of like beads whose first bead is struck (thesis 4.1.2).

Nesterenko's solitary wave, with D the diameter of a bead:

    bead velocity   v = v_max cos^4(2 x / (sqrt(10) D)), |x| up to pi sqrt(10)/4 D
    speed           V = 0.6802 (2 E / (D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6)

A bead of velocity v0 makes a wave of the peak force (4.5) 0.719 (m^3 E*^2 R* v0^6)^(1/5).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import CubicSpline

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves.pulses import LENGTH, theory

DISCRETE_WIDTH = 1.579  # full width at half maximum of the discrete chain's bead velocity, diameters
HALF_OF_COS4 = theory()["half maximum of velocity"]  # full width at half maximum, diameters
_SPLITTING = 10  # points put between two samples


class SolitaryWave:
    """The wave of a struck bead, measured far down the chain.

    Attributes
    ----------
    window
        First and last contact, from 1, between which it is measured.
    v0, force, speed
        Velocity of the first bead, peak force and speed over their units in this chain.
    coefficient
        Of (4.5).
    nesterenko
        Speed over Nesterenko's.
    x, velocity
        Profile of a bead, finely: place behind the crest in diameters, velocity over the largest.
    """

    def __init__(self, run: ChainRecord) -> None:
        self.run, scales, last = run, run.scales, run.passed
        self.window = last // 2, last
        peak = float(run.of_contacts("peak_force")[last - 1])
        crest = [run.first_peak(contact - 1)[0] for contact in range(self.window[0], last + 1)]
        speed = scales.diameter / float(np.polyfit(np.arange(len(crest)), crest, 1)[0])
        self.v0, self.speed = run.load.velocity / scales.velocity, speed / scales.velocity
        self.force = peak / scales.force
        self.coefficient = peak / scales.impulse_force(run.impulse)
        self.nesterenko = speed / scales.nesterenko(peak)
        time = np.linspace(run.time[0], run.time[-1], _SPLITTING * len(run.time))
        velocity = CubicSpline(run.time, run.velocity[:, sum(self.window) // 2])(time)
        self.x = (time - time[velocity.argmax()]) * speed / scales.diameter
        self.velocity = velocity / velocity.max()

    @property
    def virial(self) -> float:
        """4 K / 5 P on the average of the second half of the run; beads that bounced back are left out."""
        half = slice(len(self.run.time) // 2, None)
        velocity, force = self.run.velocity[half], self.run.force[half]
        kinetic = 0.5 * self.run.mass * (np.maximum(velocity, 0) ** 2).sum(axis=1)
        elastic = 0.4 * (force * self.run.scales.overlap(force)).sum(axis=1)
        return float(np.mean(4 * kinetic) / np.mean(5 * elastic))


def cos4(x: Array) -> Array:
    """Bead velocity of Nesterenko's wave over its largest, at places in diameters."""
    return np.where(np.abs(x) < 0.5 * LENGTH, np.cos(2 * x / math.sqrt(10)) ** 4, 0.0)
