"""Checks of precompression and of a moving bottom against the rest of a case."""

from __future__ import annotations

import math
from itertools import combinations_with_replacement

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.precompression import PRECOMPRESSION, Precompression
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.contact.law import flat_contact, pair_contact, sphere_contact
from granwave.lammps_inputs.contact.static_load import force_of_contact, grains_at_wall
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import materials_at, walls

# component of an axis along a wall's normal, above which a cylinder stands on its end
_UPRIGHT = 0.5
_INCLINED = 2.0  # displacement of a wall / overlap of a contact inclined by 60 degrees to it


def check_precompression(case: Case, errors: ErrorList) -> None:
    """Check the values of a precompression, and that the boundary can support it."""
    stage = case.precompression
    packing = case.packing
    boundary = case.boundary
    if stage is None:
        return
    for name, bar in (("bar", case.bar), ("incident_bar", case.incident_bar)):
        if bar is not None:
            errors.add(
                PRECOMPRESSION,
                Mismatch(
                    f"together with [{name}], whose far end has no support",
                    remedy="remove one of them",
                ),
            )
            return
    rule = stage.rule
    rule.check_keys(stage, packing, errors)
    errors.check(
        (
            stage.strikers and not case.striker,
            f"{PRECOMPRESSION}.strikers",
            Mismatch("true without [[striker]]", remedy="add a striker, or remove this key"),
        ),
    )
    lattice = packing.grains is None
    key = "kind" if rule.from_overlaps else "overlaps"
    errors.check(
        (
            stage.takes_overlaps and lattice,
            f"{PRECOMPRESSION}.{key}",
            Mismatch(
                f"with packing.kind = {show(packing.kind)}",
                "grains at user-defined positions (a file, or [[grains]]): spheres of a lattice "
                "just touch",
            ),
        ),
    )
    if stage.moves_walls:
        if boundary.gap >= 0:  # otherwise `check_side_gap` has reported it
            _check_moves(case, stage, errors)
        return
    rule.check_bounds(packing, boundary, errors)


def check_first_yield(assembly: Assembly, errors: ErrorList) -> None:
    """Reject a static load that yields every contact, exceeds the range of the law, or spreads the
    layers.
    """
    case = assembly.case
    stage = case.precompression
    contact = case.contact_between(case.material, case.material)
    if stage is None:
        return
    if stage.moves:
        _check_yield_by_walls(assembly, stage, errors)
    if stage.moves_walls or isinstance(assembly.lattice, Places):
        if (
            case.packing.cell is None or case.bears_along_z
        ):  # otherwise it is a load on an infinite packing, for bands
            _check_top(assembly, stage, errors)
        _check_presses(assembly, stage, errors)
        return
    name, unit = stage.rule.size_of(stage)
    law = sphere_contact(case)
    largest = force_of_contact(assembly)
    layers = assembly.lattice.shape[2] if stage.rule.grows_with_depth else 1
    least = largest / layers  # forces of contacts of the top layer
    deepest = _force_at_largest_overlap(law)
    # contacts with initial dents stay elastic beyond first yield
    elastic_range = contact.yields and law.elastic_limit > 0 and not case.contact.initial_overlap
    if elastic_range and least >= law.yield_force:
        most = getattr(stage, name) * law.yield_force / least
        most_loaded = f" at the top and {largest:.3g} N at the bottom" if least < largest else ""
        fault = (
            f"found {getattr(stage, name):g} {unit}, about {least:.3g} N on each "
            f"contact{most_loaded}, where all yield at {law.yield_force:.3g} N"
        )
        errors.add(f"{PRECOMPRESSION}.{name}", f"{fault}; use less than {most:.3g} {unit}")
    elif largest > deepest:
        most = getattr(stage, name) * deepest / largest
        fault = (
            f"would press contacts with {largest:.3g} N, but the law is valid only up to "
            f"{deepest:.3g} N ({LARGEST} R*)"
        )
        errors.add(f"{PRECOMPRESSION}.{name}", f"{fault}; use less than {most:.3g} {unit}")
    elif _spreads(case, stage, assembly.lattice.shape):
        errors.add(
            "boundary.sides",
            Mismatch(
                f"{show(case.boundary.sides)} under a {stage.kind} precompression of "
                f"{case.packing.kind}, which spreads without friction, even between walls",
                f"{_confined(case)}",
            ),
        )


