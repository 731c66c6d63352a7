"""Equations of symmetric motion of a row of spheres with two cylinders beside some of its gaps, between two walls.

The two cylinders of a gap move alike, so one of them is followed: its place along the row and its distance from the
axis. Spheres move along the row alone. Contacts are elastic, and act along the present line of centres:

    sphere - sphere, sphere - cylinder   F = K alpha^1.5
    cylinder - wall                      F = alpha L / (V |W(-alpha d/(2 e L^2))|), W: lower branch of Lambert's W

(Puttock & Thwaite, National Standards Laboratory Technical Paper 25, 1969, case 9). A wall rubs with f F against the
velocity of a cylinder along the row; cylinders do not turn. It shares no code with the plugin: a second solver.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

Array = NDArray[np.float64]

#: Overlap below which the line law is 0, m: the logarithm of the foot of a wave, some 1e-300 m, would overflow.
LEAST_OVERLAP = 1e-25
_NEWTON_STEPS = 8


def compiled(function: Callable[..., Any]) -> Any:
    """Compile at the first call, and cache the code on disk if possible."""
    try:
        return njit(cache=True)(function)
    except RuntimeError:  # neither the package's directory nor the user's cache is writable
        return njit(function)


def elliptic_stiffness(modulus: float, small: float, large: float) -> float:
    """Return K of F = K alpha^1.5 of an elliptic Hertz contact, N/m^1.5.

    Parameters
    ----------
    modulus
        E*, Pa.
    small, large
        Relative principal curvatures, 1/m.
    """
    if math.isclose(small, large, rel_tol=1e-12):
        return 4 / 3 * modulus / math.sqrt(large)

    def excess(m: float) -> float:
        k, e = ellipk(m), ellipe(m)
        return float((e / (1 - m) - k) / (k - e) - large / small)

    m = float(brentq(excess, 1e-9, 1 - 1e-12, xtol=1e-15))
    k, e = float(ellipk(m)), float(ellipe(m))
    return 2 * math.pi * modulus / 3 * k**-1.5 * math.sqrt((k - e) / (m * small / 2))


@compiled
def line_force(overlap: float, compliance: float, length: float, diameter: float) -> float:
    """Return the force of a cylinder on a wall, N.

    Parameters
    ----------
    overlap
        m.
    compliance
        V, the sum over both bodies of (1 - nu^2)/(pi E), 1/Pa.
    length, diameter
        Of the cylinder, m.
    """
    if overlap <= 1e-25:
        return 0.0
    level = -math.log(overlap * diameter / (2.0 * math.e * length * length))
    t = level + math.log(level)  # of t - ln t = level, t = -W
    for _ in range(_NEWTON_STEPS):
        step = (t - math.log(t) - level) / (1.0 - 1.0 / t)
        t -= step
        if abs(step) < 1e-15 * t:
            break
    return overlap * length / (compliance * t)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class SymmetricRow:
    """A row at rest before its walls move in.

    Attributes
    ----------
    place
        Of the spheres along the row, rising: (n,), m.
    along, across
        Places of one cylinder of each pair, along the row and from its axis: (m,), m.
    gap
        Number of the gap of each pair: it may touch the spheres gap and gap + 1, from 0: (m,).
    radius, small
        Of spheres and cylinders, m.
    length
        Of the cylinders, m.
    mass, small_mass
        Of a sphere and a cylinder, kg.
    sphere_stiffness, side_stiffness
        K between spheres, and between sphere and cylinder, N/m^1.5.
    compliance
        V of cylinder and wall, 1/Pa.
    wall
        Distance of a wall from the axis, after it moved in, m.
    friction
        f of the walls.
    held
        Spheres that do not move, from 0.
    """

    place: Array
    along: Array
    across: Array
    gap: NDArray[np.int64]
    radius: float
    small: float
    length: float
    mass: float
    small_mass: float
    sphere_stiffness: float
    side_stiffness: float
    compliance: float
    wall: float
    friction: float = 0.0
    held: tuple[int, ...] = ()

    def at_rest(self) -> Array:
        """Return the distances of the cylinders from the axis in balance between wall and spheres: (m,), m."""
        found = self.across.copy()
        for pair, (gap, along, across) in enumerate(zip(self.gap, self.along, self.across, strict=True)):
            steps = np.abs(self.place[gap : gap + 2] - along)
            if self.wall >= across + self.small:
                continue

            def outward(y: float, steps: Array = steps) -> float:
                apart = np.hypot(steps, y)
                push = self.side_stiffness * np.maximum(self.radius + self.small - apart, 0.0) ** 1.5 * y / apart
                wall = line_force(y + self.small - self.wall, self.compliance, self.length, 2 * self.small)
                return float(push.sum() - wall)

            found[pair] = brentq(outward, self.wall - self.small - 1e-12, across + 1e-12, xtol=1e-18, rtol=1e-14)
        return found

    def wall_force(self) -> Array:
        """Return the forces on a wall in balance, by pair: (m,), N."""
        return np.array(
            [
                line_force(y + self.small - self.wall, self.compliance, self.length, 2 * self.small)
                for y in self.at_rest()
            ]
        )

    def struck(self, sphere: int, velocity: float, end: float, step: float = 5e-8) -> Motion:
        """Integrate the motion after a sphere got a velocity (velocity Verlet).

        Parameters
        ----------
        sphere
            From 0.
        velocity
            m/s.
        end, step
            Time of the run, and timestep, s.
        """
        n_steps = math.ceil(end / step)
        moving = np.ones(len(self.place))
        moving[list(self.held)] = 0.0
        force, velocities = _integrate(
            self.place, self.along, self.at_rest(), self.gap, moving, sphere, velocity, n_steps, end / n_steps,
            np.array([self.radius, self.small, self.length, self.mass, self.small_mass, self.sphere_stiffness,
                      self.side_stiffness, self.compliance, self.wall, self.friction]),
        )  # fmt: skip
        time = np.arange(n_steps + 1)[::_EVERY] * end / n_steps
        return Motion(time, force, velocities)


@dataclasses.dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a row after it was struck.

    Attributes
    ----------
    time
        Instants, s: (n_times,).
    force
        Forces between neighbouring spheres: (n_times, n - 1), N.
    velocity
        Of the spheres, at the end: (n,), m/s.
    """

    time: Array
    force: Array
    velocity: Array

    @property
    def peaks(self) -> Array:
        """Largest force of each contact, N: (n - 1,)."""
        return np.asarray(self.force.max(axis=0))

    @property
    def arrivals(self) -> Array:
        """Time of it, s: (n - 1,)."""
        return np.asarray(self.time[self.force.argmax(axis=0)])


