"""Second solver: symmetric motion of a chain of spheres with two cylinders at some of its gaps,
between two walls.

The two cylinders of a gap have the same motion, so only one of them is computed: its position along
the chain and its distance from the axis. Spheres move only along the chain; the first and the last
are held, or the last rests on a block. Contacts are elastic, and act along the present line of
centres:

    sphere - sphere, cylinder or block   F = K alpha^1.5
    cylinder - wall                      F = alpha L / (V |W(-alpha d/(2 e L^2))|), W: lower branch of Lambert's W

(Puttock & Thwaite, National Standards Laboratory Technical Paper 25, 1969, case 9). The friction f
F of a wall opposes the velocity of a cylinder along the chain; cylinders do not rotate. The solver
shares no code with granwave.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material

Array = NDArray[np.float64]


def elliptic_stiffness(modulus: float, small: float, large: float) -> float:
    """K of F = K alpha^1.5 of an elliptic Hertz contact, N/m^1.5, of E* (Pa) and relative principal
    curvatures (1/m).
    """

    def excess(m: float) -> float:
        k = ellipk(m)
        e = ellipe(m)
        return float((e / (1 - m) - k) / (k - e) - large / small)

    m = float(brentq(excess, 1e-9, 1 - 1e-12, xtol=1e-15))
    k = float(ellipk(m))
    e = float(ellipe(m))
    return 2 * math.pi * modulus / 3 * k**-1.5 * math.sqrt((k - e) / (m * small / 2))


@njit(cache=True)
def line_force(overlap: float, compliance: float, length: float, diameter: float) -> float:
    """Force of a cylinder on a wall, N; compliance V is the sum over both bodies of (1 - nu^2)/(pi
    E), 1/Pa.
    """
    if overlap <= 1e-25:  # the logarithm of the foot of a wave, some 1e-300 m, would overflow
        return 0.0
    level = -math.log(overlap * diameter / (2.0 * math.e * length * length))
    t = level + math.log(level)  # of t - ln t = level, t = -W
    for _ in range(8):
        step = (t - math.log(t) - level) / (1.0 - 1.0 / t)
        t -= step
        if abs(step) < 1e-15 * t:
            break
    return overlap * length / (compliance * t)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class SymmetricRow:
    """A chain at rest before its walls move inwards.

    Attributes
    ----------
    place
        Positions of the spheres along the chain, rising: (n,), m.
    along, across
        Positions of one cylinder of each pair, along the chain and from its axis: (m,), m.
    gap
        Number of the gap of each pair: it may touch the spheres gap and gap + 1, from 0: (m,).
    radius, small, length
        Radii of spheres and cylinders, and length of the cylinders, m.
    mass, small_mass
        Masses of a sphere and a cylinder, kg.
    sphere_stiffness, side_stiffness
        K between spheres, and between sphere and cylinder, N/m^1.5.
    compliance
        V of cylinder and wall, 1/Pa.
    wall
        Distance of a wall from the axis after its inward displacement, m.
    friction
        f of the walls.
    block_stiffness
        K of the last sphere and the block that it rests on, N/m^1.5; 0 without a block: then the
        first and the last sphere are held.
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
    friction: float
    block_stiffness: float = 0.0

    @classmethod
    def of(cls, case: Case) -> SymmetricRow:
        """Equations of a case like the built-in ``filter-row``, whose first and last sphere are
        held, or ``gap-switch``, on a block of the material of the plates, from its values.
        """
        radius = case.packing.diameter / 2
        place, along, across, small, length = _grains_of(case)
        steel = case.material
        light = soft_material(case)
        hard = steel.youngs_modulus / (1 - steel.poisson_ratio**2)
        soft = light.youngs_modulus / (1 - light.poisson_ratio**2)
        mixed = hard * soft / (hard + soft)
        on_block = not case.hold
        moved = case.precompression.moves["x"] if case.precompression else 0.0
        return cls(
            place=place,
            along=along,
            across=across,
            gap=np.searchsorted(place, along) - 1,
            radius=radius,
            small=small,
            length=length,
            mass=steel.density * math.pi / 6 * (2 * radius) ** 3,
            small_mass=light.density * math.pi * small**2 * length,
            sphere_stiffness=4 / 3 * hard / 2 * math.sqrt(radius / 2),
            side_stiffness=_side_stiffness(mixed, radius, small),
            compliance=(2 if on_block else 1) / (math.pi * soft),
            wall=float(across.max(initial=0.0)) + small - moved,
            friction=case.boundary.friction or 0.0,
            block_stiffness=4 / 3 * mixed * math.sqrt(radius) if on_block else 0.0,
        )

    def at_rest(self) -> Array:
        """Distances of the cylinders from the axis in equilibrium between wall and spheres: (m,),
        m.
        """
        found = self.across.copy()
        for pair, (gap, along, across) in enumerate(
            zip(self.gap, self.along, self.across, strict=True)
        ):
            steps = np.abs(self.place[gap : gap + 2] - along)
            if self.wall >= across + self.small:
                continue

            def outward(y: float, steps: Array = steps) -> float:
                apart = np.hypot(steps, y)
                push = (
                    self.side_stiffness
                    * np.maximum(self.radius + self.small - apart, 0.0) ** 1.5
                    * y
                    / apart
                )
                wall = line_force(
                    y + self.small - self.wall, self.compliance, self.length, 2 * self.small
                )
                return float(push.sum() - wall)

            found[pair] = brentq(
                outward, self.wall - self.small - 1e-12, across + 1e-12, xtol=1e-18, rtol=1e-14
            )
        return found

    def wall_force(self) -> Array:
        """Forces on a wall in equilibrium, by pair: (m,), N."""
        return np.array(
            [
                line_force(y + self.small - self.wall, self.compliance, self.length, 2 * self.small)
                for y in self.at_rest()
            ]
        )

    def struck(
        self, sphere: int, velocity: float, end: float, step: float = 5e-8
    ) -> tuple[Array, Array]:
        """Largest force of each contact, N, and its time, s, for an initial velocity of one sphere
        (counted from 0).
        """
        time, force, _ = self.motion(sphere, velocity, end, step)
        return force.max(axis=0), time[force.argmax(axis=0)]

    def motion(
        self, sphere: int, velocity: float, end: float, step: float = 5e-8
    ) -> tuple[Array, Array, Array]:
        """Times, s, and forces of the contacts of spheres, N: (n_times,), (n_times, n - 1), for an
        initial velocity of one sphere, counted from 0 (velocity Verlet); displacements at the end,
        m: (n,).
        """
        n_steps = math.ceil(end / step)
        step = end / n_steps
        moving = np.ones(len(self.place))
        if not self.block_stiffness:
            moving[[0, -1]] = 0.0
        constants = np.array(
            [self.radius, self.small, self.length, self.mass, self.small_mass, self.sphere_stiffness,
             self.side_stiffness, self.compliance, self.wall, self.friction, self.block_stiffness]
        )  # fmt: skip
        force, moved = _integrate(
            self.place, self.along, self.at_rest(), self.gap, moving, sphere, velocity, n_steps, step, constants
        )  # fmt: skip
        return np.arange(len(force)) * _EVERY * step, force, moved


