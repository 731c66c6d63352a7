"""A rectangle of force on the first bead of an elastic chain of like beads (thesis 4.1).

Hertz's chain has no scale of its own: in the units of `ChainScales` a pulse of impulse I = A T is one point of one
curve, F_peak/I^(6/5) against A/I^(6/5) (thesis Fig. 4.3), and the duration at which one wave becomes a train is
T = q A^(-1/6) (Fig. 4.1). The source says neither how a train is recognised nor what q is. Here a pulse is a train if
the second peak of the force at one contact is at least `SECOND` of the first; the contact is at `_SHARE` of the chain,
so that a second wave of that height still passes it before the first one comes to the end.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from granwave.analysis.measures.chains.groups import clustered
from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import Array, maxima

ALIKE = 1e-3
SECOND = 0.01  # of the first peak: from then on a train
_SHARE = 0.35
_FEWEST_DURATIONS = 3
_FEWEST_CONTACTS = 80


class ForcePulse:
    """A rectangle of force on the first bead, and what became of it.

    Attributes
    ----------
    amplitude, duration, impulse
        A/(E* R*^2), T/tau, and their product.
    reduced, reduced_peak
        A/I^(6/5) and F_peak/I^(6/5).
    peak
        Force over E* R*^2 at the last contact that the leading wave has passed.
    contact, signal
        Contact, from 1, where waves are counted, and its force: (n_times,), N.
    first_peak
        Time of the first peak there, s.
    waves
        Heights of the successive peaks there over the first one's.
    second
        The highest of the later ones; 0 without any.
    """

    def __init__(self, run: ChainRecord) -> None:
        self.run, scales = run, run.scales
        self.amplitude, self.duration = run.load.largest / scales.force, run.load.lasts / scales.time
        self.impulse = self.amplitude * self.duration
        self.peak = float(run.of_contacts("peak_force")[run.passed - 1]) / scales.force
        self.reduced, self.reduced_peak = self.amplitude / self.impulse**1.2, self.peak / self.impulse**1.2
        self.contact = round(_SHARE * run.force.shape[1])
        self.signal: Array = run.force[:, self.contact - 1]
        places = maxima(self.signal)
        self.first_peak = float(run.time[places[0]])
        self.waves: Array = self.signal[places] / self.signal[places[0]]
        self.second = float(self.waves[1:].max(initial=0.0))


def force_pulses(runs: Iterable[ChainRecord]) -> list[ForcePulse]:
    """Pulses of elastic chains that go on after the force has ended and stop before the end of the chain."""
    return [
        ForcePulse(run) for run in runs
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.spheres == 1
        and run.load.lasts < run.time[-1] and run.passed >= _FEWEST_CONTACTS and run.undisturbed
    ]  # fmt: skip


def grouped(pulses: Sequence[ForcePulse], key: str) -> list[list[ForcePulse]]:
    """Pulses of one amplitude or impulse, in rising order of it, each group by duration; groups of enough alone.

    Parameters
    ----------
    key
        ``amplitude`` or ``impulse``.
    """
    ordered = [sorted(group, key=lambda pulse: pulse.duration) for group in clustered(pulses, key, ALIKE)]
    return [group for group in ordered if len(group) >= _FEWEST_DURATIONS]
