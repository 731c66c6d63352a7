"""Figures of lines of grains: speeds, their decay, and the diagram in space and time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patheffects import withStroke
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.force_map import space_time_map
from granwave.analysis.figures.impact_arrow import impact_arrow
from granwave.analysis.figures.series import (
    against_time,
    end_of_axis,
    label,
    panels,
)
from granwave.analysis.figures.style import (
    BLUE,
    FORCE_MAP,
    GREY,
    ORANGE,
    Drawing,
    legend_above,
)
from granwave.analysis.measures.fronts import AXIS, LineMotion, line_motions
from granwave.analysis.measures.lines import LineRecord, lines_of
from granwave.analysis.result.reader import Result

_MICRO = 1e6
_MILLI = 1e3
_MOST_COLUMNS = 2000  # largest number of columns of a map
_AFTER = 2.0  # end of the diagram of a line over the last arrival
_FEWEST_TIMES = 8  # instants of a diagram of a line
_DECADES_OF_SPEED = 3.0  # decades of speed in the diagram of a line
#: Caption and look of the diagram of a line.
DIAGRAM = "Speed of a line of grains in space and time, with the front"
LOOK_OF_DIAGRAM = (
    "Circles: the front. White: slower than one thousandth of the largest speed before it. "
    "Colours are as fine as the snapshots."
)
_EDGE = [withStroke(linewidth=2.2, foreground="white")]  # visible on dark and bright colours
_ARRIVALS: dict[str, Any] = {
    "color": "black", "markersize": 2.6, "markeredgecolor": "white", "markeredgewidth": 0.4,
}  # fmt: skip
_FITTED: dict[str, Any] = {
    "color": ORANGE, "linewidth": 1.1, "path_effects": _EDGE, "zorder": 1.5
}  # fmt: skip
_MOST_FRONTS = 25  # largest number of marked fronts, which would hide the fitted line
_MOST_OF_A_LINE = 12  # largest number of curves of a line of grains


def line_speeds(result: Result) -> Drawing | None:
    """Draw the speeds of the grains of lines against time, from first (dark) to last (light)."""
    lines = [line for line in lines_of(result) if line.straight]
    if not lines:
        return None
    figure, *stack = panels(0.7 + 1.9 * len(lines), rows=len(lines), sharex=True)
    columns = {"time_s": result[f"lines/{lines[0].name}/time"]}
    for axes, line in zip(stack, lines, strict=True):
        group = f"lines/{line.name}"
        time = result[f"{group}/time"]
        ids = result[f"{group}/id"]
        speed = np.linalg.norm(result[f"{group}/velocity"], axis=2)
        n_grains = speed.shape[1]
        last = n_grains - 1
        names = {0: "first grain", last: "last grain"}
        places = np.linspace(0, last, min(n_grains, _MOST_OF_A_LINE))
        for grain in np.unique(places.round().astype(int)):
            colour = colormaps["viridis"](0.9 * grain / max(last, 1))
            name = names.get(int(grain))
            against_time(axes, time, speed[:, grain], color=colour, linewidth=0.8, label=name)
            columns[f"{line.name}_{ids[grain]}_m_s"] = speed[:, grain]
        title = line.name if len(lines) > 1 else ""
        label(axes, y="Speed (m/s)", title=title, ylim=(0, None))
        axes.legend()
    return Drawing(figure, columns)


def line_decay(result: Result) -> Drawing | None:
    """Draw the peak speeds along each line against distance, with the broken line that is fitted to
    them.
    """
    lines = [
        line
        for line in lines_of(result)
        if line.straight and np.isfinite(line.peak_speed).sum() > 1
    ]
    if not lines:
        return None
    figure, *stack = panels(0.7 + 1.9 * len(lines), rows=len(lines))
    columns: dict[str, NDArray] = {}
    for axes, line in zip(stack, lines, strict=True):
        _draw_decay(axes, line)
        label(axes, y="Peak speed (m/s)", title=line.name if len(lines) > 1 else "", yscale="log")
        axes.yaxis.set(major_formatter=ScalarFormatter(), minor_formatter=ScalarFormatter())
        columns |= {
            f"{line.name}_distance_m": line.distance,
            f"{line.name}_peak_m_s": line.peak_speed,
            f"{line.name}_arrival_s": line.arrival,
            f"{line.name}_width_s": line.width,
            f"{line.name}_lateral_force_N": line.lateral_force,
        }
    label(stack[-1], "Distance along the line (mm)")
    return Drawing(figure, columns)


def _draw_decay(axes: Axes, line: LineRecord) -> None:
    kept = np.arange(len(line.distance)) < line.fitted.stop
    for chosen, colour, face in ((kept, BLUE, BLUE), (~kept, GREY, "white")):
        place = line.distance[chosen] * _MILLI
        speed = line.peak_speed[chosen]
        axes.plot(place, speed, "o", markersize=3, color=colour, markerfacecolor=face)
    decay = line.decay
    if decay is None:
        return

    def shape(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return -decay.first * x - (decay.second - decay.first) * np.maximum(x - decay.border, 0)

    fitted = kept & np.isfinite(line.peak_speed) & (line.peak_speed > 0)
    height = np.mean(np.log(line.peak_speed[fitted]) - shape(line.distance[fitted]))
    x = np.sort(np.append(line.distance[fitted], decay.border))
    axes.plot(x * _MILLI, np.exp(shape(x) + height), color=ORANGE, linewidth=0.9)
    axes.axvline(decay.border * _MILLI, color=GREY, linestyle=":", linewidth=0.8)


def line_diagram(result: Result) -> Drawing | None:
    """Draw the speed of the grains of lines in position and time, with the arrivals of the wave and
    the line through them.

    The lines are the chain, or the grains nearest to the axis of the load, and each ``[[line]]``.
    """
    arrow = impact_arrow(result)
    motions = [
        motion
        for motion in line_motions(result, arrow.place, arrow.direction)
        if motion.velocity.any()
    ]
    if not motions:
        return None
    figure, *stack = panels(0.9 + 2.5 * len(motions), rows=len(motions))
    columns: dict[str, NDArray] = {}
    for axes, motion in zip(stack, motions, strict=True):
        image = _draw_motion(axes, motion, result.figure_options.colour_map or FORCE_MAP)
        figure.colorbar(image, ax=axes, label="Speed along the line (m/s)", extend="min")
        columns |= _columns_of_motion(motion)
    return Drawing(figure, columns)


def words_on_diagram(result: Result, _: Path) -> tuple[str, str]:
    """Return caption and look of `line_diagram` of a run."""
    arrow = impact_arrow(result)
    motions = line_motions(result, arrow.place, arrow.direction)
    shown = [_last_shown(motion) / _MICRO for motion in motions if motion.velocity.any()]
    ends = end_of_axis(max(shown, default=np.inf), float(result["energy/time"][-1]))
    return DIAGRAM, f"{LOOK_OF_DIAGRAM} {ends}".rstrip()


def _draw_motion(axes: Axes, motion: LineMotion, colours: str) -> Any:
    """Draw the speed of the grains of a line by colour; return the image, for a colour bar."""
    speed = np.abs(motion.velocity)
    largest = float(speed.max())
    least = largest / 10**_DECADES_OF_SPEED
    norm = LogNorm(least, largest)
    rows = slice(None, None, max(1, len(motion.time) // _MOST_COLUMNS))
    places = slice(None, None, max(1, len(motion.place) // _MOST_COLUMNS))
    shown = speed[rows, places]
    # behind the front, grains that are slow for an instant have the lowest colour
    behind = motion.time[rows, None] >= motion.arrival[places]
    shown = np.where(behind & (shown > 0), np.maximum(shown, least), shown)
    shown = np.where(shown >= least, shown, np.nan)
    image = space_time_map(axes, motion.place[places], motion.time[rows], shown, norm, colours)
    left, _ = axes.get_xlim()
    limits = (left, _last_moved(motion, least), 0.0, _last_shown(motion))
    reached = np.isfinite(motion.arrival)
    axes.plot(
        motion.place[reached] * _MILLI,
        motion.arrival[reached] * _MICRO,
        "o",
        label="front at a grain",
        markevery=max(1, np.count_nonzero(reached) // _MOST_FRONTS),
        **_ARRIVALS,
    )
    if motion.front is not None:
        ends = motion.front.place[[0, -1]]
        text = f"fitted: {motion.front.speed:.4g} m/s"
        axes.plot(ends * _MILLI, motion.front.when(ends) * _MICRO, "-", label=text, **_FITTED)
    axes.axis(limits)
    title = "Distance along the load (mm)" if motion.name == AXIS else f"Along {motion.name} (mm)"
    label(axes, title, "Time (µs)")
    if reached.any():
        legend_above(axes, 2)
    return image


def _last_moved(motion: LineMotion, least: float) -> float:
    """Return the end of the axis of positions, beyond the last coloured grain, mm."""
    coloured = np.flatnonzero(np.abs(motion.velocity).max(axis=0) > least)
    last = min(int(coloured[-1]) + 1, len(motion.place) - 1)
    spacing = motion.place[last] - motion.place[last - 1]
    return float(motion.place[last] + 0.5 * spacing) * _MILLI


def _last_shown(motion: LineMotion) -> float:
    """Return the end of the axis of times, some time after the wave has arrived everywhere, µs."""
    end = float(motion.time[-1])
    arrived = np.isfinite(motion.arrival)
    if arrived[1:].all():  # the front begins below the impacted grain
        end = min(end, _AFTER * float(np.nanmax(motion.arrival, initial=0.0)))
    if np.count_nonzero(motion.time <= end) < _FEWEST_TIMES:
        end = float(motion.time[-1])
    return end * _MICRO


def _columns_of_motion(motion: LineMotion) -> dict[str, NDArray]:
    """Return the data of a line: a row for each grain at each instant, and for each grain."""
    n_times = len(motion.time)
    columns = {
        f"{motion.name}_time_s": np.repeat(motion.time, len(motion.place)),
        f"{motion.name}_id": np.tile(motion.ids, n_times),
        f"{motion.name}_place_m": np.tile(motion.place, n_times),
        f"{motion.name}_velocity_m_s": motion.velocity.ravel(),
        f"{motion.name}_arrival_s": motion.arrival,
    }
    if motion.front is not None:
        columns[f"{motion.name}_front_speed_m_s"] = np.array([motion.front.speed])
    return columns