def _confined(case: Case) -> str:
    """Return the values of keys with which a packing that spreads is confined."""
    if case.packing.rule.is_plane_crystal:
        return '"periodic"'
    free = "" if case.boundary.sides_rule.is_free else ' with boundary.sides = "free"'
    return f'"periodic", or precompression.kind = "uniform"{free}'


def _force_at_largest_overlap(law: ContactLaw) -> float:
    """Return the force at the largest overlap at which contact laws hold, N."""
    return float(law.loading_force(np.array([LARGEST * law.effective_radius]))[0])


def check_plates(assembly: Assembly, errors: ErrorList) -> None:
    """Check that spheres on a moving bottom, or under a plate, are of one material, which has a
    separate fix.
    """
    case = assembly.case
    layers = []
    if (support := case.boundary.bottom_support) is not None:
        below = materials_at(assembly, assembly.lattice.last_layer)
        layers.append(("boundary.bottom", f"found a {support.kind} under", below, "last"))
    if case.load.plate is not None:
        layers.append(
            (
                "load.kind",
                'found "plate" on',
                materials_at(assembly, assembly.lattice.top_layer),
                "top",
            )
        )
    for key, found, materials, layer in layers:
        names = " and ".join(material.name or "?" for material in materials) or "no material"
        errors.check((len(materials) != 1, key,
                      f"{found} spheres of {names}, expected a {layer} layer of one material"))  # fmt: skip


def _spreads(case: Case, stage: Precompression, shape: tuple[int, int, int]) -> bool:
    """Return True if the load would push the spheres of a layer apart: no friction, pressure or
    period holds them.
    """
    nx, ny, nz = shape
    packing = case.packing
    boundary = case.boundary
    if packing.rule.is_plane_crystal and boundary.has_planes("x") and packing.top_row != "equal":
        return False  # the tube fills the space between straight walls
    held = stage.rule.holds_layers or boundary.periodic or boundary.bottom_rule.holds_layer
    layers = packing.rule.set_back and nz > 1 and nx * ny > 1
    return layers and not held and not isinstance(packing.vacancies, tuple)


def _check_moves(case: Case, stage: Precompression, errors: ErrorList) -> None:
    """Check that there are walls to move, and that they do not move through the packing."""
    boundary = case.boundary
    there = {
        "x": boundary.has_planes("x"),
        "y": boundary.has_planes("y"),
        "tube": boundary.sides_tube is not None,
    }
    most = LARGEST * case.packing.diameter / 2
    for name, distance in stage.moves.items():
        errors.check_first(
            (
                not there[name],
                f"{PRECOMPRESSION}.{name}",
                Mismatch(f"{distance:g} m, but this wall does not exist", f"{_wall_key(name)}"),
            ),
            (
                name in stage.presses,
                f"{PRECOMPRESSION}.{name}",
                Mismatch(f"together with {name}_force", remedy="specify only one of them"),
            ),
            (
                distance > most,
                f"{PRECOMPRESSION}.{name}",
                Mismatch(f"{distance:g} m", f"at most {most:g} m, {LARGEST} radii"),
            ),
        )
    errors.check(
        *(
            (
                not there[name],
                f"{PRECOMPRESSION}.{name}_force",
                Mismatch(f"{force:g} N, but this wall does not exist", f"{_wall_key(name)}"),
            )
            for name, force in stage.presses.items()
        ),
        (
            stage.rule.takes_moves and not stage.moves and not stage.presses,
            PRECOMPRESSION,
            Mismatch(
                'kind = "walls" without a wall that moves',
                remedy="set x, y or tube (m), or x_force etc. (N)",
            ),
        ),
    )
    if case.contact.line == "plane-strain":
        return
    grains = case.packing.grains
    own = (case.packing.of_grain, case.packing.diameter)
    sizes = (
        {own} if grains is None else set(zip(grains.shape, grains.diameter.tolist(), strict=True))
    )
    for axis, name in enumerate("xy"):
        # The law of cylinders that lie along a wall is valid up to 2 length^2/diameter.
        ends = [(2 * shape.length**2 / diameter, shape.length) for shape, diameter in sizes
                if shape is not None and abs(shape.axis[axis]) < _UPRIGHT]  # fmt: skip
        most, length = min(ends, default=(math.inf, 0.0))
        distance = stage.moves.get(name, 0.0)
        errors.check(
            (
                distance >= most,
                f"{PRECOMPRESSION}.{name}",
                Mismatch(
                    f"{distance:g} m",
                    f"less than {most:.3g} m, 2 length^2/diameter: the limit of the contact law "
                    f"of a cylinder of length {length:g} m on a wall",
                ),
            ),
        )


