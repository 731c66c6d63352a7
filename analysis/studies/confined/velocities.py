"""Velocities of beads far down a confined row, with and without precompression (thesis figure 6.5)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.chains import confined as figures
from granwave.analysis.measures.signals import Array, first_peak, width
from granwave.analysis.measures.waves.pulses import LENGTH, MEASURES
from granwave.analysis.measures.waves.pulses import theory as solitary_lengths
from granwave.analysis.studies.confined.runs import ConfinedRun, confined_runs, from_thesis
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Confined rows: velocities of beads"
TEXT = (
    "Velocities of beads 100 and 150 with a = 0 and with the largest precompression of the figure, in the source's "
    "units: times sqrt(m_b/k_bb) in SI, which is "
    "1.7063e-6 s for its beads, velocities 1.1375e-4 for 1 m/s. Its axes end at 4.5e-5, and bead 100 moves between "
    "1300 and 1700: "
    "this fixes beads of 15 mm. Without precompression the beads swing on behind the wave; with it there is next to "
    "nothing."
)
BEADS = (100, 150)
_WHERE = "thesis figure 6.5"
_PROGRAM = {  # by a, bead: largest velocity, and when, of the source's model in our second program
    (0.0, 100): (4.00e-5, 1546.0),
    (0.0, 150): (2.85e-5, 2485.0),
    (1.9e-3, 100): (4.08e-5, 1285.0),
    (1.9e-3, 150): (4.07e-5, 1995.0),
}
_TAIL = (60.0, 200.0)  # units of time behind the crest; later, waves come back from the held first bead
_LARGEST = 1.9e-3  # a of the figure
_FLOOR = 0.5  # of the largest velocity, for the first peak
_SHIFT = 1200.0  # of the curves with precompression in the figure


@dataclasses.dataclass(frozen=True, eq=False)
class Pair:
    """A row without precompression, and with the largest one."""

    free: ConfinedRun
    pressed: ConfinedRun

    def curve(self, run: ConfinedRun, bead: int) -> tuple[Array, Array] | None:
        """Time and velocity of a bead in the source's units."""
        found = run.probe(bead, "vz")
        if found is None:
            return None
        unit = float(run.row.thesis_time[0])
        return found[0] / unit, found[1] * unit / float(run.row.bead[0])

    @property
    def curves(self) -> Iterator[tuple[ConfinedRun, int, Array, Array]]:
        """Run, bead, time and velocity of all that were recorded."""
        for run in (self.free, self.pressed):
            for bead in BEADS:
                if (found := self.curve(run, bead)) is not None:
                    yield run, bead, *found


def select(runs: Sequence[FinishedRun]) -> list[Pair]:
    """Select the runs of n = 8 and 1 m/s, if both are there and recorded."""
    known = [run for run in confined_runs(runs) if run.n == 8 and run.velocity == 1 and run.probe(BEADS[0], "vz")]
    known.sort(key=lambda run: run.a)
    if len(known) < 2 or known[0].a:
        return []
    printed = [run for run in known[1:] if from_thesis(run) and math.isclose(run.a, _LARGEST, rel_tol=1e-6)]
    return [Pair(known[0], (printed or known)[-1])]


def rows(pair: Pair) -> Iterator[Row]:
    """Largest velocity of each bead, when, and what is left behind; length of the wave."""
    for run, bead, time, velocity in pair.curves:
        when, largest = first_peak(time, velocity, floor=_FLOOR)
        what = f"bead {bead}, {run.label_of_row}"
        known = _PROGRAM.get((round(run.a, 6), bead)) if from_thesis(run) else None
        values = ((f"Largest velocity times 1e5, {what}", 1e5 * largest), (f"Time of it, {what}", when))
        for (quantity, ours), factor, value in zip(values, (1e5, 1.0), known or (math.nan, math.nan), strict=True):
            remark = f"The source's model in our second program: {factor * value:.5g}." if known else ""
            yield Row(quantity, "", None, ours, _WHERE, remark)
        behind = (time > when + _TAIL[0]) & (time < when + _TAIL[1])
        if behind.any():
            quantity = f"Largest velocity times 1e5, {_TAIL[0]:g} to {_TAIL[1]:g} units behind the crest, {what}"
            yield Row(quantity, "", None, 1e5 * float(np.abs(velocity[behind]).max()), _WHERE, digits=3)
    run = pair.pressed
    found = run.probe(BEADS[0], "vz")
    if found is not None and math.isfinite(run.speed):
        half = width(*found) * run.speed / float(run.row.bead[0])
        length = half * LENGTH / solitary_lengths()[MEASURES[3]]
        yield Row(
            f"Length of the wave, {run.label_of_row}", "D", 5.0, length, "thesis 6.2",
            '"About five"; from the width at half the velocity, as of a solitary wave of 4.97 D. Longer under '
            'precompression.',
        )  # fmt: skip


def pictures(pair: Pair) -> Iterator[Picture]:
    """Velocity against time."""
    curves = [(f"bead {bead}, a = {run.a:.2g}", time, velocity) for run, bead, time, velocity in pair.curves]
    shifts = [_SHIFT if run.a else 0.0 for run, *_ in pair.curves]
    caption = "Velocities of beads 100 and 150 (thesis figure 6.5); curves with precompression 1200 units to the left"
    yield Picture("", caption, figures.bead_velocities(curves, shifts))
