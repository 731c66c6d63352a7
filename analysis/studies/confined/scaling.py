"""Similarity of waves in confined rows: velocity and precompression that go together (thesis 6.11)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

from granwave.analysis.figures.chains import confined as figures
from granwave.analysis.studies.confined.runs import ConfinedRun, confined_runs, from_thesis
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Confined rows: similar waves"
TEXT = (
    "Forces of Hertz have no length of their own: with velocities v, displacements v^(4/5), and so the "
    "precompression a, forces "
    "v^(6/5) and speeds v^(1/5) the motion is the same (6.11). The source strikes at 2 m/s with the same a and with "
    "one that goes along. "
    "The moving geometry has a length, and breaks the similarity by some 1e-3."
)
_WHERE = "thesis 6.11"
_AT = (100, 200)  # contacts


@dataclasses.dataclass(frozen=True, eq=False)
class Scaled:
    """A row, the same at another velocity with the precompression that goes along, and with the same one."""

    first: ConfinedRun
    similar: ConfinedRun
    same: ConfinedRun | None

    @property
    def ratio(self) -> float:
        """Ratio of the velocities."""
        return self.similar.velocity / self.first.velocity


def select(runs: Sequence[FinishedRun]) -> list[Scaled]:
    """Rows with one that is similar to them, precompressed ones alone."""
    pressed = [run for run in confined_runs(runs) if run.a]
    found = []
    for first in pressed:
        for other in pressed:
            ratio = other.velocity / first.velocity
            if ratio > 1 and _alike(first, other) and math.isclose(other.a, first.a * ratio**0.8, rel_tol=1e-3):
                kept = [
                    run
                    for run in pressed
                    if _alike(first, run) and run.velocity == other.velocity and math.isclose(run.a, first.a)
                ]
                found.append(Scaled(first, other, kept[0] if kept else None))
    return found


def _alike(first: ConfinedRun, other: ConfinedRun) -> bool:
    names = ("n", "bead", "small", "density", "small_density", "modulus")
    return first.struck == other.struck and all(
        getattr(first.row, name)[0] == getattr(other.row, name)[0] for name in names
    )


def rows(found: Scaled) -> Iterator[Row]:
    """Powers of force and speed, and what is lost where a is kept."""
    first, similar, same, ratio = found.first, found.similar, found.same, found.ratio
    if from_thesis(first) and first.velocity == 1:
        unit = float(first.row.thesis_time[0] / first.row.bead[0])
        yield Row(
            "Velocity v of the smaller impact in the legend", "", 2.56e-8, None, "thesis figure 6.8",
            "v D sqrt(m_b/k_bb) of 1 m/s in place of v/D sqrt(m_b/k_bb): multiplied by D.", unit,
        )  # fmt: skip
        yield Row(
            f"a that goes along with {similar.velocity:g} m/s", "", 8.4e-4, similar.a, "thesis figure 6.8",
            "Theory: 2^0.8 times 4.8e-4.", 2**0.8 * 4.8e-4,
        )  # fmt: skip
    for contact in _AT:
        if contact <= min(first.passed, similar.passed):
            power = math.log(similar.peak(contact) / first.peak(contact)) / math.log(ratio)
            what = f"Power of the peak force with the velocity, contact {contact}, n = {first.n}"
            yield Row(what, "", 1.2, power, _WHERE, "", 6 / 5)
    power = math.log(similar.speed / first.speed) / math.log(ratio)
    yield Row(f"Power of the speed with the velocity, n = {first.n}", "", 0.2, power, _WHERE, "", 1 / 5)
    last = _AT[-1]
    if same is not None and last <= min(first.passed, same.passed):
        lost = 1 - same.peak(last) / first.peak(last) / ratio**1.2
        yield Row(
            f"F/v^1.2 at contact {last} with a kept: lower by", "%", None, 100 * lost, "thesis figure 6.8",
            "The source: the curves do not coincide. For the faster wave the same a is less.",
        )  # fmt: skip


def pictures(found: Scaled) -> Iterator[Picture]:
    """Peak force over v^(6/5)."""
    runs = [run for run in (found.first, found.same, found.similar) if run is not None]
    curves = [
        (f"{run.velocity:g} m/s, a = {run.a:.3g}", run.profile[0],
         run.profile[1] * run.row.force_unit[0] / run.velocity**1.2)
        for run in runs
    ]  # fmt: skip
    caption = "Peak force over the power 6/5 of the velocity (thesis figure 6.8)"
    yield Picture("", caption, figures.scaled_forces(curves))
