"""Independent solver for elastic spheres and planes without friction, by scipy in three dimensions:
for tests only.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Plane:
    """A plane: axis of its normal, coordinate, and the side of it on which the spheres are (+1:
    above).
    """

    axis: int
    coordinate: float
    side: int
    modulus: float  # E/(1 - nu^2), Pa
    n_spheres: int  # the first ones feel it; strikers do not


@dataclasses.dataclass(frozen=True)
class Spheres:
    """Spheres of one material: positions (n, 3), radii (n,), velocities (n, 3); SI units."""

    place: Array
    radius: Array
    velocity: Array
    density: float
    modulus: float  # E/(1 - nu^2), Pa
    planes: tuple[Plane, ...] = ()

    @property
    def mass(self) -> Array:
        return self.density * 4 / 3 * np.pi * self.radius**3

    def acceleration(self, place: Array) -> Array:
        """Accelerations by Hertz's forces of all pairs and planes: (n, 3)."""
        apart = place[:, None] - place[None]
        distance = np.linalg.norm(apart, axis=2) + np.eye(len(place))
        both = self.radius[:, None] + self.radius[None]
        overlap = np.clip(both - distance, 0, None)
        np.fill_diagonal(overlap, 0.0)
        curved = np.sqrt(np.outer(self.radius, self.radius) / both)
        size = 4 / 3 * (self.modulus / 2) * curved * overlap**1.5
        force = np.einsum("ij,ijk->ik", size / distance, apart)
        for plane in self.planes:
            inside = slice(plane.n_spheres)
            height = plane.side * (place[inside, plane.axis] - plane.coordinate)
            depth = np.clip(self.radius[inside] - height, 0, None)
            stiff = 1 / (1 / self.modulus + 1 / plane.modulus)
            force[inside, plane.axis] += (
                plane.side * 4 / 3 * stiff * np.sqrt(self.radius[inside]) * depth**1.5
            )
        return np.asarray(force / self.mass[:, None])

    def run(self, times: Array) -> tuple[Array, Array]:
        """Velocities and accelerations at rising times from 0: (n_times, n, 3) each."""
        n = self.place.size

        def rate(_: float, state: Array) -> Array:
            return np.concatenate([state[n:], self.acceleration(state[:n].reshape(-1, 3)).ravel()])

        start = np.concatenate([self.place.ravel(), self.velocity.ravel()])
        # tolerances: overlaps are some micrometres, velocities some 0.1 m/s
        limits = np.concatenate([np.full(n, 1e-12), np.full(n, 1e-6)])
        found = solve_ivp(
            rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-7, atol=limits, max_step=4e-6
        )
        velocity = found.y[n:].T.reshape(len(times), -1, 3)
        return velocity, np.stack([self.acceleration(one[:n].reshape(-1, 3)) for one in found.y.T])
