"""Energy input of a load, and the collisions that bound the overlaps of a run.

The hardest collision bounds all overlaps of the run. Candidates are collisions of effective mass
m_eff at the normal velocity v_n, in which the contact absorbs at most W = m_eff v_n^2 / 2 on
loading:

* the impacted sphere against one resting sphere, head on: m_eff = m/2, v_n = v;
* the impacted sphere against the n spheres that it rests on, at the angle theta to the impact
direction:
  m_eff = m / (1 + n cos^2 theta), v_n = v cos theta (for fcc and hcp n = 3, cos^2 theta = 2/3);
* a sphere accelerated by a rigid plate to twice its velocity, or the fraction of the plate's energy
  per contact;
* a sphere against a wall, or against a held sphere: m_eff = m, v_n = v if lines of contacts carry
the whole pulse to the wall (chain, simple cubic), otherwise v halved with each layer before the
wall; a wall that moves
  counts with the mass of its plate.

If bodies differ, each kind of touching pair is a candidate with the whole energy input, of which a
pair of masses m1 < m2 takes up at most m2/(m1 + m2), or all of it if one of them is held. The
energy input of a force F is at most the energy of its impulse J on a free sphere, J^2/2m, and no
contact force exceeds about 2.5 F (2.3 F in a Hertzian chain). If there are many diameters,
diameters within 10 % of each other are represented by the smallest, which has the stiffest contact
for its mass. Equal spheres with diameter scatter are represented by the smallest sphere, impacted
by a nominal sphere. Under a static load each contact also takes up the work of that load.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.boundary import Backing
from granwave.lammps_inputs.case.contact.contact import NO_FORCE
from granwave.lammps_inputs.case.loads.bounds import LARGEST_OVERLAP, work_to_force
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.initial_dents import largest_dent
from granwave.lammps_inputs.contact.law import ContactLoss, flat_contact, pair_contact, viscous_loss
from granwave.lammps_inputs.contact.static_load import force_of_contact
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.motion import (
    LoadedAssembly,
    held_against_load,
    start_speed,
    velocities_of,
)
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.sites import Sites
from granwave.lammps_inputs.packing.walls import PLATE, backing_of, walls
from granwave.lammps_inputs.roots import brentq


def expected_energy(assembly: Assembly) -> float:
    """Return the energy input of the load, J; for a force, an upper bound."""
    energy = sum(
        0.5 * assembly.mass_of(k) * math.hypot(*v) ** 2 for k, v in velocities_of(assembly).items()
    )
    return energy + assembly.case.load.energy_in(LoadedAssembly(assembly))


def fastest(assembly: Assembly) -> float:
    """Return an upper bound on the speed of any sphere, m/s."""
    speeds = [math.hypot(*velocity) for velocity in velocities_of(assembly).values()]
    return max([*speeds, assembly.case.load.speed_bound(LoadedAssembly(assembly))])


BOTTOM = "boundary.bottom"  # key of a support
# most kinds of spheres that are distinguished; if there are more, diameters within this ratio count
# as one
_MOST_KINDS = 50
_NEAR = 1.1


def kinds_of_grains(sites: Sites) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Classify spheres by material and diameter, or by ranges of diameters if there are too many.

    Returns
    -------
    of
        Kind by site: (n_sites,); -1 for vacant ones.
    example
        Id of a sphere of each kind.
    """
    if sites.uniform:
        return np.broadcast_to(0, len(sites.body)), np.ones(1, dtype=np.int64)
    diameters, size = np.unique(sites.diameter, return_inverse=True)
    if len(diameters) * len(sites.bodies) > _MOST_KINDS:
        size = (np.log(sites.diameter / diameters[0]) / math.log(_NEAR)).astype(np.int64)
    code = np.where(sites.present, sites.body * (size.max() + 1) + size, -1)
    order = np.lexsort((sites.diameter, code))  # the smallest of each kind first
    codes, first = np.unique(code[order], return_index=True)
    example = order[first][codes >= 0] + 1
    return np.searchsorted(codes[codes >= 0], code) - (code < 0), example


