"""Compiled contact laws of a case, between two spheres or a sphere and a wall or bar, and their
viscous losses.

The relaxation time that gives a restitution at a speed is found from the head-on collision of two
bodies with their own law (`ContactLaw.collide`). The grains of a material have a common relaxation
time, computed for their median diameter.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from granwave._contact_laws import ContactLaw, LineContact
from granwave.lammps_inputs.case.boundary import Backing
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import (
    LAWS,
    Contact,
)
from granwave.lammps_inputs.case.contact.tables import PRONY, Cohesion, DashpotRestitution
from granwave.lammps_inputs.case.material import Material, Shape
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bodies import PlacedBar
from granwave.lammps_inputs.packing.cylinders import cylinder_pair
from granwave.lammps_inputs.packing.places import cohesive_law
from granwave.lammps_inputs.packing.walls import backing_of, walls
from granwave.lammps_inputs.packing_kind import TOUCHING
from granwave.lammps_inputs.roots import brentq

HERTZ = Contact(law="hertz")


def elastic_contact(contact: Contact) -> Contact:
    """Return Hertz's law, or the law of the case if it is a power of the overlap
    and thus elastic.
    """
    return contact if contact.entry.is_power else HERTZ


def elastic_case(case: Case) -> Case:
    """Return a case with the elastic contacts of the first half of its static stage."""
    contact = dataclasses.replace(elastic_contact(case.contact), line=case.contact.line)
    pairs = tuple(
        dataclasses.replace(pair, contact=elastic_contact(pair.contact)) for pair in case.pair
    )
    return dataclasses.replace(case, contact=contact, pair=pairs)


def sphere_contact(case: Case) -> ContactLaw:
    """Return the law between two grains of the packing that are not replaced."""
    grain = (case.material, case.packing.diameter / 2, case.packing.of_grain)
    return _law(case, grain, grain)


def pair_contact(assembly: Assembly, first: int, second: int) -> ContactLaw:
    """Return the law between the two spheres with these ids."""
    return _law(assembly.case, _grain(assembly, first), _grain(assembly, second))


def flat_contact(assembly: Assembly, sphere: int, partner: Material | None = None) -> ContactLaw:
    """Return the law between a sphere and a flat: a wall or bar of a material, or a rigid wall
    (None).
    """
    return _law(assembly.case, _grain(assembly, sphere), (partner, math.inf, None))


def _grain(assembly: Assembly, sphere: int) -> tuple[Material, float, Shape]:
    return assembly.material_of(sphere), assembly.diameter_of(sphere) / 2, assembly.shape_of(sphere)


def _law(
    case: Case, first: tuple[Material, float, Shape], second: tuple[Material | None, float, Shape]
) -> ContactLaw:
    """Return the law between two bodies: material, radius and shape of each; without cohesion."""
    material, radius, shape = first
    other, other_radius, other_shape = second
    bare = dataclasses.replace(case.contact_between(material, other), cohesion=None)
    return law_between(
        bare, (material, other), (radius, other_radius),
        shapes=(shape, other_shape), plane_strain=case.contact.line == "plane-strain",
    )  # fmt: skip


def law_between(
    contact: Contact,
    materials: tuple[Material, Material | None],
    radii: tuple[float, float],
    *,
    checked: bool = True,
    shapes: tuple[Shape, Shape] = (None, None),
    plane_strain: bool = False,
    effective_radius: float | None = None,
) -> ContactLaw:
    """Return the law of ``[contact]`` between bodies of two materials (None: rigid) and radii (m;
    infinite: flat).

    Parameters
    ----------
    checked
        True to raise ValueError for constants of a law that is not passive.
    shapes
        Shapes of the bodies; None for spheres and flats.
    plane_strain
        True if contacts along lines are in plane strain, False if bodies are half-spaces.
    effective_radius
        Radius of the sphere with the same stiffness on a flat, m, where it does not follow from
        radii and shapes: in a tube.
    """
    others: dict[str, Any] = {"checked": checked}
    if effective_radius is not None:
        others["effective_radius"] = effective_radius
    elif any(shapes) and not contact.entry.is_power:
        pair = None if math.isinf(radii[1]) else cylinder_pair(*shapes)
        if pair is not None and not pair.parallel:
            others["effective_radius"] = pair.effective_radius(*radii)
        else:  # along a line; a flat is never the first of the two shapes
            elastic = [
                (one.youngs_modulus, one.poisson_ratio) if one else (math.inf, 0.0)
                for one in materials
            ]
            moduli, ratios = zip(*elastic, strict=True)
            bodies = {"youngs_modulus": moduli, "poisson_ratio": ratios}
            length = pair.length if pair is not None else shapes[0].length  # type: ignore[union-attr]
            others["line"] = (
                LineContact.plane_strain(**bodies, radius=radii, length=length)
                if plane_strain
                else LineContact(
                    **bodies, diameter=2 / sum(1 / radius for radius in radii), length=length
                )
            )
    return contact.between(materials, radii, **others)


def error_in_parameters(contact: Contact) -> str:
    """Describe why the parameters of a law exclude each other, or give a law that is not passive;
    empty for valid parameters.
    """
    try:
        ContactLaw(
            contact.law,
            youngs_modulus=(1.0, 1.0),
            poisson_ratio=(0.0, 0.0),
            yield_strength=(1.0, 1.0),
            radius=(1.0, 1.0),
            **contact.parameters,
        )
    except ValueError as error:
        return str(error)
    return ""


def contact_of(
    materials: Sequence[Material | None],
    radii: Sequence[float],
    law: str = "elastoplastic",
    constants: Mapping[str, float | str] | None = None,
    *,
    checked: bool = True,
    cohesion: Cohesion | None = None,
) -> ContactLaw:
    """Return the law between two bodies of one or two materials (None: rigid) and radii (m;
    infinite: flat).

    Parameters
    ----------
    constants
        Parameters of the law other than its defaults, by name.
    checked
        True to reject constants of a law that is not passive.
    cohesion
        Cohesion of the spheres.

    Raises
    ------
    InputError
        A material lacks the yield strength that the law needs.
    ValueError
        A constant is unknown, the law is not passive, or it cannot cohere so.
    """
    for material in materials:
        if LAWS[law].yields and material is not None and material.yield_strength is None:
            raise InputError(
                f"material {material.name}: yield_strength: missing; law {law} requires it: "
                "define it in a file (FILE.toml:NAME), or use a law without yield, such as hertz"
            )
    values: dict[str, Any] = dict(constants or {})
    own = [p.name for p in LAWS[law].parameters.values() if not p.of_material]
    if unknown := sorted(values.keys() - set(own)):
        raise ValueError(f"found the constant {unknown[0]}, expected some of {', '.join(own)}")
    bodies = (materials[0], materials[-1])
    contact = Contact(law=law, cohesion=cohesion, **values)
    return law_between(contact, bodies, (radii[0], radii[-1]), checked=checked)  # type: ignore[arg-type]


def energy_at_start(assembly: Assembly) -> float:
    """Energy of cohesive contacts at the start, relative to separate surfaces and thus negative, J;
    0 without cohesion.

    The energy is stationary at the start, so that rounding of positions does not change it.
    """
    case = assembly.case
    lattice = assembly.lattice
    sites = assembly.sites
    if not case.has_cohesion or not isinstance(lattice, Lattice):
        return 0.0
    found = 0.0
    if lattice.overlap:
        law = cohesive_law(case, case.material)
        found += sites.n_contacts * float(law.elastic_energy(lattice.overlap, lattice.overlap))
    for wall in walls(assembly):
        if wall.overlap:
            gaps = wall.gaps(sites.centres, sites.diameter[sites.present] / 2)
            touching = np.count_nonzero(np.abs(gaps + wall.overlap) <= TOUCHING * lattice.diameter)
            law = cohesive_law(case, wall.material, flat=True)
            found += touching * float(law.elastic_energy(wall.overlap, wall.overlap))
    return found


def cohesive_laws(assembly: Assembly) -> Iterator[tuple[ContactLaw, float]]:
    """Iterate over the laws of spheres of the packing that cohere, each with twice the effective
    mass, kg; a light plate counts with its own mass only.
    """
    case = assembly.case
    if case.contact_between(case.material, case.material).coheres:
        yield cohesive_law(case, case.material), case.sphere_mass
    for wall in walls(assembly):
        if not wall.held_layer and case.contact_between(case.material, wall.material).coheres:
            behind = backing_of(assembly, wall, case.material)
            plate = behind.mass if behind is not None and not behind.elements else 0.0
            mass = 2 * case.sphere_mass / (1 + case.sphere_mass / (plate or math.inf))
            yield cohesive_law(case, wall.material, flat=True), mass


_STEPS = 2000  # steps of a collision
_ROUNDING = 1e-6  # rounding error of a restitution without loss
# relaxation time / duration of the elastic collision: restitution is below 0.01
_MOST_TIME = 20.0
_MOST_FACTOR = 50.0  # largest factor of a dashpot: restitution is below 0.01
_ACCURACY = 1e-9  # relative accuracy of the relaxation time or factor

Viscous = tuple[Literal["time", "dashpot"], float]  # kind, and relaxation time (s) or factor
Branches = tuple[tuple[float, float], ...]  # weight and time (s) of each branch
Relaxing = tuple[Literal["prony"], Branches]
ContactLoss = Viscous | Relaxing


def viscous_loss(
    assembly: Assembly,
    contact: Contact,
    first: Material,
    second: Material | None,
    *,
    flat: bool = False,
    shapes: tuple[Shape, Shape] | None = None,
    behind: Backing | None = None,
) -> ContactLoss | None:
    """Return the loss of contacts between grains of a material and their partners; None without a
    loss.

    Parameters
    ----------
    second
        Material of the partners; None for a rigid one.
    flat
        True for partners that are planes: walls and faces of bars.
    shapes
        Shapes of the grains; by default whatever there are of these materials.
    behind
        Body behind a plane; None for a plane at rest.

    Raises
    ------
    ValueError
        No relaxation time gives the restitution.
    """
    if (loss := contact.loss) is None:
        return None
    if loss.branches:
        return (PRONY, loss.branches)
    if loss.time is not None:
        return ("time", loss.time) if loss.time else None
    if loss.restitution is None or loss.velocity is None:
        dashpot = loss.dashpot
        factor = (
            dashpot_factor(dashpot.restitution)
            if isinstance(dashpot, DashpotRestitution)
            else dashpot
        )
        return ("dashpot", factor) if factor else None
    grains = (first,) if flat or second is None else (first, second)
    ids = [
        nominal_grain(assembly, one, shapes and shapes[n : n + 1]) for n, one in enumerate(grains)
    ]
    forms = [
        *(_grain(assembly, one)[1:] for one in ids),
        (math.inf, None),
    ]  # a flat, where the second body is a plane
    mass = 1 / sum(1 / assembly.mass_of(one) for one in ids)
    time = _loss_time(
        contact, (first, second), *zip(*forms[:2], strict=True), assembly.plane_strain, mass, behind
    )
    return ("time", time) if time else None


def loss_at_bar(
    assembly: Assembly, contact: Contact, material: Material, bar: PlacedBar
) -> ContactLoss | None:
    """Return the loss of grains of a material at the face of a bar with free ends.

    The pair style treats the body of a face as immovable: the factor of a dashpot corrects for the
    mass of the bar.
    """
    loss = viscous_loss(assembly, contact, material, bar.material, flat=True, behind=bar.backing)
    if loss is None or loss[0] != "dashpot":
        return loss
    return (loss[0], loss[1] / math.sqrt(1 + assembly.mass_of(bar.touches) / bar.backing.mass))


@lru_cache(maxsize=256)
def _loss_time(
    contact: Contact,
    materials: tuple[Material, Material | None],
    radii: tuple[float, float],
    shapes: tuple[Shape, Shape],
    plane_strain: bool,
    mass: float,
    behind: Backing | None = None,
) -> float:
    """Return the relaxation time with which two bodies of an effective mass (kg) have the
    restitution of the law, s; ``behind``: a body behind the plane that a grain of this mass hits.
    """
    loss = contact.loss
    assert loss is not None and loss.restitution is not None and loss.velocity is not None
    restitution = loss.restitution
    velocity = loss.velocity
    law = law_between(contact, materials, radii, shapes=shapes, plane_strain=plane_strain)
    alone = law.collide(mass, velocity, steps=_STEPS)
    if math.isnan(alone["restitution"]):  # nothing stops them
        return 0.0
    if behind is not None:
        stiffness = mass * (math.pi / alone["duration"]) ** 2
        mass = mass / (1 + mass / behind.moved_mass(mass, stiffness))
        alone = law.collide(mass, velocity, steps=_STEPS)
    if alone["restitution"] < restitution - _ROUNDING:
        raise ValueError(
            f"at most {alone['restitution']:.4g}, the restitution of law {contact.law} at "
            f"{velocity:g} m/s from yielding only"
        )

    def left(time: float) -> float:
        return float(law.collide(mass, velocity, loss_time=time, steps=_STEPS)["restitution"])

    longest = _MOST_TIME * alone["duration"]
    return _loss_of(
        left,
        restitution,
        longest,
        f"a relaxation time of {longest:.3g} s",
        _ACCURACY * alone["duration"],
    )


@lru_cache(maxsize=64)
def dashpot_factor(restitution: float) -> float:
    """Return the factor of the dashpot that gives a Hertzian contact this restitution, at any speed
    and size.
    """

    one = (1.0, 1.0)
    law = ContactLaw(
        "hertz", youngs_modulus=one, poisson_ratio=(0.0, 0.0), yield_strength=one, radius=one
    )

    def left(factor: float) -> float:
        return float(law.collide(1.0, 1e-3, loss_dashpot=factor, steps=_STEPS)["restitution"])

    return _loss_of(left, restitution, _MOST_FACTOR, f"a factor of {_MOST_FACTOR:g}", _ACCURACY)


def _loss_of(
    left: Callable[[float], float], restitution: float, most: float, named: str, accuracy: float
) -> float:
    """Return the size of a loss, at most ``most``, that gives a restitution; raise ValueError if
    the restitution is still larger.
    """
    if left(0.0) <= restitution + _ROUNDING:
        return 0.0
    if (least := left(most)) > restitution:
        raise ValueError(f"at least {least:.4g}, which {named} gives")
    return brentq(lambda size: left(size) - restitution, 0.0, most, xtol=accuracy)


def nominal_grain(
    assembly: Assembly, material: Material, shapes: Sequence[Shape] | None = None
) -> int:
    """Return the id of the grain of a material, and one of these shapes if they are given, with the
    median diameter.
    """
    if assembly.sites.uniform and material == assembly.material:
        return 1
    fits = [one.material == material and (shapes is None or len(assembly.shapes) == 1 or one.shape in shapes)
            for one in assembly.species]  # fmt: skip
    ids = 1 + np.flatnonzero(assembly.present & np.array(fits)[assembly.body])
    own = ids[ids <= assembly.lattice.n_spheres]
    group = own if len(own) else ids
    if not len(group):
        group = np.array([1])
    return int(
        group[np.argsort(assembly.diameter[group - 1], kind="stable")[(len(group) - 1) // 2]]
    )


def velocity_normalised(
    velocity: float, modulus: float, density: float, yield_strength: float
) -> float:
    """Impact velocity in units in which all materials fall on one curve.

    ``(2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v``; for brass 4 m/s give 37.9.

    Parameters
    ----------
    velocity
        m/s.
    modulus
        E* of two spheres, Pa.
    density
        kg/m^3.
    yield_strength
        Pa.
    """
    scale = 2 / math.sqrt(3) * (2 / (1.6 * math.pi)) ** 2
    return scale * modulus**2 * math.sqrt(density) * yield_strength**-2.5 * velocity