def _wall_key(name: str) -> str:
    return (
        f'boundary.{name} = "wall"'
        if name != "tube"
        else "boundary.sides = {tube = {radius = ...}}"
    )


def _check_top(assembly: Assembly, stage: Precompression, errors: ErrorList) -> None:
    """Check that a force on the top acts on grains that can move, and that the grains are
    supported.
    """
    case = assembly.case
    top = set(assembly.lattice.top_layer.tolist())
    key = f"{PRECOMPRESSION}.force"
    held = [min(grains) for hold in case.holds.values()
            if "z" in hold.axes and (grains := top.intersection(held_ids(case, hold)))]  # fmt: skip
    errors.check_first(
        (
            stage.pressure is not None,
            f"{PRECOMPRESSION}.pressure",
            Mismatch(
                "for grains at user-defined positions, which have no face", remedy="set a force"
            ),
        ),
        *(
            (
                stage.force is not None,
                key,
                f"acts on grain {one}, the uppermost grain, which is held along z",
            )
            for one in held
        ),
        (
            stage.force is not None and not case.bears_along_z,
            key,
            Mismatch(
                "a force on the top without a support",
                remedy="hold a grain along z, or set boundary.bottom",
            ),
        ),
    )


def _check_presses(assembly: Assembly, stage: Precompression, errors: ErrorList) -> None:
    """Check that walls that move to a force neither cause yielding nor exceed the range of the
    contact law.
    """
    for name, force in stage.presses.items():
        wall = next((wall for wall in walls(assembly) if wall.key == name), None)
        grains = [] if wall is None else grains_at_wall(assembly, wall).tolist()
        if not grains or assembly.shape_of(grains[0]) is not None:  # a cylinder stays elastic
            continue
        law = flat_contact(assembly, grains[0], wall.material if wall else None)
        share = force / len(grains)
        limit = _force_at_largest_overlap(law)
        what = f"the law is valid up to {limit:.3g} N"
        if assembly.case.contact.yields and 0 < law.yield_force < limit:
            limit = law.yield_force
            what = f"first yield is at {law.yield_force:.3g} N"
        if share > limit:
            found = f"found {force:g} N, about {share:.3g} N on each of {len(grains)} grains, where {what}"
            hint = f"use less than {limit * len(grains):.3g} N, or set a distance {name}"
            errors.add(f"{PRECOMPRESSION}.{name}_force", f"{found}; {hint}")


def _check_yield_by_walls(assembly: Assembly, stage: Precompression, errors: ErrorList) -> None:
    """Reject walls that move by more than the elastic limit of any chain of contacts, from wall to
    wall or axis.
    """
    case = assembly.case
    n = assembly.lattice.n_spheres
    grains = assembly.case.packing.grains
    contact = case.contact_between(case.material, case.material)
    if errors.items or not contact.yields or case.contact.initial_overlap:
        return
    kinds = {
        (assembly.diameter_of(k), assembly.material_of(k).name): k
        for k in range(1, (n if grains else 1) + 1)
    }
    ids = list(kinds.values())
    smallest = min(diameter for diameter, _ in kinds)
    laws = [
        pair_contact(assembly, first, second)
        for first, second in combinations_with_replacement(ids, 2)
    ]
    laws += [flat_contact(assembly, sphere, case.boundary.sides_material) for sphere in ids]
    most = max(law.yield_overlap for law in laws)
    places = grains.position if grains else assembly.lattice.positions(1, n)
    across = {
        "tube": case.boundary.sides_tube or 0.0,
        "x": np.ptp(places[:, 0]) / 2,
        "y": np.ptp(places[:, 1]) / 2,
    }
    for name, distance in stage.moves.items():
        limit = _INCLINED * (math.ceil(across[name] / smallest) + 1) * most
        errors.check(
            (
                distance > limit,
                f"{PRECOMPRESSION}.{name}",
                Mismatch(
                    f"{distance:g} m, by which contacts yield before the load: their elastic "
                    f"limit is a total of less than {limit:.3g} m",
                    remedy="use a smaller distance, a higher yield_strength, or contact.law = "
                    '"hertz"',
                ),
            ),
        )
