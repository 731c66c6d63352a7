"""Legends are placed where they cover no curve."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures import style
from granwave.analysis.figures.legends import covers_curve

X = np.linspace(0, 1, 50)
CURVES = {
    "rising": [X],
    "falling": [1 - X],
    "cross": [X, 1 - X],
    "all over": [X, 1 - X, np.full(50, 0.1), np.full(50, 0.5), np.full(50, 0.9)],
}


@pytest.mark.parametrize("place", ["upper left", "upper right", "lower right", "center"])
@pytest.mark.parametrize("name", CURVES)
def test_no_curve_is_covered(name: str, place: str) -> None:
    with style.style():
        figure = style.new_figure(2.2)
        axes = figure.subplots()
        for number, y in enumerate(CURVES[name]):
            axes.plot(X, y, label=f"curve number {number}")
        axes.legend(loc=place)
        style.lay_out(figure, 200)
    legend = axes.get_legend()
    assert legend is not None
    assert not covers_curve(axes, legend)
    renderer = figure.canvas.get_renderer()
    box = legend.get_window_extent(renderer)
    assert box.y1 <= figure.bbox.y1 + 1
    assert len(legend.get_texts()) == len(CURVES[name])


def test_a_legend_that_covers_nothing_stays() -> None:
    with style.style():
        figure = style.new_figure(2.2)
        axes = figure.subplots()
        axes.plot(X, X, "o", label="points")
        axes.legend(loc="upper left")
        style.lay_out(figure, 200)
    assert axes.get_legend()._get_loc() == 2


def test_markers_count_without_a_line() -> None:
    with style.style():
        figure = style.new_figure(2.2)
        axes = figure.subplots()
        axes.plot(X, X, "o", label="points")
        axes.legend(loc="lower left")
        style.lay_out(figure, 200)
    assert not covers_curve(axes, axes.get_legend())
