"""State of a settled bed from which a run continues: motion, plastic indentations and springs.

Contacts between spheres are found by their ids. A restart file does not contain the positions of
walls: each wall of the file is identified with the wall of the case that its spheres touch.

The complete history of contacts is used; history that the case does not support is a fault. A bed
with a static stage starts only with the tangential springs (`packing.springs`) of its present
contacts.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.packing.springs import ContactSpring, parse_springs
from granwave.lammps_inputs.errors import InputError, Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.cylinders import nearest_image
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.walls import Wall, wall_friction, walls
from granwave.lammps_inputs.restart_file import NO_CLUMPS, RestartSpheres, RestartWall, read_restart
from granwave.lammps_inputs.script_words import joined, num

KEY = "packing.restart"
_ROUNDING = 1e-12  # radii; smaller overlaps with a wall are rounding errors, as in LAMMPS
_INSIDE = 1 - 1e-6  # largest gap over the gap beyond which LAMMPS deletes a contact
_SAME_OVERLAP = 1e-6  # relative tolerance of overlaps with the same wall
_SAME_MASS = 1e-9  # relative tolerance of masses of the same spheres
_DEEP = 1e-3  # diameters; deeper overlaps are contacts, except within rigid bodies
_OTHER_STYLE = (
    "settle the bed with this pair style; or use only the positions of its grains: lmp "
    '-restart2data FILE FILE.data, and packing.kind = "file" with FILE.data'
)
_TITLE = (
    "# Contacts so far: spheres i and j, or a wall fix and a sphere; largest overlap, m;\n# "
    "force, N, and compliance, m/N, of the tangential spring on the first sphere; at walls the\n# "
    "position of the indentation, m; history of laws, damping and resistances\n"
)


@dataclasses.dataclass(frozen=True, eq=False)
class BedState:
    """State of the spheres of a restart file in a case.

    Attributes
    ----------
    spheres
        The spheres of the file.
    walls
        Walls of the file with the walls of the case that they are.
    faults
        Features that the case does not support, each with its key.
    """

    spheres: RestartSpheres
    walls: tuple[tuple[RestartWall, Wall], ...]
    faults: tuple[tuple[str, Mismatch], ...]


@kept_by_assembly
def bed_state(assembly: Assembly) -> BedState | None:
    """Return the state of the bed from which a case continues; None if there is none.

    Raises
    ------
    InputError
        The restart file cannot be read.
    """
    file = assembly.case.packing.restart
    if file is None:
        return None
    try:
        spheres = read_restart(Path(file))
    except (OSError, ValueError) as error:
        raise InputError(f"{assembly.case.name}: {KEY}: {file}: {error}") from None
    matches, faults = _walls_of(assembly, spheres)
    if spheres.contacts is None:
        faults = []  # walls of another style have no state in the file
    return BedState(spheres, tuple(matches), (*_faults_of_file(assembly, spheres), *faults))


def bed_velocities(assembly: Assembly) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return velocities and angular velocities of the spheres of a bed whose motion continues.

    Returns
    -------
    tuple
        (n, 3), m/s, and (n, 3), rad/s; None where all spheres start at rest.
    """
    state = bed_state(assembly)
    if state is None:
        return None
    return state.spheres.velocity, state.spheres.spin


def bed_table(assembly: Assembly) -> str:
    """Return the contacts of a bed as input of ``gran/dents read``.

    Raises
    ------
    InputError
        The restart file cannot be read.
    """
    state = bed_state(assembly)
    lines = list(_spring_lines(assembly))
    if state is not None:
        lines += [*_pair_lines(assembly, state), *_wall_lines(assembly, state)]
    return _TITLE + "".join(lines)


def _pair_lines(assembly: Assembly, state: BedState) -> Iterator[str]:
    """Yield the lines of contacts between spheres."""
    contacts = state.spheres.contacts
    if contacts is None:
        return
    case = assembly.case
    forgotten = case.boundary.forget_gap * case.packing.diameter * _INSIDE
    gaps = _gaps(assembly, contacts.pairs)
    for row in np.flatnonzero(gaps < forgotten).tolist():
        first, second = contacts.pairs[row].tolist()
        values = [float(contacts.peak[row]), *contacts.spring[row].tolist()]
        values += contacts.block[row].tolist()
        yield f"{first} {second} {joined(map(num, values))}\n"


