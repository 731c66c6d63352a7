"""Arrival of the wave at each layer of several runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from granwave.analysis.document.model import named
from granwave.analysis.figures.series import column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import SampledCurve, front
from granwave.analysis.reports.comparison.figures.axes import (
    draw_measured,
    legend_above,
    run_markers,
    run_panels,
    run_styles,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure, itself
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

_MICRO = 1e6
_MILLI = 1e3


def draw_fronts(
    curves: Mapping[ComparedRun, SampledCurve], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the times at which the front of the wave reached each layer or bead."""
    figure, axes = run_panels(len(curves), 1, 2.7)
    columns: dict[str, Array] = {}
    for run, look in run_styles(list(curves)).items():
        curve = curves[run]
        axes.plot(curve.x * _MILLI, curve.y * _MICRO, **run_markers(run, curve.x), **look)
        name = column_name(run.label)
        columns |= {f"{name}_depth_m": curve.x, f"{name}_arrival_s": curve.y}
    columns |= draw_measured(axes, measured, _MILLI, _MICRO)
    label(axes, "Depth (mm)", "Arrival of the front (µs)")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    legend_above(figure)
    return Drawing(figure, columns)


def speed_notes(curves: Mapping[ComparedRun, SampledCurve]) -> str:
    """Return sentences on the front speeds of the runs, and on runs without one."""
    speeds = [(run.name, run.run.number("wave_speed_m_s")) for run in curves]
    parts = [f"{speed:.4g} m/s ({name})" for name, speed in speeds if speed is not None]
    without = [name for name, speed in speeds if speed is None]
    sentences: list[str] = []
    if parts:
        sentences.append(f"Speed of the front in the deeper half: {', '.join(parts)}.")
    if without:
        listed = named(without, len(without))
        sentences.append(
            f"No speed of the front, which requires nine layers that the wave reached: {listed}."
        )
    return " ".join(sentences)


FRONTS = ComparisonFigure(
    "Arrival of the front of the wave at each layer",
    front,
    draw_fronts,
    units=("m", "s"),
    notes=speed_notes,
    curve=itself,
    has_peak=False,
    values=("wave_speed_m_s",),
)
