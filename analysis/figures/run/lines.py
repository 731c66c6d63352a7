"""Lines of grains: speed against time of the grains, and peak speed against distance with its decay in two regions."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.lines import LineRecord, lines_of
from granwave.analysis.result.reader import Result

_MICRO, _MILLI = 1e6, 1e3  # us in a second, mm in a metre
_MOST_CURVES = 12
_MAP = "viridis"


def line_speeds(result: Result) -> Drawing | None:
    """Draw the speeds of the grains of each line against time, from first (dark) to last (light)."""
    lines = [line for line in lines_of(result) if line.straight]
    if not lines:
        return None
    figure, *stack = panels(0.7 + 1.9 * len(lines), rows=len(lines), sharex=True)
    columns = {"time_s": result[f"lines/{lines[0].name}/time"]}
    for axes, line in zip(stack, lines, strict=True):
        group = f"lines/{line.name}"
        time, speed = result[f"{group}/time"], np.linalg.norm(result[f"{group}/velocity"], axis=2)
        n = speed.shape[1]
        chosen = np.unique(np.linspace(0, n - 1, min(n, _MOST_CURVES)).round().astype(int))
        for one in chosen:
            axes.plot(time * _MICRO, speed[:, one], color=colormaps[_MAP](0.9 * one / max(n - 1, 1)), linewidth=0.8)
            columns[f"{line.name}_{result[f'{group}/id'][one]}_m_s"] = speed[:, one]
        title = line.name if len(lines) > 1 else ""
        label(axes, y="Speed (m/s)", title=title, ylim=(0, None), xlim=(0, time[-1] * _MICRO))
    label(stack[-1], "Time (µs)")
    return Drawing(figure, columns)


def line_decay(result: Result) -> Drawing | None:
    """Draw the peak speeds along each line against distance, with the broken line that is fitted to them."""
    lines = [line for line in lines_of(result) if line.straight and np.isfinite(line.peak_speed).sum() > 1]
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
    axes.plot(line.distance[kept] * _MILLI, line.peak_speed[kept], "o", color=BLUE, markersize=3)
    axes.plot(
        line.distance[~kept] * _MILLI, line.peak_speed[~kept], "o", color=GREY, markersize=3, markerfacecolor="white"
    )
    decay = line.decay
    if decay is None:
        return
    known = kept & np.isfinite(line.peak_speed) & (line.peak_speed > 0)
    x = np.sort(np.append(line.distance[known], decay.border))
    shape = -decay.first * x - (decay.second - decay.first) * np.maximum(x - decay.border, 0)
    at = -decay.first * line.distance[known] - (decay.second - decay.first) * np.maximum(
        line.distance[known] - decay.border, 0
    )
    height = np.mean(np.log(line.peak_speed[known]) - at)
    axes.plot(x * _MILLI, np.exp(shape + height), color=ORANGE, linewidth=0.9)
    axes.axvline(decay.border * _MILLI, color=GREY, linestyle=":", linewidth=0.8)
