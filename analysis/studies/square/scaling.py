"""Speed of the waves against the largest velocity of the particles, over a scan of the striker's velocity."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, new_figure
from granwave.analysis.measures.signals import Power, power
from granwave.analysis.studies.square.pulses import peaks, speed_of
from granwave.analysis.studies.square.regions import groups
from granwave.analysis.studies.square.runs import Array, PackingRun, squares
from granwave.analysis.studies.study import Picture, Row, Study

_LEAST = 3  # velocities for a fit
_WHERE = "square packing, equation 3, Figs 8 to 10"
#: Places of the sensors, counted along the chain from the struck sphere as 1: B and C of the source.
_SENSORS = {("in-plane", "central chains"): (6, 10), ("in-plane", "edge chains"): (5, 8)}
_OUT_OF_PLANE = (6, 8)


def wave_speeds(runs: Sequence[PackingRun]) -> Iterator[Study]:
    """One study of the elastic runs of square packings of like spheres, both ways."""
    found: dict[str, tuple[Array, Array, Power]] = {}
    for way in ("in-plane", "out-of-plane"):
        series = squares(runs, way, "hertz")
        for group in groups(series[0]) if len(series) >= _LEAST else ():
            points = np.array([point for run in series if (point := _point(run, group)) is not None])
            if len(points) >= _LEAST:
                found[f"{group}, {way}"] = (points[:, 0], points[:, 1], power(points[:, 0], points[:, 1]))
                one = series[0]
    if not found:
        return
    rows = []
    for name, (velocity, speed, fit) in found.items():
        rows.append(
            Row(
                f"Exponent of wave speed against particle velocity, {name}",
                "",
                0.2,
                fit.exponent,
                _WHERE,
                f"95 % confidence: {fit.margin:.1g} either side",
            )
        )
        middle = len(speed) // 2
        theory = float(speed_of(one.case.material, velocity[middle]))
        rows.append(
            Row(
                f"Wave speed at {velocity[middle]:.3g} m/s, {name}",
                "m/s",
                None,
                float(speed[middle]),
                _WHERE,
                "expected: Nesterenko's formula",
                theory,
            )
        )
    picture = Picture(
        "square_wave_speed", "Wave speed against particle velocity (source Figs 8 to 10)", _draw(found, one)
    )
    yield Study(
        "square-wave-speed",
        "Square packing: wave speed",
        "Between the places of two sensors in a chain: wave speed from the times of the velocity peaks, against "
        "the mean of the peaks, for a scan of the striker's velocity.",
        tuple(rows),
        (picture,),
    )


def _point(run: PackingRun, group: str) -> tuple[float, float] | None:
    """Mean peak velocity and speed between the places of the sensors, m/s."""
    first, second = (place - 1 for place in _SENSORS.get((run.way, group), _OUT_OF_PLANE))
    chain = groups(run)[group][0]
    if len(chain.rows) <= second:
        return None
    found = peaks(run.time, chain.speeds(run), run.case.packing.diameter)
    speed = (second - first) * run.case.packing.diameter / (found.time[second] - found.time[first])
    if not np.isfinite(speed) or speed <= 0:
        return None
    return float((found.velocity[first] + found.velocity[second]) / 2), float(speed)


def _draw(found: dict[str, tuple[Array, Array, Power]], run: PackingRun) -> Drawing:
    figure = new_figure(2.8)
    axes = figure.subplots()
    columns: dict[str, Array] = {}
    for (name, (velocity, speed, fit)), marker, colour in zip(found.items(), "osd", (BLUE, ORANGE, GREY), strict=False):
        label = f"{name}: {fit.exponent:.4f}"
        axes.loglog(velocity, speed, marker, color=colour, markersize=4, markerfacecolor="none", label=label)
        axes.loglog(velocity, fit(velocity), color=colour, linewidth=0.8)
        word = name.replace(", ", "_").replace(" ", "_").replace("-", "_")
        columns |= {f"{word}_peak_velocity_m_s": velocity, f"{word}_speed_m_s": speed}
    every = np.concatenate([velocity for velocity, _, _ in found.values()])
    line = np.geomspace(float(every.min()), float(every.max()), 20)
    axes.loglog(line, speed_of(run.case.material, line), ":", color="black", label="Nesterenko: 1/5")
    axes.set_xlabel("Largest particle velocity (m/s)")
    axes.set_ylabel("Wave speed (m/s)")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.5)
    axes.legend(loc="upper left")
    return Drawing(figure, columns)
