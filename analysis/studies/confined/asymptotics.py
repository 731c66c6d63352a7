"""Asymptotic theory of confined rows beside runs: travelling waves, small spheres, slopes (thesis 6.3)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.chains import confined as figures
from granwave.analysis.measures.confined.asymptotics import FirstOrder, Limit, Travelling, energy_decay, first_order
from granwave.analysis.measures.signals import Array, first_peak, width
from granwave.analysis.studies.confined.runs import ConfinedRun, confined_runs, from_thesis
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Confined rows: asymptotic theory"
TEXT = (
    "Light small spheres follow the beads, which are then a chain with a second, precompressed contact (6.13); small "
    "spheres that swing on behind the wave "
    "take energy from it (6.16 to 6.18). k_w is the source's (factor 1.2). Mended: delta_hat is 2 delta tan(theta), "
    "eta_hat has no further cos^2.5 (0.5286 for "
    "n = 8, not 0.2528), the residual keeps its powers 3/2 and c^2 w'', (6.17) has the difference of beads, (6.18) n "
    "eps^3/A^2 (w_1'^2 + u_1'^2) with the largest velocity of a bead "
    "in the place of A. Waves become wider with precompression, not narrower: C1 falls. The legends of figure 6.10 "
    "(0.09, 0.22, 0.36) are in the ratio of "
    "the precompressions, but about a quarter of delta_hat: their scale cannot be found, so slopes are compared."
)
_WHERE = "our second program"
_SHOWN = (0.2, 0.4)  # delta_hat of figure 6.9
_PROGRAM = {  # by delta_hat: C1, C3, C5 and c; axial and radial velocities of the tail
    0.2: ((2.0988, 0.1587, -0.0037), 1.0217, (1.91, 0.154)),
    0.4: ((1.9451, 0.1188, -0.0028), 1.0660, (1.15, 0.042)),
    1.32: (None, None, (0.20, 0.001)),
}
_AMPLITUDE = {1.2e-3: 1.22, 2.4e-3: 1.10}  # by a: displacement of a bead over D, times 1e3
_LEGENDS = {4.8e-4: 0.09, 1.2e-3: 0.22, 1.9e-3: 0.36}  # of figure 6.10, by a
_BEAD, _AFTER = 100, (2.0, 6.0)  # whose displacement by the wave is A, and when: widths of the wave behind its crest
_LEAST_DECAY = 2e-5  # per contact, for a slope
_DENSE = 12
_FEW_DIGITS = 0.2  # velocities that the program prints with a digit or two


@dataclasses.dataclass(frozen=True, eq=False)
class Theory:
    """Precompressed rows of one ring, by rising a."""

    runs: list[ConfinedRun]

    @cached_property
    def limit(self) -> Limit:
        """Numbers of the row, with the source's wall."""
        row = self.runs[0].row
        wall = float((row.k_thesis_wall / row.k_beads)[0])
        return Limit(float(row.n[0]), float(row.eps[0]), float(row.eta[0]), wall, float(row.tangent[0]))

    def delta_hat(self, run: ConfinedRun) -> float:
        """Precompression over the wave's amplitude."""
        return 2 * float(run.row.tangent[0] * run.row.shrinks[0]) / _amplitude(run)

    @cached_property
    def points(self) -> tuple[Array, Array]:
        """delta_hat and decay of the force in the runs: (n_runs,)."""
        known = [(self.delta_hat(run), run.decay) for run in self.runs]
        return np.array([x for x, _ in known]), np.array([y for _, y in known])

    @cached_property
    def curve(self) -> tuple[Array, Array]:
        """delta_hat and decay of the energy in theory, over the same range."""
        points = self.points[0]
        x = np.linspace(float(points[0]), float(points[-1]), _DENSE)
        return x, np.array(
            [energy_decay(self.limit, wave, first_order(self.limit, wave)) for wave in map(self.wave, x)]
        )

    def wave(self, delta_hat: float) -> Travelling:
        """Travelling wave of unit amplitude."""
        return Travelling(self.limit.eta_hat, delta_hat)

    def tail(self, delta_hat: float) -> FirstOrder:
        """Small spheres that it drives."""
        return first_order(self.limit, self.wave(delta_hat))


def select(runs: Sequence[FinishedRun]) -> list[Theory]:
    """Precompressed rows of n = 8 at 1 m/s, of three precompressions and more."""
    known = [
        run for run in confined_runs(runs) if run.n == 8 and run.velocity == 1 and run.a and math.isfinite(run.decay)
    ]
    known = [run for run in known if math.isfinite(_amplitude(run))]
    known.sort(key=lambda run: run.a)
    printed = [run for run in known if from_thesis(run) and round(run.a, 7) in _LEGENDS]
    known = printed if len(printed) == len(_LEGENDS) else known
    return [Theory(known)] if len(known) > 2 else []


