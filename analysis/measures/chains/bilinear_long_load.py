"""A bilinear chain under a force that lasts: plateaus between its fronts, beside closed forms (thesis 4.2.2)."""

from __future__ import annotations

import numpy as np

from granwave.analysis.measures.chains.bilinear import LongLoad, spring_of
from granwave.analysis.measures.chains.record import ChainRecord

_INSTANTS = (0.8, 1.2)  # of T: with one front, and with two
_LAST = 1.15  # of T_t: with the fronts apart again
_INNER = (0.2, 0.8)  # of a plateau: where it is measured


class HeldLoad:
    """One run, and what the closed forms say of it.

    Attributes
    ----------
    spring
        Contact and bead.
    theory
        Closed forms.
    times
        Under load; after it; after the fronts have met; s. For the source's case its 2, 3 and 5.2 ms.
    largest
        Largest force ever at each contact: (n_contacts,), N.
    """

    def __init__(self, run: ChainRecord) -> None:
        self.run, self.spring, self.largest = run, spring_of(run), run.of_contacts("peak_force")
        self.theory = LongLoad(self.spring, run.load.largest, run.load.lasts)
        early, late = (share * run.load.lasts for share in _INSTANTS)
        self.times = early, late, _LAST * self.theory.meeting_time

    @property
    def reaches(self) -> bool:
        """The record and the chain go as far as is measured."""
        last = self.times[-1]
        apart = self.times[1] < 0.9 * self.theory.meeting_time
        return apart and self.run.time[-1] >= last and self.run.velocity.shape[1] > self.spring.rate * last + 20

    def row(self, instant: int) -> int:
        """Row of the record nearest to one of `times`."""
        return int(np.argmin(np.abs(self.run.time - self.times[instant])))

    def plateau(self, instant: int) -> slice:
        """Beads in the inner part of the plateau behind the last front but the leading one, or behind that alone."""
        time, c, cu = self.times[instant], self.spring.rate, self.spring.unloading_rate
        if instant == 0:
            start, end = 0.0, c * time
        elif instant == 1:
            start, end = 0.0, cu * (time - self.run.load.lasts)
        else:
            met, since = self.theory.meeting / self.spring.diameter, time - self.theory.meeting_time
            start, end = met - cu * since, met + c * since
        return slice(*(int(start + share * (end - start)) for share in _INNER))

    def velocity(self, instant: int) -> float:
        """Median on the plateau, m/s."""
        return float(np.median(self.run.velocity[self.row(instant), self.plateau(instant)]))

    def force(self, instant: int) -> float:
        """Median on the plateau, N."""
        return float(np.median(self.run.force[self.row(instant), self.plateau(instant)]))

    @property
    def meeting(self) -> float:
        """Place at which the largest force has fallen half-way from F_1 to F_2, m from the centre of bead 1."""
        level = (self.force(0) + self.force(2)) / 2
        k = int(np.flatnonzero(self.largest < level)[0])
        return float(np.interp(-level, -self.largest[k - 1 : k + 1], self.run.place[k - 1 : k + 1]))
