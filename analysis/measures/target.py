"""Support of the target, the bottom of a packing, and the same impact directly on it, without the
packing.

The ground carries the target: the force on it is transmitted by the last spring or damper, and
equals the force on the target if the target is fixed.

Without the packing the impacted spheres, side by side, hit the target: a rigid plane, a plane of a
material, or a plane that moves on a support or a bar (`granwave.lammps_inputs.case.boundary`). Each
sphere is a point mass with the contact law, hysteresis included, as its force on the plane; dents
are local, so that spheres interact by the motion of the plane only:

    m x'' = -F(x - u)        sphere, x from where it touches
    m_0 u'' = sum F + k (u_1 - u_0), ..., m_n u_n'' = k (u_(n-1) - u_n) - K u_n - C u_n'      plane and support

On a fixed plane the peak force is the force at the overlap where W(alpha) = m v^2/2,
and the course of equal spheres follows from the energies: m x'^2/2 is the total energy minus the
work of loading, or minus the elastic energy. A force as load acts on the target itself.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import Reached
from granwave.lammps_inputs.case.loads.driven import DrivenLoad
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import flat_contact
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bodies import BAR
from granwave.lammps_inputs.packing.motion import struck_of, velocities_of
from granwave.lammps_inputs.packing.walls import footprint_radius
from granwave.lammps_inputs.roots import brentq

if TYPE_CHECKING:  # loads h5py, which `granwave check` does without
    pass

_TOLERANCE = 1e-8  # relative tolerance of the integration
_IN_CONTACT = 200  # fewest steps during a collision with a plane at rest
_AFTER = 1000  # fewest steps after the collision
_MOST_PHASES = 200  # most phases of loading and unloading

Event = Callable[[float, Array], float]


@dataclasses.dataclass(frozen=True, eq=False)
class Target:
    """Support of the plane: a chain of masses joined by springs, the plane first, with a spring
    from the last mass to the ground.
    """

    material: Material | None  # material of the surface; None: rigid
    # masses of the nodes, (n,), kg; empty for a fixed plane; a single 0 for a surface without mass
    mass: Array
    stiffness: float = 0.0  # stiffness of the springs between the nodes, N/m
    # stiffness of the spring between the last node and the ground, N/m
    ground_stiffness: float = 0.0
    ground_damping: float = 0.0  # N s/m

    @property
    def settles(self) -> float:
        """Time after a push during which the force on the ground may still rise, s."""
        if not self.moves or not self.mass[0]:
            return 0.0
        if len(self.mass) > 1:
            return 2 * len(self.mass) * math.sqrt(self.mass[0] * 2 / self.stiffness)
        return 2 * math.pi * math.sqrt(self.mass[0] / self.ground_stiffness)

    @property
    def moves(self) -> bool:
        """True if the plane can move."""
        return bool(len(self.mass))

    def rates(self, place: Array, speed: Array, force: float) -> tuple[Array, Array]:
        """Velocities and accelerations of the nodes under a force (N) on the plane; (n,) each.

        A surface without mass has the velocity that its damper allows, for any ``speed``.
        """
        if not self.moves:
            return place, place
        if not self.mass[0]:
            return (force - self.ground_stiffness * place) / self.ground_damping, np.zeros(1)
        pull = self.stiffness * np.diff(place)
        on = -np.append(-pull, self.ground_stiffness * place[-1] + self.ground_damping * speed[-1])
        on[0] += force
        on[1:] -= pull
        return speed, on / self.mass


@dataclasses.dataclass(frozen=True, eq=False)
class Impactors:
    """Equal spheres that hit the target side by side."""

    count: int
    mass: float  # mass of one sphere, kg
    velocity: float  # speed normal to the target, m/s
    law: ContactLaw  # law of the contact of a sphere with the target's surface

    @cached_property
    def largest_overlap(self) -> float:
        """Overlap on a fixed plane when all kinetic energy has become work of the contact, m."""
        energy = 0.5 * self.mass * self.velocity**2

        def missing(overlap: float) -> float:
            return float(self.law.loading_work(np.array([overlap]))[0]) - energy

        upper = self.law.effective_radius * 1e-6
        while missing(upper) < 0:
            upper *= 2
        return brentq(missing, 0.0, upper, xtol=1e-14 * upper, rtol=1e-14)

    @property
    def duration(self) -> float:
        """Approximate duration of a collision with a fixed plane, s."""
        return 3 * self.largest_overlap / self.velocity


def no_bare_target(assembly: Assembly) -> str:
    """Return the reason why a packing has no bare target for comparison; empty if it has one."""
    load = assembly.case.load
    if load.no_bare_target:
        return load.no_bare_target
    target = target_of(assembly)
    if target is None:
        return "the packing has no bottom"
    if not load.driven and not impactors_of(assembly, target.material):
        return "nothing moves towards the target"
    if not load.driven and np.isin(struck_of(assembly), assembly.in_clumps).any():
        return "a clump moves towards the target"
    return ""


def unprotected(assembly: Assembly, end_time: float) -> Reached | None:
    """The load of a case directly on its target; None without a target, or without spheres or
    forces that hit it.

    None for oscillating loads, too: they are measured by the transmission of the chain, not by
    protection.

    Parameters
    ----------
    end_time
        Latest end of the computation, s; the first collision is always completed.
    """
    load = assembly.case.load
    target = target_of(assembly)
    if target is None or no_bare_target(assembly):
        return None
    if isinstance(load, DrivenLoad):
        return _pushed(load, target, end_time)
    groups = impactors_of(assembly, target.material)
    if len(groups) == 1 and not target.moves:
        return _rebound(groups[0])
    return _hit(groups, target, end_time)


def target_of(assembly: Assembly) -> Target | None:
    """Target of a packing: the plane below it, the bar at a chain's end, or a rigid base.

    A last layer that is held in place represents a rigid base. None if there is nothing below.
    """
    boundary = assembly.case.boundary
    support = boundary.bottom_support
    material = boundary.bottom_material
    if support is not None:
        behind = support.backing(material, footprint_radius(assembly))
        if not behind.elements:
            return Target(material, np.array([behind.mass]), 0.0, behind.stiffness, behind.damping)
        masses = np.full(behind.elements + 1, behind.mass / behind.elements)
        masses[[0, -1]] /= 2
        if behind.end == "fixed":
            return Target(material, masses[:-1], behind.stiffness, behind.stiffness)
        return Target(
            material,
            masses,
            behind.stiffness,
            0.0,
            0.0 if isinstance(behind.end, str) else behind.end,
        )
    if boundary.bottom_rule.bears:
        return Target(material, np.empty(0))
    bar = next((bar for bar in assembly.bars if bar.name == BAR), None)
    return None if bar is None else Target(bar.material, bar.mass, bar.stiffness)


def impactors_of(assembly: Assembly, material: Material | None) -> list[Impactors]:
    """The spheres that the load moves towards the target, grouped by equal
    motion.
    """
    velocities = velocities_of(assembly)
    kinds: dict[tuple[Material, float, float], list[int]] = {}
    for sphere in struck_of(assembly):
        velocity = velocities[sphere][2]
        if velocity > 0:
            kind = assembly.material_of(sphere), assembly.diameter_of(sphere), velocity
            kinds.setdefault(kind, []).append(sphere)
    return [
        Impactors(
            len(spheres),
            assembly.mass_of(spheres[0]),
            velocity,
            flat_contact(assembly, spheres[0], material),
        )
        for (_, _, velocity), spheres in kinds.items()
    ]


def _pushed(load: DrivenLoad, target: Target, end_time: float) -> Reached:
    """Return the downward component of a force on the target."""
    end = min(end_time, load.lasts + target.settles)
    time = np.linspace(0.0, end, _AFTER + 1)
    turns = [one for one, _ in load.table or ()] + [load.lasts / 2]
    time = np.union1d(time, [one for one in turns if one < end])
    force = load.at(time) * load.way[2]
    if not target.moves:
        return Reached(time, force, force)
    n = len(target.mass)

    def rates(now: float, state: Array) -> Array:
        return np.concatenate(
            target.rates(state[:n], state[n:], float(load.at(np.array(now))) * load.way[2])
        )

    from scipy.integrate import solve_ivp  # imported on demand: slow to load

    found = solve_ivp(
        rates,
        (0.0, end),
        np.zeros(2 * n),
        "DOP853",
        time,
        rtol=_TOLERANCE,
        atol=1e-15,
        max_step=end / _AFTER,
    )
    return Reached(time, force, _on_ground(target, force, found.y[:n], found.y[n:]))


def _rebound(group: Impactors) -> Reached:
    """Equal spheres that hit a fixed plane, until they leave it.

    Overlaps are deepest - way s^2 with s in equal steps: the speed is proportional to s near the
    reversal of the spheres.
    """
    law = group.law
    deepest = np.array([group.largest_overlap])
    step = 1 / _IN_CONTACT
    edges = np.arange(_IN_CONTACT + 1) * step
    middles = (np.arange(_IN_CONTACT) + 0.5) * step

    def durations(way: Array, kinetic: Callable[[Array], Array]) -> Array:
        speed = np.sqrt(2 * kinetic(deepest - way * middles**2) / group.mass)
        return 2 * way * middles * step / speed

    back = deepest - law.residual_overlap(deepest)
    closing = durations(deepest, lambda at: law.loading_work(deepest) - law.loading_work(at))
    parting = durations(
        back, lambda at: law.elastic_energy(deepest, deepest) - law.elastic_energy(at, deepest)
    )
    time = np.concatenate([[0.0], np.cumsum([*closing[::-1], *parting])])
    loading = law.loading_force(deepest * (1 - edges[::-1] ** 2))
    force = group.count * np.concatenate(
        [loading, law.force(deepest - back * edges[1:] ** 2, deepest)]
    )
    return Reached(time, force, force)


class _Collision:
    """Spheres on the target, as an ordinary differential equation.

    The state has overlaps (of spheres from where they touch the plane at rest), velocities of the
    spheres, positions and velocities of the planes: (2 n_groups + 2 n_planes,), m and m/s.

    Parameters
    ----------
    groups
        Equal spheres, each group with its law, mass, number and velocity.
    target
        Planes on springs, the uppermost first.
    """

    def __init__(self, groups: Sequence[Impactors], target: Target) -> None:
        self.groups = groups
        self.target = target
        self.n_groups = len(groups)
        self.n_planes = len(target.mass)
        self.mass = np.array([group.mass for group in groups])
        self.count = np.array([group.count for group in groups])
        self.peak = np.zeros(self.n_groups)  # largest overlaps before the present phase, m

    def start(self) -> Array:
        """Return the state at first contact."""
        velocity = [group.velocity for group in self.groups]
        return np.concatenate([np.zeros(self.n_groups), velocity, np.zeros(2 * self.n_planes)])

    def scales(self) -> Array:
        """Return a typical size of each component of the state."""
        overlap = max(group.largest_overlap for group in self.groups)
        velocity = max(group.velocity for group in self.groups)
        return np.repeat(
            [overlap, velocity, overlap, velocity],
            [self.n_groups, self.n_groups, self.n_planes, self.n_planes],
        )

    def planes(self, state: Array) -> tuple[Array, Array]:
        """Return positions and velocities of the planes, from one state or a column for each."""
        first = 2 * self.n_groups
        return state[first : first + self.n_planes], state[first + self.n_planes :]

    def overlaps(self, state: Array) -> Array:
        """Return the overlaps with the uppermost plane, negative for gaps: (n_groups,), m."""
        position, _ = self.planes(state)
        return state[: self.n_groups] - (position[0] if self.n_planes else 0.0)

    def forces(self, state: Array) -> Array:
        """Return the force of a sphere of each group: (n_groups,), N."""
        forces = np.zeros(self.n_groups)
        for place, overlap in enumerate(self.overlaps(state)):
            if overlap > 0:
                deepest = max(self.peak[place], overlap)
                law = self.groups[place].law
                forces[place] = law.force(np.array([overlap]), np.array([deepest]))[0]
        return forces

    def force_on_target(self, state: Array) -> float:
        """Return the sum of the forces of all spheres, N."""
        return float(self.count @ self.forces(state))

    def rates(self, _: float, state: Array) -> Array:
        """Return the time derivative of the state."""
        force = self.forces(state)
        velocity = state[self.n_groups : 2 * self.n_groups]
        of_planes = self.target.rates(*self.planes(state), float(self.count @ force))
        return np.concatenate([velocity, -force / self.mass, *of_planes])

    def turn(self, place: int, direction: int) -> Event:
        """Sphere and plane stop approaching each other (-1), or separating (+1)."""

        def rate(_: float, state: Array) -> float:
            of_planes, _accelerations = self.target.rates(
                *self.planes(state), self.force_on_target(state)
            )
            of_plane = of_planes[0] if self.n_planes else 0.0
            return float(state[self.n_groups + place] - of_plane)

        return _event(rate, direction)

    def contact(self, direction: int) -> Event:
        """The last sphere leaves the plane (-1), or a first sphere touches it (+1)."""
        return _event(lambda _, state: float(self.overlaps(state).max()), direction)


def _hit(groups: list[Impactors], target: Target, end_time: float) -> Reached:
    """Impact of spheres on the target, in phases between reversals of single spheres."""
    from scipy.integrate import solve_ivp  # imported on demand: slow to load

    collision = _Collision(groups, target)
    duration = min(group.duration for group in groups)
    state = collision.start()
    tolerances = _TOLERANCE * collision.scales()
    times = [np.zeros(1)]
    states = [state[:, None]]
    peaks = [collision.peak.copy()]
    now = 0.0
    end = max(end_time, 2 * duration)
    parted = False  # once
    turns = [-1] * len(groups)  # directions of the next turn of each sphere
    parting = -1  # direction of the next event of the contact
    for _ in range(_MOST_PHASES):
        events = [collision.turn(place, direction) for place, direction in enumerate(turns)]
        solution = solve_ivp(
            collision.rates,
            (now, end),
            state,
            "DOP853",
            rtol=_TOLERANCE,
            atol=tolerances,
            max_step=_longest_step(target, duration, in_contact=parting < 0),
            events=[*events, collision.contact(parting)],
        )
        times.append(solution.t[1:])
        states.append(solution.y[:, 1:])
        peaks += [collision.peak.copy()] * len(solution.t[1:])
        now = float(solution.t[-1])
        state = solution.y[:, -1]
        if solution.status != 1:
            break
        collision.peak = np.maximum(collision.peak, collision.overlaps(state))
        *turned, passed = (len(instants) > 0 for instants in solution.t_events)
        turns = [-way if done else way for way, done in zip(turns, turned, strict=True)]
        parting = -parting if passed else parting
        if parting > 0:  # no sphere is in contact any more
            if not target.settles or target.ground_stiffness == target.ground_damping == 0:
                break
            if not parted:
                end = min(end, now + target.settles)
            parted = True
    time = np.concatenate(times)
    course = np.concatenate(states, axis=1)
    force = np.empty(len(time))
    for place, deepest in enumerate(peaks):
        collision.peak = deepest
        force[place] = collision.force_on_target(course[:, place])
    return Reached(time, force, _on_ground(target, force, *collision.planes(course)))


def _longest_step(target: Target, duration: float, *, in_contact: bool) -> float:
    """Return the longest step of the integration, s."""
    if in_contact:
        return duration / _IN_CONTACT
    return max(duration, target.settles) / _AFTER


def _event(function: Callable[[float, Array], float], direction: int) -> Event:
    """Return an event that ends a phase when the function passes zero in this direction."""
    event: Any = function
    event.terminal = True
    event.direction = direction
    return event


def _on_ground(target: Target, force: Array, place: Array, speed: Array) -> Array:
    if not target.moves or not target.mass[0]:
        return force
    return target.ground_stiffness * place[-1] + target.ground_damping * speed[-1]
