"""Legends within the axes, placed where they cover no curve."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.transforms import Bbox

_CORNERS = ("upper right", "upper left", "lower left", "lower right")
_OTHER_PLACES = ("center right", "center left", "lower center", "upper center")
_MARGIN = 2.0  # margin around a legend, points
_POINTS = 72.0  # points in an inch
_ABOVE = (0.5, 1.0)  # position of a legend that does not fit inside the axes, in axes coordinates
_COLUMNS_ABOVE = 3


def uncover_curves(figure: Figure) -> bool:
    """Move each legend that covers a curve to a free place within its axes, or above the axes.

    Returns
    -------
    bool
        True if a legend was moved above its axes, so that the layout has to be computed again.
    """
    moved = [uncover_curves_of(axes) for axes in figure.axes]
    return any(moved)


def uncover_curves_of(axes: Axes) -> bool:
    """Move the legend of axes as in `uncover_curves`; return True if it was moved
    above the axes.
    """
    legend = axes.get_legend()
    if legend is None or _is_outside(axes, legend) or not covers_curve(axes, legend):
        return False
    if _moves_within(axes, legend):
        return False
    _put_above(axes, legend)
    return True


def covers_curve(axes: Axes, legend: Legend) -> bool:
    """Return True if a legend covers a part of a line or a marker of its axes."""
    margin = _MARGIN * axes.figure.dpi / _POINTS  # type: ignore[union-attr]
    box = legend.get_window_extent().padded(margin)
    if any(path.intersects_bbox(box, filled=False) for path in _lines(axes)):
        return True
    return any(_contains(box, places) for places in _markers(axes))


def _lines(axes: Axes) -> Iterator[Path]:
    """Iterate over the drawn lines of axes, in pixels."""
    for line in axes.lines:
        if line.get_visible() and line.get_linestyle() != "None" and len(_points(line)):
            yield line.get_path().transformed(line.get_transform())


def _markers(axes: Axes) -> Iterator[np.ndarray]:
    """Iterate over the positions of markers, in pixels: (n, 2)."""
    for line in axes.lines:
        if line.get_visible() and line.get_marker() not in ("None", None, "", " "):
            yield line.get_transform().transform(_points(line))
    for collection in axes.collections:
        if isinstance(collection, PathCollection):
            yield collection.get_offset_transform().transform(collection.get_offsets())


def _points(line: Line2D) -> np.ndarray:
    return np.column_stack([line.get_xdata(orig=False), line.get_ydata(orig=False)])


def _contains(box: Bbox, places: np.ndarray) -> bool:
    """Return True if a box contains one of the positions."""
    inside = (box.x0 <= places[:, 0]) & (places[:, 0] <= box.x1)
    inside &= (box.y0 <= places[:, 1]) & (places[:, 1] <= box.y1)
    return bool(inside.any())


def _is_outside(axes: Axes, legend: Legend) -> bool:
    """Return True if a legend does not overlap the inside of its axes."""
    return not axes.bbox.overlaps(legend.get_window_extent().padded(-1.0))


def _moves_within(axes: Axes, legend: Legend) -> bool:
    """Move a legend to the first place within its axes where it covers no curve; False if there is
    none.
    """
    for place in (*_CORNERS, *_OTHER_PLACES):
        legend.set_bbox_to_anchor(None)
        moved: Any = legend  # any of the names of places
        moved.set_loc(place)
        if not covers_curve(axes, legend):
            return True
    return False


def in_one_column(axes: Axes, legend: Legend) -> Legend:
    """Replace a legend of axes by a legend with a column, within the axes."""
    handles, entries = _entries(axes, legend)
    return axes.legend(
        handles,
        entries,
        title=legend.get_title().get_text() or None,
        loc="upper right",
        frameon=legend.get_frame_on(),
        fontsize=legend.get_texts()[0].get_fontsize(),
    )


def _entries(axes: Axes, legend: Legend) -> tuple[Any, list[str]]:
    """Return the handles of a legend, as drawn in its axes, and its texts, which may be broken into
    other lines than the labels.
    """
    entries = [text.get_text() for text in legend.get_texts()]
    of_axes, labels = axes.get_legend_handles_labels()
    drawn = dict(zip(map(_in_one_line, labels), of_axes, strict=True))
    handles: Any = [  # those of the legend lack the markers of error bars
        drawn.get(_in_one_line(entry), handle)
        for entry, handle in zip(entries, legend.legend_handles, strict=True)
    ]
    return handles, entries


def _in_one_line(text: str) -> str:
    """Return a text without line breaks."""
    return text.replace("\n", " ")


def _put_above(axes: Axes, legend: Legend) -> None:
    """Replace a legend by a legend above its axes, with as many columns as fit."""
    handles, entries = _entries(axes, legend)
    for columns in range(min(_COLUMNS_ABOVE, len(entries)), 0, -1):
        above = axes.legend(
            handles,
            entries,
            title=legend.get_title().get_text() or None,
            loc="lower center",
            bbox_to_anchor=_ABOVE,
            ncols=columns,
            columnspacing=1.0,
            frameon=legend.get_frame_on(),
            fontsize=legend.get_texts()[0].get_fontsize(),
        )
        if above.get_window_extent().width <= axes.bbox.width:
            return
