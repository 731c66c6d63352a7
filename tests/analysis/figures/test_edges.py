"""Marks at the edge of a panel of points that its axis does not show."""

from __future__ import annotations

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np

from granwave.analysis.figures.edges import mark_outside
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.comparison.figures.dissipation_depth import (
    draw_dissipation,
    edge_notes,
)
from granwave.analysis.reports.comparison.subjects import ComparedRun


def test_points_beyond_both_edges_are_marked():
    figure, axes = plt.subplots()
    axes.set_ylim(1.0, 2.0)
    assert mark_outside(axes, [1, 2, 3, 4], [0.5, 1.5, 3.0, np.nan], "red") == 2
    below, above = axes.lines
    assert (below.get_xdata().tolist(), below.get_ydata().tolist()) == ([1.0], [1.0])
    assert (above.get_xdata().tolist(), above.get_ydata().tolist()) == ([3.0], [2.0])
    assert axes.get_ylim() == (1.0, 2.0)
    plt.close(figure)


def _curves(*values):
    """Dissipation by layer of a run with these values."""
    run = ComparedRun(SimpleNamespace(label="r"), "r", 0, look=0)
    return {run: SampledCurve(np.arange(len(values)) * 1e-3, np.array(values))}


def test_layers_below_the_axis_of_the_dissipation_are_marked():
    """Layers with hardly any dissipation, and without, are at the edge and in the caption."""
    curves = _curves(0.5, 0.1, 1.85e-5, 0.0)
    drawing = draw_dissipation(curves, [])
    axes = drawing.figure.axes[0]
    low = axes.get_ylim()[0]
    (marks,) = [line for line in axes.lines if line.get_marker() == "v"]
    assert marks.get_xdata().tolist() == [2.0, 3.0]
    assert marks.get_ydata().tolist() == [low, low]
    assert "Triangles" in edge_notes(curves)
    assert edge_notes(_curves(0.5, 0.1, 0.2)) == ""
    assert edge_notes(_curves(0.5, 0.1, 0.01)) == ""
