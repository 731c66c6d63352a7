"""A pulse along a line of contacts: arrival, peak forces, speed of its leading disturbance, and their powers."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np

from granwave.analysis.measures.signals import Array, Power, arrival, first_peak, power

_THRESHOLD = 0.01  # of a contact's largest force: the leading disturbance has arrived
_OVERTAKEN = 1.005  # of the leading peak: a later one that is higher
_WINDOW = 10  # contacts over which a speed is taken
_FARTHEST = 100  # contacts that are measured at most
_AFTER = 0.85  # of the run: what arrives later may not have seen its largest force yet


@dataclasses.dataclass(eq=False)
class LinePulse:
    """A pulse along a line of contacts, which are numbered from 1 at the struck end.

    Attributes
    ----------
    time
        Of the record: (n_times,), s.
    force
        Of the contacts: (n_times, n_contacts), N.
    peak_force
        Largest force of each contact, between records too: (n_contacts,), N.
    """

    time: Array
    force: Array
    peak_force: Array

    @cached_property
    def arrivals(self) -> Array:
        """When the leading disturbance reaches each contact: (n_contacts,), s; NaN: never."""
        pairs = zip(self.force.T, self.peak_force, strict=True)
        times = [arrival(self.time, force, _THRESHOLD * top) if top > 0 else np.nan for force, top in pairs]
        return np.array(times)

    @cached_property
    def contacts(self) -> int:
        """How many contacts from the struck end are measured."""
        with np.errstate(invalid="ignore"):
            late = np.flatnonzero(~(self.arrivals < _AFTER * self.time[-1]))
        reached = int(late[0]) if len(late) else len(self.arrivals)
        return min(_FARTHEST, reached, len(self.arrivals) - _WINDOW)

    @property
    def number(self) -> Array:
        """Numbers of the contacts that are measured, from 1."""
        return np.arange(1.0, self.contacts + 1)

    @property
    def largest(self) -> Array:
        """Largest force ever at each: (contacts,), N."""
        return self.peak_force[: self.contacts]

    @cached_property
    def transition(self) -> int | None:
        """First contact that a later wave presses harder than the leading one did; None: none."""
        for n in range(self.contacts):
            if self.largest[n] > _OVERTAKEN * first_peak(self.time, self.force[:, n])[1]:
                return n + 1
        return None

    def decay(self, first: int, last: int) -> float:
        """Decay of the logarithm of the largest force, per contact."""
        return float(math.log(self.largest[first - 1] / self.largest[last - 1]) / (last - first))

    def force_power(self, first: int, last: int) -> Power:
        """Power of the largest force with the distance."""
        return power(self.number[first - 1 : last], self.largest[first - 1 : last])

    @cached_property
    def speed(self) -> tuple[Array, Array]:
        """Contacts, and the speed of the leading disturbance there in contacts/s, over windows of ten contacts."""
        time, half = self.arrivals[: self.contacts], _WINDOW // 2
        return self.number[half:-half], _WINDOW / (time[_WINDOW:] - time[:-_WINDOW])

    def speed_powers(self, first: int, last: int) -> tuple[Power, Power]:
        """Powers of that speed with the distance, and with the largest force (its own power law of distance)."""
        number, speed = self.speed
        inside = (number >= first) & (number <= last)
        force = self.force_power(first, last)(number[inside])
        return power(number[inside], speed[inside]), power(force, speed[inside])
