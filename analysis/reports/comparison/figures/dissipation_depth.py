"""Dissipation of several runs by layer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from granwave.analysis.figures.edges import mark_outside
from granwave.analysis.figures.series import column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    SampledCurve,
    dissipation_at_walls,
    dissipation_by_depth,
)
from granwave.analysis.reports.comparison.figures.axes import (
    is_wide,
    legend_above,
    log_if_wide,
    run_markers,
    run_panels,
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
    """Draw the dissipated fraction of the input by layer; triangles at the lower edge of a
    logarithmic axis are layers below it, or without dissipation.
    """
    figure, axes = run_panels(len(curves), 1, 2.7)
    columns: dict[str, Array] = {}
    positive = _positive(curves)
    is_logarithmic = is_wide(positive)
    looks = run_styles(list(curves))
    for run, look in looks.items():
        curve = curves[run]
        shown = (curve.y > 0) | (not is_logarithmic)
        axes.plot(curve.x[shown] * _MILLI, curve.y[shown], **run_markers(run, curve.x), **look)
        name = column_name(run.label)
        columns |= {f"{name}_depth_m": curve.x, f"{name}_dissipated_over_input": curve.y}
    label(axes, "Depth (mm)", "Dissipation of the layer / input")
    log_if_wide(axes)
    if is_logarithmic:
        axes.set_ylim(bottom=max(axes.get_ylim()[0], _DECADES * positive.max()))
        for run, look in looks.items():
            mark_outside(axes, curves[run].x * _MILLI, curves[run].y, look["color"])
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


def _positive(curves: Mapping[ComparedRun, SampledCurve]) -> Array:
    """Return the dissipation of all layers that dissipate."""
    values = np.concatenate([curve.y for curve in curves.values()])
    return values[values > 0]


def edge_notes(curves: Mapping[ComparedRun, SampledCurve]) -> str:
    """Return a sentence on the layers at the lower edge; empty if there are none."""
    positive = _positive(curves)
    smallest = min(float(curve.y.min()) for curve in curves.values())
    if not is_wide(positive) or smallest >= _DECADES * positive.max():
        return ""
    return (
        "Triangles at the lower edge: layers that dissipate less than 1e-4 of the largest "
        "dissipation of a layer, or nothing."
    )


def depth_notes(curves: Mapping[ComparedRun, SampledCurve]) -> str:
    """Return the sentences on walls and on layers at the edge; empty if there are none."""
    return " ".join(filter(None, [_wall_notes(curves), edge_notes(curves)]))


DISSIPATION_DEPTH = ComparisonFigure(
    "Dissipation by layer, relative to the input",
    dissipation_by_depth,
    draw_dissipation,
    notes=depth_notes,
    is_cumulative=True,
    values=("dissipated_fraction", "zone_depth_90_interpolated_m"),
)
