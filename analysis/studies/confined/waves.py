"""Waves along confined rows of 6 to 9 small spheres around each contact, against precompression (thesis 6.1, 6.2)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.document.cells import value_cell
from granwave.analysis.document.model import Cell, Table
from granwave.analysis.figures.chains import confined as figures
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.confined.geometry import Row as Geometry
from granwave.analysis.measures.confined.symmetric import Wave, leading_wave
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.confined.printed import printed_rows, speed_rows
from granwave.analysis.studies.confined.reference import OFFSET, reference_of
from granwave.analysis.studies.confined.runs import (
    CONTACTS,
    FORCE,
    ConfinedRun,
    confined_runs,
    decay_of,
    from_thesis,
    speed_of,
    symmetric_waves,
)
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.tables import numeric, table_of

TITLE = "Confined rows: waves and precompression"
WHERE = "equations of symmetric motion"
_NEAR_SOLITARY = 2e-4  # decay per contact
_FRACTIONS = np.arange(5.5, 10.01, 0.125)
_LAST_OF_FRACTIONS = 110  # contacts: decays are uniform from the 60th on
_DIGITS = 3  # of a decay
_LEAST_DECAY = 1e-5  # per contact: peaks that are good to 1e-4 say nothing about less


@dataclasses.dataclass(frozen=True, eq=False)
class Waves:
    """Rows of one bead and material, struck alike: by n and a."""

    runs: list[ConfinedRun]

    @cached_property
    def theory(self) -> Wave:
        """The same in symmetric motion."""
        return symmetric_waves(self.runs)

    @property
    def by_n(self) -> dict[int, list[ConfinedRun]]:
        """Runs of each n, by rising a."""
        return {n: [run for run in self.runs if run.n == n] for n in sorted({run.n for run in self.runs})}

    @cached_property
    def fractions(self) -> tuple[Array, Array]:
        """Values of n, whole and not, and the decay of the equations without precompression."""
        one = self.runs[0].row
        row = Geometry.fitting(_FRACTIONS, one.bead, 0.0, one.modulus, one.density, one.small_density / one.density)
        wave = leading_wave(row, self.runs[0].velocity, self.runs[0].struck, _LAST_OF_FRACTIONS)
        return _FRACTIONS, np.array([decay_of(force) for force in wave.force])


def select(runs: Sequence[FinishedRun]) -> list[Waves]:
    """Elastic rows of one density, struck alike, of several n or a."""
    groups: dict[tuple, dict[tuple[int, float], ConfinedRun]] = {}
    for run in confined_runs(runs):
        row = run.row
        key = (row.bead[0], row.modulus[0], row.density[0], row.small_density[0], run.velocity, run.struck)
        groups.setdefault(key, {}).setdefault((run.n, run.a), run)
    chosen = [[found[key] for key in sorted(found)] for found in groups.values()]
    return [Waves(found) for found in chosen if len({(run.n, round(run.a, 9)) for run in found}) > 3]


def text(waves: Waves) -> str:
    """Describe the rows, and why the source's peaks are larger."""
    one = waves.runs[0]
    return (
        f"Beads of {1e3 * one.row.bead[0]:g} mm in a row, n small spheres around each contact, in a rigid tube whose "
        "radius "
        f"then shrinks by delta, a = 2 delta/D; bead {one.struck} is struck at {one.velocity:g} m/s. Forces over E* "
        "R*^2. "
        "Theory: the equations of symmetric motion, solved apart from LAMMPS with the true geometry. The source's "
        "model differs: a wall softer than any of Hertz's (factor 1.2; inside the tube 1.44 to 1.48), no contacts in "
        "the rings "
        "and directions that do not turn. For n = 8 and a = 1.9e-3 its force at contact 201 is 1.343e-4; the moving "
        "geometry makes it 1.342, the ring 1.293, the factor of a flat wall 1.267 and that of the tube 1.247. The "
        "curves "
        "of the source are pictures without numbers: its axes end at 3e-4, and all four of its statements hold, in "
        "either "
        "model: rapid decay for n = 7 and 8 that precompression takes away, hardly any for n = 6 and 9, less force "
        "and more speed with a. "
        "Contacts count from 1."
    )


def rows(waves: Waves) -> Iterator[Row]:
    """Numbers of the rows, static balance, and the wave of each run against the equations."""
    if all(from_thesis(run) for run in waves.runs):
        yield from printed_rows([run.row for run in waves.runs], *waves.fractions)
        yield from speed_rows(waves.runs)
    for k, run in enumerate(waves.runs):
        yield from _balance(run)
        yield from _wave(run, waves.theory.force[k], waves.theory.time[k])


