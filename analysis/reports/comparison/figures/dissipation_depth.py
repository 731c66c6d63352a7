"""Dissipation of several runs by layer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from granwave.analysis.figures.series import column_name, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    SampledCurve,
    dissipation_at_walls,
    dissipation_by_depth,
)
from granwave.analysis.reports.comparison.figures.axes import (
    legend_above,
    log_if_wide,
    run_markers,
    run_styles,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

_MILLI = 1e3
_MUCH = 0.1  # fraction of the dissipation of a layer
_DECADES = 1e-4  # lowest over highest value of a logarithmic axis


def draw_dissipation(
    curves: Mapping[ComparedRun, SampledCurve], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the dissipated fraction of the input by layer."""
    figure, axes = panels(2.7)
    columns: dict[str, Array] = {}
    highest = max(float(curve.y.max()) for curve in curves.values())
    for run, look in run_styles(list(curves)).items():
        curve = curves[run]
        shown = curve.y > 0
        axes.plot(curve.x[shown] * _MILLI, curve.y[shown], **run_markers(run, curve.x), **look)
        name = column_name(run.label)
        columns |= {f"{name}_depth_m": curve.x, f"{name}_dissipated_over_input": curve.y}
    label(axes, "Depth (mm)", "Dissipation of the layer / input")
    log_if_wide(axes)
    if axes.get_yscale() == "log":
        axes.set_ylim(bottom=max(axes.get_ylim()[0], _DECADES * highest))
    legend_above(figure)
    return Drawing(figure, columns)


def _wall_notes(curves: Mapping[ComparedRun, SampledCurve]) -> str:
    """Return a sentence on the layers whose dissipation is largely that at walls; empty without
    such layers.
    """
    texts = []
    for run in curves:
        at_walls = dissipation_at_walls(run)
        place = int(at_walls.y.argmax())
        if at_walls.y[place] >= _MUCH:
            depth = quantity_in(float(at_walls.x[place]), "m")
            texts.append(f"{100 * at_walls.y[place]:.3g} % at {depth} in {run.label}")
    if not texts:
        return ""
    return f"The contacts of a layer with walls are included ({'; '.join(texts)})."


DISSIPATION_DEPTH = ComparisonFigure(
    "Dissipation by layer, relative to the input",
    dissipation_by_depth,
    draw_dissipation,
    notes=_wall_notes,
    is_cumulative=True,
    values=("dissipated_fraction", "zone_depth_90_interpolated_m"),
)
