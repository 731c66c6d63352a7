"""Measured grains at an instant (positions, motion, average strain or stress), and their possible
contacts.

In the plane (cylinders) vectors have two components, in space (spheres) three. Symmetric tensors
are rows of their components: xx, yy, xy in the plane; xx, yy, zz, yz, xz, xy in space. Strains are
components of the tensor, so that exy is half the shear angle. Stretching and tension are positive,
as in displacement fields of a camera. In the plane, rotations have one component, about z. Possible
contacts are pairs, and grains at walls, within a tolerance.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
State = Literal["plane-stress", "plane-strain", "space"]
STATES: tuple[State, ...] = ("plane-stress", "plane-strain", "space")

#: Pairs of axes of the components of a symmetric tensor, by dimension.
PAIRS: dict[int, tuple[tuple[int, int], ...]] = {
    2: ((0, 0), (1, 1), (0, 1)),
    3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)),
}
#: Names of the components, by dimension.
TENSOR: dict[int, tuple[str, ...]] = {
    2: ("xx", "yy", "xy"),
    3: ("xx", "yy", "zz", "yz", "xz", "xy"),
}
#: Factors of the components, by dimension, with which sums of squares do not depend on the axes.
SCALES = {
    2: np.array([1.0, 1.0, np.sqrt(2)]),
    3: np.array([1.0, 1.0, 1.0, np.sqrt(2), np.sqrt(2), np.sqrt(2)]),
}
#: Number of components of rotations, by dimension.
TURNS = {2: 1, 3: 3}
NORMAL = 0  # component of a force along the normal of its contact
TANGENTIAL = slice(1, None)  # tangential components


@dataclasses.dataclass(frozen=True, eq=False)
class MeasuredGrains:
    """Grains at one instant; NaN for quantities that were not measured.

    Attributes
    ----------
    ids
        (n,).
    position
        Centres: (n, d), m.
    radius
        (n,), m.
    mass
        (n,), kg.
    volume
        (n,), m^3.
    acceleration
        (n, d), m/s^2.
    spin
        Angular velocities: (n, 1) in the plane, (n, 3) in space, rad/s.
    angular_acceleration
        As ``spin``, rad/s^2.
    known_force
        Sum of the known forces that are no contact forces, such as the weight: (n, d), N.
    stress
        Average stresses: (n, 3) or (n, 6), Pa; stresses from strains are computed with the
        ``modulus``.
    compliance
        Compliance matrices, from stress to strain: (n, k, k), 1/Pa; None if stresses were measured.
    modulus
        Young's moduli: (n,), Pa; None if stresses were measured.
    passes_walls
        True for grains that walls do not act on, such as strikers from outside: (n,); None if there
        are none.
    """

    ids: NDArray[np.int64]
    position: Array
    radius: Array
    mass: Array
    volume: Array
    acceleration: Array
    spin: Array
    angular_acceleration: Array
    known_force: Array
    stress: Array
    compliance: Array | None = None
    modulus: Array | None = None
    passes_walls: NDArray[np.bool_] | None = None

    def __len__(self) -> int:
        return len(self.radius)

    def take(self, rows: NDArray[np.bool_]) -> MeasuredGrains:
        """Return some of the grains."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        taken: dict[str, Any] = {
            name: None if value is None else value[rows] for name, value in values.items()
        }
        return MeasuredGrains(**taken)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return int(self.position.shape[1])

    @property
    def at_walls(self) -> NDArray[np.bool_]:
        """True for grains on which walls act: (n,)."""
        return np.ones(len(self), dtype=bool) if self.passes_walls is None else ~self.passes_walls

    @property
    def has_motion(self) -> NDArray[np.bool_]:
        """True for grains whose accelerations are known: (n,)."""
        complete = np.isfinite(self.acceleration).all(axis=1) & np.isfinite(
            self.angular_acceleration
        ).all(axis=1)
        return np.asarray(complete, dtype=bool)

    @property
    def has_stress(self) -> NDArray[np.bool_]:
        """True for grains whose stress or strain is known: (n,)."""
        return np.asarray(np.isfinite(self.stress).all(axis=1), dtype=bool)

    @property
    def strain(self) -> Array:
        """Average strains, where they were measured: (n, k)."""
        assert self.compliance is not None
        return np.asarray(np.einsum("nij,nj->ni", self.compliance, self.stress))

    @property
    def inertia(self) -> Array:
        """Moments of inertia about an axis through the centre: (n,), kg m^2."""
        return (0.5 if self.dimension == 2 else 0.4) * self.mass * self.radius**2

    @property
    def spin_stress(self) -> Array:
        """Part of the moments of the contact forces that the spin takes up: (n, k), N m.

        With w the angular velocity it is m R^2/4 (w w - w^2 1) of cylinders, and m R^2/5 (w w - w^2
        1) of spheres. Volume times stress and this are the moments of the contact forces.
        """
        share = self.mass * self.radius**2 / (4 if self.dimension == 2 else 5)
        spin = np.where(np.isfinite(self.spin), self.spin, 0.0)
        vector = np.zeros((len(self), 3))
        vector[:, 3 - spin.shape[1] :] = spin
        square = (vector**2).sum(axis=1)
        parts = [
            vector[:, a] * vector[:, b] - (square if a == b else 0.0)
            for a, b in PAIRS[self.dimension]
        ]
        return share[:, None] * np.stack(parts, axis=1)


