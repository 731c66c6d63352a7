"""Planes through the struck sphere along the symmetry directions of a packing, and preferred directions.

fcc, struck along [111] (thesis 5.2): three <110> directions OA, OB, OC go down into the packing, and the
largest forces run along them. The principal plane OAB is the close-packed plane that holds two of them; it is
inclined by 70.5 degrees. The orthogonal plane OCD holds the third and the impact axis OD; it is vertical and
a mirror plane.

The other kinds have vertical planes:

======  ==============================================  ===============================================
kind    principal                                       orthogonal
======  ==============================================  ===============================================
hcp     close-packed row and impact axis; the rows of   mirror plane x = 0, normal to that row
        odd layers, sqrt(3)/6 D beside it, are shown
bcc     (110), holds two of the <111> directions down   (010), between those directions
sc      (010), holds two rows of contacts               (110), diagonal
square  the packing itself                              none
chain   none                                            none
======  ==============================================  ===============================================
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_ON_PLANE = 0.01  # diameters
_HCP_ROWS = 0.3  # diameters: takes in the rows sqrt(3)/6 D beside the plane


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane through the struck sphere.

    Attributes
    ----------
    name
        principal or orthogonal.
    across
        Unit vector to the right: (3,).
    down
        Unit vector downwards, or along y for a packing of one layer: (3,).
    tolerance
        Largest distance of a centre from the plane, diameters.
    down_label
        What the coordinate along ``down`` is called.
    """

    name: str
    across: NDArray[np.float64]
    down: NDArray[np.float64]
    tolerance: float = _ON_PLANE
    down_label: str = "Depth"

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal: (3,)."""
        return np.cross(self.across, self.down)


@dataclass(frozen=True, eq=False)
class Section:
    """The spheres of a packing that lie on a plane.

    Attributes
    ----------
    plane
        The plane.
    index
        Rows of the spheres: (n,).
    across, down
        Coordinates in the plane, 0 at the struck sphere: (n,), m.
    """

    plane: Plane
    index: NDArray[np.int64]
    across: NDArray[np.float64]
    down: NDArray[np.float64]


def planes(kind: str) -> tuple[Plane, ...]:
    """The planes of a kind of packing: principal, then orthogonal, as far as there are any."""
    x, y, z = np.eye(3)
    diagonal = (x + y) / math.sqrt(2)
    if kind == "fcc":
        down = np.array([0.0, 1 / 3, math.sqrt(8) / 3])
        inclined = Plane("principal", x, down, down_label="Distance down the plane")
        return inclined, Plane("orthogonal", y, z)
    return {
        "hcp": (Plane("principal", x, z, _HCP_ROWS), Plane("orthogonal", y, z)),
        "bcc": (Plane("principal", diagonal, z), Plane("orthogonal", x, z)),
        "sc": (Plane("principal", x, z), Plane("orthogonal", diagonal, z)),
        "square": (Plane("principal", x, y, down_label="y"),),
    }.get(kind, ())


def section(plane: Plane, positions: NDArray[np.float64], origin: NDArray[np.float64], diameter: float) -> Section:
    """The spheres that lie on a plane.

    Parameters
    ----------
    positions
        (n_spheres, 3), m.
    origin
        Centre of the struck sphere: (3,), m.
    diameter
        m.
    """
    offset = positions - origin
    index = np.flatnonzero(np.abs(offset @ plane.normal) <= plane.tolerance * diameter)
    return Section(plane, index, offset[index] @ plane.across, offset[index] @ plane.down)


def preferred_directions(kind: str) -> NDArray[np.float64]:
    """Unit vectors from the struck sphere to those it rests on; in a square packing to its neighbours.

    Returns
    -------
    ndarray
        (n_directions, 3): 3 for fcc (<110>) and hcp, 4 for bcc (<111>) and square, 1 for sc and chain. They
        are equal by symmetry. In hcp only the first contact lies on a straight line.
    """
    if kind in ("fcc", "hcp"):
        depth, side = math.sqrt(2 / 3), math.sqrt(3) / 6
        return np.array([[0.5, side, depth], [-0.5, side, depth], [0.0, -2 * side, depth]])
    if kind == "bcc":
        return np.array([[a, b, 1] for a, b in itertools.product((1, -1), repeat=2)]) / math.sqrt(3)
    if kind == "square":
        return np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    return np.array([[0.0, 0.0, 1.0]])
