"""A bilinear chain under a force that lasts: plateaus between fronts, beside thesis 4.2.2 (table 4.1, Fig. 4.9)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.style import Drawing, new_figure
from granwave.analysis.studies.chains.bilinear import LongLoad, Spring, long_load, spring_of
from granwave.analysis.studies.chains.bilinear_figures import COLOURS, FORCE, VELOCITY
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.chains.scales import ChainScales, of_thesis
from granwave.analysis.studies.study import Picture, Row, Study

Array = NDArray[np.float64]

_LONG = 50.0  # 1/sqrt(k/m): the shortest load with plateaus
_INSTANTS = (0.8, 1.2)  # of T: with one front, and with two
_LAST = 1.15  # of T_t: with the fronts apart again
_INNER = (0.2, 0.8)  # of a plateau: where it is measured
_WHERE = "thesis 4.2.2, table 4.1"
_SOURCE = (8e3, 2.5e-3, 0.8)  # N, s, beta


@dataclasses.dataclass(frozen=True, eq=False)
class HeldLoad:
    """One run, and what the closed forms say of it."""

    run: ChainRun

    @cached_property
    def spring(self) -> Spring:
        """Contact and bead."""
        return spring_of(self.run)

    @cached_property
    def theory(self) -> LongLoad:
        """Closed forms."""
        return long_load(self.spring, self.run.load.largest, self.run.load.lasts)

    @property
    def times(self) -> tuple[float, float, float]:
        """Under load; after it; after the fronts have met; s. For the source's case its 2, 3 and 5.2 ms."""
        early, late = (share * self.run.load.lasts for share in _INSTANTS)
        return early, late, _LAST * self.theory.meeting_time

    @property
    def reaches(self) -> bool:
        """The record and the chain go as far as is measured."""
        last = self.times[-1]
        apart = self.times[1] < 0.9 * self.theory.meeting_time
        return apart and self.run.time[-1] >= last and self.run.velocity.shape[1] > self.spring.rate * last + 20

    @property
    def from_source(self) -> bool:
        """It is the case of table 4.1."""
        load = self.run.load
        own = (load.largest, load.lasts, self.spring.beta)
        return of_thesis(self.run) and all(math.isclose(*pair, rel_tol=1e-6) for pair in zip(own, _SOURCE, strict=True))

    def row(self, instant: int) -> int:
        """Of the record nearest to one of `times`."""
        return int(np.argmin(np.abs(self.run.time - self.times[instant])))

    def plateau(self, instant: int) -> slice:
        """Beads in the inner part of the plateau behind the last front but the leading one, or behind that alone."""
        time, c, cu = self.times[instant], self.spring.rate, self.spring.unloading_rate
        if instant == 0:
            start, end = 0.0, c * time
        elif instant == 1:
            start, end = 0.0, cu * (time - self.run.load.lasts)
        else:
            met, since = self.theory.meeting / self.spring.diameter, time - self.theory.meeting_time
            start, end = met - cu * since, met + c * since
        return slice(*(int(start + share * (end - start)) for share in _INNER))

    def velocity(self, instant: int) -> float:
        """Median on the plateau, m/s."""
        return float(np.median(self.run.velocity[self.row(instant), self.plateau(instant)]))

    def force(self, instant: int) -> float:
        """Median on the plateau, N."""
        return float(np.median(self.run.force[self.row(instant), self.plateau(instant)]))

    @cached_property
    def largest(self) -> Array:
        """Largest force ever at each contact, N."""
        return self.run.of_contacts("peak_force")

    @property
    def meeting(self) -> float:
        """Where the largest force falls half-way from F_1 to F_2, m from the centre of bead 1."""
        level = (self.force(0) + self.force(2)) / 2
        k = int(np.flatnonzero(self.largest < level)[0])
        return float(np.interp(-level, -self.largest[k - 1 : k + 1], self.run.place[k - 1 : k + 1]))


