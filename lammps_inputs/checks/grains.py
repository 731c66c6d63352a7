"""Checks of grains at places of their own, of held grains, of loads on chosen grains, and of lines."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.bodies import Hold
from granwave.lammps_inputs.case.boundary import Boundary, Precompression
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.grains import Grains
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.material import Material, presets
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
    packed = case.packing.grains
    shapes = [case.packing.of_grain] if packed is None else list(dict.fromkeys(packed.shape))
    if not any(shapes):
        return
    given, path = case.contact.initial_overlap, "the path of an earlier run's result.h5"
    errors.check(
        (case.boundary.sides_tube, "boundary.sides.tube", "found with cylinders; a tube holds spheres"),
        (case.bar, "bar", "found with cylinders; a bar touches spheres"),
        (case.incident_bar, "incident_bar", "found with cylinders; a bar touches spheres"),
        (case.packing.tilt, "packing.tilt", "found with cylinders; they do not roll on a tilted floor"),
        (given and not isinstance(given, str), "contact.initial_overlap", f"found with cylinders, expected {path}"),
    )
    planes = [letter for letter in "xy" if case.boundary.has_planes(letter)] + ["z"] * (case.boundary.bottom == "wall")
    for shape in shapes:
        for letter in planes if shape is not None else ():
            along = abs(shape.axis["xyz".index(letter)])  # type: ignore[union-attr]
            if _OBLIQUE < along < 1 - _OBLIQUE:
                fault = f"oblique to the wall across {letter}; expected an axis along it or normal to it"
                fault = f"found cylinders along {show(list(shape.axis))}, {fault}"  # type: ignore[union-attr]
                if packed is None:
                    errors.add("packing.axis", fault)
                else:
                    _add(errors, packed, [packed.shape.index(shape) + 1], fault)
    cylinders = [one for one in shapes if one is not None]
    for one, other in combinations(cylinders, 2) if packed is not None else ():
        if cylinder_pair(one, other).nearly_parallel:
            fault = (
                f"found cylinders along {show(list(one.axis))} and {show(list(other.axis))}, which are nearly parallel"
            )
            fault += "; expected parallel axes, or axes at 1 degree or more"
            _add(errors, packed, [packed.shape.index(other) + 1], fault)  # type: ignore[union-attr, arg-type]
            return


def _add(errors: ErrorList, grains: Grains, ids: Sequence[int], message: str) -> None:
    """Add an error of some grains, under the key and the file that gave them."""
    key = grains.key(*ids)
    errors.add(key, f"{grains.file}: {message}" if key == "packing.file" else message)


def _add_pair(errors: ErrorList, grains: Grains, pair: Sequence[int], message: str, n_pairs: int = 1) -> None:
    """Add an error of two grains; ``{}`` in the message stands for the number of more such pairs."""
    more = f" (and {n_pairs - 1} more pairs)" if n_pairs > 1 else ""
    first, second = map(grains.called, pair)
    _add(errors, grains, pair, f"found grains {first} and {second}{message.format(more)}")


def _check_ends(places: Places, errors: ErrorList) -> list[tuple[int, int]]:
    """Check that no grain touches the end of a cylinder, which has no law; return the pairs of ids that do."""
    if not any(places.grains.shape):
        return []
    pairs = end_contacts(places.grains, TOUCHING * places.diameter)
    if pairs:
        text = (
            ", which touch at the end of a cylinder{}; its side has a law, its end none: move them apart, or make the "
        )
        _add_pair(errors, places.grains, pairs[0], f"{text}cylinder longer", len(pairs))
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
    beyond = sorted(one for one in (load.index or () if load is not None else ()) if one > n)
    errors.check(
        *((True, "load.index", f"found {one}, expected an id from 1 to {n}, the end of the packing")
          for one in beyond[:1]),
        (load is not None and load.kind == "grains" and packing.grains is None, "load.kind",
         f'found "grains" with packing.kind = {show(packing.kind)}, expected it with "file"'),
    )  # fmt: skip
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
        if packing.grains is not None:
            rows = np.array(held) - 1
            moving = {letter: rows[packing.grains.velocity[rows, "xyz".index(letter)] != 0] for letter in hold.axes}
            errors.check_first(
                *((True, key, f"holds grain {grain[0] + 1} along {letter}, along which the file gives it a velocity")
                  for letter, grain in moving.items() if len(grain)),
            )  # fmt: skip


def check_touched(case: Case, errors: ErrorList) -> bool:
    """Check that the side walls that act on some grains only find these, and that there are such walls.

    Return False if walls would act on no grain, so that they have no place.
    """
    boundary, key = case.boundary, "boundary.sides_touch"
    if boundary.sides_touch is None or errors.lines:
        return True
    if boundary.sides_tube is None and not any(boundary.has_planes(axis) for axis in "xy"):
        errors.add(key, 'found it without walls; give x or y or sides = "wall", or sides = {tube = ...}')
        return True
    grains = case.packing.grains
    groups = sorted(set(grains.group) - {""}) if grains is not None else []
    sites = sites_of(case, lattice_of(case))
    used = [case.material] if sites is None else [sites.materials[k] for k in np.unique(sites.kind[sites.present])]
    materials = sorted({str(material.name) for material in used if material.name})
    for what, known in (("material", materials), ("group", groups)):
        for name in getattr(boundary.sides_touch, what):
            if name not in known:
                there = f"one of {', '.join(map(show, known))}" if known else f"none: no grain has a {what}"
                errors.add(f"{key}.{what}", f"found {show(name)}, expected {there}")
    return bool(touched(case, sites, boundary.sides_touch).any())


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


def _check_materials(parts: Mapping[str, Any], grains: Grains, errors: ErrorList) -> None:
    own: list[Material | None] = [parts.get("material"), *parts.get("materials", ())]
    known = {*presets(), *(one.name for one in own if one is not None)}
    for name in dict.fromkeys(grains.material):
        if name and name not in known:
            first = grains.material.index(name) + 1
            text = f"found material {show(name)} of grain {grains.called(first)}, expected a preset or a table "
            _add(errors, grains, [first], f"{text}[materials.{name}]")


def _check_period(packing: PackingSection, grains: Grains, errors: ErrorList) -> bool:
    """Check the periods along x and y of grains of a file."""
    before, least = len(errors.lines), _LEAST_PERIOD * float(grains.diameter.max())
    errors.check(
        (packing.period is None, "packing.period",
         'missing; boundary.sides = "periodic" of grains of a file needs [along x, along y] in m, or a file whose '
         "cell is a box, periodic along x and y"),
        *((period < least, "packing.period",
           f"found {period:g} m along {letter}, expected at least {least:g} m, {_LEAST_PERIOD:g} of the largest "
           "diameters; repeat the grains") for letter, period in zip("xy", packing.period or (), strict=False)),
    )  # fmt: skip
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
        shared = 2 / (2 / grains.diameter[pairs - 1]).sum(axis=1)  # effective radii
        worst = int(np.argmax(overlaps / shared))
        if overlaps[worst] > (most := LARGEST * shared[worst]):
            text = f"as precompression expected at most {most:.3g} m, {LARGEST} R*"
            _add_pair(errors, grains, pairs[worst].tolist(), f", which overlap by {overlaps[worst]:.3g} m; {text}")
        return
    text = f", which overlap by {overlaps[0]:.3g} m{{}}; move them apart, or take that as a load: [precompression] "
    text += 'kind = "overlaps"'
    if (grains.position[first - 1] == grains.position[second - 1]).all():
        text = " at one place{}; expected places of their own"
    _add_pair(errors, grains, (first, second), text, len(pairs))


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
        vacant = [(name, one) for name, ids in named.items() for one in np.setdiff1d(ids, assembly.ids).tolist()]
        fits = errors.check_first(
            *((True, f"{key}.{name}", f"found {one}, expected ids from 1 to {last}") for name, one in strange),
            *((True, f"{key}.{name}", f"found {one}, a vacant site; expected a grain that is there")
              for name, one in vacant),
            (len(set(index)) < len(index), f"{key}.index", f"found {show(list(index))}, expected each id once"),
        )  # fmt: skip
        if fits and (found := len(line_ids(assembly, line))) < 2:
            text = f"found {found} grain{'' if found == 1 else 's'} along {show(list(line.direction))}"
            hint = "give another direction or start, or the ids as index"
            errors.add(key, f"{text}, expected two or more; {hint}")
