"""A bilinear chain under a force that lasts: plateaus between fronts, beside thesis 4.2.2 (table 4.1, Fig. 4.9)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.curves import COLOURS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.hertz_chain import ChainScales
from granwave.analysis.studies.chains.bilinear import FORCE, VELOCITY, LongLoad, spring_of
from granwave.analysis.studies.chains.runs import ChainRun, chain_runs, uniform
from granwave.analysis.studies.chains.scales import of_thesis
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Bilinear chain under a long load"
_LONG = 50.0  # 1/sqrt(k/m): the shortest load with plateaus
_INSTANTS = (0.8, 1.2)  # of T: with one front, and with two
_LAST = 1.15  # of T_t: with the fronts apart again
_INNER = (0.2, 0.8)  # of a plateau: where it is measured
_WHERE = "thesis 4.2.2, table 4.1"
_SOURCE = (8e3, 2.5e-3, 0.8)  # N, s, beta


class HeldLoad:
    """One run, and what the closed forms say of it.

    Attributes
    ----------
    spring
        Contact and bead.
    theory
        Closed forms.
    times
        Under load; after it; after the fronts have met; s. For the source's case its 2, 3 and 5.2 ms.
    largest
        Largest force ever at each contact: (n_contacts,), N.
    """

    def __init__(self, run: ChainRun) -> None:
        self.run, self.spring, self.largest = run, spring_of(run), run.of_contacts("peak_force")
        self.theory = LongLoad(self.spring, run.load.largest, run.load.lasts)
        early, late = (share * run.load.lasts for share in _INSTANTS)
        self.times = early, late, _LAST * self.theory.meeting_time

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
        """Row of the record nearest to one of `times`."""
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

    @property
    def meeting(self) -> float:
        """Where the largest force falls half-way from F_1 to F_2, m from the centre of bead 1."""
        level = (self.force(0) + self.force(2)) / 2
        k = int(np.flatnonzero(self.largest < level)[0])
        return float(np.interp(-level, -self.largest[k - 1 : k + 1], self.run.place[k - 1 : k + 1]))


def select(runs: Sequence[FinishedRun]) -> list[HeldLoad]:
    """Chains under a force that lasts, long enough to see its fronts meet; each by itself."""
    held = [
        HeldLoad(run) for run in uniform(chain_runs(runs), "bilinear")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.lasts * spring_of(run).rate > _LONG
    ]  # fmt: skip
    return [one for one in held if one.reaches]


def text(one: HeldLoad) -> str:
    """Describe the runs."""
    load = one.run.load
    return (
        f"{load.largest:.4g} N on the first bead for {load.lasts * 1e3:.4g} ms, beta {one.spring.beta:g}. Plateaus "
        "are medians over their inner six tenths at three instants: under load, after it, and after the trailing "
        "front has caught up with the leading one. Theory is thesis 4.36 to 4.39 with the stated constants."
    )


def pictures(one: HeldLoad) -> Iterator[Picture]:
    """Thesis Fig. 4.9."""
    caption = (
        "Contact forces and bead velocities at three instants, with the largest force so far; dotted: closed forms "
        "(thesis Fig. 4.9)"
    )
    yield Picture("bilinear_long_load", caption, _drawing(one))


def rows(one: HeldLoad) -> Iterator[Row]:
    """Table 4.1, and forces."""
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
    figure, left, right = panels(2.8, 2)
    shown = int(1.15 * one.spring.rate * one.times[-1])
    contact, bead = np.arange(1, run.force.shape[1] + 1), np.arange(1, run.velocity.shape[1] + 1)
    largest = one.largest / scales.force
    data: dict[str, ArrayLike] = {"bead": bead, "contact": contact, "largest_force_normalised": largest}
    left.plot(contact[:shown], largest[:shown], color="black", linewidth=0.9, label="largest ever")
    for row, colour in zip(map(one.row, range(3)), COLOURS, strict=False):
        time, force, velocity = run.time[row], run.force[row] / scales.force, run.velocity[row] / scales.velocity
        left.plot(contact[:shown], force[:shown], color=colour, linewidth=0.9, label=f"{time * 1e3:.3g} ms")
        right.plot(bead[:shown], velocity[:shown], color=colour, linewidth=0.9, label=f"{time * 1e3:.3g} ms")
        data |= {f"force_at_{time:.4g}_s_normalised": force, f"velocity_at_{time:.4g}_s_normalised": velocity}
    for axes, lines in (
        (left, {"$F_1$": theory.force / scales.force, "$F_2$": theory.later_force / scales.force}),
        (right, {"$v_1$": theory.velocity / scales.velocity, "$v_t$": theory.trailing / scales.velocity,
                 "$v_2$": theory.later / scales.velocity}),
    ):  # fmt: skip
        for name, value in lines.items():
            axes.axhline(value, color="black", linestyle=":", linewidth=0.8)
            axes.text(0.995 * shown, value, name, ha="right", va="bottom")
    label(left, "Contact", FORCE, xlim=(0, shown), ylim=(0, 1.7 * float(largest.max())))
    label(right, "Bead", VELOCITY, xlim=(0, shown), ylim=(0, 1.7 * theory.velocity / scales.velocity))
    for axes in (left, right):
        axes.legend(ncols=2, loc="upper right")
    return Drawing(figure, data)