def stiffness(modulus: Array, poisson_ratio: Array, state: State) -> Array:
    """Return the stiffness matrices, from strain to stress, of isotropic grains, for rows of tensor
    components: (n, k, k), Pa.

    Parameters
    ----------
    modulus, poisson_ratio
        (n,), Pa and 1.
    state
        Plane stress (a free face), plane strain (held along the axis), or space.
    """
    twice_shear = modulus / (1 + poisson_ratio)
    if state == "plane-stress":
        first = modulus * poisson_ratio / (1 - poisson_ratio**2)
    else:
        first = modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    diagonal = np.array([float(a == b) for a, b in PAIRS[3 if state == "space" else 2]])
    return first[:, None, None] * np.outer(diagonal, diagonal) + twice_shear[
        :, None, None
    ] * np.eye(len(diagonal))


def volume_of(radius: Array, state: State, length: float) -> Array:
    """Return the volumes of spheres, or of cylinders of a length, m^3."""
    return 4 / 3 * np.pi * radius**3 if state == "space" else np.pi * radius**2 * length


@dataclasses.dataclass(frozen=True)
class StraightWall:
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
class CandidateContacts:
    """Possible contacts, pairs of grains first.

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
        Vectors from the centres of the two grains to the contact: (m, d), m; the second is of no
        use at walls.
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
        is_touched = np.zeros(n_grains, dtype=bool)
        is_touched[self.first] = True
        is_touched[self.second[self.second >= 0]] = True
        return is_touched

    def partners(self, ids: NDArray[np.int64]) -> list[str]:
        """Return the ids of the second grains, and the names of walls, as text."""
        pairs = zip(self.second.tolist(), self.wall.tolist(), strict=True)
        return [str(ids[j]) if j >= 0 else self.walls[wall] for j, wall in pairs]

    def vectors(self, force: Array) -> Array:
        """Return forces on the first grains as vectors, from normal and tangential components: (m,
        d), N.
        """
        return np.einsum("mij,mj->mi", self.basis, force)

    def components(self, vectors: Array) -> Array:
        """Return normal and tangential components of forces on the first grains: (m, d), N."""
        return np.einsum("mij,mi->mj", self.basis, vectors)


def find_contacts(
    grains: MeasuredGrains, walls: Mapping[str, StraightWall], tolerance: float
) -> CandidateContacts:
    """Return the pairs of grains, and of grains and walls, that may touch.

    Two grains may touch up to a distance (R_i + R_j)(1 + tolerance) of their centres; a grain may
    touch a wall up to the distance R (1 + 2 tolerance), unless it passes walls.
    """
    x = grains.position
    radius = grains.radius
    reach = 2 * float(radius.max(initial=0.0)) * (1 + tolerance)
    pairs = np.empty((0, 2), dtype=np.int64)
    if len(x) > 1:
        pairs = cKDTree(x).query_pairs(reach, output_type="ndarray")
    i, j = pairs.astype(np.int64).T
    apart = x[i] - x[j]
    distance = np.linalg.norm(apart, axis=1)
    near = distance <= (radius[i] + radius[j]) * (1 + tolerance)
    order = np.lexsort((j[near], i[near]))
    i, j, apart, distance = (values[near][order] for values in (i, j, apart, distance))
    normal = apart / distance[:, None]
    lever = (distance + radius[i] - radius[j]) / 2
    blocks = [
        (
            i,
            j,
            np.full(len(i), -1),
            normal,
            -lever[:, None] * normal,
            (distance - lever)[:, None] * normal,
        )
    ]
    for number, wall in enumerate(walls.values()):
        n = np.array(wall.normal)
        away = (x - np.array(wall.point)) @ n
        rows = np.flatnonzero((away <= radius * (1 + 2 * tolerance)) & grains.at_walls)
        arm = -away[rows, None] * n
        full = np.full(len(rows), -1)
        blocks.append(
            (
                rows,
                full,
                np.full(len(rows), number),
                np.tile(n, (len(rows), 1)),
                arm,
                np.zeros_like(arm),
            )
        )
    first, second, wall_of, normals, arms, partner_arms = (
        np.concatenate(parts) for parts in zip(*blocks, strict=True)
    )
    if grains.dimension == 2:
        basis = np.stack([normals, np.stack([-normals[:, 1], normals[:, 0]], axis=1)], axis=2)
    else:
        tangent = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        basis = np.stack([normals, tangent, np.cross(normals, tangent)], axis=2)
    return CandidateContacts(first, second, wall_of, basis, arms, partner_arms, tuple(walls))
