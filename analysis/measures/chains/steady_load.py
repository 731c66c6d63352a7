"""An elastic chain of like beads under a steady force that lasts to the end of the run (thesis 4.1.3).

A force A makes a plateau of force A whose speed is, by momentum and the virial 4 K = 5 P, c_l = D sqrt(A/(m alpha_A))
(4.16), at most c_u = sqrt(10/9) c_l (4.12); the bead velocity is then D A/(m c) (4.9).
"""

from __future__ import annotations

import math

import numpy as np

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import arrival


class SteadyLoad:
    """The chain, its plateau and the front ahead of it.

    Attributes
    ----------
    amplitude
        A, N.
    last, peak
        Contact, from 1, that the front has passed, and the largest force there, N.
    lower, upper
        Speeds (4.16) and (4.12), m/s.
    speed, front
        Speed of the front at half the force, m/s, over the last nine tenths of its way, and the contact that it has
        reached at the end.
    plateau_force, plateau_velocity
        Means over the first quarter of the way and the last tenth of the run, N and m/s.
    """

    def __init__(self, run: ChainRecord) -> None:
        self.run, self.scales, self.amplitude, self.last = run, run.scales, run.load.largest, run.passed
        self.peak = float(run.of_contacts("peak_force")[self.last - 1])
        overlap = float(self.scales.overlap(np.array(self.amplitude)))
        self.lower = self.scales.diameter * math.sqrt(self.amplitude / (run.mass * overlap))
        self.upper = math.sqrt(10 / 9) * self.lower
        numbers = np.arange(self.last // 10, self.last + 1)
        times = [arrival(run.time, run.force[:, n - 1], 0.5 * self.amplitude) for n in numbers]
        per_contact = float(np.polyfit(numbers, times, 1)[0])
        self.speed = self.scales.diameter / per_contact
        self.front = self.last + (float(run.time[-1]) - times[-1]) / per_contact
        late, plateau = slice(-len(run.time) // 10, None), slice(self.last // 50, self.last // 4)
        self.plateau_force = float(run.force[late, plateau].mean())
        self.plateau_velocity = float(run.velocity[late, plateau].mean())

    def bead_velocity(self, speed: float) -> float:
        """Velocity of the beads behind a front of this speed, m/s (thesis 4.9)."""
        return self.scales.diameter * self.amplitude / (self.run.mass * speed)

    @property
    def mean_velocity(self) -> float:
        """Mean velocity of all beads behind the front, m/s."""
        return float(self.run.velocity[-1].sum()) / self.front

    @property
    def virial(self) -> float:
        """4 K / 5 P on the average of the second half of the run."""
        time, kinetic, elastic = (self.run.array(f"energy/{name}") for name in ("time", "kinetic", "elastic"))
        half = time > 0.5 * time[-1]
        return float(0.8 * kinetic[half].mean() / elastic[half].mean())
