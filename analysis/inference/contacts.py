"""Possible contacts of measured grains: pairs and walls within a tolerance, with their normals and points."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from granwave.analysis.inference.grains import Array, Grains


@dataclasses.dataclass(frozen=True)
class Wall:
    """A straight wall: a line in the plane, a plane in space.

    Attributes
    ----------
    point
        A point of it, m.
    normal
        Unit vector into the packing.
    """

    point: tuple[float, ...]
    normal: tuple[float, ...]


@dataclasses.dataclass(frozen=True, eq=False)
class Contacts:
    """Possible contacts, those of pairs first.

    Attributes
    ----------
    first
        Rows of the grains that the normals point into: (m,).
    second
        Rows of their partners; -1 for a wall: (m,).
    wall
        Numbers of the walls; -1 for a pair: (m,).
    basis
        Unit vectors as columns, the normal first, then the tangents: (m, d, d).
    arm, partner_arm
        Vectors from the centres of the two grains to the contact: (m, d), m; the second is of no use at walls.
    walls
        Names of the walls.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    wall: NDArray[np.int64]
    basis: Array
    arm: Array
    partner_arm: Array
    walls: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.first)

    @property
    def normal(self) -> Array:
        """Unit normals into the first grain: (m, d)."""
        return self.basis[:, :, 0]

    def touched(self, n_grains: int) -> NDArray[np.bool_]:
        """Return True for grains with a possible contact: (n_grains,)."""
        found = np.zeros(n_grains, dtype=bool)
        found[self.first] = True
        found[self.second[self.second >= 0]] = True
        return found

    def vectors(self, force: Array) -> Array:
        """Return forces on the first grains as vectors, from normal and tangential components: (m, d), N."""
        return np.einsum("mij,mj->mi", self.basis, force)

    def components(self, vectors: Array) -> Array:
        """Return normal and tangential components of forces on the first grains: (m, d), N."""
        return np.einsum("mij,mi->mj", self.basis, vectors)


def find_contacts(grains: Grains, walls: Mapping[str, Wall], tolerance: float) -> Contacts:
    """Return the pairs of grains, and of grains and walls, that may touch.

    Pairs count up to a distance (R_i + R_j)(1 + tolerance), walls up to R (1 + 2 tolerance), but not of
    grains that pass walls.
    """
    x, radius = grains.position, grains.radius
    reach = 2 * float(radius.max(initial=0.0)) * (1 + tolerance)
    pairs = cKDTree(x).query_pairs(reach, output_type="ndarray") if len(x) > 1 else np.empty((0, 2), dtype=np.int64)
    i, j = pairs.astype(np.int64).T
    apart = x[i] - x[j]
    distance = np.linalg.norm(apart, axis=1)
    near = distance <= (radius[i] + radius[j]) * (1 + tolerance)
    order = np.lexsort((j[near], i[near]))
    i, j, apart, distance = (values[near][order] for values in (i, j, apart, distance))
    normal = apart / distance[:, None]
    lever = (distance + radius[i] - radius[j]) / 2
    found = [(i, j, np.full(len(i), -1), normal, -lever[:, None] * normal, (distance - lever)[:, None] * normal)]
    for number, wall in enumerate(walls.values()):
        n = np.array(wall.normal)
        away = (x - np.array(wall.point)) @ n
        rows = np.flatnonzero((away <= radius * (1 + 2 * tolerance)) & grains.at_walls)
        arm = -away[rows, None] * n
        full = np.full(len(rows), -1)
        found.append((rows, full, np.full(len(rows), number), np.tile(n, (len(rows), 1)), arm, np.zeros_like(arm)))
    first, second, wall_of, normals, arms, partner_arms = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Contacts(first, second, wall_of, _basis(normals), arms, partner_arms, tuple(walls))


def _basis(normal: Array) -> Array:
    """Return orthogonal unit vectors as columns, with the normals as first: (m, d, d)."""
    if normal.shape[1] == 2:
        return np.stack([normal, np.stack([-normal[:, 1], normal[:, 0]], axis=1)], axis=2)
    least = np.abs(normal).argmin(axis=1)
    one = np.cross(normal, np.eye(3)[least])
    one /= np.linalg.norm(one, axis=1)[:, None]
    return np.stack([normal, one, np.cross(normal, one)], axis=2)