def _balance(run: ConfinedRun) -> Iterator[Row]:
    if run.a:
        where = "balance of a small sphere: wall = ring + two beads"
        yield Row(
            f"Small spheres moved in, {run.label_of_row}", "µm", None, 1e6 * run.inward, where, "",
            1e6 * float(run.row.inward[0]), True,
        )  # fmt: skip


def _wave(run: ConfinedRun, force: Array, time: Array) -> Iterator[Row]:
    unit = FORCE / run.row.force_unit[0]
    for contact in CONTACTS:
        if contact <= min(run.passed, len(force)):
            yield Row(
                f"Peak force times 1e4 at contact {contact}, {run.label_of_row}", "", None, unit * run.peak(contact),
                WHERE, "", unit * float(force[contact - 1]), True,
            )  # fmt: skip
    last = min(run.passed, len(time))
    if math.isfinite(run.speed):
        theory = speed_of(time[:last], float(run.row.bead[0]))
        yield Row(f"Speed, {run.label_of_row}", "m/s", None, run.speed, WHERE, "", theory, True)
    if math.isfinite(run.decay):
        theory = decay_of(force[:last])
        remark = "" if theory > _LEAST_DECAY else "No decay that could be told from errors of the peaks."
        what = f"Decay per contact, {run.label_of_row}"
        yield Row(what, "", None, run.decay, WHERE, remark, theory, theory > _LEAST_DECAY, _DIGITS)


def tables(waves: Waves) -> Iterator[Table]:
    """Ours beside our second program and the model of the source."""
    lines = []
    for run in waves.runs:
        both = reference_of(run.n, run.a) if from_thesis(run) and run.velocity == 1 else None
        if both is None:
            continue
        thesis, true = both
        unit = FORCE / run.row.force_unit[0]
        ours = [unit * run.peak(contact + OFFSET) for contact in CONTACTS]
        values = [run.n, run.a, *ours, *true.peaks, *thesis.peaks, run.speed, true.speed, thesis.speed, run.decay,
                  true.decay, thesis.decay]  # fmt: skip
        lines.append([value_cell(value) if math.isfinite(value) else Cell("-") for value in values])
    if lines:
        at = [contact + OFFSET for contact in CONTACTS]
        heads = [f"{who} at {one}" for who in ("ours", "program", "thesis model") for one in at]
        heads += [f"{what}, {who}" for what in ("speed (m/s)", "decay") for who in ("ours", "program", "thesis model")]
        caption = (
            "Peak forces times 1e4, speed and decay beside our second program, for the same rows and for the "
            "source's model. "
            "Its run stopped at some 6 ms: for n = 6, and n = 7 with a = 0, its last force is that of the contact "
            "where the "
            "wave was then (129, 142, 154, and 185)."
        )
        yield table_of(caption, numeric("n", "a", *heads), lines)


def verdict(waves: Waves) -> Iterator[str]:
    """Say what precompression does to each ring."""
    for n, runs in waves.by_n.items():
        known = [run for run in runs if math.isfinite(run.decay)]
        if len(known) > 1:
            first, last = known[0], known[-1]
            kept = "hardly decays" if last.decay < _NEAR_SOLITARY else "decays"
            yield (
                f"n = {n}: the wave {kept} ({number(last.decay)} per contact) at a = {last.a:.2g}, "
                f"{number(first.decay)} "
                f"at a = {first.a:.2g}; its speed rises from {first.speed:.0f} to {last.speed:.0f} m/s."
            )


def pictures(waves: Waves) -> Iterator[Picture]:
    """Peak forces along the rows, speed, and decay against n."""
    series = {f"n = {n}": [(f"a = {run.a:.3g}", *run.profile) for run in runs] for n, runs in waves.by_n.items()}
    yield Picture("", "Peak forces of the contacts of beads (thesis figures 6.2 and 6.3)", figures.peak_forces(series))
    curves = [
        (f"n = {n}", np.array([run.a for run in runs]), np.array([run.speed for run in runs]))
        for n, runs in waves.by_n.items()
        if len(runs) > 1
    ]
    one = waves.runs[0].row
    unit = float(one.bead[0] / one.thesis_time[0])
    if curves:
        yield Picture("_speed", "Speed against precompression (thesis figure 6.4)", figures.speeds(curves, unit))
    free = [run for run in waves.runs if not run.a and math.isfinite(run.decay)]
    if free:
        theory = ("equations, any n", *waves.fractions)
        points = ("simulation", np.array([run.n for run in free]), np.array([run.decay for run in free]))
        caption = "Decay without precompression against the number of small spheres (thesis figure 6.6)"
        drawing = figures.decays(theory, points, "Small spheres around a contact, n", column="n")
        yield Picture("_decay", caption, drawing)
