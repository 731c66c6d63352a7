"""Speed of the waves against the largest velocity of the particles, over a scan of the striker's velocity."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import column_name, one_panel
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.signals import Array, Power, power
from granwave.analysis.measures.square.pulses import peaks, speed_between, speed_of
from granwave.analysis.measures.square.regions import groups
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import WAYS, PackingRun, squares
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.material import Material

TITLE = "Square packing: wave speed"
TEXT = (
    "Between the places of two sensors in a chain: wave speed from the times of the velocity peaks, against "
    "the mean of the peaks, for a scan of the striker's velocity."
)
_LEAST = 3  # velocities for a fit
_WHERE = "square packing, equation 3, Figs 8 to 10"
#: Places of the sensors, counted along the chain from the struck sphere as 1: B and C of the source.
_SENSORS = {("in-plane", "central chains"): (6, 10), ("in-plane", "edge chains"): (5, 8)}
_OUT_OF_PLANE = (6, 8)


@dataclasses.dataclass(frozen=True, eq=False)
class Series:
    """Peak velocity of the particles and speed of the wave in chains of one kind, m/s: (n_runs,) each."""

    name: str
    material: Material
    velocity: Array
    speed: Array

    @property
    def fit(self) -> Power:
        """Speed against velocity."""
        return power(self.velocity, self.speed)


def select(runs: Sequence[FinishedRun]) -> list[list[Series]]:
    """One group of all chains of elastic square packings of like spheres, both ways."""
    found = []
    for way in WAYS:
        series = squares(runs, way, "hertz")
        for group in groups(series[0].snapshots) if len(series) >= _LEAST else ():
            points = np.array([point for run in series if np.isfinite(point := _point(run, group)).all()])
            if len(points) >= _LEAST:
                found.append(Series(f"{group}, {way}", series[0].case.material, *points.T))
    return [found] if found else []


def rows(found: Sequence[Series]) -> Iterator[Row]:
    """Exponents, and a speed in the middle of each series."""
    for one in found:
        fit, middle = one.fit, len(one.speed) // 2
        velocity, speed = float(one.velocity[middle]), float(one.speed[middle])
        exponent = f"Exponent of wave speed against particle velocity, {one.name}"
        yield Row(exponent, "", 0.2, fit.exponent, _WHERE, f"95 % confidence: {fit.margin:.1g} either side")
        theory = float(speed_of(one.material, velocity))
        where = f"Wave speed at {velocity:.3g} m/s, {one.name}"
        yield Row(where, "m/s", None, speed, _WHERE, "expected: Nesterenko's formula", theory)


def pictures(found: Sequence[Series]) -> Iterator[Picture]:
    """Speeds of all chains with the theory."""
    figure, axes = one_panel(2.8, "Largest particle velocity (m/s)", "Wave speed (m/s)")
    columns: dict[str, Array] = {}
    for one, marker, colour in zip(found, "osd", (BLUE, ORANGE, GREY), strict=False):
        label = f"{one.name}: {one.fit.exponent:.4f}"
        axes.loglog(one.velocity, one.speed, marker, color=colour, markersize=4, markerfacecolor="none", label=label)
        axes.loglog(one.velocity, one.fit(one.velocity), color=colour, linewidth=0.8)
        word = column_name(one.name)
        columns |= {f"{word}_peak_velocity_m_s": one.velocity, f"{word}_speed_m_s": one.speed}
    every = np.concatenate([one.velocity for one in found])
    line = np.geomspace(float(every.min()), float(every.max()), 20)
    axes.loglog(line, speed_of(found[-1].material, line), ":", color="black", label="Nesterenko: 1/5")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.5)
    axes.legend(loc="upper left")
    yield Picture("", "Wave speed against particle velocity (source Figs 8 to 10)", Drawing(figure, columns))


def _point(run: PackingRun, group: str) -> tuple[float, float]:
    """Mean peak velocity and speed between the places of the sensors, m/s."""
    seen, diameter = run.snapshots, run.case.packing.diameter
    passed = peaks(seen.time, groups(seen)[group][0].speeds(seen), diameter)
    return speed_between(passed, *_SENSORS.get((run.way, group), _OUT_OF_PLANE), diameter)
