"""Composite chains: a section of other beads in a chain, between two sensors (the composite-chain source).

V is the distance of the two sensors over the time between the first peaks that arrive there, lambda the ratio of these
peaks, output over incident. Later peaks are waves that were reflected on the way, or at the end.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import Array, first_peak, maxima
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.yield_factor import hertz_von_mises_yield_factor
from granwave.lammps_inputs.contact.law import pair_contact

_LEAST_PEAK = 0.005  # of the largest force at a contact: smaller maxima are not told apart


@dataclasses.dataclass(frozen=True)
class Wave:
    """A maximum of the force at a contact: time in s, force in N; ``forth``: its beads move from the struck end on."""

    time: float
    force: float
    forth: bool


@dataclasses.dataclass(frozen=True, eq=False)
class Composite:
    """A recorded chain with one section of beads of another material, a sensor before and a sensor behind it.

    Attributes
    ----------
    first, last
        Ids of the section's beads.
    before, behind
        Names of the sensors.
    """

    run: ChainRecord
    first: int
    last: int
    before: str
    behind: str

    @property
    def n(self) -> int:
        """Beads in the section."""
        return self.last - self.first + 1

    @property
    def light(self) -> Material:
        """Material of the section."""
        return self.run.assembly.material_of(self.first)

    @property
    def strength(self) -> float:
        """Yield strength of the section, Pa; infinite where nothing yields."""
        return (self.light.yield_strength or math.inf) if self.run.case.contact.yields else math.inf

    @cached_property
    def incident(self) -> tuple[float, float]:
        """Time (s) and height (N) of the first peak at the first sensor."""
        return first_peak(self.run.time, self.run.sensors[self.before])

    @cached_property
    def output(self) -> tuple[float, float]:
        """Time (s) and height (N) of the first peak at the second sensor."""
        return first_peak(self.run.time, self.run.sensors[self.behind])

    @property
    def speed(self) -> float:
        """V, m/s."""
        where = {sensor.name: self.run.assembly.positions()[sensor.id - 1, 2] for sensor in self.run.case.sensor}
        return float((where[self.behind] - where[self.before]) / (self.output[0] - self.incident[0]))

    @property
    def ratio(self) -> float:
        """Lambda."""
        return self.output[1] / self.incident[1]

    @property
    def middle(self) -> int:
        """Bead whose contact with the next is watched for reflections: the section's third, as in source Fig. 6."""
        return self.first + min(2, self.n - 2)

    def flow(self) -> Array:
        """Force of every contact between beads, negative while its beads move towards the struck end, N."""
        n = self.run.velocity.shape[1] - 1  # a wall's contact is not among them
        return self.run.force[:, :n] * np.sign(self.run.velocity[:, :-1] + self.run.velocity[:, 1:])

    def waves(self, bead: int) -> list[Wave]:
        """All maxima of the force between this bead and the next, in time."""
        k = self.run.contact_between(bead)
        force, time, flow = self.run.force[:, k], self.run.time, self.flow()[:, k]
        places = maxima(force, _LEAST_PEAK * float(force.max()))
        return [Wave(float(time[n]), float(force[n]), bool(flow[n] >= 0)) for n in places]

    @cached_property
    def reflections(self) -> Mapping[str, Wave]:
        """Waves at the watched contact, by the source's names, as far as they are found.

        ``BRW``: the first that runs back, from the section's far end. ``FRW``: the next one after the BRW has come to
        the section's near end, where it may meet a later wave back; ``DFRW`` the one after that. ``end``: the first
        one back after a wave from the chain's end has come to the section's far end.
        """
        watched = self.waves(self.middle)
        found = {"incident": watched[0]} if watched else {}
        back = [wave for wave in watched if not wave.forth]
        at_near = [wave for wave in self.waves(self.first - 1) if not wave.forth]
        after = min((wave.time for wave in self.waves(self.last + 1) if not wave.forth), default=math.inf)
        from_end = [wave for wave in back if wave.time > after]
        if from_end:
            found["end"] = from_end[0]
        if not back or back[0].time > after:
            return found
        found["BRW"] = back[0]
        turned = [wave.time for wave in at_near if wave.time > back[0].time]
        until = found["end"].time if "end" in found else math.inf
        again = [wave for wave in watched if turned and turned[0] < wave.time < until]
        return found | dict(zip(("FRW", "DFRW"), again, strict=False))

    def stress(self, bead: int) -> float:
        """Largest von Mises stress between this bead and the next in the first peak, Pa; elastic chains alone."""
        return self.pressure(bead) / hertz_von_mises_yield_factor(self.light.poisson_ratio)

    def pressure(self, bead: int) -> float:
        """Largest pressure of the same contact by Hertz, Pa."""
        law = pair_contact(self.run.case, bead, bead + 1)
        _, force = first_peak(self.run.time, self.run.force[:, self.run.contact_between(bead)])
        modulus, radius = law.effective_modulus, law.effective_radius
        return float((6 * force * modulus**2 / (math.pi**3 * radius**2)) ** (1 / 3))


def composite_of(run: ChainRecord) -> Composite | None:
    """A run as a composite chain; None if it is something else."""
    assembly = run.assembly
    replaced = sorted(assembly.materials)
    if not run.recorded or len(replaced) < 2 or assembly.diameters or assembly.bars or replaced[0] == 1:
        return None
    first, last = replaced[0], replaced[-1]
    if last - first + 1 != len(replaced) or len(set(assembly.materials.values())) > 1:
        return None
    before = [sensor.name for sensor in run.case.sensor if sensor.id < first]
    behind = [sensor.name for sensor in run.case.sensor if last < sensor.id <= assembly.lattice.n_spheres]
    return Composite(run, first, last, before[-1], behind[0]) if before and behind else None
