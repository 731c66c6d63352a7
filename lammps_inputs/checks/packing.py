"""Checks of the disorder of a packing, and of contact laws, losses and initial dents."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.bodies import Replace
from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact import RIGID, Contact, Pair
from granwave.lammps_inputs.case.material import Material, Shape
from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.contact.initial_dents import KEY, error_in_dents
from granwave.lammps_inputs.contact.law import error_in_constants, viscous_loss
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly, lattice_of
from granwave.lammps_inputs.packing.sites import Sites, chosen_sites, named_spheres, sites_of, vacant_sites
from granwave.lammps_inputs.packing.walls import wall_fixes, walls

_OVERLAP = 1e-9  # diameters; largest overlap of a larger sphere with another one, for rounding
_WAYS = "index, a box from low to high, or share"


def check_disorder(parts: Mapping[str, Any], errors: ErrorList) -> None:
    """Check the disorder as far as possible before the bodies are placed; missing or wrong parts are None."""
    packing: PackingSection = parts["packing"]
    boundary: Boundary | None = parts.get("boundary")
    periodic = boundary is not None and boundary.sides == "periodic"
    lattice = packing.lattice(periodic=periodic)
    scatter, radius = packing.diameter_scatter, packing.diameter / 2
    if scatter >= radius:
        errors.add("packing.diameter_scatter", f"found {scatter:g}, expected less than the radius, {radius:g} m")
    if packing.tilt is not None:
        _check_tilt(packing, parts, periodic, errors)
    for place, entry in enumerate(parts.get("replace", ()), start=1):
        _check_replaced(entry, f"replace.{place}", packing, lattice, errors)
    if packing.vacancies:
        _check_vacancies(parts, packing, lattice, errors)
    elif parts.get("replace") and not errors.lines:
        _check_something_is_chosen(parts, packing, lattice, np.ones(lattice.n_spheres, dtype=bool), errors)


def check_room(case: Case, errors: ErrorList) -> None:
    """Check that spheres larger than the lattice spacing overlap neither other spheres nor walls."""
    if case.packing.kind == "chain" or not any((entry.diameter or 0) > case.packing.diameter for entry in case.replace):
        return
    lattice = lattice_of(case)
    sites = sites_of(case, lattice)
    if sites is None:
        return
    pairs, gaps = sites.near_larger()
    slack = -_OVERLAP * case.packing.diameter
    if gaps.min(initial=0.0) < slack:
        one, other = pairs[gaps.argmin()].tolist()
        large = one if sites.larger[one - 1] else other
        more = np.count_nonzero(gaps < slack) - 1
        image = "its own image" if one == other else f"sphere {one + other - large}"
        errors.add(
            _entry_of(case, sites, large),
            f"sphere {large} of {sites.diameter[large - 1]:g} m overlaps {image} by {-gaps.min():.3g} m"
            f"{f' (and {more} more)' if more else ''}; make it smaller, or leave out the spheres around it "
            "(packing.vacancies)",
        )
    _check_walls(case, sites, errors)


def _check_tilt(packing: PackingSection, parts: Mapping[str, Any], periodic: bool, errors: ErrorList) -> None:
    """Check that every sphere of a packing on a tilted floor finds two to lean on."""
    errors.check(
        (packing.kind != "square", "packing.tilt",
         f'found with packing.kind = "{packing.kind}", expected "square", a layer on a floor'),
        (packing.vacancies, "packing.vacancies",
         "found beside packing.tilt; spheres beside a vacancy would roll into it"),
        (parts.get("precompression"), "precompression",
         "found beside packing.tilt, which closes contacts without force: the static stage has no weight along the "
         "floor that would hold the spheres in their corner; take one of them out"),
        (periodic, "boundary.sides",
         'found "periodic" beside packing.tilt, expected "wall" or "free": it needs a corner'),
    )  # fmt: skip
    for place, entry in enumerate(parts.get("replace", ()), start=1):
        if (entry.diameter or 0.0) > packing.diameter:
            found = f"found {entry.diameter:g} above packing.diameter, {packing.diameter:g} m, beside packing.tilt"
            errors.add(f"replace.{place}.diameter", f"{found}; make that the largest diameter")


def _check_replaced(entry: Replace, key: str, packing: PackingSection, lattice: Lattice, errors: ErrorList) -> None:
    n, least = lattice.n_spheres, packing.diameter_scatter
    ways = {"index": entry.index, "a box": entry.low or entry.high, "share": entry.share}
    found = [name for name, value in ways.items() if value is not None]
    beyond = [sphere for sphere in entry.index or () if sphere > n]
    errors.check(
        (entry.diameter is None and entry.material is None, key, "changes nothing; give a material, or a diameter"),
        (entry.diameter is not None and least >= entry.diameter / 2, f"{key}.diameter",
         f"found {entry.diameter or 0.0:g}, expected more than twice packing.diameter_scatter, {least:g} m"),
        (len(found) != 1, key, f"found {' and '.join(found) or 'no spheres'}, expected one of {_WAYS}"),
    )  # fmt: skip
    if len(found) != 1:
        return
    errors.check(*((True, f"{key}.index", f"found {one}, expected an id from 1 to {n}, the end of the packing")
                   for one in beyond[:1]))  # fmt: skip
    if (entry.low is None) != (entry.high is None):
        errors.add(f"{key}.{'low' if entry.low is None else 'high'}", "missing; a box has both corners")
    elif entry.low and entry.high and any(low > high for low, high in zip(entry.low, entry.high, strict=True)):
        errors.add(f"{key}.high", f"found {list(entry.high)}, expected none of it below low, {list(entry.low)}")


def _check_vacancies(parts: Mapping[str, Any], packing: PackingSection, lattice: Lattice, errors: ErrorList) -> None:
    key, n = "packing.vacancies", lattice.n_spheres
    if packing.kind == "chain":
        errors.add(key, "found in a chain, which has none: it would be two chains")
        return
    wrong = [sphere for sphere in packing.vacancies if sphere > n] if isinstance(packing.vacancies, tuple) else []
    if wrong:
        errors.add(key, f"found {wrong[0]}, expected ids from 1 to {n}, the end of the packing")
    if errors.lines:
        return  # the named spheres are unknown while other keys are wrong
    named = named_spheres(lattice, *(parts[name] for name in ("load", "replace", "striker", "sensor", "output")))
    if isinstance(packing.vacancies, tuple):
        clash = [sphere for sphere in packing.vacancies if sphere in named]
        if clash:
            errors.add(key, f"found {clash[0]}, which {named[clash[0]]} needs; expected a sphere that nothing names")
        elif len(packing.vacancies) == n:
            errors.add(key, f"found all {n} spheres, expected fewer: it leaves no sphere")
    if errors.lines:
        return
    try:
        vacant = vacant_sites(packing, n, set(named))
    except ValueError as error:
        errors.add(key, f"found {packing.vacancies:g} of {n} spheres, which {error}; make the share smaller")
        return
    present = np.ones(n, dtype=bool)
    present[vacant] = False
    _check_something_is_chosen(parts, packing, lattice, present, errors)


def _check_something_is_chosen(
    parts: Mapping[str, Any], packing: PackingSection, lattice: Lattice, present: np.ndarray, errors: ErrorList
) -> None:
    """Check that every ``[[replace]]`` entry replaces a sphere."""
    for place, entry in enumerate(parts.get("replace", ()), start=1):
        chosen = chosen_sites(packing, lattice, entry, place, present)
        if not present[chosen].any():
            low, high = lattice.bounds()
            errors.add(
                f"replace.{place}",
                f"found a share of {entry.share:g} of {np.count_nonzero(present)} spheres, which is none"
                if entry.share is not None
                else f"found no sphere in the box from {list(entry.low or ())} to {list(entry.high or ())}; "
                f"centres lie from {_point(low)} to {_point(high)}",
            )


def _check_walls(case: Case, sites: Sites, errors: ErrorList) -> None:
    """Check that larger spheres do not overlap the planes, which touch nominal spheres."""
    lattice, boundary = sites.lattice, case.boundary
    low, high = lattice.bounds() + np.array([[-1.0], [1.0]]) * lattice.diameter / 2
    planes = [("bottom", 2, high[2], 1)] if boundary.bottom == "wall" else []
    planes += [("plate", 2, low[2], -1)] if case.load.plate is not None else []
    if boundary.sides == "wall":
        low[:2] -= max(boundary.gap, 0.0)
        high[:2] += max(boundary.gap, 0.0)
        planes += [(f"{letter}{end}", axis, plane[axis], sign) for axis, letter in enumerate("xy")
                   for end, plane, sign in (("lo", low, -1), ("hi", high, 1))]  # fmt: skip
    large = np.flatnonzero(sites.larger & sites.present)
    centres = sites.positions(1, lattice.n_spheres)[large]
    for name, axis, plane, sign in planes:
        beyond = sign * (centres[:, axis] - plane) + sites.diameter[large] / 2
        if beyond.max(initial=0.0) > _OVERLAP * lattice.diameter:
            sphere = int(large[beyond.argmax()]) + 1
            errors.add(
                _entry_of(case, sites, sphere),
                f"sphere {sphere} of {sites.diameter[sphere - 1]:g} m overlaps the wall {name} by "
                f"{beyond.max():.3g} m; make it smaller, or take the wall away (boundary)",
            )


def _entry_of(case: Case, sites: Sites, sphere: int) -> str:
    """Return the key of the ``[[replace]]`` entry that sets the diameter of a sphere."""
    for place, entry in reversed(list(enumerate(case.replace, start=1))):
        if sphere - 1 in chosen_sites(case.packing, sites.lattice, entry, place, sites.present):
            return f"replace.{place}.diameter"
    return "replace"


def _point(values: np.ndarray) -> str:
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"


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
            loss = dataclasses.asdict(contact.loss) if contact.loss else {}
            found = show({name: value for name, value in loss.items() if value is not None})
            wrong.setdefault(key, f"found {found}, expected of {names} a restitution of {error}")
    for key, message in wrong.items():
        errors.add(key, message)


def _check_power(contact: Contact, key: str, errors: ErrorList) -> None:
    """Check that law power has its constant and exponent, and no other law has them."""
    for name in ("constant", "exponent"):
        value, takes = getattr(contact, name), contact.takes(name)
        errors.check(
            (value is None and takes, f"{key}.{name}",
             f'missing; law = "{contact.law}" is F = constant overlap^exponent'),
            (value is not None and not takes, f"{key}.{name}",
             f'found {value or 0.0:g} with law = "{contact.law}"; it belongs to law = "power"'),
        )  # fmt: skip


def _check_constants(contact: Contact, key: str, errors: ErrorList) -> None:
    if not contact.constants:
        return
    names = list(contact.constants)
    if not contact.takes("constants") or contact.variant != "continuous":
        found = f"found {contact.law}, {contact.variant}"
        errors.check(*((True, f"{key}.{name}", f"belongs to law elastoplastic, variant continuous; {found}")
                       for name in names))  # fmt: skip
    elif (fault := error_in_constants(contact)) and len(names) == 1:
        errors.add(f"{key}.{names[0]}", f"no passive law: {fault}")
    elif fault:
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
        there = f"{', '.join(map(show, known))} (a rigid wall)"
        errors.check(
            *((name not in known, f"pair.{n}.materials", f"found {show(name)}, expected materials of the case: {there}")
              for name in dict.fromkeys(pair.materials)),
        )  # fmt: skip


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
