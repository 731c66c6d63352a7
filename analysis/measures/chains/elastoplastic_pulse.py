"""Elasto-plastic chains after a pulse, in the units of the chain (thesis 2.2)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.elastoplastic_model import SPACING
from granwave.analysis.measures.chains.groups import clustered
from granwave.analysis.measures.chains.record import OVERTAKEN, ChainRecord
from granwave.analysis.measures.signals import Array, Power, arrival, power

_THRESHOLD = 0.01  # of a contact's largest force: the leading disturbance has arrived
_HALF = 5  # contacts on either side over which a speed is taken
_WINDOW = 2 * _HALF
_FARTHEST = 100  # contacts that are measured at most
_AFTER = 0.85  # of the run: what arrives later may not have seen its largest force yet
_FEWEST = 30  # contacts that make a chain worth while
_LONGEST = 150.0  # tau: what lasts longer is no pulse; the source's longest is 129
_USUAL = 12.93  # tau: 10 us for brass of R = 4.76 mm, the duration that the source's impulses share
_SAME = 5e-3


class PlasticWave:
    """A pulse along an elasto-plastic chain, whose contacts are numbered from 1 at the struck end.

    Attributes
    ----------
    time, force
        Of the record: (n_times,), s, and (n_times, n_contacts), N.
    peak_force
        Largest force of each contact, between records too: (n_contacts,), N.
    scales
        Units of the chain.
    impulse, duration
        Of the load, in units of E* R*^2 tau, and in tau.
    peak_unit, energy_unit
        E* R*^2 times that impulse, which peak forces are given in, N; F_y alpha_y, J.
    name
        The load in a few characters.
    """

    def __init__(self, run: ChainRecord) -> None:
        self.run, self.scales, load = run, run.scales, run.load
        self.time, self.force, self.peak_force = run.time, run.force, run.of_contacts("peak_force")
        self.impulse, self.duration = run.impulse / self.scales.impulse, load.lasts / self.scales.time
        self.peak_unit, self.energy_unit = self.scales.force * self.impulse, run.law.yield_force * run.law.yield_overlap
        force = f"{load.largest / 1e3:g} kN, {load.lasts * 1e6:.3g} µs"
        self.name = f"{load.velocity:g} m/s" if load.kind == "impact" else force

    @cached_property
    def arrivals(self) -> Array:
        """Times at which the leading disturbance reaches each contact: (n_contacts,), s; NaN: never."""
        return self._arrivals(_THRESHOLD)

    def _arrivals(self, level: float) -> Array:
        """Times at which each contact first bears a share of its largest force: (n_contacts,), s; NaN: never."""
        pairs = zip(self.force.T, self.peak_force, strict=True)
        return np.array([arrival(self.time, force, level * top) if top > 0 else np.nan for force, top in pairs])

    @cached_property
    def contacts(self) -> int:
        """Number of contacts, from the struck end, that are measured."""
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
            if self.largest[n] > OVERTAKEN * self.run.first_peak(n)[1]:
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
        return self._speed(self.arrivals)

    def _speed(self, arrivals: Array) -> tuple[Array, Array]:
        time = arrivals[: self.contacts]
        return self.number[_HALF:-_HALF], _WINDOW / (time[_WINDOW:] - time[:-_WINDOW])

    @property
    def last_speed(self) -> int:
        """The last contact whose speed is known."""
        return self.contacts - _HALF

    def speed_powers(self, first: int, last: int, level: float = _THRESHOLD) -> tuple[Power, Power]:
        """Powers of that speed with the distance, and with the largest force (its own power law of distance).

        Parameters
        ----------
        first, last
            Contacts of the fit.
        level
            Share of a contact's largest force that counts as arrival.
        """
        number, speed = self._speed(self._arrivals(level))
        inside = (number >= first) & (number <= last)
        force = self.force_power(first, last)(number[inside])
        return power(number[inside], speed[inside]), power(force, speed[inside])

    @property
    def place(self) -> Array:
        """Distance of the contacts from the struck end over R*: (contacts,)."""
        return SPACING * self.number

    @property
    def normalised(self) -> Array:
        """Largest force at each contact over E* R*^2 I: (contacts,)."""
        return self.largest / self.peak_unit

    def inverse_constant(self, first: int, last: int) -> float:
        """Mean of (x/R*) F / (E* R*^2 I) over contacts."""
        chosen = slice(first - 1, last)
        return float(np.mean(self.place[chosen] * self.normalised[chosen]))

    @property
    def speed_normalised(self) -> tuple[Array, Array]:
        """Distances over R*, and the speed of the leading disturbance there in R*/tau."""
        number, speed = self.speed
        return SPACING * number, SPACING * self.scales.time * speed

    @cached_property
    def dissipated(self) -> Array:
        """Up to each contact: (contacts,), J."""
        return np.cumsum(self.run.of_contacts("dissipated_energy"))[: self.contacts]


class Pulses:
    """Chains of one material and radius after pulses, and the elastic chain under one of them.

    Attributes
    ----------
    groups
        By impulse, the largest first; within one in rising order of duration.
    elastic
        An elastic chain and the one of the others under the same load.
    chosen
        One of each impulse, with the duration that the source's impulses share.
    weakest
        That of the smallest impulse.
    contacts
        How many all chosen waves have passed.
    """

    def __init__(self, waves: Sequence[PlasticWave], elastic: tuple[PlasticWave, PlasticWave] | None) -> None:
        groups = clustered(waves, "impulse", _SAME)
        self.groups = [sorted(group, key=lambda wave: wave.duration) for group in reversed(groups)]
        self.elastic = elastic
        self.chosen = [min(group, key=lambda wave: abs(wave.duration - _USUAL)) for group in self.groups]
        self.weakest, self.contacts = self.chosen[-1], min(wave.contacts for wave in self.chosen)

    def impulse_power(self, contact: Array) -> Power | None:
        """Power of the leading speed with the impulse, at equal places; None from one impulse."""
        if len(self.chosen) < 2:
            return None
        speed = [float(np.exp(np.mean(np.log(np.interp(contact, *wave.speed))))) for wave in self.chosen]
        return power(np.array([wave.impulse for wave in self.chosen]), np.array(speed))


def collect_pulses(runs: Iterable[ChainRecord], elastic: Sequence[ChainRecord]) -> Pulses | None:
    """The elasto-plastic chains after pulses among runs; of several materials or radii those of the most runs.

    Parameters
    ----------
    elastic
        Elastic chains, among which that under the load of one of the others is looked for.
    """
    alike: dict[tuple[float, float], list[PlasticWave]] = {}
    for run in runs:
        if run.is_pulse and run.force.shape[1] > _FEWEST:
            wave = PlasticWave(run)
            if wave.duration <= _LONGEST and wave.contacts >= _FEWEST and wave.largest[0] > run.law.yield_force:
                alike.setdefault((wave.scales.force, wave.scales.time), []).append(wave)
    most = max(alike.values(), key=len, default=[])
    return Pulses(most, _elastic(elastic, most)) if most else None


def _elastic(runs: Iterable[ChainRecord], waves: Sequence[PlasticWave]) -> tuple[PlasticWave, PlasticWave] | None:
    """An elastic chain and the elasto-plastic one under the same load."""
    for run in runs:
        own = (run.load, run.mass, run.law.effective_modulus)
        for wave in waves:
            same = own == (wave.run.load, wave.run.mass, wave.run.law.effective_modulus)
            if same and run.force.shape[1] > _FEWEST:
                return PlasticWave(run), wave
    return None
