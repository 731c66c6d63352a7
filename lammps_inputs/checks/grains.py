"""Checks of grains at user-defined positions, of held grains, of loads on chosen grains, and of
lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import presets
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.contact.bed_state import bed_state
from granwave.lammps_inputs.contact.contact_advice import advice_on
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.errors import InputError, Mismatch
from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import cylinder_pair, end_contacts
from granwave.lammps_inputs.packing.motion import line_ids
from granwave.lammps_inputs.packing.places import Places, layout_of
from granwave.lammps_inputs.packing.sites import sites_of
from granwave.lammps_inputs.packing.walls import touched
from granwave.lammps_inputs.packing_kind import TOUCHING

# keys of grains that could not be placed
_PLACED = ("packing.grains", "packing.file", "packing.gaps", "grains.")
# smallest period in largest diameters: with less, two grains could touch twice, once across the
# boundary
_LEAST_PERIOD = 2.5
_OBLIQUE = 1e-9  # largest component of an axis along a wall's normal, for rounding
_OF_LATTICES = {
    "replace": "the file sets the diameter and material of each grain",
    "bar": "a bar requires a chain",
    "incident_bar": "a bar requires a chain",
}


def check_columns(case: Case, errors: ErrorList) -> None:
    """Check the materials of grains of a file, and reject features that only lattices
    support.
    """
    grains = case.packing.grains
    stage = case.precompression
    if grains is None:
        return
    errors.check(
        *(
            (
                getattr(case, name),
                name,
                Mismatch(f'with packing.kind = "file": {reason}', remedy="remove it"),
            )
            for name, reason in _OF_LATTICES.items()
        ),
        (
            stage is not None and stage.rule.on_all_faces and case.packing.cell is None,
            "precompression.kind",
            Mismatch(
                '"uniform" with packing.kind = "file", whose faces are not known',
                '"walls", "overlaps", "uniaxial" or "gravity"',
            ),
        ),
    )
    known = {"", *presets(), *(one.name for one in (case.material, *case.materials))}
    for name in dict.fromkeys(grains.material):
        if name not in known:
            first = grains.material.index(name) + 1
            found = f"material {show(name)} of grain {grains.called(first)}"
            fault = Mismatch(found, f"a preset or a table [materials.{name}]")
            _add(errors, grains, [first], fault)


def check_restart(assembly: Assembly, errors: ErrorList) -> None:
    """Check that a case has the spheres, masses and walls of its restart file."""
    try:
        state = bed_state(assembly)
    except InputError as error:
        errors.add("packing.restart", str(error).partition("packing.restart: ")[2])
        return
    for key, fault in state.faults if state is not None else ():
        errors.add(key, fault)


def _missing_period(grains: Grains) -> str:
    """Return the fault of a missing period, with the period of the box of the file."""
    text = (
        'missing; boundary.sides = "periodic" of grains of a file needs [along x, along y] in m, '
        "or a file whose cell is a box, periodic along x and y"
    )
    reading = grains.reading
    if reading is None or reading.bounds is None:
        return text
    widths = [f"{high - low:.6g}" for low, high in reading.bounds[:2]]
    edges = f"the box of this file is {' × '.join(widths)} m"
    return f"{text}; {edges}: packing.period = [{', '.join(widths)}] if it was periodic"


def check_places(case: Case, errors: ErrorList) -> None:
    """Check the periods of grains of a file, and that no grains overlap at the start or touch at a
    cylinder's end.
    """
    packing = case.packing
    grains = case.packing.grains
    stage = case.precompression
    if grains is None:
        return
    periodic = (
        "boundary" in vars(case) and case.boundary.periodic
    )  # an invalid boundary does not hide overlaps
    if periodic:
        before = len(errors.items)
        least = _LEAST_PERIOD * float(grains.diameter.max())
        errors.check(
            (
                packing.period is None,
                "packing.period",
                _missing_period(grains),
            ),
            *(
                (
                    period < least,
                    "packing.period",
                    Mismatch(
                        f"{period:g} m along {letter}",
                        f"at least {least:g} m, {_LEAST_PERIOD:g} of the largest diameters; "
                        "repeat the grains to make it longer",
                    ),
                )
                for letter, period in zip("xy", packing.period or (), strict=False)
            ),
        )
        if len(errors.items) > before:
            return
    places = Places(grains, packing.diameter, packing.period if periodic else None)
    at_ends = end_contacts(grains, TOUCHING * places.diameter) if any(grains.shape) else []
    if at_ends:
        text = (
            ", which touch at the end of a cylinder{}; only its side has a contact law: move "
            "them apart, or make the"
        )
        _add_pair(errors, grains, at_ends[0], f"{text} cylinder longer", len(at_ends))
    _check_enclosure(case, grains, errors)
    pairs, overlaps = places.overlapping()
    if at_ends:
        other = np.array([tuple(pair) not in at_ends for pair in pairs.tolist()], dtype=bool)
        pairs = pairs[other]
        overlaps = overlaps[other]
    if not len(pairs):
        return errors.check(
            (
                stage is not None and stage.rule.from_overlaps and packing.cell is None,
                "precompression.kind",
                Mismatch(
                    '"overlaps" with grains that do not overlap',
                    "at least two overlapping grains",
                    'move them together, or use another kind, such as "walls"',
                ),
            ),
        )
    if stage is not None and stage.takes_overlaps:
        shared = 2 / (2 / grains.diameter[pairs - 1]).sum(axis=1)  # effective radii
        worst = int(np.argmax(overlaps / shared))
        if overlaps[worst] > (most := LARGEST * shared[worst]):
            text = f"with precompression expected at most {most:.3g} m, {LARGEST} R*"
            _add_pair(
                errors,
                grains,
                pairs[worst].tolist(),
                f", which overlap by {overlaps[worst]:.3g} m; {text}",
            )
        return
    first, second = grains.position[pairs[0] - 1]
    if (first == second).all():
        text = " at the same position{}; expected different positions"
    else:
        advice = advice_on(case, grains, places.period)
        text = f", which overlap by {overlaps[0]:.3g} m{{}}; {advice.remedy}"
    _add_pair(errors, grains, pairs[0].tolist(), text, len(pairs))


def _check_enclosure(case: Case, grains: Grains, errors: ErrorList) -> None:
    """Check that no centre of a grain is beyond a plane of the enclosure that is a wall."""
    enclosure = case.packing.enclosure
    boundary = vars(case).get("boundary")  # which may be invalid
    if enclosure is None or boundary is None:
        return
    planes: dict[str, tuple[float, float]] = {}
    for letter, ends in (("x", enclosure.x), ("y", enclosure.y)):
        if ends is not None and boundary.has_planes(letter):
            planes[letter] = ends
    if enclosure.bottom is not None and boundary.bottom_rule.has_plane:
        planes["z"] = (-np.inf, enclosure.bottom)
    for letter, (low, high) in planes.items():
        along = grains.position[:, "xyz".index(letter)]
        beyond = np.flatnonzero((along < low) | (along > high))
        if not len(beyond):
            continue
        grain = grains.called(int(beyond[0]) + 1)
        found = (
            f"{counted(len(beyond), 'grain')} beyond the walls along {letter}, such as grain "
            f"{grain} at {letter} = {along[beyond[0]]:.6g} m (the grains are at "
            f"{along.min():.6g} to {along.max():.6g} m)"
        )
        remedy = (
            "move the walls, or correct packing.units; packing.up rotates all axes of the file "
            '(with "z", y changes its sign)'
        )
        key = "bottom" if letter == "z" else letter
        errors.add(
            f"packing.enclosure.{key}", Mismatch(found, "all centres between the walls", remedy)
        )
        return


def check_cylinders(case: Case, errors: ErrorList) -> None:
    """Reject features that only spheres support, and cylinders that are oblique to
    walls.
    """
    packed = case.packing.grains
    shapes = [case.packing.of_grain] if packed is None else list(dict.fromkeys(packed.shape))
    cylinders = [one for one in shapes if one is not None]
    if not cylinders:
        return
    given = case.contact.initial_overlap
    path = "the path of an earlier run's result.h5"
    errors.check(
        (
            case.boundary.sides_tube,
            "boundary.sides.tube",
            Mismatch("with cylinders", remedy="a tube can only hold spheres"),
        ),
        (case.bar, "bar", Mismatch("with cylinders", remedy="a bar can only touch spheres")),
        (
            case.incident_bar,
            "incident_bar",
            Mismatch("with cylinders", remedy="a bar can only touch spheres"),
        ),
        (
            case.packing.tilt,
            "packing.tilt",
            Mismatch("with cylinders", remedy="cylinders do not roll on a tilted floor"),
        ),
        (
            given and not isinstance(given, str),
            "contact.initial_overlap",
            Mismatch("with cylinders", path),
        ),
    )
    planes = [letter for letter in "xy" if case.boundary.has_planes(letter)]
    if case.boundary.bottom_rule.has_plane:
        planes.append("z")
    for shape in cylinders:
        for letter in planes:
            if _OBLIQUE < abs(shape.axis["xyz".index(letter)]) < 1 - _OBLIQUE:
                axis = show(list(shape.axis))
                found = f"cylinders along {axis}, oblique to the {letter} walls"
                fault = Mismatch(found, "an axis parallel or normal to the wall")
                if packed is None:
                    errors.add("packing.axis", fault)
                else:
                    _add(errors, packed, [packed.shape.index(shape) + 1], fault)
    for one, other in combinations(cylinders, 2):
        if packed is not None and cylinder_pair(one, other).nearly_parallel:
            axes = f"{show(list(one.axis))} and {show(list(other.axis))}"
            found = f"cylinders along {axes}, which are nearly parallel"
            fault = Mismatch(found, "parallel axes, or an angle of 1 degree or more")
            _add(errors, packed, [packed.shape.index(other) + 1], fault)
            return


def _add(errors: ErrorList, grains: Grains, ids: Sequence[int], fault: str | Mismatch) -> None:
    """Add an error about grains, under the key and the file of the grains."""
    key = grains.key(*ids)
    errors.add(key, f"{grains.file}: {fault}" if key == "packing.file" else fault)


def _add_pair(
    errors: ErrorList, grains: Grains, pair: Sequence[int], message: str, n_pairs: int = 1
) -> None:
    """Add an error of two grains; ``{}`` in the message stands for the number of more such
    pairs.
    """
    more = f" (and {n_pairs - 1} more pairs)" if n_pairs > 1 else ""
    first, second = map(grains.called, pair)
    _add(errors, grains, pair, f"found grains {first} and {second}{message.format(more)}")


def check_loaded(case: Case, errors: ErrorList) -> None:
    """Check that grains of a file move if they are the load; another load replaces the velocities
    of the grains that it acts on.
    """
    grains = case.packing.grains
    load = case.load
    found = show(load.kind)
    if grains is None:
        fault = Mismatch(f"{found} with packing.kind = {show(case.packing.kind)}", 'it with "file"')
        errors.check((load.moves_grains, "load.kind", fault))
        return
    fault = Mismatch(f"{found}, but no grain has a velocity", remedy="add columns vx, vy, vz")
    errors.check((load.moves_grains and not grains.velocity.any(), "load.kind", fault))


def check_held(case: Case, errors: ErrorList) -> None:
    """Check the grains of ``[[hold]]`` and ``[[guide]]``."""
    grains = case.packing.grains
    n = case.packing.n_spheres
    groups = sorted(set(grains.group) - {""}) if grains is not None else []
    there = f"one of {', '.join(map(show, groups))}" if groups else "index: no grain has a group"
    for key, hold in case.held.items():
        of_group = hold.group is not None and hold.group not in groups
        if (
            of_group
            and hold.index is None
            and any(item.key.startswith(_PLACED) for item in errors.items)
        ):
            continue  # grains of the group could not be placed; this is reported separately
        fits = errors.check_first(
            (
                (hold.index is None) == (hold.group is None),
                key,
                Mismatch(
                    f"{'both index and group' if hold.index else 'neither index nor group'}",
                    "one of them",
                ),
            ),
            (of_group, f"{key}.group", Mismatch(show(hold.group), there)),
        )
        if not fits or max(hold.index or (0,)) > n:
            continue
        errors.check(
            (
                not hold.axes and not hold.rotation,
                key,
                "blocks no motion; set directions, or rotation = true",
            )
        )
        rows = np.array(hold.index or (grains.of_group(hold.group or "") if grains else ())) - 1
        moving = {
            letter: rows[grains.velocity[rows, "xyz".index(letter)] != 0]
            for letter in hold.axes
            if grains
        }
        errors.check_first(
            *(
                (
                    len(there),
                    key,
                    f"holds grain {there[0] + 1} along {letter}, but the file gives it a velocity "
                    'in this direction; packing.velocities = "drop" ignores the velocities of '
                    "the file",
                )
                for letter, there in moving.items()
                if len(there)
            ),
        )


def check_touched(case: Case, errors: ErrorList) -> bool:
    """Check that side walls that act only on some grains find these grains, and that there are such
    walls.

    Return False if walls would act on no grain, so that their position is undefined.
    """
    boundary = case.boundary
    key = "boundary.sides_touch"
    if boundary.sides_touch is None or errors.items:
        return True
    if boundary.sides_tube is None and not any(boundary.has_planes(axis) for axis in "xy"):
        errors.add(
            key,
            Mismatch(
                "this key without walls",
                remedy='set x, y or sides to "wall", or sides = {tube = ...}',
            ),
        )
        return True
    grains = case.packing.grains
    sites = sites_of(case, layout_of(case.packing, case.boundary))
    used = dict.fromkeys(sites.bodies[k][0] for k in np.unique(sites.body[sites.present]))
    known = {
        "material": sorted({str(material.name) for material in used if material.name}),
        "group": sorted(set(grains.group) - {""}) if grains is not None else [],
    }
    for what, names in known.items():
        there = f"one of {', '.join(map(show, names))}" if names else f"none: no grain has a {what}"
        errors.check(
            *(
                (name not in names, f"{key}.{what}", Mismatch(show(name), there))
                for name in getattr(boundary.sides_touch, what)
            )
        )
    return bool(touched(case, sites, boundary.sides_touch).any())


def check_tube(case: Case, errors: ErrorList) -> None:
    """Check that the packing fits into its tube before it shrinks, and each grain afterwards."""
    tube = case.boundary.sides_tube
    if tube is None or errors.items:
        return
    lattice = layout_of(case.packing, case.boundary)
    sites = sites_of(case, lattice)
    place = sites.positions(1, lattice.n_spheres)
    reach = np.hypot(place[:, 0], place[:, 1]) + sites.diameter / 2
    if case.boundary.sides_touch is not None:
        reach[~touched(case, sites, case.boundary.sides_touch)] = 0.0
    reach[~sites.present] = 0.0
    widest = int(np.argmax(reach))
    stage = case.precompression
    slack = TOUCHING * lattice.diameter
    if stage is not None and stage.takes_overlaps:
        slack = LARGEST * float(sites.diameter[widest]) / 2
    if reach[widest] > tube + slack:
        errors.add(
            "boundary.sides.tube.radius",
            Mismatch(
                f"{tube:g} m, but sphere {widest + 1} reaches {reach[widest]:.9g} m "
                "from the axis x = y = 0"
            ),
        )
    if stage is None:
        return
    radius = np.where(reach > 0, sites.diameter / 2, 0.0)
    largest = int(np.argmax(radius))
    room = tube - float(radius[largest]) - TOUCHING * lattice.diameter
    least = f"sphere {largest + 1} with a radius of {radius[largest]:.9g} m"
    errors.check(
        (
            0 < stage.moves.get("tube", 0.0) >= room,
            "precompression.tube",
            Mismatch(
                f"{stage.moves.get('tube', 0.0):g} m, which would make a tube of {tube:.9g} m "
                f"narrower than {least}",
                remedy="use a wider tube, or a smaller distance",
            ),
        ),
        (
            "tube" in stage.presses and room <= 0,
            "precompression.tube_force",
            Mismatch(
                f"a tube of {tube:.9g} m that shrinks, but is not wider than {least}",
                remedy="use a wider tube",
            ),
        ),
    )


def check_lines(assembly: Assembly, errors: ErrorList) -> None:
    """Check names, ids and grains of the lines of a case."""
    lines = numbered("line", assembly.case.line)
    errors.check_names(lines)
    for key, line in lines.items():
        index = line.index if isinstance(line.index, tuple) else ()
        named = [("index", one) for one in index] + (
            [("start", line.start)] if line.start is not None else []
        )
        vacant = np.setdiff1d([one for _, one in named], assembly.ids)
        fits = errors.check_first(
            (
                line.index is not None and line.start is not None,
                f"{key}.index",
                Mismatch("together with start", remedy="specify only one of them"),
            ),
            *(
                (
                    one in vacant,
                    f"{key}.{name}",
                    Mismatch(f"{one}, a vacant site", "an existing grain"),
                )
                for name, one in named
            ),
            (
                len(set(index)) < len(index),
                f"{key}.index",
                Mismatch(show(list(index)), "each id once"),
            ),
        )
        if fits and (found := len(line_ids(assembly, line))) < 2:
            grains = f"{found} grain{'' if found == 1 else 's'}"
            remedy = "change direction or start, or list the ids in index"
            fault = Mismatch(f"{grains} along {show(list(line.direction))}", "two or more", remedy)
            errors.add(key, fault)
