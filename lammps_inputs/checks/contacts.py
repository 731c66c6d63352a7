"""Checks of contact laws against materials, and of initial dents against contact laws."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.contact import RIGID, Contact, Pair
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.case.shape import Shape
from granwave.lammps_inputs.contact.initial_dents import KEY, error_in_dents
from granwave.lammps_inputs.contact.law import error_in_constants, viscous_loss
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import wall_fixes, walls


def check_contacts(parts: Mapping[str, Any], errors: ErrorList) -> None:
    """Check the contact laws; parts that are None (missing or wrong) are skipped."""
    contact: Contact | None = parts.get("contact")
    if contact is not None:
        _check_constants(contact, "contact", errors)
        _check_power(contact, "contact", errors)
    pairs: tuple[Pair, ...] = parts.get("pair", ())
    for n, pair in enumerate(pairs, start=1):
        _check_constants(pair.contact, f"pair.{n}", errors)
        _check_power(pair.contact, f"pair.{n}", errors)
    if parts.get("material") is not None:
        _check_names(parts, pairs, errors)
    if contact is not None:
        _check_yields(parts, contact, pairs, errors)


def check_dents(assembly: Assembly, errors: ErrorList) -> None:
    """Check initial dents that are given by value."""
    if fault := error_in_dents(assembly):
        errors.add(KEY, fault)


def check_losses(assembly: Assembly, errors: ErrorList) -> None:
    """Check that some loss time gives the restitution that is asked for, of each pair of materials."""
    case = assembly.case
    if not case.has_loss:
        return
    grains = [species for species in assembly.species if species.role == "sphere"]
    faces = [species for species in assembly.species if species.role == "face"]
    pairs: list[tuple[Material, Material | None, tuple[Shape, Shape] | None]]
    pairs = [(one.material, other.material, (one.shape, other.shape))
             for n, one in enumerate(grains) for other in grains[n:]]  # fmt: skip
    pairs += [(one.material, face.material, None) for one in grains for face in faces]
    for wall in walls(assembly):
        fixes = [] if wall.held_layer else wall_fixes(assembly, wall)
        pairs += [(material, wall.material, None) for _, _, material in fixes]
    wrong: dict[str, str] = {}
    for first, second, shapes in pairs:
        contact = case.contact_between(first, second)
        own = next((n for n, pair in enumerate(case.pair, start=1) if pair.contact is contact), None)
        key = "contact.loss" if own is None else f"pair.{own}.loss"
        try:
            viscous_loss(assembly, contact, first, second, flat=shapes is None, shapes=shapes)
        except ValueError as error:
            names = " and ".join(RIGID if one is None else str(one.name) for one in (first, second))
            found = show(_plain_loss(contact))
            wrong.setdefault(key, f"found {found}, expected of {names} a restitution of {error}")
    for key, message in wrong.items():
        errors.add(key, message)


def _plain_loss(contact: Contact) -> dict[str, Any]:
    assert contact.loss is not None
    return {name: value for name, value in dataclasses.asdict(contact.loss).items() if value is not None}


def _check_power(contact: Contact, key: str, errors: ErrorList) -> None:
    """Check that law power has its constant and exponent, and no other law has them."""
    for name in ("constant", "exponent"):
        value = getattr(contact, name)
        if value is None and contact.takes(name):
            errors.add(f"{key}.{name}", f'missing; law = "{contact.law}" is F = constant overlap^exponent')
        elif value is not None and not contact.takes(name):
            errors.add(f"{key}.{name}", f'found {value:g} with law = "{contact.law}"; it belongs to law = "power"')


def _check_constants(contact: Contact, key: str, errors: ErrorList) -> None:
    if not contact.constants:
        return
    if not contact.takes("constants") or contact.variant != "continuous":
        for name in contact.constants:
            errors.add(
                f"{key}.{name}",
                f"belongs to law elastoplastic, variant continuous; found {contact.law}, {contact.variant}",
            )
        return
    if fault := error_in_constants(contact):
        names = list(contact.constants)
        if len(names) == 1:
            errors.add(f"{key}.{names[0]}", f"no passive law: {fault}")
        else:
            errors.add(key, f"{', '.join(names)}: no passive law: {fault}")


def _check_names(parts: Mapping[str, Any], pairs: tuple[Pair, ...], errors: ErrorList) -> None:
    """Check that every ``[[pair]]`` names materials of the case."""
    boundary: Boundary | None = parts.get("boundary")
    bodies = [*parts.get("replace", ()), *parts.get("striker", ()), parts.get("bar"), parts.get("incident_bar")]
    materials: list[Material | None] = [parts["material"], *(body.material for body in bodies if body is not None)]
    materials += parts.get("materials", ())
    if boundary is not None:
        materials += [boundary.bottom_material, boundary.sides_material]
    known = dict.fromkeys([*(material.name or "" for material in materials if material is not None), RIGID])
    known.pop("", None)
    for n, pair in enumerate(pairs, start=1):
        for name in dict.fromkeys(pair.materials):
            if name not in known:
                errors.add(
                    f"pair.{n}.materials",
                    f"found {show(name)}, expected materials of the case: {', '.join(map(show, known))} (a rigid wall)",
                )


def _check_yields(parts: Mapping[str, Any], contact: Contact, pairs: tuple[Pair, ...], errors: ErrorList) -> None:
    """Check that spheres whose law yields have a yield strength; walls and bars without one are elastic."""
    materials: dict[str, Material | None] = {"material": parts.get("material")}
    for name in ("replace", "striker"):
        materials |= {f"{name}.{n}.material": body.material for n, body in enumerate(parts.get(name, ()), start=1)}
    for key, material in materials.items():
        if material is None or material.yield_strength is not None:
            continue
        own = next((pair.contact for pair in pairs if pair.fits(material.name, material.name)), contact)
        if own.yields:
            errors.add(
                f"{key}.yield_strength",
                f'missing; the {own.law} law needs it: give a number in Pa, or set contact.law = "hertz"',
            )