def rows(theory: Theory) -> Iterator[Row]:
    """Coefficients and speed of the series, velocities of the small spheres, slopes."""
    program = from_thesis(theory.runs[0])
    if program:
        yield Row("eta_hat of (6.13), n = 8", "", None, theory.limit.eta_hat, _WHERE, "", 0.5286, True, 4)
    for delta_hat, (coefficients, speed, tails) in _PROGRAM.items():
        wave, at = theory.wave(delta_hat), f"delta_hat = {delta_hat:g}"
        if delta_hat in _SHOWN:
            series = wave.series()
            for k, ours in enumerate(series.coefficients):
                what, value = f"C{2 * k + 1} of the series, {at}", coefficients[k] if program and coefficients else None
                yield Row(what, "", None, ours, _WHERE, "", value, value is not None, 3)
            remark = f"Our second program: {speed}." if program else ""
            yield Row(f"c of the series, {at}", "", None, series.speed, "lattice", remark, wave.speed, True)
            z = np.linspace(-3, 3, 241)
            apart = float(np.abs(series(z) - wave.displacement(z)).max())
            yield Row(f"Largest difference of the series from the lattice's profile, {at}", "", None, apart,
                      "thesis figure 6.9", "Our second program: within 0.004." if program else "",
                      digits=2)  # fmt: skip
        found = theory.tail(delta_hat)
        for way, ours, value in zip(("Axial", "Radial"), (found.axial_tail, found.radial_tail), tails, strict=True):
            what = f"{way} first-order velocity behind the wave, {at}"
            if program:
                few = "The program gives a digit or two." if ours < _FEW_DIGITS else ""
                yield Row(what, "", None, ours, _WHERE, few, value, True, 2)
            else:
                yield Row(what, "", None, ours, "thesis 6.16, 6.17", digits=2)
    yield from _scales(theory, program=program)
    x, decay = theory.points
    known = decay > _LEAST_DECAY
    if np.count_nonzero(known) > 1:
        slope, expected = float(np.polyfit(x[known], np.log(decay[known]), 1)[0]), _slope(*theory.curve)
        yield Row(
            "Slope of ln(decay of the force) with delta_hat", "", None, slope, "thesis figure 6.11",
            "Theory: decay of the energy by (6.18), with the source's wall and without the rings. The source calls "
            "the slopes equal; "
            "its own model has -3.16 in our second program.", expected, digits=3,
        )  # fmt: skip


def _scales(theory: Theory, *, program: bool) -> Iterator[Row]:
    """Displacement of a bead by the wave, and delta_hat beside the legends of figure 6.10."""
    for run in theory.runs:
        a = round(run.a, 7)
        known = _AMPLITUDE.get(a) if program else None
        remark = f"The source's model in our second program: {known:g}." if known else ""
        moved = _amplitude(run) / float(run.row.bead[0])
        what = f"Displacement of a bead by the wave over D, times 1e3, {run.label_of_row}"
        yield Row(what, "", None, 1e3 * moved, _WHERE, remark, digits=3)
        legend = _LEGENDS.get(a) if program else None
        if legend is not None:
            yield Row(f"delta_hat of the legend, {run.label_of_row}", "", legend, theory.delta_hat(run),
                      "thesis figure 6.10", "Its scale cannot be found: some four times, in the ratio of a.",
                      digits=3)  # fmt: skip


def _slope(x: Array, y: Array) -> float:
    return float(np.polyfit(x, np.log(y), 1)[0])


def _amplitude(run: ConfinedRun) -> float:
    """Displacement of a bead by the wave, m; NaN if it was not recorded."""
    velocity, moved = run.probe(_BEAD, "vz"), run.probe(_BEAD, "uz")
    if velocity is None or moved is None:
        return math.nan
    time, place = moved
    crest, _ = first_peak(*velocity, floor=0.5)
    length = width(*velocity)
    after = (time > crest + _AFTER[0] * length) & (time < crest + _AFTER[1] * length)
    return float(place[after].mean() - place[0]) if after.any() else math.nan


def pictures(theory: Theory) -> Iterator[Picture]:
    """Travelling waves, velocities of small spheres, slopes."""
    z = np.linspace(-3, 3, 121)
    waves = [(f"δ̂ = {one:g}", z, theory.wave(one).series()(z), theory.wave(one).displacement(z)) for one in _SHOWN]
    yield Picture(
        "", "Travelling waves: series of three terms and lattice (thesis figure 6.9)", figures.travelling_waves(waves)
    )
    tails = [(one, theory.tail(one)) for one in theory.points[0]]
    caption = "First-order velocities of the small spheres (thesis figure 6.10)"
    curves = [(f"δ̂ = {one:.2f}", tail.time, tail.axial, tail.radial) for one, tail in tails]
    yield Picture("_small_spheres", caption, figures.small_sphere_velocities(curves))
    caption = "Decay of the force in the runs, and of the energy by theory (thesis figure 6.11)"
    drawing = figures.decay_slopes(("energy, theory", *theory.curve), ("force, simulation", *theory.points))
    yield Picture("_slopes", caption, drawing)
