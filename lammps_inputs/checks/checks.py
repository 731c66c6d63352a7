"""Checks of the tables of a case against each other."""

from __future__ import annotations

from collections.abc import Callable

from granwave.lammps_inputs.case.case import Case, WrongTable
from granwave.lammps_inputs.case.packing.packing import check_memory_of_sites, check_size
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.checks import (
    boundary,
    clumps,
    grains,
    ids,
    loads,
    normals,
    packing,
    precompression,
    region_walls,
    strikers,
    times,
)
from granwave.lammps_inputs.contact.initial_dents import KEY, error_in_dents
from granwave.lammps_inputs.packing.assembly import Assembly, assemble

_MEMORY_OF_SITE = 40.0  # bytes a site; measured 34 to 68 for 1e7 spheres

Check = Callable[[Case, ErrorList], None]


def check_together(case: Case, errors: ErrorList) -> None:
    """Check keys of different tables against each other, for valid tables."""
    _fit(
        case,
        errors,
        packing.check_pairs,
        packing.check_contact,
        times.check_times,
        times.check_probe_interval,
        times.check_resolution,
    )
    if not _fit(case, errors, _check_size):
        return
    _fit(
        case,
        errors,
        grains.check_columns,
        grains.check_places,
        grains.check_loaded,
        grains.check_held,
        clumps.check_clumps,
        ids.check_ids,
        strikers.check_strikers,
        times.check_history,
    )
    if _fit(case, errors, boundary.check_boundary):
        _fit(
            case,
            errors,
            loads.check_struck_spheres,
            boundary.check_bars,
            loads.check_side_gap,
            loads.check_excluded,
            precompression.check_precompression,
            boundary.check_holder,
        )
    _fit(case, errors, packing.check_disorder, packing.check_vacancies)


def _fit(case: Case, errors: ErrorList, *checks: Check) -> bool:
    """Return True if a case passes all checks; a check that reads an invalid table
    does not pass.
    """
    before = len(errors.items)
    complete = True
    for check in checks:
        try:
            check(case, errors)
        except WrongTable:
            complete = False
    return complete and len(errors.items) == before


def _check_size(case: Case, errors: ErrorList) -> None:
    """Check size and memory; grains of a file were read into memory, a lattice needs arrays over
    sites.
    """
    if not check_size(case.packing, errors) or case.packing.grains is not None:
        return
    nx, ny, nz = case.packing.lattice().shape
    unlike = case.packing.diameter_scatter or case.packing.vacancies or case.replace
    check_memory_of_sites(case.packing, nx * ny * (nz if unlike else 1), _MEMORY_OF_SITE, errors)


def check_case(case: Case, errors: ErrorList) -> Assembly | None:
    """Check the whole case: space for larger spheres, positions of strikers, support, static load
    and dents.
    """
    packing.check_room(case, errors)
    grains.check_cylinders(case, errors)
    if not grains.check_touched(case, errors):
        return None
    grains.check_tube(case, errors)
    try:
        assembly = assemble(case)
    except ValueError as error:
        errors.add("striker", str(error))
        return None
    grains.check_lines(assembly, errors)
    grains.check_restart(assembly, errors)
    for check in (
        precompression.check_plates,
        loads.check_struck,
        precompression.check_first_yield,
        loads.check_absorbing,
        clumps.check_loaded_clumps,
        region_walls.check_region_walls,
    ):
        check(assembly, errors)
    if not errors.items:
        loads.check_driving(assembly, errors)
    if fault := error_in_dents(assembly):
        errors.add(KEY, fault)
    for check in (
        packing.check_losses,
        packing.check_rates,
        packing.check_cohesion,
        normals.check_normals,
        strikers.check_below,
        strikers.check_held_strikers,
    ):
        check(assembly, errors)
    return assembly
