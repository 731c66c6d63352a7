"""Energy of the beads and sections of a composite chain in time, and the energy that waves carry (source Fig. 8).

A bead has its kinetic energy and half of the energy stored in each of its contacts with other beads; the record has
none of the wall's. A section's energy density is its energy over the volume of its beads.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.composite_section import Composite
from granwave.analysis.measures.signals import Array
from granwave.lammps_inputs.contact.law import pair_contact


@dataclasses.dataclass(frozen=True, eq=False)
class SectionEnergy:
    """Energies of a recorded composite chain; beads in the order of the chain, strikers first."""

    chain: Composite

    @property
    def time(self) -> Array:
        """Instants: (n_times,), s."""
        return self.chain.run.time

    @cached_property
    def beads(self) -> Array:
        """Energy of the beads: (n_times, n_beads), J."""
        run = self.chain.run
        ids, velocity, place = run.array("chain/id"), run.velocity, run.array("chain/displacement")
        mass = np.array([run.assembly.mass_of(int(one)) for one in ids])
        energy = 0.5 * mass * velocity**2
        pairs = zip(run.array("chain/contact_i"), run.array("chain/contact_j"), strict=True)
        order = {int(one): n for n, one in enumerate(ids)}
        for i, j in pairs:
            first, second = sorted((order[int(i)], order[int(j)]))
            overlap = np.maximum(place[:, first] - place[:, second], 0.0)
            law = pair_contact(run.assembly, int(i), int(j))
            stored = np.asarray(law.elastic_energy(overlap, np.maximum.accumulate(overlap)))
            energy[:, first] += 0.5 * stored
            energy[:, second] += 0.5 * stored
        return energy

    @cached_property
    def volumes(self) -> Array:
        """Volume of the beads: (n_beads,), m^3."""
        assembly = self.chain.run.assembly
        return np.array([math.pi / 6 * assembly.diameter_of(int(one)) ** 3 for one in self.chain.run.array("chain/id")])

    @cached_property
    def _parts(self) -> tuple[slice, slice, slice]:
        """Beads of the first steel section with the striker, of the light section, and of the second steel section."""
        ids = list(self.chain.run.array("chain/id"))
        first, last = ids.index(self.chain.first), ids.index(self.chain.last)
        return slice(0, first), slice(first, last + 1), slice(last + 1, None)

    @cached_property
    def sections(self) -> Array:
        """Energy of the three sections over the input: (n_times, 3)."""
        given = float(self.chain.run.array("energy/input")[-1])
        return np.stack([self.beads[:, part].sum(axis=1) for part in self._parts], axis=1) / given

    @property
    def highest_densities(self) -> Array:
        """Largest energy density of each bead until `before_return`: (n_beads,), J/m^3."""
        until = self.time <= self.before_return
        return np.asarray(self.beads[until].max(axis=0) / self.volumes)

    @property
    def before_return(self) -> float:
        """Time at which the first wave back from the chain's end comes to the section, or the end of the run, s."""
        back = (wave.time for wave in self.chain.waves(self.chain.last + 1) if not wave.forth)
        return min(back, default=float(self.time[-1]))

    def at(self, time: float) -> Array:
        """Energy of the three sections over the input at a time: (3,)."""
        return np.array([np.interp(time, self.time, column) for column in self.sections.T])

    def passed(self, bead: int) -> tuple[float, float]:
        """Energy that went forth and back through the contact of this bead and the next, until `before_return`, J."""
        run, k = self.chain.run, self.chain.run.contact_between(bead)
        power = run.force[:, k] * 0.5 * (run.velocity[:, k] + run.velocity[:, k + 1])
        until = self.time <= self.before_return
        forth, back = (np.trapezoid(np.maximum(sign * power, 0.0)[until], self.time[until]) for sign in (1, -1))
        return float(forth), float(back)