_EVERY = 4  # steps between instants that are kept


def soft_material(case: Case) -> Material:
    """Material of the cylinders, and of plates and block if there are any."""
    grains = case.packing.grains
    return case.materials[0] if grains is None else case.named_material(grains.material[-1])


def _grains_of(case: Case) -> tuple[Array, Array, Array, float, float]:
    """Positions of the spheres along the chain; position along the chain and distance from the axis
    of one cylinder of each pair; radius and length of the cylinders (0 without any).
    """
    grains = case.packing.grains
    if grains is None:
        none = np.empty(0)
        return case.packing.diameter * np.arange(case.packing.size[0]), none, none, 0.0, 0.0
    shape = grains.shape[-1]
    assert shape is not None
    spheres = np.array([one != "cylinders" for one in grains.group])
    beside = np.flatnonzero(~spheres)[::2]
    along = grains.position[beside, 2]
    across = np.abs(grains.position[beside, 0])
    return grains.position[spheres, 2], along, across, float(grains.diameter[-1]) / 2, shape.length


def _side_stiffness(modulus: float, radius: float, small: float) -> float:
    """K of a sphere and a cylinder, N/m^1.5; 0 without cylinders."""
    if not small:
        return 0.0
    return elliptic_stiffness(modulus, 1 / radius, 1 / radius + 1 / small)


@njit(cache=True)
def _integrate(  # type: ignore[no-untyped-def]
    place, along, across, gap, moving, sphere, velocity, n_steps, step, constants
):
    radius, small, length, mass, small_mass, k_big, k_side, compliance = constants[:8]
    wall, friction, k_block = constants[8:]
    n = len(place)
    m = len(along)
    reach = radius + small
    z = place.copy()
    w = along.copy()
    y = across.copy()
    vz = np.zeros(n)
    vw = np.zeros(m)
    vy = np.zeros(m)
    az = np.zeros(n)
    aw = np.zeros(m)
    ay = np.zeros(m)
    vz[sphere] = velocity
    kept = np.zeros((n_steps // _EVERY + 1, n - 1))
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
            # displacements first: overlaps of the foot of a wave are far below the rounding of
            # places
            overlap = (
                2 * radius
                - (place[i + 1] - place[i])
                + ((z[i] - place[i]) - (z[i + 1] - place[i + 1]))
            )
            push = k_big * overlap * math.sqrt(overlap) if overlap > 0.0 else 0.0
            present[i] = push
            az[i] -= push
            az[i + 1] += push
        sunk = z[n - 1] - place[n - 1]
        if sunk > 0.0:
            az[n - 1] -= k_block * sunk * math.sqrt(sunk)
        for b in range(m):
            along_row = 0.0
            outward = 0.0
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
        if count % _EVERY == 0:
            kept[count // _EVERY] = present
    return kept, z - place
