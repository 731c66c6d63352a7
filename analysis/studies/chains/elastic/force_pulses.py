"""Runs with a rectangle of force on the first bead of an elastic chain (thesis 4.1)."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.measures.chains.force_pulse import ForcePulse
from granwave.analysis.studies.chains.runs import uniform
from granwave.analysis.studies.runs import FinishedRun

_FEWEST_CONTACTS = 80


def force_pulses(runs: Sequence[FinishedRun]) -> list[ForcePulse]:
    """Pulses of runs that go on after the force has ended and stop before the end of the chain."""
    return [
        ForcePulse(run) for run in uniform(runs, "hertz")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.spheres == 1
        and run.load.lasts < run.time[-1] and run.passed >= _FEWEST_CONTACTS and run.undisturbed
    ]  # fmt: skip
