"""Titles of axes stay within the figure."""

from __future__ import annotations

import pickle

import pytest
from matplotlib.figure import Figure

from granwave.analysis.figures import style
from granwave.analysis.figures.titles import in_two_lines


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_long_title_is_broken(axis: str) -> None:
    with style.style():
        figure = style.new_figure(2.2)
        axes = figure.subplots()
        title = getattr(axes, f"{axis}axis").label
        title.set_text("Peak force between the spheres of a packing and its walls $F/F_y$")
        style.lay_out(figure, 200)
    box = title.get_window_extent(figure.canvas.get_renderer())
    assert title.get_text().count("\n") == 1
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1


@pytest.mark.parametrize("copy", [lambda figure: figure, lambda figure: pickle.loads(pickle.dumps(figure))])  # fmt: skip
def test_figures_without_a_canvas_to_draw_on_are_laid_out(copy) -> None:
    with style.style():
        figure = Figure((2.2, 2.0), layout="constrained")
        figure.subplots().set_xlabel("Peak force between the spheres of a packing and its walls")
        laid_out = copy(figure)
        style.lay_out(laid_out, 200)
    assert "\n" in laid_out.axes[0].get_xlabel()


def test_a_title_of_a_colour_bar_that_has_room_stays() -> None:
    with style.style():
        figure = style.new_figure(2.2)
        axes = figure.subplots()
        picture = axes.imshow([[0, 1], [2, 3]])
        bar = figure.colorbar(picture, ax=axes, location="bottom", label="Peak force $F/F_y$")
        style.lay_out(figure, 200)
    assert bar.ax.get_xlabel() == "Peak force $F/F_y$"


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("one two", "one\ntwo"),
        ("of $a / b c d e f$", "of\n$a / b c d e f$"),
        ("$a b$", "$a b$"),
        ("word", "word"),
        ("a\nb c", "a\nb c"),
    ],
)
def test_formulas_are_not_broken(text: str, lines: str) -> None:
    assert in_two_lines(text) == lines
