"""Speed of the waves against the largest velocity of the particles, over a scan of the striker's velocity."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.packings.regions import wave_speeds
from granwave.analysis.measures.impact.regions import groups
from granwave.analysis.measures.waves.pulses import ChainSpeeds, peaks, speed_between, speed_of
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import WAYS, PackingRun, squares
from granwave.analysis.studies.study import Picture, Row

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


def select(runs: Sequence[FinishedRun]) -> list[list[ChainSpeeds]]:
    """One group of all chains of elastic square packings of like spheres, both ways."""
    found = []
    for way in WAYS:
        series = squares(runs, way, "hertz")
        for group in groups(series[0].snapshots) if len(series) >= _LEAST else ():
            points = np.array([point for run in series if np.isfinite(point := _point(run, group)).all()])
            if len(points) >= _LEAST:
                found.append(ChainSpeeds(f"{group}, {way}", series[0].case.material, *points.T))
    return [found] if found else []


def rows(found: Sequence[ChainSpeeds]) -> Iterator[Row]:
    """Exponents, and a speed in the middle of each series."""
    for one in found:
        fit, middle = one.fit, len(one.speed) // 2
        velocity, speed = float(one.velocity[middle]), float(one.speed[middle])
        exponent = f"Exponent of wave speed against particle velocity, {one.name}"
        remark = f"95 % confidence: {fit.margin:.1g} either side. Similarity forces it on any correct elastic code."
        yield Row(exponent, "", None, fit.exponent, _WHERE, remark, 0.2, True)
        theory = float(speed_of(one.material, velocity))
        where = f"Wave speed at {velocity:.3g} m/s, {one.name}"
        yield Row(where, "m/s", None, speed, _WHERE, "Theory: Nesterenko's formula.", theory)


def pictures(found: Sequence[ChainSpeeds]) -> Iterator[Picture]:
    """Speeds of all chains with the theory."""
    yield Picture("", "Wave speed against particle velocity (source Figs 8 to 10)", wave_speeds(found))


def _point(run: PackingRun, group: str) -> tuple[float, float]:
    """Mean peak velocity and speed between the places of the sensors, m/s."""
    seen, diameter = run.snapshots, run.case.packing.diameter
    passed = peaks(seen.time, groups(seen)[group][0].speeds(seen), diameter)
    return speed_between(passed, *_SENSORS.get((run.way, group), _OUT_OF_PLANE), diameter)
