"""Elasto-plastic chains after a pulse: decay, speed and dissipation, beside thesis 2.2 (Figs. 2.11 to 2.16)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Power, arrival, first_peak, power
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.chains.scales import ChainScales, impulse_of, is_pulse, of_thesis

Array = NDArray[np.float64]

_THRESHOLD = 0.01  # of a contact's largest force: the leading disturbance has arrived
_OVERTAKEN = 1.005  # of the leading peak: a later one that is higher
_WINDOW = 10  # contacts over which a speed is taken
_FEWEST = 30  # contacts that make a study worth while
_FARTHEST = 100  # contacts: x/R* = 400, where the source's figures end
_AFTER = 0.85  # of the run: what arrives later may not have seen its largest force yet
_USUAL = 12.93  # tau: 10 us for brass of R = 4.76 mm, the duration that the source's impulses share
_LONGEST = 150.0  # tau: what lasts longer is no pulse; the source's longest is 129
_SAME = 5e-3


@dataclasses.dataclass(frozen=True, eq=False)
class Wave:
    """One elasto-plastic chain after a pulse."""

    run: ChainRun

    @cached_property
    def scales(self) -> ChainScales:
        """Units of the chain."""
        return ChainScales(self.run)

    @cached_property
    def impulse(self) -> float:
        """In units of E* R*^2 tau."""
        return impulse_of(self.run) / self.scales.impulse

    @property
    def duration(self) -> float:
        """Of the load, in tau."""
        return self.run.load.lasts / self.scales.time

    @property
    def name(self) -> str:
        """The load in a few characters."""
        load = self.run.load
        if load.kind == "impact":
            return f"{load.velocity:g} m/s"
        return f"{load.largest / 1e3:g} kN, {load.lasts * 1e6:.3g} µs"

    @property
    def peak_unit(self) -> float:
        """E* R*^2 times the impulse in its unit, N: peak forces are given in it."""
        return self.scales.force * self.impulse

    @cached_property
    def arrivals(self) -> Array:
        """When the leading disturbance reaches each contact: (n_contacts,), s; NaN: never."""
        largest = self.run.of_contacts("peak_force")
        pairs = zip(self.run.force.T, largest, strict=True)
        return np.array(
            [arrival(self.run.time, force, _THRESHOLD * top) if top > 0 else np.nan for force, top in pairs]
        )

    @cached_property
    def contacts(self) -> int:
        """How many contacts from the struck end are measured."""
        with np.errstate(invalid="ignore"):
            late = np.flatnonzero(~(self.arrivals < _AFTER * self.run.time[-1]))
        reached = int(late[0]) if len(late) else len(self.arrivals)
        return min(_FARTHEST, reached, len(self.arrivals) - _WINDOW)

    @property
    def number(self) -> Array:
        """Of the contacts that are measured, from 1."""
        return np.arange(1.0, self.contacts + 1)

    @cached_property
    def largest(self) -> Array:
        """Largest force ever at each: (contacts,), N."""
        return self.run.of_contacts("peak_force")[: self.contacts]

    @cached_property
    def normalised(self) -> Array:
        """The same over E* R*^2 I: (contacts,)."""
        return self.largest / self.peak_unit

    @cached_property
    def transition(self) -> int | None:
        """First contact that a later wave presses harder than the leading one did; None: none."""
        for n in range(self.contacts):
            if self.largest[n] > _OVERTAKEN * first_peak(self.run.time, self.run.force[:, n])[1]:
                return n + 1
        return None

    def decay(self, first: int, last: int) -> float:
        """Of the logarithm of the largest force, per contact."""
        return float(math.log(self.largest[first - 1] / self.largest[last - 1]) / (last - first))

    def inverse_constant(self, first: int, last: int) -> float:
        """Mean of (x/R*) F / (E* R*^2 I) over contacts."""
        chosen = slice(first - 1, last)
        return float(np.mean(4 * self.number[chosen] * self.normalised[chosen]))

    def force_power(self, first: int, last: int) -> Power:
        """Power of the largest force with the distance."""
        return power(self.number[first - 1 : last], self.largest[first - 1 : last])

    @cached_property
    def speed(self) -> tuple[Array, Array]:
        """Contacts, and the speed of the leading disturbance there in R*/tau, over windows of ten contacts."""
        time = self.arrivals[: self.contacts] / self.scales.time
        half = _WINDOW // 2
        return self.number[half:-half], 4 * _WINDOW / (time[_WINDOW:] - time[:-_WINDOW])

    def speed_at(self, contact: Array) -> Array:
        """Of the leading disturbance at contacts, in R*/tau."""
        return np.interp(contact, *self.speed)

    def speed_powers(self, first: int, last: int) -> tuple[Power, Power]:
        """Powers of that speed with the distance, and with the largest force (its own power law of distance)."""
        number, speed = self.speed
        inside = (number >= first) & (number <= last)
        force = self.force_power(first, last)(number[inside])
        return power(number[inside], speed[inside]), power(force, speed[inside])

    @cached_property
    def dissipated(self) -> Array:
        """Up to each contact: (contacts,), J."""
        return np.cumsum(self.run.of_contacts("dissipated_energy"))[: self.contacts]

    @property
    def energy_unit(self) -> float:
        """F_y alpha_y, J."""
        return self.run.law.yield_force * self.run.law.yield_overlap


@dataclasses.dataclass(frozen=True, eq=False)
class Pulses:
    """Chains of one material and radius after pulses, and the elastic chain under one of them.

    Attributes
    ----------
    groups
        By impulse, the largest first; within one in rising order of duration.
    elastic
        Its load is that of one of the others.
    """

    groups: tuple[tuple[Wave, ...], ...]
    elastic: tuple[Wave, Wave] | None

    @cached_property
    def chosen(self) -> tuple[Wave, ...]:
        """One of each impulse, with the duration that the source's impulses share."""
        return tuple(min(group, key=lambda wave: abs(wave.duration - _USUAL)) for group in self.groups)

    @property
    def weakest(self) -> Wave:
        """The chosen wave of the smallest impulse."""
        return self.chosen[-1]

    @property
    def contacts(self) -> int:
        """That all chosen waves have passed."""
        return min(wave.contacts for wave in self.chosen)

    @property
    def from_source(self) -> bool:
        """Beads of the thesis."""
        return of_thesis(self.weakest.run)

    def impulse_power(self, contact: Array) -> Power | None:
        """Power of the leading speed with the impulse, at equal places; None from one impulse."""
        if len(self.chosen) < 2:
            return None
        speed = [float(np.exp(np.mean(np.log(wave.speed_at(contact))))) for wave in self.chosen]
        return power(np.array([wave.impulse for wave in self.chosen]), np.array(speed))


