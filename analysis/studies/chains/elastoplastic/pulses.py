"""Runs of elasto-plastic chains after pulses, by impulse (thesis 2.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from granwave.analysis.measures.chains.elastoplastic_pulse import PlasticWave
from granwave.analysis.measures.signals import Array, Power, power
from granwave.analysis.studies.chains.runs import clustered, from_thesis, uniform
from granwave.analysis.studies.runs import FinishedRun

_FEWEST = 30  # contacts that make a study worth while
_USUAL = 12.93  # tau: 10 us for brass of R = 4.76 mm, the duration that the source's impulses share
_LONGEST = 150.0  # tau: what lasts longer is no pulse; the source's longest is 129
_SAME = 5e-3


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

    def __init__(self, waves: Sequence[PlasticWave], elastic: tuple[PlasticWave, PlasticWave] | None) -> None:
        groups = clustered(waves, "impulse", _SAME)
        self.groups = [sorted(group, key=lambda wave: wave.duration) for group in reversed(groups)]
        self.elastic = elastic
        self.chosen = [min(group, key=lambda wave: abs(wave.duration - _USUAL)) for group in self.groups]
        self.weakest, self.contacts = self.chosen[-1], min(wave.contacts for wave in self.chosen)
        self.from_source = from_thesis(self.weakest.run, yielding=True)

    def impulse_power(self, contact: Array) -> Power | None:
        """Power of the leading speed with the impulse, at equal places; None from one impulse."""
        if len(self.chosen) < 2:
            return None
        speed = [float(np.exp(np.mean(np.log(np.interp(contact, *wave.speed))))) for wave in self.chosen]
        return power(np.array([wave.impulse for wave in self.chosen]), np.array(speed))


def collect_pulses(runs: Sequence[FinishedRun]) -> Pulses | None:
    """The elasto-plastic chains after pulses among runs; of several materials or radii those of the most runs."""
    alike: dict[tuple[float, float], list[PlasticWave]] = {}
    for run in uniform(runs, "elastoplastic"):
        if run.is_pulse and run.force.shape[1] > _FEWEST:
            wave = PlasticWave(run)
            if wave.duration <= _LONGEST and wave.contacts >= _FEWEST and wave.largest[0] > run.law.yield_force:
                alike.setdefault((wave.scales.force, wave.scales.time), []).append(wave)
    most = max(alike.values(), key=len, default=[])
    return Pulses(most, _elastic(runs, most)) if most else None


def _elastic(runs: Sequence[FinishedRun], waves: Sequence[PlasticWave]) -> tuple[PlasticWave, PlasticWave] | None:
    """An elastic chain and the elasto-plastic one under the same load."""
    for run in uniform(runs, "hertz"):
        own = (run.load, run.mass, run.law.effective_modulus)
        for wave in waves:
            same = own == (wave.run.load, wave.run.mass, wave.run.law.effective_modulus)
            if same and run.force.shape[1] > _FEWEST:
                return PlasticWave(run), wave
    return None
