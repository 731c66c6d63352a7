"""Planes, directions, layers and nearest positions in packings.

Planes and directions belong to the perfect packing. Spheres on the planes are selected by position,
within a tolerance, so that scattered diameters, settled positions and missing spheres are allowed.

fcc, impact along [111]: three <110> directions OA, OB, OC go down into the packing, and the largest
forces run along them. The principal plane OAB is the close-packed plane that holds two of them; it
is inclined by 70.5 degrees. The orthogonal plane OCD holds the third and the impact axis OD; it is
vertical and a mirror plane.

The other kinds have vertical planes:

======  ==============================================  ===============================================
kind    principal                                       orthogonal
======  ==============================================  ===============================================
hcp     close-packed row and impact axis; the rows of   mirror plane x = 0, normal to that row
        odd layers, sqrt(3)/6 D next to it, are shown
bcc     (110), holds two of the <111> directions down   (010), between those directions
sc      (010), holds two rows of contacts               (110), diagonal
square  the packing itself                              none
chain   none                                            none
======  ==============================================  ===============================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Array
from granwave.lammps_inputs.lattices import INCLINED, kind_of, section_planes

_LEVEL = 1 - 1e-9  # cosine from which two directions are the same
_LAYER_GAP = 0.2  # diameters of the smallest sphere, between two layers
_LAYER_HEIGHT = 0.5  # nominal diameters, at most, that a layer's centres are apart

_BY_TREE = 3_000_000  # distances from which on a tree gains more than loading it takes
# distances that are computed at a time, whose numbers fit into the processor's cache
_BLOCK = 200_000


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane through the impacted sphere; vectors are (3,)."""

    name: str  # principal, orthogonal or section
    across: Array  # unit vector to the right
    down: Array  # unit vector downwards, or along y for a packing of one layer
    tolerance: float  # largest distance of a centre from the plane, diameters
    down_label: str  # name of the coordinate along `down`
    across_label: str = "Distance from the impact axis"  # name of the coordinate along `across`
    through: Array | None = None  # a point of the plane, m; None: the centre of the struck sphere

    @property
    def normal(self) -> Array:
        """Unit normal: (3,)."""
        return np.cross(self.across, self.down)


@dataclass(frozen=True, eq=False)
class SpheresOnPlane:
    """The spheres of a packing that lie on a plane; every array (n,)."""

    plane: Plane
    index: NDArray[np.int64]  # rows of the spheres
    across: Array  # coordinates in the plane, 0 at the struck sphere, m
    down: Array
    height: Array  # distances of the centres from the plane, m


def planes(kind: str) -> tuple[Plane, ...]:
    """The planes of a kind of packing: principal, then orthogonal, if they exist."""
    return tuple(
        Plane(name, np.array(plane.across), np.array(plane.down), plane.tolerance, plane.down_label)
        for name, plane in zip(("principal", "orthogonal"), section_planes(kind), strict=False)
    )


def section(plane: Plane, positions: Array, origin: Array, diameter: float) -> SpheresOnPlane:
    """The spheres at ``positions`` (n_spheres, 3), m, that lie on a plane; ``origin``: centre of
    the impacted sphere.
    """
    offset = positions - origin
    middle = np.zeros(3) if plane.through is None else plane.through - origin
    height = (offset - middle) @ plane.normal
    index = np.flatnonzero(np.abs(height) <= plane.tolerance * diameter)
    return SpheresOnPlane(
        plane, index, offset[index] @ plane.across, offset[index] @ plane.down, height[index]
    )


def own_plane(
    normal: Sequence[float], through: Sequence[float] | None, tolerance: float = 0.5
) -> Plane:
    """Return a plane of any direction, named section; depth is downwards in it; in a horizontal
    plane the second axis is y.

    Parameters
    ----------
    normal
        Its normal, of any length: (3,).
    through
        A point of it: (3,), m; None: the centre of the impacted sphere.
    tolerance
        As in `Plane`; half a diameter shows all spheres that the plane cuts.
    """
    unit = np.array(normal, dtype=float) / np.linalg.norm(normal)
    level = abs(unit[2]) > _LEVEL
    down = np.array([0.0, 1.0, 0.0] if level else [0.0, 0.0, 1.0])
    down = down - (down @ unit) * unit
    down /= np.linalg.norm(down)
    across = np.cross(down, unit)
    across *= 1.0 if across[np.argmax(np.abs(across))] > 0 else -1.0
    vertical = abs(unit[2]) < 1 - _LEVEL
    down_label = "Depth" if vertical else INCLINED
    if level:
        down_label = "y"
    axis = "Distance across"
    if level or abs(across[0]) > _LEVEL:
        axis = "x"
    elif abs(across[1]) > _LEVEL:
        axis = "y"
    across_label = f"{axis}, from the impact axis"
    point = None if through is None else np.array(through, dtype=float)
    return Plane("section", across, down, tolerance, down_label, across_label, point)


def preferred_directions(kind: str) -> Array:
    """Unit vectors from the impacted sphere to the spheres on which it rests; in a square packing
    to its neighbours.

    (n_directions, 3): 3 for fcc (<110>) and hcp, 4 for bcc (<111>) and square, 1 for sc and chain.
    They are equal by symmetry. In hcp only the first contact lies on a straight line.
    """
    return kind_of(kind).preferred_directions


def layers(depth: Array, radii: Array, diameter: float) -> tuple[Array, NDArray[np.int64]]:
    """The layers in which spheres lie, found by the gaps between their depths.

    Without gaps, as in a disordered bed, layers are slices with a thickness of half a diameter.

    Parameters
    ----------
    depth, radii
        Of the centres, and of the spheres: (n_spheres,), m.
    diameter
        Nominal, m.

    Returns
    -------
    tuple
        Mean depth of each layer, rising, (n_layers,), m, and the row of each sphere's layer,
        (n_spheres,).
    """
    order = np.argsort(depth, kind="stable")
    apart = np.diff(depth[order]) > _LAYER_GAP * 2 * radii.min(initial=np.inf)
    layer = np.empty(len(depth), dtype=np.int64)
    layer[order] = np.concatenate([[0], np.cumsum(apart)])
    n_layers = layer.max(initial=-1) + 1
    lowest = np.full(n_layers, np.inf)
    highest = np.full(n_layers, -np.inf)
    np.minimum.at(lowest, layer, depth)
    np.maximum.at(highest, layer, depth)
    if np.any(highest - lowest > _LAYER_HEIGHT * diameter):
        slices = np.floor((depth - depth.min()) / (_LAYER_HEIGHT * diameter))
        layer = np.unique(slices, return_inverse=True)[1]
    return np.bincount(layer, depth) / np.bincount(layer), layer


def nearest(points: Array, places: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return the distance from each point to its nearest position, m, and the row of that position:
    (n_points,) each.

    Points and positions are (n_points, 3) and (n_places, 3), m; with at least one position.
    """
    if len(points) * len(places) > _BY_TREE and len(places) > 1:
        from scipy.spatial import cKDTree  # imported on demand: slow to load

        distance, row = cKDTree(places).query(points)
        return distance, row.astype(np.int64)
    row = np.empty(len(points), dtype=np.int64)
    block = max(1, _BLOCK // len(places))
    for start in range(0, len(points), block):
        square = sum(
            (points[start : start + block, None, axis] - places[:, axis]) ** 2 for axis in range(3)
        )
        row[start : start + block] = np.argmin(square, axis=1)
    return np.linalg.norm(points - places[row], axis=1), row
