"""Checks of grains at places of their own, of held grains, of loads on chosen grains, and of lines."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.bodies import Hold
from granwave.lammps_inputs.case.boundary import Boundary, Precompression
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.grains import Grains
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.material import Material, Shape, presets
from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import Assembly, lattice_of
from granwave.lammps_inputs.packing.cylinders import cylinder_pair, end_contacts
from granwave.lammps_inputs.packing.motion import line_ids
from granwave.lammps_inputs.packing.places import Places, places_of
from granwave.lammps_inputs.packing.sites import sites_of
from granwave.lammps_inputs.packing.walls import touched

_PLACED = (
    ": packing.grains",
    ": packing.file",
    ": packing.gaps",
    ": grains.",
)  # of errors of grains that could not be placed
_LEAST_PERIOD = 2.5  # largest diameters; in fewer two grains could touch twice, one of them also as its image
_OBLIQUE = 1e-9  # largest component of an axis along a wall's normal, for rounding
_OF_LATTICES = {
    "replace": "the file gives each grain its diameter and material",
    "bar": "a bar needs a chain",
    "incident_bar": "a bar needs a chain",
}


def check_grains(parts: Mapping[str, Any], packing: PackingSection, errors: ErrorList) -> None:
    """Check the grains of a file, and that nothing is asked of them that only lattices have."""
    grains = packing.grains
    if grains is None:
        return
    for name, reason in _OF_LATTICES.items():
        if parts.get(name):
            errors.add(name, f'found with packing.kind = "file": {reason}; take it out')
    stage: Precompression | None = parts.get("precompression")
    if stage is not None and stage.kind == "uniform" and packing.cell is None:
        errors.add(
            "precompression.kind",
            'found "uniform" with packing.kind = "file", whose faces are not known; expected "walls", "overlaps", '
            '"uniaxial" or "gravity"',
        )
    _check_materials(parts, grains, errors)
    boundary: Boundary | None = parts.get("boundary")
    periodic = boundary is not None and boundary.sides == "periodic"
    if periodic and not _check_period(packing, grains, errors):
        return
    places = places_of(grains, packing.diameter, packing.period if periodic else None)
    at_ends = _check_ends(places, errors)
    _check_overlaps(places, errors, taken=stage is not None and stage.takes_overlaps, besides=at_ends)
    load: Load | None = parts.get("load")
    if load is None:
        return
    if load.kind == "grains" and not grains.velocity.any():
        errors.add("load.kind", 'found "grains", but no grain has a velocity; give columns vx, vy, vz')
    if load.kind == "impact":
        moving = [one for one in load.index or () if one <= len(grains) and grains.velocity[one - 1].any()]
        if moving:
            errors.add("load.index", f"found grain {moving[0]}, which has a velocity in the file; give one of them")


def check_cylinders(case: Case, errors: ErrorList) -> None:
    """Check that nothing is asked of cylinders that only spheres have, and that they lie along or across walls."""
    shapes = lattice_shapes(case)
    if not any(shapes):
        return
    if case.boundary.sides_tube is not None:
        errors.add("boundary.sides.tube", "found with cylinders; a tube holds spheres")
    for name in ("bar", "incident_bar"):
        if getattr(case, name) is not None:
            errors.add(name, "found with cylinders; a bar touches spheres")
    if case.packing.tilt is not None:
        errors.add("packing.tilt", "found with cylinders; they do not roll on a tilted floor")
    given = case.contact.initial_overlap
    if given and not isinstance(given, str):
        errors.add("contact.initial_overlap", "found with cylinders, expected the path of an earlier run's result.h5")
    planes = [letter for letter in "xy" if case.boundary.has_planes(letter)] + ["z"] * (case.boundary.bottom == "wall")
    for shape in shapes:
        for letter in planes if shape is not None else ():
            along = abs(shape.axis["xyz".index(letter)])  # type: ignore[union-attr]
            if _OBLIQUE < along < 1 - _OBLIQUE:
                fault = (
                    f"found cylinders along {show(list(shape.axis))}, "  # type: ignore[union-attr]
                    f"oblique to the wall across {letter}; expected an axis along it or normal to it"
                )
                if (grains := case.packing.grains) is None:
                    errors.add("packing.axis", fault)
                else:
                    _add(errors, grains, _first_of(grains, shape), fault)
    if case.packing.grains is not None:
        _check_crossings(case.packing.grains, shapes, errors)


def _add(errors: ErrorList, grains: Grains, ids: Sequence[int], message: str) -> None:
    """Add an error of some grains, under the key and the file that gave them."""
    key = grains.key(*ids)
    errors.add(key, f"{grains.file}: {message}" if key == "packing.file" else message)


def _first_of(grains: Grains, shape: Shape) -> list[int]:
    """Return the id of the first grain of a shape."""
    return [grains.shape.index(shape) + 1]


def lattice_shapes(case: Case) -> list[Shape]:
    """Return the shapes of the grains of a case, each once."""
    grains = case.packing.grains
    return [case.packing.of_grain] if grains is None else list(dict.fromkeys(grains.shape))


def _check_crossings(grains: Grains, shapes: list[Shape], errors: ErrorList) -> None:
    cylinders = [one for one in shapes if one is not None]
    for n, one in enumerate(cylinders):
        for other in cylinders[n + 1 :]:
            if cylinder_pair(one, other).nearly_parallel:
                _add(
                    errors,
                    grains,
                    _first_of(grains, other),
                    f"found cylinders along {show(list(one.axis))} and {show(list(other.axis))}, which are nearly "
                    "parallel; expected parallel axes, or axes at 1 degree or more",
                )
                return


def _check_ends(places: Places, errors: ErrorList) -> list[tuple[int, int]]:
    """Check that no grain touches the end of a cylinder, which has no law; return the pairs of ids that do."""
    if not any(places.grains.shape):
        return []
    pairs = end_contacts(places.grains, TOUCHING * places.diameter)
    if pairs:
        first, second = pairs[0]
        more = f" (and {len(pairs) - 1} more pairs)" if len(pairs) > 1 else ""
        _add(
            errors,
            places.grains,
            (first, second),
            f"found grains {places.grains.called(first)} and {places.grains.called(second)}, which touch at the end "
            f"of a cylinder{more}; its side has a law, "
            "its end none: move them apart, or make the cylinder longer",
        )
    return pairs


def check_chosen(
    load: Load | None, holds: Mapping[str, Hold], packing: PackingSection, n: int, errors: ErrorList
) -> None:
    """Check the ids of ``load.index``, ``[[hold]]`` and ``[[guide]]``.

    Parameters
    ----------
    holds
        What is held, by key.
    n
        Number of spheres of the packing, without strikers.
    """
    struck = set(load.index or ()) if load is not None else set()
    for sphere in sorted(struck):
        if sphere > n:
            errors.add("load.index", f"found {sphere}, expected an id from 1 to {n}, the end of the packing")
            break
    if load is not None and load.kind == "grains" and packing.grains is None:
        errors.add("load.kind", f'found "grains" with packing.kind = {show(packing.kind)}, expected it with "file"')
    for key, hold in holds.items():
        if (hold.index is None) == (hold.group is None):
            found = "both index and group" if hold.index else "neither index nor group"
            errors.add(key, f"found {found}, expected one of them")
            continue
        if hold.group is not None:
            groups = sorted(set(packing.grains.group) - {""}) if packing.grains is not None else []
            if hold.group not in groups and any(one in line for line in errors.lines for one in _PLACED):
                continue  # the grains of the group could not be placed, which has its own error
            if hold.group not in groups:
                there = f"one of {', '.join(map(show, groups))}" if groups else "index: no grain has a group"
                errors.add(f"{key}.group", f"found {show(hold.group)}, expected {there}")
                continue
        held = hold.index or packing.grains.of_group(hold.group or "")  # type: ignore[union-attr]
        if max(held) > n:
            errors.add(f"{key}.index", f"found {max(held)}, expected ids from 1 to {n}, the end of the packing")
            continue
        if not hold.axes and not hold.rotation:
            errors.add(key, "holds nothing; give directions, or rotation = true")
        _check_motion(hold, held, packing.grains, key, errors)


def check_touched(case: Case, errors: ErrorList) -> None:
    """Check that the side walls that act on some grains only find these, and that there are such walls."""
    boundary, key = case.boundary, "boundary.sides_touch"
    if boundary.sides_touch is None or errors.lines:
        return
    if boundary.sides_tube is None and not any(boundary.has_planes(axis) for axis in "xy"):
        errors.add(key, 'found it without walls; give x or y or sides = "wall", or sides = {tube = ...}')
        return
    grains = case.packing.grains
    groups = sorted(set(grains.group) - {""}) if grains is not None else []
    sites = sites_of(case, lattice_of(case))
    used = [case.material] if sites is None else [sites.materials[kind] for kind in np.unique(sites.kind)]
    materials = sorted({str(material.name) for material in used if material.name})
    for what, names, known in (
        ("material", boundary.sides_touch.material, materials),
        ("group", boundary.sides_touch.group, groups),
    ):
        for name in names:
            if name not in known:
                there = f"one of {', '.join(map(show, known))}" if known else f"none: no grain has a {what}"
                errors.add(f"{key}.{what}", f"found {show(name)}, expected {there}")


def check_tube(case: Case, errors: ErrorList) -> None:
    """Check that the packing fits into its tube, before this shrinks."""
    tube = case.boundary.sides_tube
    if tube is None or errors.lines:
        return
    lattice = lattice_of(case)
    sites = sites_of(case, lattice)
    diameter = np.full(lattice.n_spheres, lattice.diameter) if sites is None else sites.diameter
    place = (lattice if sites is None else sites).positions(1, lattice.n_spheres)
    reach = np.hypot(place[:, 0], place[:, 1]) + diameter / 2
    if case.boundary.sides_touch is not None:
        reach[~touched(case, sites, case.boundary.sides_touch)] = 0.0
    if sites is not None:
        reach[~sites.present] = 0.0
    widest = int(np.argmax(reach))
    if reach[widest] > tube + TOUCHING * lattice.diameter:
        errors.add(
            "boundary.sides.tube.radius",
            f"found {tube:g} m, but sphere {widest + 1} reaches {reach[widest]:.9g} m from the axis x = y = 0",
        )


def _check_motion(hold: Hold, held: tuple[int, ...], grains: Grains | None, key: str, errors: ErrorList) -> None:
    """Check that held grains of a file have no velocity in a direction in which they are held."""
    if grains is None:
        return
    rows = np.array(held) - 1
    for axis, letter in enumerate("xyz"):
        moving = rows[grains.velocity[rows, axis] != 0]
        if letter in hold.axes and len(moving):
            errors.add(key, f"holds grain {moving[0] + 1} along {letter}, along which the file gives it a velocity")
            return


def _check_materials(parts: Mapping[str, Any], grains: Grains, errors: ErrorList) -> None:
    own: list[Material | None] = [parts.get("material"), *parts.get("materials", ())]
    known = {*presets(), *(one.name for one in own if one is not None)}
    for name in dict.fromkeys(grains.material):
        if name and name not in known:
            first = grains.material.index(name) + 1
            _add(
                errors,
                grains,
                [first],
                f"found material {show(name)} of grain {grains.called(first)}, expected a preset or a table "
                f"[materials.{name}]",
            )


def _check_period(packing: PackingSection, grains: Grains, errors: ErrorList) -> bool:
    """Check the periods along x and y of grains of a file."""
    key, before = "packing.period", len(errors.lines)
    if packing.period is None:
        errors.add(
            key,
            'missing; boundary.sides = "periodic" of grains of a file needs [along x, along y] in m, or a file whose '
            "cell is a box, periodic along x and y",
        )
        return False
    least = _LEAST_PERIOD * float(grains.diameter.max())
    for letter, period in zip("xy", packing.period, strict=True):
        if period < least:
            errors.add(
                key,
                f"found {period:g} m along {letter}, expected at least {least:g} m, {_LEAST_PERIOD:g} of the largest "
                "diameters; repeat the grains",
            )
    return len(errors.lines) == before


def _check_overlaps(
    places: Places, errors: ErrorList, *, taken: bool, besides: Collection[tuple[int, int]] = ()
) -> None:
    """Check that no grains overlap at the start.

    Parameters
    ----------
    taken
        True if they may a little, as precompression.
    besides
        Pairs of ids that are refused for another reason.
    """
    pairs, overlaps = places.overlapping()
    if besides:
        other = np.array([tuple(pair) not in besides for pair in pairs.tolist()], dtype=bool)
        pairs, overlaps = pairs[other], overlaps[other]
    if not len(pairs):
        return
    grains, (first, second) = places.grains, pairs[0].tolist()
    if taken:
        shared = 2 / (2 / places.grains.diameter[pairs - 1]).sum(axis=1)  # effective radii
        worst = int(np.argmax(overlaps / shared))
        if overlaps[worst] > LARGEST * shared[worst]:
            first, second = pairs[worst].tolist()
            _add(
                errors,
                grains,
                (first, second),
                f"found grains {grains.called(first)} and {grains.called(second)}, which overlap by "
                f"{overlaps[worst]:.3g} m; as precompression "
                f"expected at most {LARGEST * shared[worst]:.3g} m, {LARGEST} R*",
            )
        return
    more = f" (and {len(pairs) - 1} more pairs)" if len(pairs) > 1 else ""
    both = f"found grains {grains.called(first)} and {grains.called(second)}"
    if (grains.position[first - 1] == grains.position[second - 1]).all():
        _add(errors, grains, (first, second), f"{both} at one place{more}; expected places of their own")
    else:
        _add(
            errors,
            grains,
            (first, second),
            f"{both}, which overlap by {overlaps[0]:.3g} m{more}; move them "
            'apart, or take that as a load: [precompression] kind = "overlaps"',
        )


def check_lines(assembly: Assembly, errors: ErrorList) -> None:
    """Check names, ids and grains of the lines of a case."""
    lines, last = assembly.case.line, assembly.last_sphere
    for place, line in enumerate(lines, start=1):
        key = f"line.{place}"
        if line.name in [other.name for other in lines[: place - 1]]:
            errors.add(f"{key}.name", f"found {show(line.name)} twice, expected a name of its own")
        if line.index is not None and line.start is not None:
            errors.add(f"{key}.index", "found beside start; give one of them")
            continue
        index = () if line.index is None or isinstance(line.index, str) else line.index
        named = {"index": index, "start": () if line.start is None else (line.start,)}
        strange = [(name, one) for name, ids in named.items() for one in ids if one > last]
        if strange:
            name, one = strange[0]
            errors.add(f"{key}.{name}", f"found {one}, expected ids from 1 to {last}")
            continue
        vacant = [(name, one) for name, ids in named.items() for one in np.setdiff1d(ids, assembly.ids).tolist()]
        if vacant:
            errors.add(f"{key}.{vacant[0][0]}", f"found {vacant[0][1]}, a vacant site; expected a grain that is there")
            continue
        if len(set(index)) < len(index):
            errors.add(f"{key}.index", f"found {show(list(index))}, expected each id once")
        elif (found := len(line_ids(assembly, line))) < 2:
            errors.add(
                key,
                f"found {found} grain{'' if found == 1 else 's'} along {show(list(line.direction))}, expected two "
                "or more; give another direction or start, or the ids as index",
            )
