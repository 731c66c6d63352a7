"""A bilinear chain under a force that lasts: plateaus between fronts, beside thesis 4.2.2 (table 4.1, Fig. 4.9)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.chains.labels import FORCE, VELOCITY
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.bilinear import spring_of
from granwave.analysis.measures.chains.bilinear_long_load import HeldLoad
from granwave.analysis.studies.chains.runs import from_thesis, uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Bilinear chain under a long load"
_LONG = 50.0  # 1/sqrt(k/m): the shortest load with plateaus
_WHERE = "thesis 4.2.2, table 4.1"
_SOURCE = (8e3, 2.5e-3, 0.8)  # N, s, beta


def select(runs: Sequence[FinishedRun]) -> list[HeldLoad]:
    """Chains under a force that lasts, long enough to see its fronts meet; each by itself."""
    held = [
        HeldLoad(run) for run in uniform(runs, "bilinear")
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


def rows(one: HeldLoad) -> Iterator[Row]:
    """Table 4.1, and forces; the source's values for its case alone."""
    load, theory = one.run.load, one.theory
    own = (load.largest, load.lasts, one.spring.beta)
    sourced = from_thesis(one.run, yielding=True) and np.allclose(own, _SOURCE, rtol=1e-6, atol=0)
    #        quantity, unit, numerical and predicted as printed, ours, theory, remarks on both
    table = (
        ("v1, velocity behind the leading front", "m/s", 26.4, 26.18, one.velocity(0), theory.velocity, "", ""),
        ("vt, velocity behind the trailing front", "m/s", 14.6, 14.47, one.velocity(1), theory.trailing, "", ""),
        ("v2, velocity once the fronts have met; source: lowest of its 14.5 to 15", "m/s", 14.5, 14.84,
         one.velocity(2), theory.later,
         "Printed: 14.5 to 15, near vt. Only about 10 m/s agree with the printed F2, as F2 D = m v2 c.",
         "4.39 as printed gives the theory value, not 14.84 m/s."),
        ("F2, force once the fronts have met", "N", 3060, 3056, one.force(2), theory.later_force, "", ""),
        ("xt, where the fronts meet", "m", 0.333, 0.342, one.meeting, theory.meeting,
         "The print is ten times too small: at 3 ms, in Fig. 4.9, the fronts are still apart, one near 2.3 m.",
         "The print is ten times too small."),
    )  # fmt: skip
    for quantity, unit, numerical, _, ours, closed, remark, _ in table:
        yield Row(quantity, unit, numerical if sourced else None, ours, _WHERE, remark if sourced else "", closed)
    for quantity, unit, _, predicted, _, closed, _, remark in table if sourced else ():
        name = quantity.split(",")[0]
        yield Row(f"{name} as predicted by 4.36 to 4.39", unit, predicted, None, _WHERE, remark, closed)
    yield Row("F1, force behind the leading front under load", "N", None, one.force(0),
              "balance of forces", "", theory.force)  # fmt: skip
    remark = (
        "The first contacts overshoot by inertia. The axis of Fig. 4.9(a), to 0.14 E*R*^2, would be six times the load "
        "and is not compared."
    )
    over = float(one.largest.max()) / theory.force
    yield Row("Largest force of all over the load", "", None, over, "thesis 4.2.2", remark if sourced else "")


def pictures(one: HeldLoad) -> Iterator[Picture]:
    """Thesis Fig. 4.9."""
    run, scales, theory = one.run, one.run.scales, one.theory
    figure, left, right = panels(2.8, 2)
    shown = int(1.15 * one.spring.rate * one.times[-1])
    contact, bead = np.arange(1, run.force.shape[1] + 1), np.arange(1, run.velocity.shape[1] + 1)
    largest = one.largest / scales.force
    data: dict[str, ArrayLike] = {"bead": bead, "contact": contact, "largest_force_normalised": largest}
    left.plot(contact[:shown], largest[:shown], color="black", label="largest ever")
    for row in map(one.row, range(3)):
        time, force, velocity = run.time[row], run.force[row] / scales.force, run.velocity[row] / scales.velocity
        left.plot(contact[:shown], force[:shown], label=f"{time * 1e3:.3g} ms")
        right.plot(bead[:shown], velocity[:shown], label=f"{time * 1e3:.3g} ms")
        data |= {f"force_at_{time:.4g}_s_normalised": force, f"velocity_at_{time:.4g}_s_normalised": velocity}
    forces = {"$F_1$": theory.force, "$F_2$": theory.later_force}
    velocities = {"$v_1$": theory.velocity, "$v_t$": theory.trailing, "$v_2$": theory.later}
    for axes, lines, unit in ((left, forces, scales.force), (right, velocities, scales.velocity)):
        for name, value in lines.items():
            axes.axhline(value / unit, color="black", linestyle=":", linewidth=0.8)
            axes.text(0.995 * shown, value / unit, name, ha="right", va="bottom")
    label(left, "Contact", FORCE, xlim=(0, shown), ylim=(0, 1.7 * float(largest.max())))
    label(right, "Bead", VELOCITY, xlim=(0, shown), ylim=(0, 1.7 * theory.velocity / scales.velocity))
    for axes in (left, right):
        axes.legend(ncols=2, loc="upper right")
    caption = (
        "Contact forces and bead velocities at three instants, with the largest force so far; dotted: closed forms "
        "(thesis Fig. 4.9)"
    )
    yield Picture("bilinear_long_load", caption, Drawing(figure, data))