def _gaps(assembly: Assembly, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the gaps between pairs of ids (n, 2) in the case, negative for overlaps: (n,), m."""
    lattice = assembly.lattice
    period = lattice.lengths if lattice.periodic else None
    position = assembly.positions()
    apart = nearest_image(position[pairs[:, 1] - 1] - position[pairs[:, 0] - 1], period)
    radii = assembly.sphere_diameters()[pairs - 1].sum(axis=1) / 2
    return np.asarray(np.linalg.norm(apart, axis=1) - radii)


def _wall_lines(assembly: Assembly, state: BedState) -> Iterator[str]:
    """Yield the lines of contacts with walls."""
    n = len(state.spheres.radius)
    moved = assembly.positions()[:n] - assembly.deck_origin - state.spheres.position
    for of_file, wall in state.walls:
        along = _axes_along(wall)
        place = of_file.place
        if not wall.tube:
            place = place + moved[of_file.ids - 1][:, along]
        fixes = {material: name for name, _, material in wall.fixes}
        for row, sphere in enumerate(of_file.ids.tolist()):
            material = assembly.material_of(sphere)
            friction = wall_friction(assembly.case, wall, material) > 0
            springs = of_file.springs(friction=friction)[row]
            block = of_file.blocks(friction=friction)[row]
            values = [float(of_file.peak[row]), *springs.tolist()]
            values += [*place[row].tolist(), *block.tolist()]
            yield f"{fixes[material]} {sphere} {joined(map(num, values))}\n"


def _spring_lines(assembly: Assembly) -> Iterator[str]:
    """Yield the lines of springs of the case, for contacts that overlap and have friction."""
    case = assembly.case
    text = case.packing.springs
    if text is None or not case.has_friction:
        return
    springs = parse_springs(text)
    n = assembly.lattice.n_spheres
    pairs = [
        spring for spring in springs if spring.second <= n and not isinstance(spring.first, str)
    ]
    ids = np.array([(spring.first, spring.second) for spring in pairs], dtype=np.int64)
    gaps = _gaps(assembly, ids.reshape(-1, 2))
    for spring, gap in zip(pairs, gaps.tolist(), strict=True):
        if gap < 0:
            yield f"{spring.first} {spring.second} {_values(spring, -gap)}\n"
    there = {wall.name: wall for wall in walls(assembly) if not wall.held_layer}
    for spring in springs:
        wall = there.get(str(spring.first))
        if wall is not None and spring.second <= n:
            yield from _line_at_wall(assembly, spring, wall)


def _line_at_wall(assembly: Assembly, spring: ContactSpring, wall: Wall) -> Iterator[str]:
    """Yield the line of the spring of a sphere at a wall, if they overlap and have friction."""
    row = spring.second - 1
    position = assembly.positions()[row : row + 1]
    overlap = -float(wall.gaps(position, assembly.sphere_diameters()[row : row + 1] / 2)[0])
    material = assembly.material_of(spring.second)
    if overlap <= 0 or not wall_friction(assembly.case, wall, material):
        return
    fixes = {own: name for name, _, own in wall.fixes}
    place = [0.0, 0.0]
    if not wall.tube:
        along = _axes_along(wall)
        place = (position[0] - assembly.deck_origin)[along].tolist()
    values = f"{_values(spring, overlap)} {joined(map(num, place))}"
    yield f"{fixes[material]} {spring.second} {values}\n"


def _axes_along(wall: Wall) -> list[int]:
    """Return the axes along a plane, in the order of the positions of dents."""
    return [(wall.axis + 1) % 3, (wall.axis + 2) % 3]


def _values(spring: ContactSpring, overlap: float) -> str:
    """Return the overlap and the spring of a contact as words."""
    return joined(map(num, [overlap, *spring.force, spring.compliance]))


def _walls_of(
    assembly: Assembly, spheres: RestartSpheres
) -> tuple[list[tuple[RestartWall, Wall]], list[tuple[str, Mismatch]]]:
    """Return the walls of the case that match walls of the file, and the faults of the others."""
    n = len(spheres.radius)
    position = assembly.positions()[:n]
    radius = assembly.sphere_diameters()[:n] / 2
    there = [wall for wall in walls(assembly) if not wall.held_layer]
    overlaps = {wall.name: -wall.gaps(position, radius) for wall in there}
    untouched = {name: overlap > _ROUNDING * radius for name, overlap in overlaps.items()}
    matches = []
    faults = []
    for of_file in spheres.walls:
        rows = of_file.ids[of_file.touching] - 1
        fits = [wall for wall in there if _is_same(of_file, wall, overlaps[wall.name], radius)]
        if not fits:
            faults.append((KEY, _unknown_wall(of_file)))
            continue
        untouched[fits[0].name][rows] = False
        matches.append((of_file, fits[0]))
    for name, others in untouched.items():
        if others.any():
            first = 1 + int(np.argmax(others))
            text = f"sphere {first} in the wall {name}, which it does not touch in the file"
            remedy = "set packing.enclosure to the positions of the walls in the script"
            faults.append((KEY, Mismatch(text, "walls of the file", remedy)))
    return matches, faults


def _is_same(
    of_file: RestartWall,
    wall: Wall,
    overlap: NDArray[np.float64],
    radius: NDArray[np.float64],
) -> bool:
    """Return True if the spheres at a wall of the file have the same overlaps with a wall of the
    case.

    Parameters
    ----------
    overlap
        Overlaps of all spheres of the file with the wall of the case: (n,), m.
    radius
        Their radii: (n,), m.
    """
    rows = of_file.ids[of_file.touching] - 1
    sides = {-1: 0, 1: 1}
    if not len(rows) or sides[wall.outward] != of_file.side:
        return False
    slack = _ROUNDING * radius[rows]
    in_file = of_file.overlap[of_file.touching]  # the largest overlap of spheres between two walls
    as_deep = np.abs(overlap[rows] - in_file) <= _SAME_OVERLAP * in_file + slack
    return bool(as_deep.any() and (overlap[rows] > -slack).all())


def _unknown_wall(of_file: RestartWall) -> Mismatch:
    """Return the fault of a wall of the file without a counterpart in the case."""
    n_touching = int(of_file.touching.sum())
    if not n_touching:
        text = f"plastic indentations in the wall of fix {of_file.fix}, which no sphere touches"
        return Mismatch(
            text, remedy="end the script while spheres touch this wall, or remove the wall"
        )
    first = int(of_file.ids[of_file.touching][0])
    return Mismatch(
        f"{n_touching} spheres at the wall of fix {of_file.fix}, such as sphere {first}",
        "a wall of the case there",
        "define it in [boundary], with the position of the script in packing.enclosure",
    )


def _faults_of_file(assembly: Assembly, spheres: RestartSpheres) -> Iterator[tuple[str, Mismatch]]:
    """Iterate over the features of the file that the case does not support or sets differently."""
    case = assembly.case
    if spheres.contacts is None:
        found = "no contacts of pair_style gran/hysteretic"
        yield KEY, Mismatch(found, remedy=_OTHER_STYLE)
    pair = _rigid_pair(assembly, spheres)
    if pair is not None:
        found = f"spheres {pair[0]} and {pair[1]}, which overlap without a contact, as in a clump"
        yield KEY, Mismatch(found, "spheres that move independently", NO_CLUMPS)
    for name, style in spheres.other_walls:
        found = f"fix {name} of style {style}"
        yield KEY, Mismatch(found, "walls of style wall/gran/hysteretic")
    if case.boundary.bottom_support is not None:
        yield KEY, Mismatch("with a moving bottom", "a bottom at rest")
    if case.contact.initial_overlap:
        yield (
            KEY,
            Mismatch(
                "with contact.initial_overlap", remedy="the file contains the plastic indentations"
            ),
        )
    if spheres.walls and assembly.has_rate:
        yield KEY, Mismatch("walls of the file with a yield strength that depends on the rate")
    n = len(spheres.mass)
    masses = assembly.sphere_masses()[:n]
    worst = int(np.argmax(np.abs(spheres.mass / masses - 1)))
    if abs(spheres.mass[worst] / masses[worst] - 1) > _SAME_MASS:
        expected = f"{masses[worst]:.9g} kg by the density of the material"
        found = f"sphere {worst + 1} with a mass of {spheres.mass[worst]:.9g} kg"
        yield "material.density", Mismatch(found, expected)


def _rigid_pair(assembly: Assembly, spheres: RestartSpheres) -> tuple[int, int] | None:
    """Return the ids of two spheres of a rigid body of the file; None if there is none.

    Such spheres overlap and have no contact, as LAMMPS leaves out the contacts within bodies.
    Spheres that the case holds may overlap without a contact too, and spheres of a clump whose
    number is in the file.
    """
    if spheres.contacts is None:
        return None
    from scipy.spatial import cKDTree  # imported on demand: slow to load

    tree = cKDTree(spheres.position)
    near = tree.query_pairs(2 * float(spheres.radius.max()), output_type="ndarray")
    apart = np.linalg.norm(np.diff(spheres.position[near], axis=1)[:, 0], axis=1)
    reach = spheres.radius[near].sum(axis=1)
    deep = near[reach - apart > _DEEP * reach] + 1
    held = set[int]()
    for hold in assembly.case.holds.values():
        held.update(held_ids(assembly.case, hold))
    still = np.isin(deep, list(held)).all(axis=1)
    bodies = spheres.bodies[deep - 1]
    together = (bodies[:, 0] > 0) & (bodies[:, 0] == bodies[:, 1])
    contacts = set(map(tuple, spheres.contacts.pairs.tolist()))
    for pair in np.sort(deep[~still & ~together], axis=1).tolist():
        if tuple(pair) not in contacts:
            return pair[0], pair[1]
    return None