_EVERY = 4  # steps between instants that are kept


@compiled
def _integrate(  # type: ignore[no-untyped-def]
    place, along, across, gap, moving, sphere, velocity, n_steps, step, constants
):
    radius, small, length, mass, small_mass, k_big, k_side, compliance, wall, friction = constants
    n, m, reach = len(place), len(along), radius + small
    z, w, y = place.copy(), along.copy(), across.copy()
    vz, vw, vy = np.zeros(n), np.zeros(m), np.zeros(m)
    az, aw, ay = np.zeros(n), np.zeros(m), np.zeros(m)
    vz[sphere] = velocity
    kept = np.zeros((n_steps // 4 + 1, n - 1))
    present = np.zeros(n - 1)
    for count in range(n_steps + 1):
        if count:
            for i in range(n):
                vz[i] += 0.5 * step * az[i]
                z[i] += step * vz[i]
            for b in range(m):
                vw[b] += 0.5 * step * aw[b]
                vy[b] += 0.5 * step * ay[b]
                w[b] += step * vw[b]
                y[b] += step * vy[b]
        az[:] = 0.0
        for i in range(n - 1):
            # displacements first: overlaps of the foot of a wave are far below the rounding of places
            overlap = 2 * radius - (place[i + 1] - place[i]) + ((z[i] - place[i]) - (z[i + 1] - place[i + 1]))
            push = k_big * overlap * math.sqrt(overlap) if overlap > 0.0 else 0.0
            present[i] = push
            az[i] -= push
            az[i + 1] += push
        for b in range(m):
            along_row, outward = 0.0, 0.0
            for i in range(gap[b], gap[b] + 2):
                dz = w[b] - z[i]
                apart = math.hypot(dz, y[b])
                overlap = reach - apart
                if overlap > 0.0:
                    push = k_side * overlap * math.sqrt(overlap) / apart
                    along_row += push * dz
                    outward += push * y[b]
                    az[i] -= 2.0 * push * dz
            pressed = line_force(y[b] + small - wall, compliance, length, 2.0 * small)
            rub = 0.0
            if friction > 0.0 and pressed > 0.0:
                rub = friction * pressed * (1.0 if vw[b] > 0.0 else -1.0 if vw[b] < 0.0 else 0.0)
            aw[b] = (along_row - rub) / small_mass
            ay[b] = (outward - pressed) / small_mass
        for i in range(n):
            az[i] *= moving[i] / mass
        if count:
            for i in range(n):
                vz[i] += 0.5 * step * az[i]
            for b in range(m):
                vw[b] += 0.5 * step * aw[b]
                vy[b] += 0.5 * step * ay[b]
        if count % 4 == 0:
            kept[count // 4] = present
    return kept, vz
