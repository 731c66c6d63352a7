"""Marks at the edge of a panel of the points that its vertical axis does not show."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

_BELOW = "v"
_ABOVE = "^"
_SIZE = 4  # points
_NAME_OF_MARKS = "_outside"  # label that legends leave out


def mark_outside(axes: Axes, x: ArrayLike, y: ArrayLike, colour: Any) -> int:
    """Draw triangles at the lower and upper edge for finite points beyond the limits of the
    vertical axis, which must be final; return the number of these points.
    """
    places = np.asarray(x, dtype=np.float64)
    values = np.asarray(y, dtype=np.float64)
    low, high = axes.get_ylim()
    count = 0
    for edge, marker, outside in ((low, _BELOW, values < low), (high, _ABOVE, values > high)):
        at = places[outside]
        if not len(at):
            continue
        axes.plot(
            at,
            np.full(len(at), edge),
            marker,
            color=colour,
            markersize=_SIZE,
            clip_on=False,
            zorder=4,
            label=_NAME_OF_MARKS,
        )
        count += len(at)
    return count
