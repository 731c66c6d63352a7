"""Numbers that the source prints of its confined rows, and sizes and units of these (thesis 6.1, 6.2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.confined.geometry import Row as Geometry
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.confined.reference import (
    E_STAR,
    FORCE_UNIT,
    GEOMETRY,
    SLOWEST,
    SPEED_NUMBER,
    TIME_UNIT,
)
from granwave.analysis.studies.confined.runs import ConfinedRun
from granwave.analysis.studies.study import Row

_LEGENDS = {  # a of figures 6.2 and 6.3, for inward motions of the small spheres of these parts of D
    6: (5.2e-4, 1.3e-3, 2.1e-3),
    7: (5.0e-4, 1.3e-3, 2.0e-3),
    8: (4.8e-4, 1.2e-3, 1.9e-3),
    9: (4.6e-4, 1.2e-3, 1.9e-3),
}
_INWARD = (1.6e-4, 4.0e-4, 6.4e-4)
_CHECKED = "Check value, from the same formulas apart from granwave."


def printed_rows(rows: Sequence[Geometry], fractions: Array, decay: Array) -> Iterator[Row]:
    """Sizes, units, static balance of the legends, and resonances in n.

    Parameters
    ----------
    rows
        Rows of the source, of any n and a.
    fractions, decay
        Values of n, whole and not, and the decay of the equations without precompression.
    """
    one = rows[0]
    yield from _sizes(one)
    yield from _units(one)
    eight = next((row for row in rows if row.n[0] == 8), None)
    if eight is not None:
        yield Row("eps = m_s/m_b, n = 8", "", 0.04, float(eight.eps[0]), "thesis 6.8")
        yield Row("eta, n = 8", "", 0.34, float(eight.eta[0]), "thesis 6.8")
        yield Row(
            "gamma = k_w/k_bb, n = 8", "", 1.53, float((eight.k_wall / eight.k_beads)[0]), "thesis 6.8",
            "Theory: its own formula with the factor 1.2. Ours: ellipse in the tube; a flat wall has 1.657.",
            float((eight.k_thesis_wall / eight.k_beads)[0]),
        )  # fmt: skip
    yield Row(
        "Impact velocity of 1 m/s in the source's unit", "", 1.35e-4, None, "thesis 6.1",
        "Its unit D sqrt(k_bb/m_b) is not dimensionless (m^(-1/4)); 1.3528e-4 belongs to D = 30 mm, and figures 6.2 "
        "and 6.5 to 15 mm.",
        float(one.thesis_time[0] / one.bead[0]),
    )  # fmt: skip
    for n, legends in _LEGENDS.items():
        yield from _legend_rows(Geometry.fitting(n, one.bead[0], 0.0, one.modulus, one.density), n, legends)
    for place, source in ((7.0, 7), (8.0, 8)):
        near = np.abs(fractions - place - 0.15) < 0.5
        yield Row(
            f"n of the largest decay near {source}, a = 0", "", source, None, "thesis figure 6.6",
            f"Theory: {number(float(decay[near].max()))} per contact. A fraction of n has meaning in the equations "
            "only.",
            float(fractions[near][decay[near].argmax()]),
        )  # fmt: skip


def speed_rows(runs: Sequence[ConfinedRun]) -> Iterator[Row]:
    """Speeds in the source's unit, without precompression and with the largest, by n."""
    for n in sorted({run.n for run in runs}):
        known = sorted((run for run in runs if run.n == n and math.isfinite(run.speed)), key=lambda run: run.a)
        for run in known[:1] + known[1:][-1:]:
            remark = "The axis is 0.04 to 0.085."
            if not run.a and n in SLOWEST:
                remark += f" The source's model in our second program: {SLOWEST[n]:g}."
            unit = float(run.row.thesis_time[0] / run.row.bead[0])
            what = f"Speed in the source's unit, {run.label_of_row}"
            yield Row(what, "", None, unit * run.speed, "thesis figure 6.4", remark, digits=3)


def _sizes(one: Geometry) -> Iterator[Row]:
    for n, values in GEOMETRY.items():
        row = Geometry.fitting(n, one.bead[0], 0.0, one.modulus, one.density)
        ours = (
            ("Diameter of the small spheres over D", row.small / row.bead),
            ("Radius of the tube over D", row.tube / row.bead),
            ("cos(theta)", row.cosine),
            ("eps", row.eps),
            ("eta", row.eta),
            ("gamma with the source's factor", row.k_thesis_wall / row.k_beads),
            ("gamma in the tube", row.k_wall / row.k_beads),
        )
        for (what, value), known in zip(ours, values, strict=True):
            yield Row(f"{what}, n = {n}", "", None, float(value[0]), "thesis 6.1 to 6.8", _CHECKED, known, True)


def _units(one: Geometry) -> Iterator[Row]:
    speed = math.sqrt(np.pi / 2 * float(one.density[0] / one.modulus[0]))
    for what, unit, ours, known in (
        ("E* of two beads", "Pa", one.modulus[0] / 2, E_STAR),
        ("E* R*^2 of two beads", "N", one.force_unit[0], FORCE_UNIT),
        ("Unit of time sqrt(m_b/k_bb), in SI", "", one.thesis_time[0], TIME_UNIT),
        ("v sqrt(pi/2 rho (1 - nu^2)/E) of 1 m/s, on which the response depends", "", speed, SPEED_NUMBER),
    ):
        yield Row(what, unit, None, float(ours), "thesis 6.1", _CHECKED, known, True)


def _legend_rows(row: Geometry, n: int, legends: tuple[float, ...]) -> Iterator[Row]:
    for printed, part in zip(legends, _INWARD, strict=True):
        inward = part * row.bead
        with_printed, with_right, without = (
            float(2 * row.thesis_shrinks(inward, **which)[0] / row.bead[0])
            for which in ({"printed_ring": True}, {"right_ring": True}, {})
        )
        remark = f"The printed balance needs {number(with_printed)}, the right one {number(with_right)}"
        remark += "; the legends follow from it without the ring." if part == _INWARD[0] else "."
        yield Row(
            f"a of the legends, n = {n}, small spheres moved in by {part:g} D", "", printed, None,
            "thesis figures 6.2, 6.3", remark, without,
        )  # fmt: skip
