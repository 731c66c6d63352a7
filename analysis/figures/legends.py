"""Legends within the axes, placed where they cover no curve."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.transforms import Bbox, offset_copy

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
    if legend is None or is_outside(axes, legend) or uncovers(axes, legend):
        return False
    if moves_within(axes, legend):
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


def is_outside(axes: Axes, legend: Legend) -> bool:
    """Return True if a legend does not overlap the inside of its axes."""
    return not axes.bbox.overlaps(legend.get_window_extent().padded(-1.0))


def moves_within(axes: Axes, legend: Legend) -> bool:
    """Move a legend to the first place within its axes where it covers no curve; False if there is
    none.
    """
    for place in (*_CORNERS, *_OTHER_PLACES):
        legend.set_bbox_to_anchor(None)
        moved: Any = legend  # any of the names of places
        moved.set_loc(place)
        if uncovers(axes, legend):
            return True
    return False


@dataclass(frozen=True, eq=False)
class Content:
    """Content of a legend: handles, texts, title, and True for a frame."""

    handles: list[Any]
    entries: list[str]
    title: str
    has_frame: bool

    def draw(self, axes: Axes, **options: Any) -> Legend:
        """Draw the legend in axes; ``options``: of a legend, such as its place."""
        return axes.legend(
            self.handles,
            self.entries,
            title=self.title or None,
            frameon=self.has_frame,
            **options,
        )


def content_of(axes: Axes, legend: Legend) -> Content:
    """Return the content of a legend: the handles as drawn in its axes, and its texts, which may be
    broken into other lines than the labels.
    """
    entries = [text.get_text() for text in legend.get_texts()]
    of_axes, labels = axes.get_legend_handles_labels()
    drawn = dict(zip(map(_in_one_line, labels), of_axes, strict=True))
    handles: Any = [  # those of the legend lack the markers of error bars
        drawn.get(_in_one_line(entry), handle)
        for entry, handle in zip(entries, legend.legend_handles, strict=True)
    ]
    return Content(handles, entries, legend.get_title().get_text(), legend.get_frame_on())


def _in_one_line(text: str) -> str:
    """Return a text without line breaks."""
    return text.replace("\n", " ")


def uncovers(axes: Axes, legend: Legend) -> bool:
    """Return True if a legend covers no curve of its axes, or of axes at the same position."""
    return not any(covers_curve(drawn, legend) for drawn in _at_one_position(axes))


def _at_one_position(axes: Axes) -> list[Axes]:
    """Return axes with the second axes that lie over them."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    place = axes.get_position().bounds
    others = [other for other in figure.axes if other.get_position().bounds == place]
    return [axes, *(other for other in others if other is not axes)]


def _put_above(axes: Axes, legend: Legend) -> None:
    """Replace a legend by a legend above its axes, with as many columns as fit."""
    content = content_of(axes, legend)
    size = float(legend.get_texts()[0].get_fontsize())
    for n_columns in range(min(_COLUMNS_ABOVE, len(content.entries)), 0, -1):
        above = place_above(axes, content, n_columns, size)
        if above.get_window_extent().width <= axes.bbox.width:
            return


def place_above(axes: Axes, content: Content, n_columns: int, size: float) -> Legend:
    """Draw a legend above axes and their title.

    Parameters
    ----------
    size
        Of its text, points.
    """
    title = axes.title.get_window_extent()
    height = max(title.y1 - axes.bbox.y1, 0.0) if axes.get_title() else 0.0
    figure = axes.get_figure(root=True)
    assert figure is not None
    points = _POINTS * height / figure.dpi
    return content.draw(
        axes,
        loc="lower center",
        bbox_to_anchor=_ABOVE,
        bbox_transform=offset_copy(axes.transAxes, figure, 0.0, points, units="points"),
        ncols=n_columns,
        columnspacing=1.0,
        fontsize=size,
    )
