"""Force on the bottom of several runs against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from granwave.analysis.figures.series import against_time, column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import SampledCurve, drawn_force_at_bottom
from granwave.analysis.reports.comparison.figures.axes import (
    draw_measured,
    first_change,
    force_unit,
    legend_above,
    run_panels,
    run_styles,
    show_times_up_to,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure, itself
from granwave.analysis.reports.comparison.figures.static_loads import static_notes
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

_MICRO = 1e6
_HIDES = 8.0  # ratio of the largest to the smallest peak that a linear axis hides
_BELOW = 1e-2  # lowest force of a logarithmic axis, divided by the smallest peak


def draw_bottom_force(
    curves: Mapping[ComparedRun, SampledCurve], measured: Sequence[MeasuredCurve]
) -> Drawing | None:
    """Draw the force on the bottom against time; None if it is zero in every run."""
    largest = max(float(np.abs(curve.y).max(initial=0.0)) for curve in curves.values())
    if not largest and not measured:
        return None
    figure, axes = run_panels(len(curves), 1, 2.7)
    scale, unit = force_unit(largest)
    columns: dict[str, Array] = {}
    for run, look in run_styles(list(curves)).items():
        curve = curves[run]
        linestyle = look.pop("linestyle")
        against_time(axes, curve.x, curve.y * scale, linestyle, **look)
        name = column_name(run.label)
        columns |= {f"{name}_time_s": curve.x, f"{name}_force_N": curve.y}
    columns |= draw_measured(axes, measured, _MICRO, scale)
    label(axes, "Time (µs)", f"Force on the bottom ({unit})")
    ends = {run: float(curve.x[-1]) for run, curve in curves.items()}
    show_times_up_to(axes, ends, {run: first_change(curve) for run, curve in curves.items()})
    _show_small_forces(axes, [scale * float(curve.y.max()) for curve in curves.values()])
    legend_above(figure)
    return Drawing(figure, columns)


def _show_small_forces(axes: Axes, peaks: Sequence[float]) -> None:
    """Make the vertical axis logarithmic if a linear axis would hide the lowest peak.

    Parameters
    ----------
    peaks
        Largest force of each run, in the unit of the axis: (n_runs,).
    """
    present = [peak for peak in peaks if peak > 0]
    if not present or max(present) < _HIDES * min(present):
        axes.axhline(0, color="black", linewidth=0.4, zorder=0)
        return
    axes.set_yscale("log")
    axes.set_ylim(min(present) * _BELOW, 2 * max(present))


BOTTOM_FORCE = ComparisonFigure(
    "Force on the bottom against time",
    drawn_force_at_bottom,
    draw_bottom_force,
    units=("s", "N"),
    notes=static_notes,
    curve=itself,
    values=(
        "wall_peak_force_N",
        "wall_dynamic_peak_force_N",
        "wall_impulse_Ns",
        "wall_dynamic_impulse_Ns",
        "base_arrival_s",
    ),
)