def kinds_of_pairs(assembly: Assembly) -> list[tuple[int, int]]:
    """Return one pair for each kind of neighbours, and a pair of spheres that are not replaced if
    there are two.
    """
    sites = assembly.sites
    pairs: list[tuple[int, int]] = []
    if sites.uniform:
        if sites.count > 1:
            pairs.append((1, 1))
    else:
        of, example = kinds_of_grains(sites)
        n = len(example)
        codes = set[int]()
        for near, _ in sites.neighbours():
            codes.update(np.unique(of[near - 1] @ np.array([n, 1])).tolist())
        if isinstance(assembly.lattice, Places):  # any two grains may collide
            codes = set()
            for first in range(n):
                for second in range(first, n):
                    codes.add(first * n + second)
        pairs += [(int(example[code // n]), int(example[code % n])) for code in sorted(codes)]
        like = sites.made_of(assembly.material) & (sites.diameter == assembly.lattice.diameter)
        if np.count_nonzero(like) > 1:
            unmodified = int(like.argmax()) + 1
            pairs.append((unmodified, unmodified))
    for number, (striker, _) in enumerate(assembly.strikers, start=assembly.lattice.n_spheres + 1):
        pairs += [(number, touched) for touched in striker.touches]

    def kind(grain: int) -> tuple[object, ...]:
        return assembly.material_of(grain), assembly.diameter_of(grain), assembly.shape_of(grain)

    return list({frozenset(map(kind, pair)): pair for pair in pairs}.values())


_SLOPE_SPAN = 1e-6  # relative step of a finite difference in overlap
# F alpha over the work of a Hertz contact up to the force F of a static load
_OF_PRECOMPRESSION = 2.5
_OF_HERTZ = 2.943  # duration of a collision times its velocity over its largest overlap


@dataclasses.dataclass(frozen=True)
class Encounter:
    """Collision that bounds the overlaps of the run.

    Attributes
    ----------
    law
        Law of the contact.
    energy
        Work of loading that the contact takes up, J.
    mass
        Twice the effective mass, kg: the mass of either of two equal spheres, or twice the mass of
        a sphere at a wall or at a held sphere.
    against_wall
        True if there is no second sphere.
    dent
        Largest overlap that such a contact had before the run, m; up to it the unloading stiffness
        applies.
    loss
        Kind and size of the viscous loss of the contact.
    body
        Key of the body behind a wall, and the mass of this body, if it is lighter than the sphere;
        empty otherwise.
    """

    law: ContactLaw
    energy: float
    mass: float
    against_wall: bool = False
    dent: float = 0.0
    loss: ContactLoss | None = None
    body: str = ""

    @cached_property
    def overlap(self) -> float:
        """Overlap at which the work of loading equals the energy, m."""

        limit = LARGEST_OVERLAP * self.law.effective_radius
        if self.law.loading_work(limit) <= self.energy:
            return limit

        def excess(logarithm: float) -> float:
            return math.log(self.law.loading_work(math.exp(logarithm)) / self.energy)

        low = math.log(limit)
        while excess(low) > 0:
            low -= 5.0
        return math.exp(brentq(excess, low, math.log(limit), xtol=1e-10))

    @cached_property
    def stiffness(self) -> float:
        """Effective stiffness at that overlap, N/m: of unloading for recoverable work, of loading
        for the rest.
        """
        law = self.law
        peak = self.overlap
        dent = self.dent
        if (
            dent > peak
            # an elastic contact with a dent stores this energy; unloading is a power law
        ):
            held = law.loading_work(dent) - law.dissipated_energy(dent)
            steepest = law.unloading_stiffness(dent)
            ratio = (
                steepest * held / law.loading_force(dent) ** 2
            )  # n/(n + 1) of the exponent n; 2 ratio - 1 is below
            return float(
                steepest * min(1.0, self.energy / held) ** (2 * ratio - 1)
            )  # (n - 1)/(n + 1)
        below = peak * (1 - _SLOPE_SPAN)
        loading = (law.loading_force(peak) - law.loading_force(below)) / (peak - below)
        returned = 1 - law.dissipated_energy(peak) / law.loading_work(peak)
        return float(returned * law.unloading_stiffness(peak) + (1 - returned) * loading)

    @property
    def duration(self) -> float:
        """Duration of an elastic collision, s: Hertz's value for the overlap and velocity of this
        one.
        """
        velocity = math.sqrt(2 * self.energy / (self.mass / 2))
        return _OF_HERTZ * self.overlap / velocity

    @property
    def decay_time(self) -> float:
        """Time in which the viscous force would stop the bodies at that overlap, s; infinite
        without one.
        """
        if self.loss is None or self.loss[0] == "prony":  # branches are exact in any timestep
            return math.inf
        kind, size = self.loss
        stiffness = max(self.law.unloading_stiffness(max(self.overlap, self.dent)), self.stiffness)
        coefficient = (
            size * stiffness if kind == "time" else size * math.sqrt(self.mass / 3 * stiffness)
        )
        return self.mass / 2 / coefficient


def some_encounters(assembly: Assembly) -> list[Encounter]:
    """Return the encounters; raise ValueError if there are none, or one of them has no
    stiffness.
    """
    if not (found := encounters(assembly)):
        raise ValueError("no contact absorbs energy")
    for one in found:
        try:
            there = 0 < one.stiffness < math.inf
        except (ArithmeticError, ValueError):  # the law of line contacts ends, others overflow
            there = False
        if not there:
            raise ValueError("the load would compress a contact beyond the range of its law")
    return found


@kept_by_assembly
def encounters(assembly: Assembly) -> list[Encounter]:
    """Return the collisions that bound the overlaps of a run."""
    case = assembly.case
    plain = assembly.like and case.boundary.bottom_material is None and case.load.gives_velocity
    plain = plain and not case.wall
    found = _of_impact(assembly) if plain else _of_any(assembly)
    found = [one for one in found if one.law.name != NO_FORCE]
    if case.precompression is not None:
        force = force_of_contact(
            assembly
        )  # its work is stored initially, and the load does more work during the run
        stored = [_OF_PRECOMPRESSION * work_to_force(one.law, force) for one in found]
        found = [
            dataclasses.replace(one, energy=one.energy + more)
            for one, more in zip(found, stored, strict=True)
        ]
    if case.contact.initial_overlap:
        found = [dataclasses.replace(one, dent=largest_dent(assembly, one.law)) for one in found]
    return [one for one in found if one.energy > 0]


def _of_impact(assembly: Assembly) -> list[Encounter]:
    """Return the collisions of an impact among equal spheres, with or without diameter scatter."""
    case = assembly.case
    sites = assembly.sites
    rule = assembly.lattice.rule
    striking = case.sphere_mass
    velocity = start_speed(assembly)
    smallest = (
        1 if sites.uniform else int(np.where(sites.present, sites.diameter, np.inf).argmin()) + 1
    )
    law = pair_contact(assembly, smallest, smallest)
    mass = assembly.mass_of(smallest)
    loss = _loss(assembly, assembly.material, assembly.material)
    found = [
        Encounter(law, striking * velocity**2 / 2 * (striking / (striking + mass)), mass, loss=loss)
    ]
    if n := len(rule.supports):
        cosine_squared = float(rule.supports[0, 2] ** 2)
        energy = striking * velocity**2 * cosine_squared / (1 + n * cosine_squared) / 2
        found.append(Encounter(law, energy, mass, loss=loss))
    if case.boundary.bottom_rule.has_plane:
        # along lines of contacts, or through a single layer, the pulse reaches the wall undivided
        halvings = assembly.lattice.n_layers - 1 if rule.set_back else 0
        energy = striking * (velocity * 0.5**halvings) ** 2 / 2
        loss = _loss(assembly, assembly.material, None, flat=True)
        at_wall = Encounter(
            flat_contact(assembly, smallest), energy, 2 * mass, against_wall=True, loss=loss
        )
        behind = _behind(assembly, "bottom", assembly.material)
        found.append(_with_body(at_wall, behind, BOTTOM))
    if held := held_against_load(assembly):
        # the pulse runs through the layers above the last one; other held grains may be next to
        # the struck one
        layers = max(assembly.lattice.n_layers - 2, 0)
        far = rule.set_back and np.isin(held, assembly.lattice.last_layer).all()
        energy = striking * (velocity * 0.5 ** (layers if far else 0)) ** 2 / 2
        loss = _loss(assembly, assembly.material, assembly.material)
        found.append(Encounter(law, energy, 2 * mass, loss=loss))
    return found


def _behind(assembly: Assembly, name: str, material: Material) -> Backing | None:
    """Return the moving mass and support behind the wall of this name that grains of a material
    press.
    """
    wall = next((wall for wall in walls(assembly) if wall.name == name), None)
    return None if wall is None else backing_of(assembly, wall, material)


def _with_body(collision: Encounter, behind: Backing | None, key: str) -> Encounter:
    """Return a collision with a plane, with the mass of the body behind it, which has this key."""
    if behind is None or collision.energy <= 0 or collision.law.name == NO_FORCE:
        return collision
    try:
        stiffness = collision.stiffness
    except (ArithmeticError, ValueError):  # `some_encounters` names it
        return collision
    if not 0 < stiffness < math.inf:
        return collision
    sphere = collision.mass / 2
    body = behind.moved_mass(sphere, stiffness)
    return dataclasses.replace(
        collision, mass=2 * sphere / (1 + sphere / body), body=key if body < sphere else ""
    )


def _of_any(assembly: Assembly) -> list[Encounter]:
    """Return a collision with the whole energy input for each kind of touching pair."""
    collisions = _of_pairs(assembly)
    energy = expected_energy(assembly)
    for sphere, material, behind, key in _flats(assembly):
        law = flat_contact(assembly, sphere, material)
        mass = 2 * assembly.mass_of(sphere)
        loss = _loss(assembly, assembly.material_of(sphere), material, flat=True)
        taken = _limited(assembly, law, energy)
        at_flat = Encounter(law, taken, mass, against_wall=True, loss=loss)
        collisions.append(_with_body(at_flat, behind, key))
    return collisions


def _of_pairs(assembly: Assembly) -> list[Encounter]:
    """Return a collision for each kind of touching pair, and for pairs with a held grain."""
    energy = expected_energy(assembly)
    of, _ = kinds_of_grains(assembly.sites)
    held = held_against_load(assembly)
    kinds = set(of[np.array(held, dtype=np.int64) - 1].tolist())

    def may_be_held(grain: int) -> bool:
        return grain <= len(of) and int(of[grain - 1]) in kinds

    collisions = []
    for first, second in kinds_of_pairs(assembly):
        masses = assembly.mass_of(first), assembly.mass_of(second)
        law = pair_contact(assembly, first, second)
        loss = _loss(assembly, assembly.material_of(first), assembly.material_of(second))
        # a grain of a clump meets others with more than its own mass
        share = 1.0 if assembly.clumps else max(masses) / sum(masses)
        effective = math.prod(masses) / sum(masses)
        collisions.append(
            Encounter(law, _limited(assembly, law, energy * share), 2 * effective, loss=loss)
        )
        for mass, partner in zip(masses, (second, first), strict=True):
            if may_be_held(partner):
                collisions.append(
                    Encounter(law, _limited(assembly, law, energy), 2 * mass, loss=loss)
                )
    return collisions


def _flats(assembly: Assembly) -> list[tuple[int, Material | None, Backing | None, str]]:
    """Return a grain for each kind that may meet a flat: its id, the material of the flat, and the
    body behind it with its key.
    """
    case = assembly.case
    boundary = assembly.case.boundary
    lattice = assembly.lattice
    of, example = kinds_of_grains(assembly.sites)
    flats: list[tuple[int, Material | None, Backing | None, str]] = [
        (bar.touches, bar.material, bar.backing, f"{bar.name}.length") for bar in assembly.bars
    ]
    if (plate := case.load.plate) is not None:
        grain = int(lattice.top_layer[0])
        behind = _behind(assembly, PLATE, assembly.material_of(grain))
        flats.append((grain, None, behind, plate.key))
    if boundary.bottom_rule.has_plane:
        there = np.unique(of[lattice.last_layer - 1])
        flats += [
            (
                sphere,
                boundary.bottom_material,
                _behind(assembly, "bottom", assembly.material_of(sphere)),
                BOTTOM,
            )
            for sphere in example[there[there >= 0]].tolist()
        ]
    aside = any(case.load.way[:2])
    if (assembly.has_cylinders or aside) and any(boundary.has_planes(axis) for axis in "xy"):
        grains = [grain for grain in example.tolist() if aside or assembly.shape_of(grain)]
        flats += [(grain, boundary.sides_material, None, "") for grain in grains]
    for wall in case.wall:
        flats += [(n, wall.material, None, "") for n in example.tolist()]
    held = [n for n, (one, _) in enumerate(assembly.strikers, lattice.n_spheres + 1) if one.walls]
    for material in (boundary.bottom_material, boundary.sides_material):
        flats += [(n, material, None, "") for n in held]
    return flats


def _loss(
    assembly: Assembly, first: Material, second: Material | None, *, flat: bool = False
) -> ContactLoss | None:
    return viscous_loss(
        assembly, assembly.case.contact_between(first, second), first, second, flat=flat
    )


def _limited(assembly: Assembly, law: ContactLaw, energy: float) -> float:
    """Limit the energy absorbed by a contact by the magnitude of the load, J."""
    return assembly.case.load.contact_energy(energy, law, LoadedAssembly(assembly))
