"""Style of points and bars of plastic zones: open if they reach a boundary, half open or pale if a wave returned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from numpy.typing import NDArray

from granwave.analysis.measures.zone.marks import LABELS, Mark

Marks = NDArray[np.int64] | None  # `Mark` of each point: (n,); None for quantities without marks


def marks_of(series: Sequence[Marks]) -> dict[Mark, str]:
    """Return the marks that occur in several series, with their labels."""
    there = {mark for marks in series if marks is not None for mark in np.unique(marks).tolist()}
    return {mark: label for mark, label in LABELS.items() if mark in there}


def draw_marks(axes: Axes, x: NDArray, y: NDArray, marks: Marks, marker: str, size: float, colour: Any) -> None:
    """Draw the marked points over existing ones."""
    for mark in LABELS:
        shown = np.zeros(len(x), dtype=bool) if marks is None else marks == mark
        if shown.any():
            axes.plot(np.asarray(x)[shown], np.asarray(y)[shown], zorder=3, **marked_marker(mark, marker, size, colour))


def marked_marker(mark: Mark, marker: str, size: float, colour: Any) -> dict[str, Any]:
    """Return the style of a marked point."""
    look = {"marker": marker, "markersize": size, "color": colour, "markeredgewidth": 0.9, "linestyle": "none"}
    if mark is Mark.CUT:
        return look | {"markerfacecolor": "white"}
    return look | {"fillstyle": "left", "markerfacecoloralt": "white"}


def marked_fill(mark: Mark, colour: str) -> dict[str, Any]:
    """Return the style of a marked bar."""
    return {"facecolor": "white" if mark is Mark.CUT else to_rgba(colour, 0.35), "edgecolor": colour, "linewidth": 1.0}
