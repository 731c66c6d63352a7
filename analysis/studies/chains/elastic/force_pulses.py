"""Runs with a rectangle of force on the first bead of an elastic chain (thesis 4.1)."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.measures.chains.force_pulse import ForcePulse
from granwave.analysis.measures.chains.records import clustered
from granwave.analysis.studies.chains.runs import uniform
from granwave.analysis.studies.runs import FinishedRun

ALIKE = 1e-3
_FEWEST_DURATIONS = 3
_FEWEST_CONTACTS = 80


def force_pulses(runs: Sequence[FinishedRun]) -> list[ForcePulse]:
    """Pulses of runs that go on after the force has ended and stop before the end of the chain."""
    return [
        ForcePulse(run) for run in uniform(runs, "hertz")
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
