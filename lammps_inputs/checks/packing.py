"""Checks of the disorder of a packing, and of contact laws, losses and initial dents."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np

from granwave.lammps_inputs.case.bodies import Replace
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import RIGID, Contact
from granwave.lammps_inputs.case.contact.law_parameters import PARAMETERS, laws_with
from granwave.lammps_inputs.case.contact.tables import MARSHALL, PRONY
from granwave.lammps_inputs.case.material import Material, Shape, presets
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.contact.law import cohesive_laws, error_in_parameters, viscous_loss
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import vacant_sites
from granwave.lammps_inputs.packing.places import Places, layout_of
from granwave.lammps_inputs.packing.sites import Sites, chosen_sites, named_spheres, sites_of
from granwave.lammps_inputs.packing.walls import walls

_OVERLAP = 1e-9  # diameters; largest overlap of a larger sphere with another one, for rounding
_WAYS = "index, a box from low to high, or share"


def check_disorder(case: Case, errors: ErrorList) -> None:
    """Check scatter, tilt and replaced spheres of a lattice, as far as possible before the bodies
    are placed.
    """
    packing = case.packing
    replaced = numbered("replace", case.replace)
    if packing.grains is not None:
        return
    scatter = packing.diameter_scatter
    radius = packing.diameter / 2
    errors.check(
        (
            scatter >= radius,
            "packing.diameter_scatter",
            Mismatch(f"{scatter:g}", f"less than the radius, {radius:g} m"),
        ),
    )
    for key, entry in replaced.items():
        _check_replaced(case, entry, key, errors)
    if packing.tilt is None:
        return
    found = (
        f"above packing.diameter, {packing.diameter:g} m, together with packing.tilt; set "
        "packing.diameter to the largest diameter"
    )
    errors.check(
        (
            not packing.rule.is_layer,
            "packing.tilt",
            Mismatch(f'with packing.kind = "{packing.kind}"', '"square", a layer on a floor'),
        ),
        (
            packing.vacancies,
            "packing.vacancies",
            Mismatch(
                "together with packing.tilt", remedy="spheres next to a vacancy would roll into it"
            ),
        ),
        (
            case.precompression,
            "precompression",
            Mismatch(
                "together with packing.tilt, which closes contacts without force: the static "
                "stage has no force along the floor that holds the spheres in their corner",
                remedy="remove one of them",
            ),
        ),
        *(
            (
                (entry.diameter or 0.0) > packing.diameter,
                f"{key}.diameter",
                Mismatch(f"{entry.diameter or 0.0:g} {found}"),
            )
            for key, entry in replaced.items()
        ),
    )
    errors.check(
        (
            case.boundary.periodic,
            "boundary.sides",
            Mismatch(
                '"periodic" together with packing.tilt',
                '"wall" or "free": the tilt requires a corner',
            ),
        ),
    )


def _check_replaced(case: Case, entry: Replace, key: str, errors: ErrorList) -> None:
    scatter = case.packing.diameter_scatter
    ways = {"index": entry.index, "a box": entry.low or entry.high, "share": entry.share}
    found = [name for name, value in ways.items() if value is not None]
    low = entry.low
    high = entry.high
    one_way = len(found) == 1
    errors.check(
        (
            entry.diameter is None and entry.material is None,
            key,
            "has no effect; add a material or a diameter",
        ),
        (
            entry.diameter is not None and scatter >= entry.diameter / 2,
            f"{key}.diameter",
            Mismatch(
                f"{entry.diameter or 0.0:g}",
                f"more than twice packing.diameter_scatter, {scatter:g} m",
            ),
        ),
        (not one_way, key, Mismatch(f"{' and '.join(found) or 'no spheres'}", f"one of {_WAYS}")),
        (
            one_way and (low is None) != (high is None),
            f"{key}.{'low' if low is None else 'high'}",
            "missing; a box requires low and high",
        ),
        (
            one_way and low and high and (np.array(low) > high).any(),
            f"{key}.high",
            Mismatch(f"{list(high or ())}", f"no component below low, {list(low or ())}"),
        ),
    )


def check_vacancies(case: Case, errors: ErrorList) -> None:
    """Check that vacancies do not remove spheres that the case names, and that every
    ``[[replace]]`` entry replaces a sphere.
    """
    packing = case.packing
    key = "packing.vacancies"
    if packing.grains is not None or not (packing.vacancies or case.replace):
        return
    listed = packing.vacancies if isinstance(packing.vacancies, tuple) else ()
    n = packing.n_spheres
    chain = bool(packing.vacancies) and packing.rule.is_chain
    wrong = [sphere for sphere in listed if sphere > n]
    errors.check(
        (chain, key, Mismatch("in a chain, where they would divide it into two chains")),
        *(
            (not chain, key, Mismatch(f"{one}", f"ids from 1 to {n}, the end of the packing"))
            for one in wrong[:1]
        ),
    )
    if errors.items:
        return  # the named spheres are unknown while other keys have errors
    lattice = packing.lattice(periodic=case.boundary.periodic)
    present = np.ones(n, dtype=bool)
    if packing.vacancies:
        named = named_spheres(case, lattice)
        clash = [sphere for sphere in listed if sphere in named]
        fits = errors.check_first(
            *(
                (
                    True,
                    key,
                    Mismatch(f"{one}, which {named[one]} needs", "a sphere that no other key uses"),
                )
                for one in clash
            ),
            (len(listed) == n, key, Mismatch(f"all {n} spheres", "fewer, so that spheres remain")),
        )
        if not fits:
            return
        try:
            present[vacant_sites(packing, n, named)] = False
        except ValueError as error:
            errors.add(
                key,
                Mismatch(
                    f"{packing.vacancies:g} of {n} spheres, which {error}",
                    remedy="use a smaller fraction",
                ),
            )
            return
    low, high = (
        "[" + ", ".join(f"{value:g}" for value in corner) + "]" for corner in lattice.bounds()
    )
    for place, entry in enumerate(case.replace, start=1):
        if not present[chosen_sites(packing, lattice, entry, place, present)].any():
            box = f"the box from {list(entry.low or ())} to {list(entry.high or ())}"
            fault = Mismatch(f"no sphere in {box}", remedy=f"centres lie from {low} to {high}")
            if entry.share is not None:
                n_there = np.count_nonzero(present)
                share = (
                    f"a fraction of {entry.share:g} of {n_there} spheres, which selects no sphere"
                )
                fault = Mismatch(share)
            errors.add(f"replace.{place}", fault)


def check_room(case: Case, errors: ErrorList) -> None:
    """Check that spheres larger than the lattice spacing overlap neither other spheres nor
    walls.
    """
    if case.packing.rule.is_chain or not any(
        (entry.diameter or 0) > case.packing.diameter for entry in case.replace
    ):
        return
    sites = sites_of(case, layout_of(case.packing, case.boundary))
    pairs, gaps = sites.near_larger()
    slack = -_OVERLAP * case.packing.diameter
    if gaps.min(initial=0.0) < slack:
        one, other = pairs[gaps.argmin()].tolist()
        large = one if sites.larger[one - 1] else other
        more = np.count_nonzero(gaps < slack) - 1
        image = "its own image" if one == other else f"sphere {one + other - large}"
        errors.add(
            _entry_of(case, sites, large),
            f"sphere {large} of {sites.diameter[large - 1]:g} m overlaps {image} by "
            f"{-gaps.min():.3g} m{f' (and {more} more)' if more else ''}; make it smaller, or "
            "remove the spheres around it (packing.vacancies)",
        )
    _check_walls(case, sites, errors)


def _check_walls(case: Case, sites: Sites, errors: ErrorList) -> None:
    """Check that larger spheres do not overlap the planes, which touch nominal spheres."""
    lattice = sites.lattice
    boundary = case.boundary
    low, high = lattice.bounds() + np.array([[-1.0], [1.0]]) * lattice.diameter / 2
    planes = [("bottom", 2, high[2], 1)] if boundary.bottom_rule.has_plane else []
    planes += [("plate", 2, low[2], -1)] if case.load.plate is not None else []
    if boundary.sides_rule.has_planes:
        low[:2] -= max(boundary.gap, 0.0)
        high[:2] += max(boundary.gap, 0.0)
        for axis, letter in enumerate("xy"):
            planes.append((f"{letter}lo", axis, low[axis], -1))
            planes.append((f"{letter}hi", axis, high[axis], 1))
    large = np.flatnonzero(sites.larger & sites.present)
    centres = sites.positions(1, lattice.n_spheres)[large]
    for name, axis, plane, sign in planes:
        beyond = sign * (centres[:, axis] - plane) + sites.diameter[large] / 2
        if beyond.max(initial=0.0) > _OVERLAP * lattice.diameter:
            sphere = int(large[beyond.argmax()]) + 1
            errors.add(
                _entry_of(case, sites, sphere),
                f"sphere {sphere} of {sites.diameter[sphere - 1]:g} m overlaps the wall {name} by "
                f"{beyond.max():.3g} m; make it smaller, or remove the wall (boundary)",
            )


def _entry_of(case: Case, sites: Sites, sphere: int) -> str:
    """Return the key of the ``[[replace]]`` entry that sets the diameter of a sphere."""
    for place, entry in reversed(list(enumerate(case.replace, start=1))):
        if sphere - 1 in chosen_sites(case.packing, sites.lattice, entry, place, sites.present):
            return f"replace.{place}.diameter"
    return "replace"


def check_pairs(case: Case, errors: ErrorList) -> None:
    """Check the laws of the ``[[pair]]`` tables, and that they name materials of the case."""
    for key, pair in numbered("pair", case.pair).items():
        _check_law(pair.contact, key, errors)
    bodies = [*case.replace, *case.striker, *case.wall, case.bar, case.incident_bar]
    materials = [
        case.material,
        *(body.material for body in bodies if body is not None),
        *case.materials,
    ]
    materials += [case.boundary.bottom_material, case.boundary.sides_material]
    known = dict.fromkeys([*(one.name for one in materials if one is not None and one.name), RIGID])
    for key, pair in numbered("pair", case.pair).items():
        there = f"{', '.join(map(show, known))} (a rigid wall)"
        errors.check(
            *(
                (
                    name not in known,
                    f"{key}.materials",
                    Mismatch(show(name), f"materials of the case: {there}"),
                )
                for name in dict.fromkeys(pair.materials)
            ),
        )


def check_contact(case: Case, errors: ErrorList) -> None:
    """Check ``[contact]``, and yield strengths where a law yields; walls and bars without a yield
    strength are elastic.
    """
    _check_law(case.contact, "contact", errors)
    for key, body in (
        numbered("replace", case.replace) | numbered("striker", case.striker)
    ).items():
        _check_yield(case, body.material, f"{key}.material", errors)
    _check_yield(case, case.material, "material", errors)
    of_file = case.packing.grains.material if case.packing.grains is not None else ()
    for name in sorted(
        {*presets(), *(str(one.name) for one in case.materials)}.intersection(of_file)
    ):
        _check_yield(case, case.named_material(name), f"packing.file: material {name}", errors)


def _check_yield(case: Case, material: Material | None, key: str, errors: ErrorList) -> None:
    """Check that a material has a yield strength if its contacts yield."""
    if material is None or material.yield_strength is not None:
        return
    law = case.contact_between(material, material)
    name = material.name
    give = "set a number (Pa)"
    if name in presets():
        give = f'{name} has none; write material = {{preset = "{name}", yield_strength = (Pa)}}'
    errors.check((law.yields, f"{key}.yield_strength",
                  f'missing; the {law.law} law requires it: {give}, or set contact.law = "hertz"'))  # fmt: skip


def _check_law(contact: Contact, key: str, errors: ErrorList) -> None:
    """Check that a law has exactly the constants that it requires, and supports cohesion and
    resistance to twisting where set.
    """
    kind = contact.cohesion.kind if contact.cohesion is not None and contact.coheres else ""
    found = f'"{kind}" with law = "{contact.law}"'
    errors.check(
        (
            contact.twisting == MARSHALL and not contact.friction,
            f"{key}.twisting",
            Mismatch(
                f'"{MARSHALL}" with friction = 0', "friction above 0, from which its torque follows"
            ),
        ),
        (
            kind and contact.entry.is_power,
            f"{key}.cohesion",
            Mismatch(f"{found}, which has no contact circle", "a law of two materials"),
        ),
        (
            kind == "jkr" and contact.yields,
            f"{key}.cohesion",
            Mismatch(
                f'{found}; "jkr" is a law of elastic spheres', 'law = "hertz", or kind = "dmt"'
            ),
        ),
    )
    _check_parameters(contact, key, errors)


def _check_parameters(contact: Contact, key: str, errors: ErrorList) -> None:
    """Check that a law has the parameters that it requires and no parameters of other laws, and
    that it is passive.
    """
    before = len(errors.items)
    required = [p.name for p in contact.entry.parameters.values() if p.required]
    for name in required:
        expected = f'missing; law = "{contact.law}" requires {" and ".join(required)}'
        errors.check((name not in contact.parameters, f"{key}.{name}", expected))
    for name, value in contact.foreign.items():
        laws = " or ".join(f'law = "{law}"' for law in laws_with(PARAMETERS[name]))
        found = f'{value:g} with law = "{contact.law}"'
        errors.add(f"{key}.{name}", Mismatch(found, remedy=f"it applies only to {laws}"))
    if len(errors.items) > before or not (fault := error_in_parameters(contact)):
        return
    names = list(contact.constants)
    if len(names) == 1:
        errors.add(f"{key}.{names[0]}", fault)
    else:
        errors.add(key, f"{', '.join(names)}: {fault}")


# overlap by cohesion / radius of a sphere, up to which contacts are small
_MOST_SUNKEN = 0.05


def check_cohesion(assembly: Assembly, errors: ErrorList) -> None:
    """Check that a packing that coheres begins at rest, and that necks are within reach."""
    case = assembly.case
    boundary = assembly.case.boundary
    packing = assembly.case.packing
    if not case.has_cohesion:
        return
    keys = [
        f"{key}.cohesion"
        for key, pair in numbered("pair", case.pair).items()
        if pair.contact.coheres
    ]
    key = "contact.cohesion" if case.contact.coheres else keys[0]
    unlike = [name for name, there in (
        ("packing.diameter_scatter", packing.diameter_scatter), ("replace", case.replace),
        ("packing.tilt", packing.tilt),
        ("bar", case.bar), ("incident_bar", case.incident_bar), ("precompression", case.precompression),
        ("contact.initial_overlap", case.contact.initial_overlap), ("boundary.sides.tube", boundary.sides_tube),
        ("cylinders", assembly.has_cylinders),
    ) if there]  # fmt: skip
    rest = (
        "the run starts at rest without contact forces, a state that is computed only for "
        "equal spheres"
    )
    errors.check(
        *((True, key, Mismatch(f"with {name}", f"a packing without it: {rest}")) for name in unlike)
    )
    if isinstance(assembly.lattice, Places) and assembly.lattice.n_contacts:
        contacts = f"{counted(assembly.lattice.n_contacts, 'contact')} between its grains"
        found = f'with packing.kind = "file" and {contacts}'
        errors.add(key, Mismatch(found, f"grains that do not touch: {rest} on a lattice"))
    gap = boundary.forget_gap * packing.diameter
    radius = packing.diameter / 2
    laws = [] if unlike else [law for law, _ in cohesive_laws(assembly)]
    neck = max((law.neck_length for law in laws), default=0.0)
    sunken = max((law.balanced_overlap for law in laws), default=0.0)
    errors.check(
        (
            assembly.has_rate,
            key,
            Mismatch("with material.rate_sensitivity", "a yield strength without a rate"),
        ),
        (
            neck >= gap,
            "boundary.forget_gap",
            Mismatch(
                f"{boundary.forget_gap:g}, a gap of {gap:.3g} m",
                f"more than {neck:.3g} m, up to which {key} holds surfaces together",
            ),
        ),
        (
            sunken > _MOST_SUNKEN * radius,
            key,
            f"the work of adhesion presses spheres of radius {radius:g} m into each other by {sunken:.3g} m; expected "
            f"less, for overlaps of at most {_MOST_SUNKEN:g} of the radius",
        ),
    )


def check_losses(assembly: Assembly, errors: ErrorList) -> None:
    """Check that a relaxation time gives the specified restitution for each pair of materials, and
    that contacts with tangential damping have friction.
    """
    case = assembly.case
    if not case.has_loss:
        return
    _check_damping(case, errors)
    _check_series(case, errors)
    wrong: dict[str, Mismatch] = {}
    for first, second, shapes in _material_pairs(assembly):
        contact = case.contact_between(first, second)
        own = [
            f"{key}.loss"
            for key, pair in numbered("pair", case.pair).items()
            if pair.contact is contact
        ]
        try:
            viscous_loss(assembly, contact, first, second, flat=shapes is None, shapes=shapes)
        except ValueError as error:
            names = " and ".join(RIGID if one is None else str(one.name) for one in (first, second))
            loss = dataclasses.asdict(contact.loss) if contact.loss else {}
            found = show({name: value for name, value in loss.items() if value is not None})
            wrong.setdefault(
                [*own, "contact.loss"][0],
                Mismatch(found, f"for {names} a restitution of {error}"),
            )
    errors.check(*((True, key, message) for key, message in wrong.items()))


def _check_damping(case: Case, errors: ErrorList) -> None:
    """Check that there is friction where contacts are damped along their surfaces."""
    ratios = [one.loss.tangential or 0.0 for one in case.contact_laws if one.loss is not None]
    largest = max(ratios)
    slides = case.boundary.friction or any(one.friction for one in case.contact_laws)
    without_friction = Mismatch(
        f"{largest:g} with friction = 0",
        "friction above 0, which limits the tangential force",
        "set contact.friction",
    )
    errors.check((largest and not slides, "contact.loss.tangential", without_friction))


def _check_series(case: Case, errors: ErrorList) -> None:
    """Check that contacts with a relaxing modulus have an elastic law, and no static stage."""
    keys = {"contact": case.contact}
    keys |= {key: pair.contact for key, pair in numbered("pair", case.pair).items()}
    for key, contact in keys.items():
        if contact.loss is None or not contact.loss.branches:
            continue
        series = f'with {key}.loss.kind = "{PRONY}"'
        yields = Mismatch(f'"{contact.law}" {series}', 'a law that does not yield, such as "hertz"')
        coheres = Mismatch(f"{key}.cohesion {series}", "no cohesion, or another loss")
        errors.check(
            (contact.yields, f"{key}.law", yields), (contact.coheres, f"{key}.cohesion", coheres)
        )
    damped = Mismatch(
        f'"damped" with contact.loss.kind = "{PRONY}", since contacts would relax during the '
        "damped run",
        "another way to balance the packing, or another loss",
    )
    errors.check((case.is_viscoelastic and case.settles_damped, "packing.relaxation", damped))


def check_rates(assembly: Assembly, errors: ErrorList) -> None:
    """Check that laws of yielding contacts know materials whose yield strength depends on the
    strain rate.
    """
    case = assembly.case
    for first, second, _ in _material_pairs(assembly):
        contact = case.contact_between(first, second)
        known = contact.takes("rate_sensitivity") and contact.variant == "continuous"
        if (
            contact.yields
            and not known
            and any(one is not None and one.rate_sensitivity for one in (first, second))
        ):
            law = f"{contact.law}, {contact.variant}" if contact.takes("variant") else contact.law
            names = ", ".join(laws_with(PARAMETERS["rate_sensitivity"]))
            errors.add(
                "material.rate_sensitivity",
                Mismatch(f"with law {law}", f"one of {names} (continuous), or none"),
            )
            return


def _material_pairs(
    assembly: Assembly,
) -> Iterable[tuple[Material, Material | None, tuple[Shape, Shape] | None]]:
    """Iterate over the materials that may touch, and the shapes of two grains; None: contact with a
    plane.
    """
    grains = [species for species in assembly.species if species.role == "sphere"]
    for n, one in enumerate(grains):
        yield from (
            (one.material, other.material, (one.shape, other.shape)) for other in grains[n:]
        )
        yield from (
            (one.material, face.material, None) for face in assembly.species if face.role == "face"
        )
    for wall in walls(assembly):
        fixes = wall.fixes
        yield from ((material, wall.material, None) for _, _, material in fixes)
