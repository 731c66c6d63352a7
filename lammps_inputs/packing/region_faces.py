"""Faces of regions: distances and normals of spheres at them, as computed by the wall fix."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import elliptic_radius
from granwave.lammps_inputs.case.region_walls import SIDE, RegionShape

Floats = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class RegionFace:
    """Face of a region that is a wall.

    Attributes
    ----------
    region
        Id of the region in the deck.
    words
        Its words behind the id.
    shape
        Shape of the region.
    name
        Name of the face.
    """

    region: str
    words: str
    shape: RegionShape
    name: str

    @property
    def definition(self) -> str:
        """Command that defines the region."""
        return f"region          {self.region} {self.words} units box"

    @property
    def style(self) -> str:
        """Words of the wall fix."""
        return f"region {self.region} {self.name}"

    def distances(self, positions: Floats) -> Floats:
        """Return the distances of positions (n, 3) from the face, infinite outside of the region:
        (n,), m.
        """
        own, _ = _distance(self.shape, self.name, positions)
        if not self.shape.is_inside:
            return np.where(own > 0, own, np.inf)
        beyond = [_distance(self.shape, name, positions)[0] < 0 for name in _all_faces(self.shape)]
        return np.where(np.any(beyond, axis=0), np.inf, own)

    def nearest(self, positions: Floats) -> Floats:
        """Return the nearest points of the face to positions (n, 3): (n, 3), m."""
        distance, normal = _distance(self.shape, self.name, positions)
        return positions - distance[:, None] * normal

    def effective_radii(self, radii: Floats) -> Floats:
        """Return the radii of spheres that are as stiff on a plane as the given spheres on the
        face: (n,), m.
        """
        shape = self.shape
        side = -1.0 if shape.is_inside else 1.0
        if shape.style == "sphere":
            return np.asarray(1 / (1 / radii + side / shape.values[3]))
        if shape.style == "cylinder" and (self.name == SIDE or not shape.is_inside):
            return np.asarray(elliptic_radius(1 / radii, 1 / radii + side / shape.values[2]))
        return radii


def contains(shape: RegionShape, positions: Floats) -> NDArray[np.bool_]:
    """Return True for positions (n, 3), m, in a region or on its faces: (n,)."""
    names = _all_faces(shape) if shape.is_inside else ("",)
    distances = [_distance(shape, name, positions)[0] for name in names]
    inside: NDArray[np.bool_] = np.min(distances, axis=0) >= 0
    return inside


def _all_faces(shape: RegionShape) -> tuple[str, ...]:
    """Return the names of all faces of the inside of a region at finite positions."""
    bounds = shape.bounds
    names = [name for name, place in bounds.items() if math.isfinite(place)]
    if shape.style == "block":
        return tuple(names)
    return (*names, SIDE) if shape.axis else ("",)


def _distance(shape: RegionShape, face: str, positions: Floats) -> tuple[Floats, Floats]:
    """Return distances (n,), m, from a face, negative behind it, and its normals (n, 3)."""
    if face in shape.bounds:
        axis = "xyz".index(shape.axis or face[0])
        sign = 1.0 if face.endswith("lo") else -1.0
        normal = np.zeros_like(positions)
        normal[:, axis] = sign
        return sign * (positions[:, axis] - shape.bounds[face]), normal
    if shape.style == "plane":
        direction = np.array(shape.values[3:]) / np.linalg.norm(shape.values[3:])
        normal = np.broadcast_to(direction, positions.shape)
        return (positions - shape.values[:3]) @ direction, normal
    return _distance_of_round(shape, positions)


def _distance_of_round(shape: RegionShape, positions: Floats) -> tuple[Floats, Floats]:
    """Return the distances and normals for a sphere, or for the side of a cylinder or cone."""
    slope = 0.0
    radius: Floats | float = shape.values[3] if shape.style == "sphere" else shape.values[2]
    outward = positions - shape.values[:3]
    if shape.axis:
        axis = "xyz".index(shape.axis)
        across = [(axis + 1) % 3, (axis + 2) % 3]
        outward = np.zeros_like(positions)
        outward[:, sorted(across)] = positions[:, sorted(across)] - shape.values[:2]
    if shape.style == "cone":
        low, high, first, last = shape.values[2:]
        slope = (high - low) / (last - first)
        radius = low + slope * (positions[:, axis] - first)
    away = np.linalg.norm(outward, axis=1)
    unit = outward / np.where(away > 0, away, 1.0)[:, None]
    if slope:
        unit[:, axis] = -slope
    side = -1.0 if shape.is_inside else 1.0
    length = math.hypot(1.0, slope)
    return side * (away - radius) / length, side * unit / length
