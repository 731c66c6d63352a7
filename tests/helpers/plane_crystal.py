"""A plane crystal of soft cylinders under a falling plate, in numpy: states with known contact forces.

An independent program that shares no code with granwave. Grains are discs of unit length between two rigid walls on a
rigid floor; they touch by Johnson's line contact (plane strain) with a loss proportional to stiffness and rate, and rub
with a tangential spring and Coulomb's limit. A rigid plate, which moves vertically, strikes the top row. SI units, all per
metre of length; x to the right, y up.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
RADIUS, DENSITY, MODULUS, POISSON, FRICTION, LOSS = 6.35e-3, 1130.0, 70e6, 0.48, 0.3, 12e-6
PLATE_MASS, PLATE_SPEED = 20.0, 6.0
MASS = np.pi * DENSITY * RADIUS**2
INERTIA = MASS * RADIUS**2 / 2
PAIR_MODULUS = MODULUS / (2 * (1 - POISSON**2))
WALL_MODULUS = 2 * PAIR_MODULUS
_TANGENTIAL = 2 * (1 - POISSON) / (2 - POISSON) * 0.539  # spring over the modulus of the contact
_LOGARITHM = 8 * np.pi * PAIR_MODULUS * RADIUS  # the same for walls
WALLS = ("left", "right", "floor", "plate")


@dataclasses.dataclass(frozen=True, eq=False)
class Snapshot:
    """Grains and forces at one instant; forces are those on the first grain, as vectors.

    Attributes
    ----------
    second
        Rows of the partners, or -1 - number for a wall of `WALLS`.
    levels
        x of the side walls, y of floor and plate, m.
    """

    position: Array
    acceleration: Array
    spin: Array
    angular_acceleration: Array
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    force: Array
    normal: Array
    levels: tuple[float, float, float, float]

    def stress(self) -> Array:
        """Average stresses, tension positive, as symmetric matrices: (n, 2, 2), Pa."""
        total = np.zeros((len(self.position), 2, 2))
        for i, j, force, normal in zip(self.first, self.second, self.force, self.normal, strict=True):
            if j >= 0:
                half = 0.5 * np.linalg.norm(self.position[i] - self.position[j])
                total[j] += np.outer(half * normal, -force)
            else:
                axis = 0 if j >= -2 else 1
                half = abs(self.position[i][axis] - self.levels[-1 - j])
            total[i] += np.outer(-half * normal, force)
        inertia = MASS * RADIUS**2 / 4 * self.spin**2
        total += inertia[:, None, None] * np.eye(2)
        return 0.5 * (total + total.transpose(0, 2, 1)) / (np.pi * RADIUS**2)


def centred_square(rows: int, longest: int) -> Array:
    """Centres of rows of ``longest`` and one less grains, sqrt2 D apart: (n, 2), m."""
    return _rows(rows, longest, np.sqrt(2), 1 / np.sqrt(2))


def hexagonal(rows: int, longest: int) -> Array:
    """Centres of rows of ``longest`` and one less grains that touch: (n, 2), m."""
    return _rows(rows, longest, 1.0, np.sqrt(3) / 2)


def _rows(rows: int, longest: int, apart: float, height: float) -> Array:
    places = [
        (0.5 + apart * (k + 0.5 * (row % 2)), 0.5 + height * row)
        for row in range(rows)
        for k in range(longest - row % 2)
    ]
    return 2 * RADIUS * np.array(places)


def snapshots(position: Array, times: tuple[float, ...]) -> list[Snapshot]:
    """Drop the plate on a crystal, and return its state at these times, s."""
    crystal = _Crystal(position)
    found = []
    for time in times:
        while crystal.time < time:
            crystal.step()
        found.append(crystal.snapshot())
    return found


class _Crystal:
    def __init__(self, position: Array) -> None:
        self.x, n = position.copy(), len(position)
        self.v, self.spin = np.zeros((n, 2)), np.zeros(n)
        self.plate, self.plate_speed = float(position[:, 1].max()) + RADIUS, -PLATE_SPEED
        self.levels = [float(position[:, 0].min()) - RADIUS, float(position[:, 0].max()) + RADIUS, 0.0]
        self.springs, self.time, self.dt = np.zeros((n, n + 4)), 0.0, 0.02 / np.sqrt(8 * 1.2 * PAIR_MODULUS / MASS)
        self.steps = 0
        self.search()
        self.forces(0.0)

    def search(self) -> None:
        apart = np.linalg.norm(self.x[:, None] - self.x[None], axis=2)
        self.i, self.j = np.nonzero(np.triu(apart < 2.4 * RADIUS, 1))

    def forces(self, dt: float) -> None:
        n, x, v = len(self.x), self.x, self.v
        i, j = self.i, self.j
        gap = x[i] - x[j]
        distance = np.linalg.norm(gap, axis=1)
        touching = distance < 2 * RADIUS
        i, j, gap, distance = i[touching], j[touching], gap[touching], distance[touching]
        first, partner, normal = [i], [j], [gap / distance[:, None]]
        overlap, arm, other_arm = [2 * RADIUS - distance], [distance / 2], [distance / 2]
        velocity, wall = [v[i] - v[j]], [np.zeros(len(i), dtype=np.int64)]
        for number, (axis, sign) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1))):
            level = self.plate if number == 3 else self.levels[number]
            away = sign * (x[:, axis] - level)
            rows = np.flatnonzero(away < RADIUS)
            direction = np.zeros(2)
            direction[axis] = sign
            first.append(rows)
            partner.append(np.full(len(rows), n + number))
            normal.append(np.tile(direction, (len(rows), 1)))
            overlap.append(RADIUS - away[rows])
            arm.append(away[rows])
            other_arm.append(np.zeros(len(rows)))
            velocity.append(v[rows] - ([0.0, self.plate_speed] if number == 3 else [0.0, 0.0]))
            wall.append(np.ones(len(rows), dtype=np.int64))
        first, partner, normal, overlap, arm, other_arm, velocity, wall = map(
            np.concatenate, (first, partner, normal, overlap, arm, other_arm, velocity, wall)
        )
        modulus = np.where(wall == 1, WALL_MODULUS, PAIR_MODULUS)
        static, slope = line_contact(overlap, modulus)
        rate = -(velocity * normal).sum(axis=1)
        push = np.maximum(0.0, static + LOSS * slope * rate)
        tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        pair = np.flatnonzero(wall == 0)
        # velocity of the point of contact of the first grain relative to its partner, along the tangent
        slip = (velocity * tangent).sum(axis=1) - arm * self.spin[first]
        slip[pair] -= other_arm[pair] * self.spin[partner[pair]]
        stretch = self.springs[first, partner] + slip * dt
        spring = _TANGENTIAL * modulus
        limit = FRICTION * push / spring
        stretch = np.clip(stretch, -limit, limit)
        self.springs[:] = 0.0
        self.springs[first, partner] = stretch
        shear = -spring * stretch
        force = push[:, None] * normal + shear[:, None] * tangent
        total, torque = np.zeros((n, 2)), np.zeros(n)
        np.add.at(total, first, force)
        np.add.at(torque, first, -arm * shear)
        np.add.at(total, partner[pair], -force[pair])
        np.add.at(torque, partner[pair], -other_arm[pair] * shear[pair])
        self.a, self.alpha = total / MASS, torque / INERTIA
        self.plate_a = -force[partner == n + 3, 1].sum() / PLATE_MASS
        self.contacts = first, np.where(partner < n, partner, n - 1 - partner), force, normal

    def step(self) -> None:
        dt = self.dt
        self.v += 0.5 * dt * self.a
        self.spin += 0.5 * dt * self.alpha
        self.plate_speed += 0.5 * dt * self.plate_a
        self.x += dt * self.v
        self.plate += dt * self.plate_speed
        self.steps += 1
        if self.steps % 25 == 0:
            self.search()
        self.forces(dt)
        self.v += 0.5 * dt * self.a
        self.spin += 0.5 * dt * self.alpha
        self.plate_speed += 0.5 * dt * self.plate_a
        self.time += dt

    def snapshot(self) -> Snapshot:
        first, second, force, normal = self.contacts
        left, right, floor = self.levels
        return Snapshot(
            self.x.copy(), self.a.copy(), self.spin.copy(), self.alpha.copy(),
            first.copy(), second.copy(), force.copy(), normal.copy(), (left, right, floor, self.plate),
        )  # fmt: skip


def line_contact(overlap: Array, modulus: Array) -> tuple[Array, Array]:
    """Return force per length and stiffness of Johnson's line contact, from overlap/modulus, by Newton's method."""
    if not len(overlap):
        return np.zeros(0), np.zeros(0)
    wanted = np.pi * modulus * overlap
    log_force = np.log(0.5 * modulus * np.maximum(overlap, 1e-18))
    for _ in range(6):
        force = np.exp(log_force)
        log_ratio = np.log(_LOGARITHM) - log_force
        log_force -= (force * (log_ratio - 1) - wanted) / (force * (log_ratio - 2))
    force = np.exp(log_force)
    return force, np.pi * modulus / (np.log(_LOGARITHM) - log_force - 2)
