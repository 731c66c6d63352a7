"""Warnings about values of a case that are valid but may not be meant."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Iterator, Sequence

from granwave._contact_laws import FE_RANGE
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import (
    FITTED_POISSON_RATIO,
    hertz_von_mises_yield_factor,
)
from granwave.lammps_inputs.case.contact.law_parameters import (
    OF_MATERIAL,
    PARAMETERS,
    RATE,
    is_set,
    laws_with,
)
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.packing.contact_ways import KEEP, KEY
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.values import Enclosure
from granwave.lammps_inputs.checks.products import missing_products
from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.box_walls import BoxWall, box_walls
from granwave.lammps_inputs.packing.motion import own_spins
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import untouched

_BOTTOM = "bottom"
_KEYS_OF_WALLS = ("x", "y", _BOTTOM)  # keys of walls by axis
_LOG = logging.getLogger("granwave")
_FAR_LONGER = 100.0  # duration of a load over the run, above which its unit is probably wrong
_OTHER_UNITS = 100.0  # ratio of densities above which their units are probably wrong
_SMALL_GAP = 1e-3  # diameters; gaps caused by plastic indentation are larger


def warn_about(assembly: Assembly, planned: Iterable[str] = ()) -> None:
    """Log warnings about values that are valid but may not be meant.

    Parameters
    ----------
    planned
        Warnings that follow from the plan of the run.
    """
    for text in [*case_warnings(assembly), *planned]:
        _LOG.warning("%s: %s", assembly.case.name, text)


def case_warnings(assembly: Assembly) -> list[str]:
    """Return warnings about values that are valid but may not be meant."""
    return [
        *missing_products(assembly.case.figures),
        *_of_yield_factor(assembly),
        *_of_materials(assembly),
        *_of_bodies(assembly),
        *_of_probes(assembly),
        *_of_initial_dents(assembly),
        *_of_times(assembly),
        *_of_cut_contacts(assembly),
        *_of_overlaps_that_push_apart(assembly),
        *_of_units(assembly),
        *_of_walls_of_the_file(assembly),
        *_of_spins(assembly),
    ]


def _of_yield_factor(assembly: Assembly) -> Iterator[str]:
    """Warn of a fit for another Poisson's ratio, unless its factor was set by the user: it is in
    the case file, or differs from its default.
    """
    law = assembly.case.contact
    ratio = assembly.case.material.poisson_ratio
    factor = PARAMETERS["yield_factor"]
    is_chosen = f"contact.{factor.name}" in assembly.case.chosen or is_set(law, factor)
    if law.takes(factor.name) and not is_chosen and ratio != FITTED_POISSON_RATIO:
        yield (
            f"the contact law was fitted for a Poisson's ratio of {FITTED_POISSON_RATIO:.2f}, "
            f"found {ratio:g}; its exact Hertz-von Mises yield factor is C = "
            f"{hertz_von_mises_yield_factor(ratio):.4f} (contact.yield_factor is "
            f'{law.yield_factor:g}); law = "elastoplastic-fe" is valid for ratios of 0 to 0.45'
        )


def _of_materials(assembly: Assembly) -> Iterator[str]:
    """Warn of materials outside the range of the law, and of parameters that the law ignores."""
    law = assembly.case.contact
    materials = {id(species.material): species.material for species in assembly.species}.values()
    if law.takes("hardening"):
        yield from filter(None, map(_outside_fit, materials))
    for parameter in OF_MATERIAL:
        # `check_rates` checks rate-dependent parameters
        if law.takes(parameter.name) or parameter.keyword == RATE:
            continue
        if any(is_set(material, parameter) for material in materials):
            laws = " or ".join(laws_with(parameter))
            yield (
                f"contact.law: found {law.law}, expected law {laws} for a material with "
                f"{parameter.name}, which other laws ignore"
            )


def _outside_fit(material: Material) -> str:
    """Return the values of a material beyond the range of law elastoplastic-fe; empty if there are
    none.
    """
    ratio = math.inf
    if material.yield_strength is not None:
        ratio = material.youngs_modulus / material.yield_strength
    ranges = (
        ("Poisson's ratio", material.poisson_ratio, FE_RANGE["poisson_ratio"]),
        ("Young's modulus / yield strength", ratio, FE_RANGE["modulus_over_strength"]),
        ("hardening", material.hardening or 0.0, FE_RANGE["hardening"]),
    )
    outside = [
        f"{name} {value:.3g}, expected {low:g} to {high:g}"
        for name, value, (low, high) in ranges
        if math.isfinite(value) and not low <= value <= high
    ]
    if not outside:
        return ""
    return (
        "law elastoplastic-fe is used outside the range of its fit, without an error bar: "
        f"{'; '.join(outside)}"
    )


def _of_bodies(assembly: Assembly) -> Iterator[str]:
    """Warn of cylinders that never yield, and of grains in walls that do not act on them."""
    law = assembly.case.contact
    if law.yields and assembly.has_cylinders:
        yield (
            "contacts along a line, of parallel cylinders and of cylinders on walls, stay "
            f"elastic: contact.law = {law.law} applies only to the other contacts"
        )
    for wall, grain, depth in untouched(assembly):
        yield (
            f"grain {grain} reaches {depth:.3g} m into the wall {wall}, which does not act on it: "
            "boundary.sides_touch"
        )


def _of_probes(assembly: Assembly) -> Iterator[str]:
    """Warn of probed contacts of spheres that do not touch."""
    contacts = [probe.contact for probe in assembly.case.output.probes if probe.contact is not None]
    for contact in contacts:
        if not _touch_at_start(assembly, contact):
            yield f"the spheres of the probed contact {contact} do not touch at the start"


def _touch_at_start(assembly: Assembly, contact: tuple[int, int]) -> bool:
    """Return True if two spheres touch at the start, or are at neighbouring sites."""
    low, high = sorted(contact)
    if high > assembly.lattice.n_spheres:
        return (low, high) in assembly.striker_contacts
    return high in assembly.lattice.neighbours(low)


def _of_initial_dents(assembly: Assembly) -> Iterator[str]:
    """Warn of initial dents that a static load would erase."""
    case = assembly.case
    forget_gap = case.boundary.forget_gap
    if case.contact.initial_overlap and case.precompression and forget_gap < _SMALL_GAP:
        gap = forget_gap * case.packing.diameter
        yield (
            "boundary.forget_gap: initial plastic indentations are forgotten beyond gaps of "
            f"{gap:.3g} m, so the packing may never come to rest under its static load; use "
            f"{_SMALL_GAP:g} or more"
        )


def _of_times(assembly: Assembly) -> Iterator[str]:
    """Warn of loads that begin after the run or seem to be in another unit, and of short runs."""
    case = assembly.case
    end = case.run.longest
    if case.load.first_time >= end:
        yield (
            f"load.table: the load begins at {case.load.first_time:.3g} s, after the end of the "
            "run: use a later run.end_time"
        )
    if end * _FAR_LONGER < case.load.lasts < math.inf:
        if case.load.table is not None:
            key = "load.table"
            question = "are its times in seconds?"
        else:
            key = "load.duration"
            question = "is it in seconds?"
        yield f"{key}: the load lasts {case.load.lasts:.3g} s, the run {end:.3g} s: {question}"
    if case.run.end_time == "auto" and not case.contact.yields and not case.has_cohesion:
        yield (
            'a Hertzian packing dissipates no energy, so run.end_time = "auto" ends after the '
            "first collision (at least 50 µs)"
        )


def _of_cut_contacts(assembly: Assembly) -> Iterator[str]:
    """Warn of grains of a file that touch across sides of its periodic box that are not periodic in
    the case.
    """
    case = assembly.case
    grains = case.packing.grains
    lattice = assembly.lattice
    if grains is None or grains.period is None or case.boundary.periodic:
        return
    if not isinstance(lattice, Places):
        return
    n_cut = Places(grains, lattice.diameter, grains.period).n_contacts - lattice.n_contacts
    if n_cut > 0:
        contacts = f"{counted(n_cut, 'contact')} {'crosses' if n_cut == 1 else 'cross'}"
        yield (
            f"packing.file: the box of the file is periodic along x and y, and {contacts} "
            f'its sides; found boundary.sides = "{case.boundary.sides}", which ignores '
            'these contacts; boundary.sides = "periodic" includes them'
        )


def _of_overlaps_that_push_apart(assembly: Assembly) -> Iterator[str]:
    """Warn of overlaps that push unconfined grains apart."""
    case = assembly.case
    stage = case.precompression
    way = case.packing.contact_way
    lattice = assembly.lattice
    if stage is None or way is None or not isinstance(lattice, Places):
        return
    if not way.balances or not stage.is_overlaps_alone or _holds_together(case):
        return
    overlaps = lattice.overlapping()[1]
    if len(overlaps):
        yield (
            f"packing.contacts: {len(overlaps)} overlaps, up to {overlaps.max():.3g} m, push "
            "apart grains that no load, wall or held grain confines: at equilibrium they no "
            'longer touch; add a load, such as precompression.kind = "gravity"'
        )


def _of_spins(assembly: Assembly) -> Iterator[str]:
    """Warn of angular velocities of a file that are ignored."""
    case = assembly.case
    grains = case.packing.grains
    if grains is None or not grains.spin.any() or own_spins(assembly):
        return
    reason = "grains in clumps, and grains whose rotation is held, start without spin"
    if not case.has_friction:
        reason = "they have no effect without contact.friction"
    elif case.precompression is not None and case.seeks_balance:
        reason = f'the grains come to equilibrium; {KEY} = "{KEEP.name}" keeps them'
    yield f"packing.file: angular velocities are ignored: {reason}"


def _of_units(assembly: Assembly) -> Iterator[str]:
    """Warn of densities of a file that are so low that its lengths may be in another unit."""
    grains = assembly.case.packing.grains
    if grains is None or grains.reading is None or grains.reading.density is None:
        return
    highest = grains.reading.density[1]
    lowest = min(species.material.density for species in assembly.species)
    if not 0 < highest < lowest / _OTHER_UNITS:
        return
    yield (
        f"packing.file: the densities in the file are at most {highest:.4g} kg/m^3, those of the "
        f"materials at least {lowest:.4g} kg/m^3; the largest grain has a diameter of "
        f"{grains.diameter.max():.4g} m; are its lengths in another unit, such as packing.units = "
        '"cm"?'
    )


def _of_walls_of_the_file(assembly: Assembly) -> Iterator[str]:
    """Warn of walls of another program that the case lacks or has at other positions."""
    case = assembly.case
    grains = case.packing.grains
    way = case.packing.contact_way
    if grains is None or way is None or not way.presses:
        return
    enclosure = case.packing.enclosure or Enclosure()
    missing: list[str] = []
    moved: list[BoxWall] = []
    for wall in box_walls(grains):
        key = _KEYS_OF_WALLS[wall.axis]
        if key == _BOTTOM and not wall.is_upper:
            continue  # the top is free
        if not _has_wall(case, key):
            missing.append(f"boundary.{key}")
        elif getattr(enclosure, key) is None:
            moved.append(wall)
    if moved:
        yield _walls_elsewhere(grains, moved)
    if missing:
        keys = " and ".join(dict.fromkeys(missing))
        yield (
            "packing.file: grains overlap with faces of the box of the file, which had walls "
            f'there; the case has none; set {keys} = "wall" to add them'
        )


def _has_wall(case: Case, key: str) -> bool:
    """Return True if a case has planes across x or y, or at the bottom."""
    if key == _BOTTOM:
        return case.boundary.bottom_rule.has_plane
    return case.boundary.has_planes(key)


def _walls_elsewhere(grains: Grains, walls: Sequence[BoxWall]) -> str:
    """Return a warning of walls of a file that are at other positions in the case."""
    assert grains.reading is not None and grains.reading.bounds is not None
    places: list[str] = []
    for axis in dict.fromkeys(wall.axis for wall in walls):
        low, high = (grains.reading.bounds[axis] + 0.0).tolist()
        key = _KEYS_OF_WALLS[axis]
        place = f"{high:.12g}" if key == _BOTTOM else f"[{low:.12g}, {high:.12g}]"
        places.append(f"{key} = {place}")
    n_grains = sum(wall.n_grains for wall in walls)
    several = "s overlap" if n_grains > 1 else " overlaps"
    deepest = max(wall.deepest for wall in walls)
    return (
        f"packing.file: {n_grains} grain{several} with faces of the box of the file by up to "
        f"{deepest:.3g} m, as the file had walls there; the walls of the case touch the outermost "
        f"grains, so these overlaps are lost; set packing.enclosure = {{{', '.join(places)}}} for "
        "walls at the faces"
    )


def _holds_together(case: Case) -> bool:
    """Return True if held grains, side walls, or the packing itself hold its grains together."""
    boundary = case.boundary
    has_sides = boundary.periodic or boundary.sides_tube is not None
    has_walls = bool(case.wall) or any(map(boundary.has_planes, "xy"))
    return bool(case.holds) or has_sides or has_walls
