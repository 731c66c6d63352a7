"""Checks of precompression and of a moving bottom against the rest of a case."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.case.sections import Boundary, Precompression
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import force_of_contact
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import materials_of_last_layer

_TABLE = "precompression"


def check_precompression(
    parts: Mapping[str, Any], packing: PackingSection, boundary: Boundary, errors: ErrorList
) -> None:
    """Check the values of a precompression, and that the boundary can bear it."""
    stage: Precompression | None = parts.get(_TABLE)
    if stage is None:
        return
    bars = [name for name in ("bar", "incident_bar") if parts.get(name) is not None]
    if bars:
        errors.add(_TABLE, f"found beside [{bars[0]}], whose far end nothing holds; take one of them out")
        return
    _check_size(stage, packing, errors)
    if stage.kind == "walls":
        _check_moves(stage, packing, boundary, errors)
        return
    if stage.kind == "uniform":
        if packing.kind == "chain":
            errors.add(f"{_TABLE}.kind", 'found "uniform" for a chain, expected "uniaxial" with a force')
        elif boundary.sides != "free" and boundary.bottom != "periodic" and packing.grains is None:
            errors.add(
                "boundary.sides",
                f'found {show(boundary.sides)} with precompression.kind = "uniform", expected "free": '
                "the pressure is on the sides too",
            )
    elif boundary.bottom == "free":
        errors.add("boundary.bottom", f'found "free" under a {stage.kind} precompression, which something must bear')
    if stage.kind == "uniaxial" and packing.kind == "square":
        errors.add(f"{_TABLE}.kind", 'found "uniaxial" for square, a single layer; expected "uniform" or "gravity"')
    support = boundary.bottom_support
    if support is not None and not support.bears:
        errors.add(
            "boundary.bottom.bar.end",
            f'found {show(support.bar.end if support.bar else "")} under a precompression, expected "fixed": '
            "such a bar gives way to a load that lasts",
        )


def check_first_yield(assembly: Assembly, errors: ErrorList) -> None:
    """Refuse a static load that yields every contact, exceeds the range of the law, or spreads the layers."""
    case = assembly.case
    stage, contact = case.precompression, case.contact_between(case.material, case.material)
    if stage is None or stage.kind == "walls" or case.packing.grains is not None:
        return
    name, unit = ("force", "N") if stage.force is not None else ("pressure", "Pa")
    if stage.kind == "gravity":
        name, unit = "acceleration", "m/s^2"
    law, largest = sphere_contact(case), force_of_contact(assembly)
    least = (
        largest / assembly.lattice.shape[2] if stage.kind == "gravity" else largest
    )  # of the contacts of the top layer
    deepest = float(law.loading_force(np.array([LARGEST * law.effective_radius]))[0])
    fault, force, limit = "", largest, deepest
    # contacts with initial dents stay elastic beyond first yield
    has_elastic_range = contact.yields and law.elastic_limit > 0
    if has_elastic_range and not case.contact.initial_overlap and least >= law.yield_force:
        force, limit = least, law.yield_force
        fault = f"would yield every contact: about {force:.3g} N on each, first yield at {limit:.3g} N"
    elif largest > deepest:
        fault = f"would press contacts with {force:.3g} N, the law holds up to {limit:.3g} N ({LARGEST} R*)"
    if fault:
        errors.add(f"{_TABLE}.{name}", f"{fault}; give less than {getattr(stage, name) * limit / force:.3g} {unit}")
    elif _spreads(assembly):
        errors.add(
            "boundary.sides",
            f"found {show(case.boundary.sides)} under a {stage.kind} precompression of {case.packing.kind}, which "
            'spreads without friction, also between walls; expected "periodic", or precompression.kind = "uniform"',
        )


def check_support(assembly: Assembly, errors: ErrorList) -> None:
    """Check that all spheres on a moving bottom are of one material, as each material has a fix of its own."""
    case = assembly.case
    if case.boundary.bottom_support is None:
        return
    names = [material.name or "?" for material in materials_of_last_layer(assembly)]
    if len(names) != 1:
        errors.add(
            "boundary.bottom",
            f"found a {case.boundary.bottom_support.kind} under spheres of {' and '.join(names) or 'no material'}, "
            "expected a last layer of one material",
        )


def _spreads(assembly: Assembly) -> bool:
    """Return True if the load would push the spheres of a layer apart: no friction, pressure or period holds them."""
    case = assembly.case
    stage, packing, boundary = case.precompression, case.packing, case.boundary
    nx, ny, nz = assembly.lattice.shape
    held = boundary.sides == "periodic" or boundary.bottom == "fixed"
    free = stage is not None and stage.kind != "uniform" and not held
    layers = KINDS[packing.kind].set_back and nz > 1 and nx * ny > 1 and not isinstance(packing.vacancies, tuple)
    return free and layers


def _check_moves(stage: Precompression, packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
    """Check that there are walls to move, and that they do not move through the packing."""
    there = {"x": boundary.has_planes("x"), "y": boundary.has_planes("y"), "tube": boundary.sides_tube is not None}
    for name, distance in stage.moves.items():
        if not there[name]:
            expected = f'boundary.{name} = "wall"' if name != "tube" else "boundary.sides = {tube = {radius = ...}}"
            errors.add(f"{_TABLE}.{name}", f"found {distance:g} m, but there is no such wall; expected {expected}")
        elif distance > LARGEST * packing.diameter / 2:
            most = LARGEST * packing.diameter / 2
            errors.add(f"{_TABLE}.{name}", f"found {distance:g} m, expected at most {most:g} m, {LARGEST} radii")
    if not stage.moves:
        errors.add(_TABLE, 'found kind = "walls" and no wall that moves; give x, y or tube, in m')


def _check_size(stage: Precompression, packing: PackingSection, errors: ErrorList) -> None:
    given = [name for name in ("pressure", "force") if getattr(stage, name) is not None]
    for name in stage.moves if stage.kind != "walls" else ():
        errors.add(f"{_TABLE}.{name}", f'belongs to precompression.kind = "walls"; found {show(stage.kind)}')
    if stage.kind in ("gravity", "walls"):
        instead = "acceleration" if stage.kind == "gravity" else "x, y or tube, in m"
        for name in given:
            errors.add(
                f"{_TABLE}.{name}", f"does not belong to precompression.kind = {show(stage.kind)}; give {instead}"
            )
        if stage.kind == "gravity":
            return
    if stage.acceleration != Precompression.acceleration:
        errors.add(f"{_TABLE}.acceleration", f'belongs to precompression.kind = "gravity"; found "{stage.kind}"')
    if stage.kind == "walls":
        return
    if stage.kind == "uniform" and stage.force is not None:
        errors.add(f"{_TABLE}.force", 'found with precompression.kind = "uniform", expected a pressure')
    elif len(given) != 1:
        found = "neither pressure nor force" if not given else "both pressure and force"
        errors.add(_TABLE, f"found {found}, expected one of them")
    elif packing.kind == "chain" and stage.pressure is not None:
        errors.add(f"{_TABLE}.pressure", "found for a chain, which has no face; expected a force")
