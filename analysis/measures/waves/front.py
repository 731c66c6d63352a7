"""Front of a wave in a packing: peak forces by layer within the cone of the preferred directions."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.geometry.planes import preferred_directions
from granwave.analysis.result.reader import Result

_INSIDE = -1e-6  # diameters, of a coordinate along a preferred direction: within the cone that these span
_LAYERS = 1e3  # in a diameter, by which depths are told apart


@dataclasses.dataclass(frozen=True, eq=False)
class Front:
    """Peak forces of the layers that the wave reached; every array (n_layers,).

    Attributes
    ----------
    depth
        Below the struck sphere, m.
    largest
        Peak force of a sphere, in the unit of the front.
    uniformity
        Mean over largest: 1 where the front is planar.
    """

    depth: NDArray[np.float64]
    largest: NDArray[np.float64]
    uniformity: NDArray[np.float64]

    @property
    def weak_from(self) -> float | None:
        """Depth of the layer from which on no force is above the unit, m; None if all are."""
        above = np.flatnonzero(self.largest > 1)
        first = int(above[-1]) + 1 if len(above) else 0
        return float(self.depth[first]) if first < len(self.depth) else None


def front_of(result: Result, unit: float) -> Front:
    """Return the front of an impact.

    Parameters
    ----------
    unit
        Of the forces, N.
    """
    depth, inside = result["spheres/position"][:, 2] - result.origin[2], in_cone(result)
    force, diameter = result["spheres/peak_force"][inside] / unit, result.case.packing.diameter
    layers, layer = np.unique(np.rint(_LAYERS * depth[inside] / diameter), return_inverse=True)
    largest = np.zeros(len(layers))
    np.maximum.at(largest, layer, force)
    mean = np.bincount(layer, force) / np.bincount(layer)
    reached = largest > 0
    return Front(layers[reached] * diameter / _LAYERS, largest[reached], mean[reached] / largest[reached])


def in_cone(result: Result) -> NDArray[np.bool_]:
    """Spheres within the cone that the preferred directions span: (n_spheres,); all where these are not three."""
    case = result.case
    directions = preferred_directions(case.packing.kind)
    offset = result["spheres/position"] - result.origin
    if len(directions) != 3:
        return np.ones(len(offset), dtype=bool)
    return np.all(offset @ np.linalg.inv(directions) > _INSIDE * case.packing.diameter, axis=1)
