"""A bilinear chain after an impulse: leading wave, collisions and inverse regime (thesis 4.2.1)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.bilinear import PRINTED, leading_wave, spring_of
from granwave.analysis.measures.chains.record import OVERTAKEN, ChainRecord
from granwave.analysis.measures.signals import Array, Power, at_time, power

INVERSE = (30, 300)  # contacts of the fit in the inverse regime
_SHORT = 0.25  # of 1/sqrt(k/m): the longest pulse that is an impulse alone
_FINE = 0.25  # of 1/sqrt(k/m): the coarsest record that shows the leading wave
_SHORTEST = 8.0  # 1/sqrt(k/m): the shortest record, in which contacts 1 to 3 have peaked
_CONTACTS = 12  # of the leading wave that are followed
_FEWEST = 100  # contacts that make such a fit worth while
_FRONTS = (119.1, 238.2, 357.4)  # sqrt(k/m) t of Fig. 4.8: 1.5, 3 and 4.5 ms
_BEHIND = 0.9  # of the way to the front over which velocities are averaged


class ShortPulse:
    """Chains of one beta after a short pulse.

    Attributes
    ----------
    near, far
        One recorded in short steps, and one followed far.
    spring, beta
        Contact and bead; residual overlap over the largest one.
    model
        Of thesis 4.23 to 4.31.
    impulse, velocity_unit, force_unit
        I in N s, I/m in m/s, sqrt(k/m) I in N.
    contacts
        How many the leading wave is followed over.
    crests, leading
        When it peaks at each, s, and how high, N: (contacts,).
    largest
        Largest force ever at each contact: (n_contacts,), N.
    """

    def __init__(self, near: ChainRecord, far: ChainRecord) -> None:
        self.near, self.far, self.spring = near, far, spring_of(near)
        self.beta, self.model = self.spring.beta, leading_wave(self.spring.beta)
        self.impulse = near.impulse
        self.velocity_unit, self.force_unit = self.impulse / self.spring.mass, self.impulse * self.spring.rate
        reached = self.spring.rate * near.time[-1] - 3  # three contacts long
        self.contacts = max(2, min(_CONTACTS, int(reached), near.force.shape[1]))
        self.crests, heights = np.array([near.first_peak(n) for n in range(self.contacts)]).T
        # the parabola overshoots where unloading is much steeper than loading; peaks of every step bound it
        self.leading: Array = np.minimum(heights, near.of_contacts("peak_force")[: self.contacts])
        self.largest = far.of_contacts("peak_force")

    @property
    def transition(self) -> int | None:
        """First contact that a later wave presses harder than the leading one did; None: beyond those followed."""
        n = min(self.contacts, len(self.largest))
        over = np.flatnonzero(self.largest[:n] > OVERTAKEN * self.leading[:n])
        return int(over[0]) + 1 if len(over) else None

    @property
    def excess(self) -> float:
        """Excess of the later wave over the leading one at the `transition`, per cent."""
        n = (self.transition or 1) - 1
        return float(100 * (self.largest[n] / self.leading[n] - 1))

    @property
    def last_of_leading(self) -> int:
        """The last contact whose largest force is that of the leading wave."""
        return (self.transition or self.contacts + 1) - 1

    @property
    def decay(self) -> float:
        """Fall of the logarithm of the leading peak from contact 1 to 2, where the leading wave rules for all beta."""
        return float(math.log(self.leading[0] / self.leading[1]))

    def profile(self, contact: int) -> Array:
        """Forces of all contacts when one (from 1) is at its leading peak: (n_contacts,), N."""
        return at_time(self.peak_time(contact), self.near.time, self.near.force)

    def peak_time(self, contact: int) -> float:
        """Time at which the beads of a contact (from 1) are first equally fast after touching, s."""
        closing = self.near.velocity[:, contact - 1] - self.near.velocity[:, contact]
        k = int(np.flatnonzero((closing <= 0) & (self.near.force[:, contact - 1] > 0))[0])
        return float(np.interp(0.0, -closing[k - 1 : k + 1], self.near.time[k - 1 : k + 1]))

    @property
    def at_first_peak(self) -> tuple[float, float, float]:
        """v_m, F_p and F_2, in units of I/m and sqrt(k/m) I, when the first contact is at its peak."""
        moving = float(at_time(self.peak_time(1), self.near.time, self.near.velocity)[0])
        second = float(self.profile(1)[1])
        return moving / self.velocity_unit, float(self.leading[0]) / self.force_unit, second / self.force_unit

    def residual(self, bead: int) -> float:
        """Velocity of a bead (from 1) in free flight once the leading wave has left it, m/s; NaN: none."""
        if bead > self.contacts:
            return math.nan
        force = self.near.force[:, max(0, bead - 2) : bead]
        free = (self.near.time > self.crests[bead - 1]) & (force.max(axis=1) == 0)
        places = np.flatnonzero(free)
        return float(self.near.velocity[places[0], bead - 1]) if len(places) else math.nan

    @property
    def trailing_factor(self) -> float:
        """Factor of sqrt(1 - beta) in thesis 4.22, with its v_m = 0.482 I/m."""
        return (PRINTED[0] - self.residual(1) / self.velocity_unit) / self.spring.share

    @cached_property
    def inverse(self) -> Power | None:
        """Power of the largest force with the distance far down the chain; None: the chain is short for it."""
        last = min(INVERSE[1], int(0.85 * self.spring.rate * self.far.time[-1]), len(self.largest) - 20)
        if last - INVERSE[0] < _FEWEST:
            return None
        number = np.arange(INVERSE[0], last + 1)
        return power(number.astype(float), self.largest[INVERSE[0] - 1 : last])

    @property
    def instants(self) -> list[int]:
        """Rows of the far record at the times of Fig. 4.8, as far as it goes."""
        phase = self.spring.rate * self.far.time
        shown = [front for front in _FRONTS if front <= min(phase[-1], self.far.velocity.shape[1] - 10)]
        return [int(np.argmin(np.abs(phase - front))) for front in shown]

    def uniform(self, row: int) -> tuple[float, float, float]:
        """Mean velocity behind the front (m/s), its standard deviation over that, and I/m over the beads that move."""
        v = self.far.velocity[row]
        front = int(np.flatnonzero(v > 0.5 * v[: len(v) // 10 + 2].mean())[-1]) + 1
        behind = v[: max(2, int(_BEHIND * front))]
        return float(behind.mean()), float(behind.std() / behind.mean()), self.velocity_unit / front


def short_pulses(runs: Iterable[ChainRecord]) -> list[ShortPulse]:
    """Bilinear chains after short pulses, by beta; those of one beta are of one material and impulse."""
    found: dict[float, list[ChainRecord]] = {}
    for run in runs:
        if run.is_pulse and run.force.shape[1] > 2 and run.load.lasts * spring_of(run).rate < _SHORT:
            found.setdefault(run.case.contact.beta, []).append(run)
    pulses = []
    for _, group in sorted(found.items()):
        near = min(group, key=lambda run: float(run.time[1] - run.time[0]))
        alike = [run for run in group if np.allclose((run.impulse, run.mass), (near.impulse, near.mass), 1e-6, 0)]
        far = max(alike, key=lambda run: min(run.force.shape[1], spring_of(run).rate * run.time[-1]))
        rate = spring_of(near).rate
        if (near.time[1] - near.time[0]) * rate < _FINE and near.time[-1] * rate > _SHORTEST:
            pulses.append(ShortPulse(near, far))
    return pulses
