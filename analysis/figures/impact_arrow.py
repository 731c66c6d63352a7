"""Arrow that shows the position and direction of the load in images of a packing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.motion import struck_of, velocities_of

_SEEN = 0.1  # length of a unit vector as seen, below which it points at the viewer or away
_LENGTH = 1.3  # length of the arrow, diameters
_GAP = 0.1  # gap between the tip and the sphere, diameters
_LOOK = {"arrowstyle": "-|>", "linewidth": 1.2, "color": "black", "shrinkA": 0, "shrinkB": 0}
_DOT = 1.5  # size of the symbol of an arrow that is seen end-on, points
_CIRCLE = 5.0  # points: around it

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ImpactArrow:
    """Position and direction of a load.

    Attributes
    ----------
    place
        Centre of the bodies that move first, or that the load acts on: (3,), m.
    direction
        Unit vector along their momentum or the force: (3,).
    """

    place: Vector
    direction: Vector


def impact_arrow(result: Result) -> ImpactArrow:
    """Return the arrow of the load of a run."""
    assembly = result.assembly
    moving = velocities_of(assembly)
    if not moving:
        ids = np.array(struck_of(assembly), dtype=np.int64)
        place = result["spheres/position"][result.rows(ids)].mean(axis=0) if len(ids) else None
        direction = np.array(assembly.case.load.way)
        return ImpactArrow(result.origin if place is None else place, direction)
    masses = np.array([assembly.mass_of(number) for number in moving])
    momentum = masses @ np.array(list(moving.values()))
    rows = result.rows(np.array(list(moving), dtype=np.int64))
    place = masses @ result["spheres/position"][rows] / masses.sum()
    length = float(np.linalg.norm(momentum))
    if length == 0:  # bodies that move towards each other
        return ImpactArrow(place, np.array([0.0, 0.0, 1.0]))
    return ImpactArrow(place, momentum / length)


def draw_arrow(
    axes: Axes, place: Vector, direction: Vector, diameter: float, length: float = _LENGTH
) -> Vector:
    """Draw an arrow whose tip touches a disc, or a circle with a dot if it points along the line of
    sight.

    Parameters
    ----------
    place
        Centre of the disc in the axes: (2,).
    direction
        Unit vector as seen in the axes: (2,), shorter than 1 if it does not lie in their plane.
    diameter
        Diameter of the disc, in the unit of the axes.
    length
        Length of the arrow, in diameters.

    Returns
    -------
    ndarray
        Tail of the arrow: (2,).
    """
    seen = float(np.hypot(*direction))
    if seen < _SEEN:
        axes.plot(*place, "o", color="black", markersize=_CIRCLE, markerfacecolor="none")
        axes.plot(*place, "o", color="black", markersize=_DOT)
        return place
    along = direction / seen
    tip = place - (0.5 + _GAP) * diameter * along
    tail = tip - length * diameter * along
    axes.annotate("", xy=tuple(tip), xytext=tuple(tail), arrowprops=_LOOK, annotation_clip=False)
    return tail
