"""Compiled contact laws of a case: between two spheres, and between a sphere and a wall or bar."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from granwave._contact_laws import ContactLaw, LineContact
from granwave.lammps_inputs.case.contact import LAW_CONSTANTS, LAWS, Contact
from granwave.lammps_inputs.case.shape import Shape
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.cylinders import cylinder_pair

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.material import Material

_RIGID = (math.inf, 0.0, math.inf)  # Young's modulus, Poisson's ratio, yield strength


def sphere_contact(case: Case) -> ContactLaw:
    """Return the law between two grains of the packing that are not replaced."""
    radius, shape = case.packing.diameter / 2, case.packing.of_grain
    return _law(case, (case.material, case.material), (radius, radius), (shape, shape))


def pair_contact(case: Case | Assembly, first: int, second: int) -> ContactLaw:
    """Return the law between the two spheres with these ids."""
    assembly = assemble(case)
    case = assembly.case
    return _law(
        case,
        (assembly.material_of(first), assembly.material_of(second)),
        (assembly.diameter_of(first) / 2, assembly.diameter_of(second) / 2),
        (assembly.shape_of(first), assembly.shape_of(second)),
    )


def flat_contact(case: Case | Assembly, sphere: int, partner: Material | None = None) -> ContactLaw:
    """Return the law between a sphere and a flat: a wall or bar of a material, or a rigid wall (None)."""
    assembly = assemble(case)
    case = assembly.case
    return _law(
        case,
        (assembly.material_of(sphere), partner),
        (assembly.diameter_of(sphere) / 2, math.inf),
        (assembly.shape_of(sphere), None),
    )


def _law(
    case: Case,
    materials: tuple[Material, Material | None],
    radii: tuple[float, float],
    shapes: tuple[Shape, Shape],
) -> ContactLaw:
    contact, plane_strain = case.contact_between(*materials), case.contact.line == "plane-strain"
    return law_between(contact, materials, radii, shapes=shapes, plane_strain=plane_strain)


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
    """Return the law of ``[contact]`` between bodies of two materials (None: rigid) and radii (m; infinite: flat).

    Parameters
    ----------
    checked
        True to raise ValueError for constants of a law that is not passive.
    shapes
        Shapes of the bodies; None for spheres and flats.
    plane_strain
        True if contacts along lines are in plane strain, False if bodies are half-spaces.
    effective_radius
        Radius of the sphere that is as stiff on a flat, m, where it does not follow from radii and shapes: in a tube.
    """
    bodies = [(one.youngs_modulus, one.poisson_ratio, one.yield_strength or math.inf) if one else _RIGID
              for one in materials]  # fmt: skip
    moduli, ratios, strengths = zip(*bodies, strict=True)
    constants: dict[str, Any] = {} if contact.constant is None else {"constant": contact.constant}
    if contact.exponent is not None:
        constants["exponent"] = contact.exponent
    if effective_radius is not None:
        constants["effective_radius"] = effective_radius
    elif any(shapes) and not contact.entry.is_power:
        constants |= _of_cylinders({"youngs_modulus": moduli, "poisson_ratio": ratios}, radii, shapes, plane_strain)
    return ContactLaw(
        youngs_modulus=moduli,
        poisson_ratio=ratios,
        yield_strength=strengths,
        radius=radii,
        law=contact.law,
        variant=contact.variant,
        yield_factor=contact.yield_factor,
        beta=contact.beta,
        constants=contact.constants,
        checked=checked,
        **constants,
    )


def _of_cylinders(
    bodies: dict[str, Any], radii: tuple[float, float], shapes: tuple[Shape, Shape], plane_strain: bool
) -> dict[str, Any]:
    """Return the effective radius of a contact in a point, or the law of one along a line."""
    if math.isinf(radii[1]):
        assert shapes[0] is not None
        length = shapes[0].length
        if plane_strain:
            return {"line": LineContact.plane_strain(**bodies, radius=radii, length=length)}
        return {"line": LineContact(**bodies, diameter=2 * radii[0], length=length)}
    pair = cylinder_pair(*shapes)
    if pair.parallel and plane_strain:
        return {"line": LineContact.plane_strain(**bodies, radius=radii, length=pair.length)}
    if pair.parallel:
        return {"line": LineContact(**bodies, diameter=2 / sum(1 / radius for radius in radii), length=pair.length)}
    return {"effective_radius": pair.effective_radius(*radii)}


def error_in_constants(contact: Contact) -> str:
    """Describe why the constants of the elasto-plastic law do not give a passive law; empty if they do."""
    try:
        ContactLaw(
            youngs_modulus=(1.0, 1.0), poisson_ratio=(0.0, 0.0), yield_strength=(1.0, 1.0), radius=(1.0, 1.0),
            yield_factor=contact.yield_factor, constants=contact.constants,
        )  # fmt: skip
    except ValueError as error:
        return str(error)
    return ""


def contact_of(
    materials: Sequence[Material],
    radii: Sequence[float],
    law: str = "elastoplastic",
    variant: str = "continuous",
    constants: Mapping[str, float] | None = None,
    *,
    checked: bool = True,
) -> ContactLaw:
    """Return the law between two spheres of one or two materials and one or two radii (m).

    Parameters
    ----------
    constants
        Constants of the elasto-plastic law that differ from the published ones.
    checked
        True to refuse constants of a law that is not passive.

    Raises
    ------
    InputError
        A material lacks the yield strength that the law needs.
    ValueError
        A constant is unknown, or the law is not passive.
    """
    _require_strength(materials, law)
    given = dict(constants or {})
    unknown = sorted(given.keys() - set(LAW_CONSTANTS))
    if unknown:
        raise ValueError(f"found the constant {unknown[0]}, expected some of {', '.join(LAW_CONSTANTS)}")
    return law_between(
        _contact(law, variant, given), (materials[0], materials[-1]), (radii[0], radii[-1]), checked=checked
    )


def rigid_wall_contact_of(
    material: Material, radius: float, law: str = "elastoplastic", variant: str = "continuous"
) -> ContactLaw:
    """Return the law between a sphere and a rigid plane; raise as `contact_of`."""
    _require_strength([material], law)
    return law_between(_contact(law, variant, {}), (material, None), (radius, math.inf))


def _contact(law: str, variant: str, constants: Mapping[str, float]) -> Contact:
    values: dict[str, Any] = {"law": law, "variant": variant, **constants}
    return Contact(**values)


def _require_strength(materials: Sequence[Material], law: str) -> None:
    for material in materials:
        if LAWS[law].yields and material.yield_strength is None:
            raise InputError(f"material {material.name}: yield_strength: missing; law {law} needs it")
