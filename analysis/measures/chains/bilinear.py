"""Bilinear chains, theory: the linear chain, the leading wave, collisions behind it, and long loads (thesis 4.2).

loading             F = k alpha                        k = 18.5 sigma_y R*
un- and reloading   of slope k_u = k / (1 - beta)      dissipated: beta F^2 / 2k
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import Array

#: As thesis 4.19 to 4.22 print them: v_m, F_p, F_2, and the factor of sqrt(1 - beta) in v_t.
PRINTED = (0.482, 0.721, 0.199, 0.599)
_SMALL = 1e-3  # of R*: an overlap at which the slope is taken


@dataclasses.dataclass(frozen=True)
class Spring:
    """The contact and the bead of a bilinear chain.

    Attributes
    ----------
    stiffness
        k of loading, N/m.
    beta
        Residual overlap over the largest overlap.
    mass
        Of a bead, kg.
    diameter
        Of a bead, m.
    """

    stiffness: float
    beta: float
    mass: float
    diameter: float

    @property
    def rate(self) -> float:
        """sqrt(k/m), 1/s: a wave of loading passes so many beads in a second."""
        return math.sqrt(self.stiffness / self.mass)

    @property
    def unloading_rate(self) -> float:
        """sqrt(k_u/m), 1/s."""
        return self.rate / self.share

    @property
    def share(self) -> float:
        """c/c_u = sqrt(1 - beta): speed of loading over that of unloading waves."""
        return math.sqrt(1 - self.beta)


def spring_of(run: ChainRecord) -> Spring:
    """Return the springs of a run under the bilinear law."""
    overlap = np.array([_SMALL * run.law.effective_radius])
    stiffness = float(run.law.loading_force(overlap)[0] / overlap[0])
    return Spring(stiffness, run.case.contact.beta, run.mass, run.case.packing.diameter)


def bead_velocity(bead: int, phase: Array) -> Array:
    """Velocity of a bead (from 1) of a half-infinite linear chain after an impulse on bead 1, in units of I/m.

    ``J_{2n-2}(2s) + J_{2n}(2s)`` at the phase s = sqrt(k/m) t.
    """
    return jv(2 * bead - 2, 2 * phase) + jv(2 * bead, 2 * phase)


def contact_force(contact: int, phase: Array) -> Array:
    """Force of a contact (from 1) of the same chain, in units of sqrt(k/m) I: ``J_{2n-1}(2s) + J_{2n+1}(2s)``."""
    return jv(2 * contact - 1, 2 * phase) + jv(2 * contact + 1, 2 * phase)


def first_coefficients() -> tuple[float, float, float]:
    """v_m, F_p and F_2 of thesis 4.19 to 4.21: at the peak of contact 1, when beads 1 and 2 are equally fast."""
    phase = brentq(lambda s: float(bead_velocity(1, s) - bead_velocity(2, s)), 0.5, 2.0)
    return float(bead_velocity(1, phase)), float(contact_force(1, phase)), float(contact_force(2, phase))


@dataclasses.dataclass(frozen=True)
class LeadingWave:
    """The leading wave as self-similar: what follows the peak force F at every contact (thesis 4.23 to 4.31).

    Attributes
    ----------
    ahead
        eta: force of the next contact, of F.
    moving
        gamma sqrt(k m): velocity of both beads at the peak, of F / sqrt(k m).
    residual
        omega sqrt(k m): velocity that the bead behind keeps, of F / sqrt(k m).
    beta
        Of the law.
    """

    ahead: float
    moving: float
    residual: float
    beta: float

    @property
    def ratio(self) -> float:
        """Peak force from one contact to the next: the root of the energy balance (thesis 4.26)."""
        lost = self.beta + self.residual**2
        return math.sqrt(1 - lost / (1 + self.ahead**2 + 2 * self.moving**2))

    @property
    def decay(self) -> float:
        """1 - ratio: decay per contact once the balance is read as a differential equation (thesis 4.28)."""
        return 1 - self.ratio

    def printed(self, contact: Array) -> Array:
        """Peak force over that of contact 1 (thesis 4.28)."""
        return np.exp(-self.decay * (contact - 1))

    def discrete(self, contact: Array) -> Array:
        """Peak force over that of contact 1, contact by contact as the balance has it."""
        return self.ratio ** (contact - 1)

    def secondary(self, contact: Array) -> Array:
        """Peak of collisions behind the wave over that of contact 1: ``sqrt(k_u m / 2) omega (F_1 - F_{i+1})``."""
        return math.sqrt(0.5 / (1 - self.beta)) * self.residual * (1 - self.printed(contact + 1))

    @property
    def transition(self) -> float | None:
        """Contact at which collisions overtake the leading wave, a fraction between contacts; None: never."""
        if self.residual <= 0:
            return None
        if self.secondary(np.array(1.0)) >= 1:
            return 1.0
        return float(brentq(lambda n: float(self.secondary(n) - self.printed(n)), 1.0, 200.0))


def leading_wave(beta: float) -> LeadingWave:
    """With the coefficients that thesis 4.19 to 4.22 print."""
    moving, peak, second, trailing = PRINTED
    return LeadingWave(second / peak, moving / peak, (moving - trailing * math.sqrt(1 - beta)) / peak, beta)


class LongLoad:
    """A force A held for T, much longer than a wave takes for a bead, in closed form (thesis 4.36 to 4.39).

    In 4.38 the second c_u is read as c, without which 4.39 does not follow.

    Attributes
    ----------
    velocity, trailing, later
        v_1 behind the leading front, v_t behind the trailing one, v_2 after the two have met, m/s.
    force, later_force
        F_1 = A and F_2, N.
    meeting, meeting_time
        x_t, where they meet, m, and T_t, when, s.
    """

    def __init__(self, spring: Spring, amplitude: float, duration: float) -> None:
        self.force, self.velocity = amplitude, amplitude / (spring.mass * spring.rate)
        self.trailing = self.velocity * (1 - spring.share)
        self.later = self.trailing / (1 + spring.share)
        self.later_force = spring.mass * self.later * spring.rate
        self.meeting_time = duration / (1 - spring.share) if spring.beta else math.inf
        self.meeting = spring.diameter * spring.rate * self.meeting_time
