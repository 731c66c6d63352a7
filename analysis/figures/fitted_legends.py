"""Legends of axes of the user: no wider than the axes, inside them where they cover nothing, else
above with a limited height.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.legend import Legend

from granwave.analysis.figures.legends import (
    Content,
    content_of,
    is_outside,
    moves_within,
    place_above,
    uncovers,
)
from granwave.analysis.figures.titles import in_lines

_SIZES = (8.0, 7.0, 6.0)  # font sizes, points; smaller text cannot be read in print
_TALLEST = 0.38  # height of a legend above axes / height of the axes without it
_LOW = 0.22  # such a height below which a legend stays above axes with space for it inside
_NARROW = 0.97  # width of a legend above axes / width of the axes; text widths vary with dpi
_WIDEST_INSIDE = 0.75  # width of a legend inside axes / width of the axes
_TALLEST_INSIDE = 0.62  # height of a legend inside axes / height of the axes
_MOST_LINES = 4  # in an entry
_MOST_COLUMNS = 6
_LONG = 0.5  # width of an entry / longest entry, from which it is broken into lines


class _Form(NamedTuple):
    """Form of a legend: font size, points, number of columns, and lines in an entry, 0 for those of
    the labels.
    """

    size: float
    n_columns: int
    n_lines: int


def fit_legend(axes: Axes) -> bool:
    """Fit the legend of axes, whose layout leaves no place for it yet; return True if it is above
    the axes, so that the layout has to be computed again.
    """
    legend = axes.get_legend()
    if legend is None:
        return False
    if not is_outside(axes, legend) and _is_small(axes, legend) and uncovers(axes, legend):
        return False
    content = content_of(axes, legend)
    sizes = _sizes(legend)
    form = _best_above(axes, content, sizes)
    legend = _drawn_above(axes, content, form)
    height = legend.get_window_extent().height
    if height > _LOW * axes.bbox.height and _has_curves_only(axes):
        if _goes_inside(axes, content, sizes):
            return False
        legend = _drawn_above(axes, content, form)
    legend.set_in_layout(True)
    return True


def narrow_above(axes: Axes) -> None:
    """Reduce the text of a legend above axes, which the layout may have made narrower, to their
    width; a legend with the smallest text gets fewer columns or more lines in its entries.
    """
    legend = axes.get_legend()
    if legend is None or not is_outside(axes, legend):
        return
    ratio = _NARROW * axes.bbox.width / legend.get_window_extent().width
    if ratio >= 1:
        return
    size = float(legend.get_texts()[0].get_fontsize())
    smallest = min(size, _SIZES[-1])
    if ratio * size >= smallest:
        for text in legend.get_texts():
            text.set_fontsize(ratio * size)
        return
    content = content_of(axes, legend)
    legend = _drawn_above(axes, content, _best_above(axes, content, [smallest]))
    legend.set_in_layout(True)


def _is_small(axes: Axes, legend: Legend) -> bool:
    """Return True if a legend leaves room for curves inside its axes."""
    extent = legend.get_window_extent()
    is_narrow = extent.width <= axes.bbox.width
    return is_narrow and extent.height <= _TALLEST_INSIDE * axes.bbox.height


def _has_curves_only(axes: Axes) -> bool:
    """Return True for axes with lines and markers only, without areas and images."""
    is_curves = all(
        isinstance(collection, LineCollection | PathCollection) for collection in axes.collections
    )
    return is_curves and not axes.images and not axes.patches


def _sizes(legend: Legend) -> list[float]:
    """Return the font sizes for a legend, none larger than its own."""
    own = float(legend.get_texts()[0].get_fontsize())
    return [min(own, size) for size in _SIZES if size <= own] or [own]


def _forms(n_entries: int, sizes: Sequence[float], most_columns: int) -> Iterator[list[_Form]]:
    """Iterate over the forms of a legend by font size."""
    counts = range(min(most_columns, n_entries), 0, -1)
    for size in sizes:
        pairs = product(counts, range(_MOST_LINES + 1))
        yield [_Form(size, n_columns, n_lines) for n_columns, n_lines in pairs]


def _best_above(axes: Axes, content: Content, sizes: Sequence[float]) -> _Form:
    """Return the form of a legend above axes with the largest text with which it is no wider than
    the axes and not too tall, or with the lowest height.
    """
    lowest = _Form(sizes[-1], 1, _MOST_LINES)
    least = float("inf")
    for forms in _forms(len(content.entries), sizes, _MOST_COLUMNS):
        for form in forms:
            extent = _drawn_above(axes, content, form).get_window_extent()
            if extent.width <= axes.bbox.width and extent.height < least:
                least = extent.height
                lowest = form
        if least <= _TALLEST * axes.bbox.height:
            break
    return lowest


def _drawn_above(axes: Axes, content: Content, form: _Form) -> Legend:
    """Draw a legend above axes in a form."""
    legend = place_above(axes, content, form.n_columns, form.size)
    _break(legend, form.n_lines)
    return legend


def _goes_inside(axes: Axes, content: Content, sizes: Sequence[float]) -> bool:
    """Draw a legend inside axes that covers no curve; return False if there is no place."""
    for forms in _forms(len(content.entries), sizes, 1):
        for form in forms:
            inside = content.draw(axes, loc="upper right", fontsize=form.size)
            _break(inside, form.n_lines)
            extent = inside.get_window_extent()
            is_narrow = extent.width <= _WIDEST_INSIDE * axes.bbox.width
            if not is_narrow or extent.height > _TALLEST_INSIDE * axes.bbox.height:
                continue
            if uncovers(axes, inside) or moves_within(axes, inside):
                inside.set_in_layout(False)
                return True
    return False


def _break(legend: Legend, n_lines: int) -> None:
    """Break the long entries of a legend into a number of lines; 0: leaves them as they are."""
    if not n_lines:
        return
    texts = legend.get_texts()
    for text in texts:
        text.set_text(text.get_text().replace("\n", " "))
    longest = max(text.get_window_extent().width for text in texts)
    for text in texts:
        if text.get_window_extent().width > _LONG * longest and n_lines > 1:
            text.set_text(in_lines(text.get_text(), n_lines))