def collect_pulses(runs: Sequence[ChainRun]) -> Pulses | None:
    """The elasto-plastic chains after pulses among runs; of several materials or radii those of the most runs."""
    waves = [Wave(run) for run in uniform(runs, "elastoplastic") if is_pulse(run) and run.force.shape[1] > _FEWEST]
    alike: dict[tuple[float, float], list[Wave]] = {}
    for wave in waves:
        if wave.duration <= _LONGEST and wave.contacts >= _FEWEST and wave.largest[0] > wave.run.law.yield_force:
            alike.setdefault((wave.scales.force, wave.scales.time), []).append(wave)
    if not alike:
        return None
    most = max(len(group) for group in alike.values())
    chosen = next(group for group in alike.values() if len(group) == most)
    chosen = sorted(chosen, key=lambda wave: (-wave.impulse, wave.duration))
    groups: list[list[Wave]] = []
    for wave in chosen:
        if groups and math.isclose(groups[-1][0].impulse, wave.impulse, rel_tol=_SAME):
            groups[-1].append(wave)
        else:
            groups.append([wave])
    ordered = tuple(tuple(sorted(group, key=lambda wave: wave.duration)) for group in groups)
    return Pulses(ordered, _elastic(runs, chosen))


def _elastic(runs: Sequence[ChainRun], waves: Sequence[Wave]) -> tuple[Wave, Wave] | None:
    """An elastic chain and the elasto-plastic one under the same load."""
    for run in uniform(runs, "hertz"):
        for wave in waves:
            same = run.load == wave.run.load and run.mass == wave.run.mass
            if same and run.force.shape[1] > _FEWEST and run.law.effective_modulus == wave.run.law.effective_modulus:
                return Wave(run), wave
    return None