def long_loads(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """The studies of bilinear chains under a force that lasts, one for each run."""
    held = [
        HeldLoad(run)
        for run in uniform(runs, "bilinear")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.lasts * spring_of(run).rate > _LONG
    ]
    found = [one for one in held if one.reaches]
    for number, one in enumerate(found, start=1):
        load, name = one.run.load, "bilinear-long-load" + (f"-{number}" if len(found) > 1 else "")
        yield Study(
            name,
            "Bilinear chain under a long load" + (f" ({one.run.label})" if len(found) > 1 else ""),
            f"{load.largest:.4g} N on the first bead for {load.lasts * 1e3:.4g} ms, beta {one.spring.beta:g}. Plateaus "
            "are medians over their inner six tenths at three instants: under load, after it, and after the trailing "
            "front has caught up with the leading one. Theory is thesis 4.36 to 4.39 with the stated constants.",
            tuple(_rows(one)),
            (
                Picture(
                    name.replace("-", "_"),
                    "Contact forces and bead velocities at three instants, with the largest force so far; dotted: "
                    "closed forms (thesis Fig. 4.9)",
                    _drawing(one),
                ),
            ),
        )


def _rows(one: HeldLoad) -> Iterator[Row]:
    theory = one.theory
    #        quantity, unit, numerical and predicted as printed, ours, theory, remarks on both
    table = (
        ("v1, velocity behind the leading front", "m/s", 26.4, 26.18, one.velocity(0), theory.velocity, "", ""),
        ("vt, velocity behind the trailing front", "m/s", 14.6, 14.47, one.velocity(1), theory.trailing, "", ""),
        ("v2, velocity once the fronts have met", "m/s", 14.75, 14.84, one.velocity(2), theory.later,
         "Printed: 14.5 to 15, near vt. Only about 10 m/s agree with the printed F2, as F2 D = m v2 c.",
         "4.39 as printed gives the theory value, not 14.84 m/s."),
        ("F2, force once the fronts have met", "N", 3060, 3056, one.force(2), theory.later_force, "", ""),
        ("xt, where the fronts meet", "m", 0.333, 0.342, one.meeting, theory.meeting,
         "The print is ten times too small: at 3 ms, in Fig. 4.9, the fronts are still apart, one near 2.3 m.",
         "The print is ten times too small."),
    )  # fmt: skip
    for quantity, unit, numerical, _, ours, expected, remark, _ in table:
        source = numerical if one.from_source else None
        yield Row(quantity, unit, source, ours, _WHERE, remark if one.from_source else "", expected)
    if one.from_source:
        for quantity, unit, _, predicted, _, expected, _, remark in table:
            name = quantity.split(",")[0]
            yield Row(f"{name} as predicted by 4.36 to 4.39", unit, predicted, expected, _WHERE, remark, expected)
    yield Row("F1, force behind the leading front under load", "N", theory.force if one.from_source else None,
              one.force(0), "thesis 4.2.2", "", theory.force)  # fmt: skip
    over = float(one.largest.max()) / theory.force
    remark = (
        "The first contacts overshoot by inertia. The axis of Fig. 4.9(a), to 0.14 E*R*^2, would be six times the load "
        "and is not compared."
    )
    yield Row("Largest force of all over the load", "", None, over, "thesis 4.2.2", remark if one.from_source else "")


def _drawing(one: HeldLoad) -> Drawing:
    run, scales, theory = one.run, ChainScales(one.run), one.theory
    figure = new_figure(2.8, 7.0)
    left, right = figure.subplots(1, 2)
    shown = int(1.15 * one.spring.rate * one.times[-1])
    contact, bead = np.arange(1, run.force.shape[1] + 1), np.arange(1, run.velocity.shape[1] + 1)
    largest = one.largest / scales.force
    columns: dict[str, ArrayLike] = {"bead": bead, "contact": contact, "largest_force_normalised": largest}
    left.plot(contact[:shown], largest[:shown], color="black", linewidth=0.9, label="largest ever")
    for instant, colour in zip(range(3), COLOURS, strict=False):
        time, row = run.time[one.row(instant)], one.row(instant)
        force, velocity = run.force[row] / scales.force, run.velocity[row] / scales.velocity
        left.plot(contact[:shown], force[:shown], color=colour, linewidth=0.9, label=f"{time * 1e3:.3g} ms")
        right.plot(bead[:shown], velocity[:shown], color=colour, linewidth=0.9, label=f"{time * 1e3:.3g} ms")
        columns |= {f"force_at_{time:.4g}_s_normalised": force, f"velocity_at_{time:.4g}_s_normalised": velocity}
    for axes, lines, scale in (
        (left, (("$F_1$", theory.force), ("$F_2$", theory.later_force)), scales.force),
        (right, (("$v_1$", theory.velocity), ("$v_t$", theory.trailing), ("$v_2$", theory.later)), scales.velocity),
    ):
        for name, value in lines:
            axes.axhline(value / scale, color="black", linestyle=":", linewidth=0.8)
            axes.text(0.995 * shown, value / scale, name, ha="right", va="bottom")
        axes.set_xlim(0, shown)
    left.set_ylim(0, 1.7 * float(largest.max()))
    right.set_ylim(0, 1.7 * theory.velocity / scales.velocity)
    left.set_xlabel("Contact")
    left.set_ylabel(FORCE)
    right.set_xlabel("Bead")
    right.set_ylabel(VELOCITY)
    left.legend(ncols=2, loc="upper right")
    right.legend(ncols=2, loc="upper right")
    return Drawing(figure, columns)
