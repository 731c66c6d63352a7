"""Elasto-plastic chains after a pulse, in the units of the chain (thesis 2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.measures.hertz_chain import ChainScales
from granwave.analysis.measures.line_pulse import LinePulse
from granwave.analysis.measures.signals import Array, Power, power
from granwave.analysis.studies.chains.runs import ChainRun, chain_runs, clustered, uniform
from granwave.analysis.studies.chains.scales import impulse_of, is_pulse, of_thesis
from granwave.analysis.studies.runs import FinishedRun

_FEWEST = 30  # contacts that make a study worth while
_USUAL = 12.93  # tau: 10 us for brass of R = 4.76 mm, the duration that the source's impulses share
_LONGEST = 150.0  # tau: what lasts longer is no pulse; the source's longest is 129
_SAME = 5e-3


class Wave(LinePulse):
    """One elasto-plastic chain after a pulse.

    Attributes
    ----------
    scales
        Units of the chain.
    impulse, duration
        Of the load, in units of E* R*^2 tau, and in tau.
    peak_unit, energy_unit
        E* R*^2 times that impulse, which peak forces are given in, N; F_y alpha_y, J.
    name
        The load in a few characters.
    """

    def __init__(self, run: ChainRun) -> None:
        super().__init__(run.time, run.force, run.of_contacts("peak_force"))
        self.run, self.scales, load = run, ChainScales(run), run.load
        self.impulse, self.duration = impulse_of(run) / self.scales.impulse, load.lasts / self.scales.time
        self.peak_unit, self.energy_unit = self.scales.force * self.impulse, run.law.yield_force * run.law.yield_overlap
        force = f"{load.largest / 1e3:g} kN, {load.lasts * 1e6:.3g} µs"
        self.name = f"{load.velocity:g} m/s" if load.kind == "impact" else force

    @property
    def normalised(self) -> Array:
        """Largest force at each contact over E* R*^2 I: (contacts,)."""
        return self.largest / self.peak_unit

    def inverse_constant(self, first: int, last: int) -> float:
        """Mean of (x/R*) F / (E* R*^2 I) over contacts."""
        chosen = slice(first - 1, last)
        return float(np.mean(4 * self.number[chosen] * self.normalised[chosen]))

    @property
    def speed_normalised(self) -> tuple[Array, Array]:
        """Contacts, and the speed of the leading disturbance there in R*/tau."""
        number, speed = self.speed
        return number, 4 * self.scales.time * speed

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
    from_source
        The beads are those of the thesis.
    """

    def __init__(self, waves: Sequence[Wave], elastic: tuple[Wave, Wave] | None) -> None:
        groups = clustered(waves, "impulse", _SAME)
        self.groups: list[list[Wave]] = [sorted(group, key=lambda wave: wave.duration) for group in reversed(groups)]
        self.elastic = elastic
        self.chosen = [min(group, key=lambda wave: abs(wave.duration - _USUAL)) for group in self.groups]
        self.weakest, self.contacts = self.chosen[-1], min(wave.contacts for wave in self.chosen)
        self.from_source = of_thesis(self.weakest.run)

    def impulse_power(self, contact: Array) -> Power | None:
        """Power of the leading speed with the impulse, at equal places; None from one impulse."""
        if len(self.chosen) < 2:
            return None
        speed = [float(np.exp(np.mean(np.log(np.interp(contact, *wave.speed))))) for wave in self.chosen]
        return power(np.array([wave.impulse for wave in self.chosen]), np.array(speed))


def collect_pulses(runs: Sequence[FinishedRun]) -> Pulses | None:
    """The elasto-plastic chains after pulses among runs; of several materials or radii those of the most runs."""
    long = [run for run in uniform(chain_runs(runs), "elastoplastic") if run.force.shape[1] > _FEWEST]
    alike: dict[tuple[float, float], list[Wave]] = {}
    for wave in (Wave(run) for run in long if is_pulse(run)):
        if wave.duration <= _LONGEST and wave.contacts >= _FEWEST and wave.largest[0] > wave.run.law.yield_force:
            alike.setdefault((wave.scales.force, wave.scales.time), []).append(wave)
    most = max(alike.values(), key=lambda waves: len(waves), default=[])
    return Pulses(most, _elastic(chain_runs(runs), most)) if most else None


def _elastic(runs: Sequence[ChainRun], waves: Sequence[Wave]) -> tuple[Wave, Wave] | None:
    """An elastic chain and the elasto-plastic one under the same load."""
    for run in uniform(runs, "hertz"):
        for wave in waves:
            same = run.load == wave.run.load and run.mass == wave.run.mass
            if same and run.force.shape[1] > _FEWEST and run.law.effective_modulus == wave.run.law.effective_modulus:
                return Wave(run), wave
    return None
