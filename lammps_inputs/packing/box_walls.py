"""Walls of another program, identified by grains that extend slightly beyond the box of its
file.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.packing.cylinders import extents
from granwave.lammps_inputs.packing_kind import TOUCHING

_DEEPEST = 0.05  # diameters by which a grain reaches into a wall; beyond, the face is no wall
_AXES = 3


@dataclasses.dataclass(frozen=True)
class BoxWall:
    """Face of the box of a file that grains press.

    Attributes
    ----------
    axis
        Axis that it is normal to: 0 to 2.
    is_upper
        True for the face at the higher coordinate.
    place
        Its coordinate, m.
    n_grains
        Number of grains that press it.
    deepest
        Largest overlap of a grain with it, m.
    """

    axis: int
    is_upper: bool
    place: float
    n_grains: int
    deepest: float


def box_walls(grains: Grains) -> list[BoxWall]:
    """Return the faces of the box of a file that are walls, by the grains that press them.

    Grains extend beyond such a face, but not by more than the overlap of a contact. Periodic faces,
    and faces that grains cross, are no walls.
    """
    reading = grains.reading
    if reading is None or reading.bounds is None:
        return []
    extent = extents(grains.diameter / 2, grains.shape)
    slack = TOUCHING * grains.usual_diameter
    walls: list[BoxWall] = []
    for axis in range(_AXES):
        if reading.periodic[axis]:
            continue
        centre = grains.position[: len(extent), axis]
        low, high = reading.bounds[axis].tolist()
        beyond_faces = (low - (centre - extent[:, axis]), centre + extent[:, axis] - high)
        for is_upper, beyond in enumerate(beyond_faces):
            n_pressing = int(np.count_nonzero(beyond > slack))
            if n_pressing and (beyond <= _DEEPEST * grains.diameter).all():
                place = high if is_upper else low
                deepest = float(beyond.max())
                walls.append(BoxWall(axis, bool(is_upper), place, n_pressing, deepest))
    return walls
