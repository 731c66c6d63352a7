"""Rectangles of force on the first bead of an elastic chain of like beads (thesis 4.1).

Hertz's chain has no scale of its own: in the units of `ChainScales` a pulse of impulse I = A T is one point of one
curve, F_peak/I^(6/5) against A/I^(6/5) (thesis Fig. 4.3), and the duration at which one wave becomes a train is
T = q A^(-1/6) (Fig. 4.1). The source says neither how a train is recognised nor what q is. Here a pulse is a train if
the second peak of the force at one contact is at least `SECOND` of the first; the contact is at `_SHARE` of the chain,
so that a second wave of that height still passes it before the first one comes to the end.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cached_property

from granwave.analysis.measures.signals import Array, maxima
from granwave.analysis.studies.chains.runs import ChainRun, chains, uniform
from granwave.analysis.studies.chains.scales import ChainScales, passed, undisturbed
from granwave.analysis.studies.runs import FinishedRun

SECOND = 0.01  # of the first peak: from then on a train
FEWEST_DURATIONS = 3
ALIKE = 1e-3
_SHARE = 0.35
_FEWEST_CONTACTS = 80


@dataclasses.dataclass(frozen=True, eq=False)
class ForcePulse:
    """A rectangle of force on the first bead, and what became of it; all in normalised units."""

    run: ChainRun

    @cached_property
    def amplitude(self) -> float:
        """A/(E* R*^2)."""
        return self.run.load.largest / ChainScales(self.run).force

    @cached_property
    def duration(self) -> float:
        """T/tau."""
        return self.run.load.lasts / ChainScales(self.run).time

    @cached_property
    def impulse(self) -> float:
        """A T."""
        return self.amplitude * self.duration

    @property
    def reduced(self) -> float:
        """A/I^(6/5)."""
        return float(self.amplitude / self.impulse**1.2)

    @cached_property
    def peak(self) -> float:
        """Force at the last contact that the leading wave has passed."""
        force = self.run.of_contacts("peak_force")[passed(self.run) - 1]
        return float(force) / ChainScales(self.run).force

    @property
    def contact(self) -> int:
        """Contact, from 1, where waves are counted."""
        return round(_SHARE * self.run.force.shape[1])

    @property
    def signal(self) -> Array:
        """Force at that contact: (n_times,), N."""
        return self.run.force[:, self.contact - 1]

    @cached_property
    def waves(self) -> Array:
        """Heights of the successive peaks at that contact over the first one's."""
        heights = self.signal[maxima(self.signal)]
        return heights / heights[0] if len(heights) else heights

    @property
    def second(self) -> float:
        """The highest of the later peaks over the first one; 0 without any."""
        return float(self.waves[1:].max(initial=0.0))


def force_pulses(runs: Sequence[FinishedRun]) -> list[ForcePulse]:
    """Pulses of runs that go on after the force has ended and stop before the end of the chain."""
    return [
        ForcePulse(run) for run in uniform(chains(runs), "hertz")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.spheres == 1
        and run.load.lasts < run.time[-1] and passed(run) >= _FEWEST_CONTACTS and undisturbed(run)
    ]  # fmt: skip


def grouped(pulses: Sequence[ForcePulse], key: str) -> list[list[ForcePulse]]:
    """Pulses of one amplitude or impulse, in rising order of it, each group by duration; groups of enough alone.

    Parameters
    ----------
    key
        ``amplitude`` or ``impulse``.
    """
    groups: list[list[ForcePulse]] = []
    for pulse in sorted(pulses, key=lambda pulse: float(getattr(pulse, key))):
        if not groups or getattr(pulse, key) > (1 + ALIKE) * getattr(groups[-1][0], key):
            groups.append([])
        groups[-1].append(pulse)
    ordered = [sorted(group, key=lambda pulse: pulse.duration) for group in groups]
    return [group for group in ordered if len(group) >= FEWEST_DURATIONS]
