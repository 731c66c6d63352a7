"""Composite chains: a section of other beads in a chain, between two sensors (the composite-chain source).

V is the distance of the two sensors over the time between the first peaks that arrive there, lambda the ratio of these
peaks, output over incident. Later peaks are waves that were reflected on the way, or at the end.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit

from granwave.analysis.measures.signals import first_peak
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.lammps_inputs.case.material import Material, material
from granwave.lammps_inputs.case.yield_factor import hertz_von_mises_yield_factor
from granwave.lammps_inputs.contact.law import pair_contact

_FEWEST_FITTED = 4
_LEAST_PEAK = 0.005  # of the largest force at a contact: smaller maxima are not told apart


@dataclasses.dataclass(frozen=True)
class Decay:
    """``y = end + span exp(-x/length)``, fitted by least squares.

    Attributes
    ----------
    residual
        Root mean square.
    """

    end: float
    span: float
    length: float
    residual: float

    def __call__(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of the law."""
        return _exponential(x, self.end, self.span, self.length)


def _exponential(x: NDArray[np.float64], end: float, span: float, length: float) -> NDArray[np.float64]:
    return end + span * np.exp(-x / length)


def decay(x: NDArray[np.float64], y: NDArray[np.float64]) -> Decay | None:
    """The exponential law through points (n_points,); None where there are too few, or no such law is found."""
    if len(x) < _FEWEST_FITTED:
        return None
    start = (float(y[-1]), float(y[0] - y[-1]) * math.e, float(x[-1] - x[0]) / 3)
    try:
        (end, span, length), _ = curve_fit(_exponential, x, y, p0=start, maxfev=5000)
    except RuntimeError:
        return None
    found = Decay(float(end), float(span), float(length), 0.0)
    return dataclasses.replace(found, residual=float(np.sqrt(np.mean((found(x) - y) ** 2))))


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

    run: ChainRun
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

    def contact(self, bead: int) -> int:
        """Place, in the arrays of the history, of the contact between this bead and the next."""
        i, j = self.run.array("contact_i"), self.run.array("contact_j")
        return int(np.flatnonzero((i == bead) & (j == bead + 1))[0])

    @property
    def middle(self) -> int:
        """Bead whose contact with the next is watched for reflections: the section's third, as in source Fig. 6."""
        return self.first + min(2, self.n - 2)

    def flow(self) -> NDArray[np.float64]:
        """Force of every contact between beads, negative while its beads move towards the struck end, N."""
        n = self.run.velocity.shape[1] - 1  # a wall's contact is not among them
        return self.run.force[:, :n] * np.sign(self.run.velocity[:, :-1] + self.run.velocity[:, 1:])

    def waves(self, bead: int) -> list[Wave]:
        """All maxima of the force between this bead and the next, in time."""
        k = self.contact(bead)
        force, time, flow = self.run.force[:, k], self.run.time, self.flow()[:, k]
        inner = (force[1:-1] > force[:-2]) & (force[1:-1] >= force[2:]) & (force[1:-1] > _LEAST_PEAK * force.max())
        return [Wave(float(time[n]), float(force[n]), bool(flow[n] >= 0)) for n in np.flatnonzero(inner) + 1]

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
        law = pair_contact(self.run.case, bead, bead + 1)
        _, force = first_peak(self.run.time, self.run.force[:, self.contact(bead)])
        modulus, radius = law.effective_modulus, law.effective_radius
        pressure = (6 * force * modulus**2 / (math.pi**3 * radius**2)) ** (1 / 3)
        return pressure / hertz_von_mises_yield_factor(self.light.poisson_ratio)


def composites(runs: Sequence[ChainRun]) -> Iterator[tuple[Material, list[Composite]]]:
    """Composite chains by the material of their section, the shortest section first."""
    found = [chain for run in runs if (chain := _composite(run)) is not None]
    for name in dict.fromkeys(chain.light.name for chain in found):
        chains = sorted((c for c in found if c.light.name == name), key=lambda c: (c.n, -c.strength))
        yield chains[0].light, chains


def _composite(run: ChainRun) -> Composite | None:
    assembly = run.assembly
    replaced = sorted(assembly.materials)
    whole = bool(replaced) and replaced == list(range(replaced[0], replaced[-1] + 1))
    if not run.recorded or not whole or assembly.diameters or assembly.bars or len(replaced) < 2:
        return None
    if len(set(assembly.materials.values())) > 1:
        return None
    inside = [sensor for sensor in run.case.sensor if sensor.id <= run.assembly.lattice.n_spheres]
    before = [sensor.name for sensor in inside if sensor.id < replaced[0]]
    behind = [sensor.name for sensor in inside if sensor.id > replaced[-1]]
    if not before or not behind or replaced[0] == 1:
        return None
    return Composite(run, replaced[0], replaced[-1], before[-1], behind[0])


def is_source(chain: Composite, light: str) -> bool:
    """The chain of the composite-chain source with this material of the section."""
    case, assembly = chain.run.case, chain.run.assembly
    return (
        _same(case.material, material("stainless-steel"))
        and _same(chain.light, material(light))
        and (case.packing.size[0], chain.first, case.packing.diameter) == (40, 8, 0.01)
        and [striker.velocity[2] for striker in case.striker] == [0.626]
        and assembly.strikers[0][0].material in (None, case.material)
    )


def _same(one: Material, other: Material) -> bool:
    return (one.youngs_modulus, one.poisson_ratio, one.density) == (
        other.youngs_modulus,
        other.poisson_ratio,
        other.density,
    )
