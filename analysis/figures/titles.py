"""Titles of axes that are longer than the figure, broken into lines."""

from __future__ import annotations

import re

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

_MOST_LINES = 4  # in a title of an axis
_DIVIDED_BY = "/"  # no line ends with it
_UNIT = re.compile(r"\([^()]{1,12}\)")  # units in parentheses, which are never broken
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


def fit_titles(axes: Axes) -> bool:
    """Break titles that are longer than their axis into up to `_MOST_LINES` lines; return True if a
    title was broken, so that the layout has to be computed again.
    """
    broken = False
    for length, axis in ((axes.bbox.width, axes.xaxis), (axes.bbox.height, axes.yaxis)):
        title = axis.label
        extent = "width" if axis is axes.xaxis else "height"
        text = title.get_text().replace("\n", " ")
        n_lines = title.get_text().count("\n") + 1
        while getattr(title.get_window_extent(), extent) > length and n_lines < _MOST_LINES:
            n_lines += 1
            title.set_text(in_lines(text, n_lines))
            broken = True
    return broken


def in_two_lines(text: str) -> str:
    """Return a text in two lines of similar length; unchanged if it has several lines, or only
    formulas.
    """
    return text if "\n" in text else in_lines(text, 2)


def in_lines(text: str, n_lines: int) -> str:
    """Return a text of one line in lines of similar length, in fewer if it has too few words;
    formulas and units are not broken.
    """
    places = [place for place, letter in enumerate(text) if letter == " " and _breaks(text, place)]
    if not places:
        return text
    ends = [len(text) * line / n_lines for line in range(1, n_lines)]
    breaks = {min(places, key=lambda place: abs(place - end)) for end in ends}
    return "".join("\n" if place in breaks else character for place, character in enumerate(text))


def _breaks(text: str, place: int) -> bool:
    """Return True for a blank of a text at which a line can end."""
    if text[:place][-1:] == _DIVIDED_BY or text.count(_MATHEMATICS, 0, place) % 2:
        return False
    return not any(unit.start() < place < unit.end() for unit in _UNIT.finditer(text))


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
