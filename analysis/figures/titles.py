"""Titles of axes that are longer than the figure, broken into lines."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.text import Text

_MATHEMATICS = "$"  # delimiter of formulas, which are never broken


def break_long_titles(figure: Figure) -> bool:
    """Break each title of an axis that leaves the figure into two lines of similar length.

    Returns
    -------
    bool
        True if a title was broken, so that the layout has to be computed again.
    """
    broken = False
    for axes in figure.axes:
        middle = 0.5 * (axes.bbox.p0 + axes.bbox.p1)
        for direction, axis in enumerate((axes.xaxis, axes.yaxis)):
            if _leaves(figure, axis.label, direction, float(middle[direction])):
                lines = in_two_lines(axis.label.get_text())
                axis.label.set_text(lines)
                broken = broken or "\n" in lines
    return broken


def in_two_lines(text: str) -> str:
    """Return a text in two lines of similar length; unchanged if it has several lines, or only
    formulas.
    """
    places = [
        place
        for place, character in enumerate(text)
        if character == " " and text.count(_MATHEMATICS, 0, place) % 2 == 0
    ]
    if "\n" in text or not places:
        return text
    middle = min(places, key=lambda place: abs(place - len(text) / 2))
    return f"{text[:middle]}\n{text[middle + 1 :]}"


def _leaves(figure: Figure, title: Text, direction: int, middle: float) -> bool:
    """Return True if a title around the middle of its axis extends beyond the figure.

    Parameters
    ----------
    direction
        0 for a title along x, 1 along y.
    middle
        Middle of the axis, pixels: a title is moved there only when it is drawn.
    """
    if not title.get_text():
        return False
    half = 0.5 * title.get_window_extent().size[direction]
    low, high = figure.bbox.get_points()[:, direction]
    return bool(middle - half < low or middle + half > high)
