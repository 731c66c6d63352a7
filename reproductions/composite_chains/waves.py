"""Waves in and behind the section of a composite chain: reflections, output, energies (source 3.3)."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from granwave.measures import maxima

LEAST = 0.005  # fraction of the largest force at a contact: smaller maxima are not distinguished
NAMES = {
    "incident": "Incident pulse",
    "BRW": "Backward reflection (BRW)",
    "FRW": "Forward reflection (FRW)",
    "DFRW": "Delayed forward reflection (DFRW)",
    "end": "Pulse reflected from the end of the chain",
}


@dataclass(frozen=True)
class Wave:
    """A maximum of the force at a contact: time in s, force in N; ``forth``: the wave travels away
    from the impacted end.
    """

    time: float
    force: float
    forth: bool


class Waves:
    """Waves of a section (`section.Section`), and energies of its beads: kinetic, and half of the
    energy of each contact.
    """

    def __init__(self, section):
        self.section = section
        self.chain = section.chain
        self.time = section.time
        self.first = section.first
        self.last = section.last
        self.n = section.n
        self.middle = self.first + min(
            2, self.n - 2
        )  # the bead whose contact with the next is watched
        self.at = f"between beads {self.middle} and {self.middle + 1}, N2 = {self.n}"

    @cached_property
    def flow(self):
        """Force of every contact between beads, negative while its beads move towards the struck
        end, N.
        """
        velocity = self.chain.velocity
        return self.chain.force[:, : velocity.shape[1] - 1] * np.sign(
            velocity[:, :-1] + velocity[:, 1:]
        )

    def between(self, bead):
        """All maxima of the force between this bead and the next, in time."""
        force = self.section.force(bead)
        flow = self.flow[:, self.chain.contact_between(bead)]
        places = maxima(force, LEAST * force.max())
        return [
            Wave(*one)
            for one in zip(self.time[places], force[places], flow[places] >= 0, strict=True)
        ]

    @cached_property
    def watched(self):
        """Waves at the watched contact."""
        return self.between(self.middle)

    @cached_property
    def reflections(self):
        """Waves at the watched contact by the names of the source, as far as they exist.

        ``BRW``: the first backward wave, from the far end of the section. ``FRW``: the next wave
        after the BRW has reached the near end of the section, where it may meet a later backward
        wave; ``DFRW``: the wave after the FRW. ``end``: the first backward wave after a wave from
        the end of the chain has reached the far end of the section.
        """
        found = {"incident": self.watched[0]}
        back = [wave for wave in self.watched if not wave.forth]
        after = min(
            (wave.time for wave in self.between(self.last + 1) if not wave.forth), default=math.inf
        )
        from_end = [wave for wave in back if wave.time > after]
        if from_end:
            found["end"] = from_end[0]
        if not back or back[0].time > after:
            return found
        turned = [
            w.time for w in self.between(self.first - 1) if not w.forth and w.time > back[0].time
        ]
        until = from_end[0].time if from_end else math.inf
        again = [wave for wave in self.watched if turned and turned[0] < wave.time < until]
        return found | {"BRW": back[0]} | dict(zip(("FRW", "DFRW"), again, strict=False))

    def until_back(self, bead):
        """Waves between this bead and the next before the first backward wave, and thus before any
        reflection.
        """
        found = self.between(bead)
        return found[: next((n for n, wave in enumerate(found) if not wave.forth), len(found))]

    @cached_property
    def train(self):
        """Waves of the incident train, at the contact before the section's first bead."""
        return self.until_back(self.first - 1)

    @cached_property
    def transmitted(self):
        """Forward waves at the second contact behind the section, as in source Fig. 7."""
        return self.until_back(self.last + 2)

    @property
    def second(self):
        """Second wave of the incident train at the watched contact."""
        return [wave for wave in self.watched if wave.forth][1]

    @cached_property
    def before_return(self):
        """Time at which the first backward wave from the chain's end reaches the section, or the
        end of the run, s.
        """
        back = (wave.time for wave in self.between(self.last + 1) if not wave.forth)
        return min(back, default=self.time[-1])

    @cached_property
    def energy(self):
        """Energy of the beads: (n_times, n_beads), J."""
        chain = self.chain
        ids = self.chain.array("chain/id")
        overlap = np.maximum(-np.diff(chain.array("chain/displacement"), axis=1), 0.0)
        largest = np.maximum.accumulate(overlap)
        energy = 0.5 * self.section.run.spheres.mass.loc[ids].to_numpy() * chain.velocity**2
        for k, (first, second) in enumerate(pairwise(ids)):
            stored = chain.law_between(int(first), int(second)).elastic_energy(
                overlap[:, k], largest[:, k]
            )
            energy[:, k : k + 2] += 0.5 * np.asarray(stored)[:, None]
        return energy

    @cached_property
    def shares(self):
        """Energies of the first steel section (with the striker), the light section and the second
        steel section, divided by the input.
        """
        ends = list(self.chain.array("chain/id")).index(self.first), self.n
        parts = np.split(self.energy, np.cumsum(ends), axis=1)
        return (
            np.stack([part.sum(axis=1) for part in parts], axis=1)
            / self.section.run.energies.input.iloc[-1]
        )

    @cached_property
    def density(self):
        """Largest energy density of each bead until `before_return`: (n_beads,), J/m^3."""
        volume = math.pi / 6 * self.section.case.packing.diameter**3
        return self.energy[self.time <= self.before_return].max(axis=0) / volume

    def passed(self, bead):
        """Energy transmitted forward and backward through the contact of this bead and the next,
        until `before_return`, J.
        """
        k = self.chain.contact_between(bead)
        until = self.time <= self.before_return
        power = (
            self.chain.force[:, k]
            * 0.5
            * (self.chain.velocity[:, k] + self.chain.velocity[:, k + 1])
        )
        return [
            np.trapezoid(np.maximum(sign * power, 0.0)[until], self.time[until]) for sign in (1, -1)
        ]
