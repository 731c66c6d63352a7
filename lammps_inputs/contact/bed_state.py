"""State of a bed that was settled before, which a run goes on from: motion, dents and springs.

Contacts between spheres are found by their ids. A restart file does not tell where walls are: each
wall of the file is the wall of the case that its spheres touch.

A packing that starts as it is (`packing.contacts = "keep"`) takes all that its contacts remember,
and what the case has no place for is a fault. One that comes to balance first takes the frictional
springs alone, of the contacts that it still has.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.errors import InputError, Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.walls import Wall, wall_friction, walls
from granwave.lammps_inputs.restart_file import RestartSpheres, RestartWall, read_restart
from granwave.lammps_inputs.script_words import joined, num

KEY = "packing.restart"
_ROUNDING = 1e-12  # radii; smaller overlaps with a wall are rounding, as LAMMPS counts them
_INSIDE = 1 - 1e-6  # largest gap over the one beyond which LAMMPS forgets a contact
_SAME_MASS = 1e-9  # relative difference of masses of the same spheres
_TITLE = (
    "# Contacts so far: spheres i and j, or the fix of a wall and a sphere; largest overlap, m;\n"
    "# force, N, and compliance, m/N, of the tangential spring on the first sphere; at walls the\n"
    "# place of the dent, m; what laws, losses and resistances remember\n"
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
        What the case cannot take over, each with its key.
    """

    spheres: RestartSpheres
    walls: tuple[tuple[RestartWall, Wall], ...]
    faults: tuple[tuple[str, Mismatch], ...]


@kept_by_assembly
def bed_state(assembly: Assembly) -> BedState | None:
    """Return the state of the bed that a case goes on from; None if there is none.

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
    if assembly.case.packing.keeps_state:
        faults = [*_faults_of_file(assembly, spheres), *faults]
    else:
        faults = []
    return BedState(spheres, tuple(matches), tuple(faults))


def bed_velocities(assembly: Assembly) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return velocities and angular velocities of the spheres of a bed whose motion goes on.

    Returns
    -------
    tuple
        (n, 3), m/s, and (n, 3), rad/s; None where all spheres start at rest.
    """
    state = bed_state(assembly)
    if state is None or not assembly.case.packing.keeps_state:
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
    assert state is not None
    return _TITLE + "".join([*_pair_lines(assembly, state), *_wall_lines(assembly, state)])


def _pair_lines(assembly: Assembly, state: BedState) -> Iterator[str]:
    """Give the lines of contacts between spheres."""
    contacts = state.spheres.contacts
    if contacts is None:
        return
    whole = assembly.case.packing.keeps_state
    springs = contacts.spring
    if not (whole or assembly.case.has_friction):
        springs = np.zeros_like(springs)
    case = assembly.case
    forgotten = case.boundary.forget_gap * case.packing.diameter * _INSIDE
    gaps = _gaps(assembly, contacts.pairs)
    for row in np.flatnonzero(gaps < (forgotten if whole else 0.0)).tolist():
        first, second = contacts.pairs[row].tolist()
        values = [float(contacts.peak[row]), *springs[row].tolist()]
        values += contacts.block[row].tolist() if whole else []
        yield f"{first} {second} {joined(map(num, values))}\n"


def _gaps(assembly: Assembly, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the gaps between pairs of ids (n, 2) in the case, negative for overlaps: (n,), m."""
    lattice = assembly.lattice
    period = np.array([*lattice.lengths, np.inf]) if lattice.periodic else np.full(3, np.inf)
    position = assembly.positions()
    apart = position[pairs[:, 1] - 1] - position[pairs[:, 0] - 1]
    apart -= np.where(np.isfinite(period), np.round(apart / period) * period, 0.0)
    radii = assembly.sphere_diameters()[pairs - 1].sum(axis=1) / 2
    return np.asarray(np.linalg.norm(apart, axis=1) - radii)


def _wall_lines(assembly: Assembly, state: BedState) -> Iterator[str]:
    """Give the lines of contacts with walls."""
    whole = assembly.case.packing.keeps_state
    n = len(state.spheres.radius)
    moved = assembly.positions()[:n] - assembly.deck_origin - state.spheres.position
    for of_file, wall in state.walls:
        along = [axis for axis in range(3) if axis != wall.axis]
        place = of_file.place
        if not wall.tube:
            place = place + moved[of_file.ids - 1][:, along]
        fixes = {material: name for name, _, material in wall.fixes}
        for row, sphere in enumerate(of_file.ids.tolist()):
            material = assembly.material_of(sphere)
            friction = wall_friction(assembly.case, wall, material) > 0
            springs = of_file.springs(friction=friction or not whole)[row]
            if not (whole or friction):
                springs = np.zeros_like(springs)
            block = of_file.blocks(friction=friction)[row] if whole else np.zeros(0)
            values = [float(of_file.peak[row]), *springs.tolist()]
            values += [*place[row].tolist(), *block.tolist()]
            yield f"{fixes[material]} {sphere} {joined(map(num, values))}\n"


def _walls_of(
    assembly: Assembly, spheres: RestartSpheres
) -> tuple[list[tuple[RestartWall, Wall]], list[tuple[str, Mismatch]]]:
    """Return which walls of the file are which of the case, and the faults of others."""
    overlapping = _overlapping(assembly, len(spheres.radius))
    matches = []
    faults = []
    touched: dict[str, set[int]] = {name: set() for name in overlapping}
    there = {wall.name: wall for wall in walls(assembly) if not wall.held_layer}
    for of_file in spheres.walls:
        ids = set(of_file.ids[of_file.touching].tolist())
        able = [name for name, others in overlapping.items() if ids and ids <= others]
        if not able:
            faults.append((KEY, _unknown_wall(of_file, len(ids))))
            continue
        name = min(able, key=lambda name: len(overlapping[name]))
        touched[name] |= ids
        matches.append((of_file, there[name]))
    for name, ids in overlapping.items():
        if others := sorted(ids - touched[name]):
            text = f"sphere {others[0]} in the wall {name}, which it does not touch in the file"
            remedy = "give the places of the walls in packing.enclosure as the script has them"
            faults.append((KEY, Mismatch(text, "walls of the file", remedy)))
    return matches, faults


def _overlapping(assembly: Assembly, n: int) -> dict[str, set[int]]:
    """Return the ids of the first n spheres that overlap each wall, by the name of the wall."""
    position = assembly.positions()[:n]
    radius = assembly.sphere_diameters()[:n] / 2
    found = {}
    for wall in walls(assembly):
        if wall.held_layer:
            continue
        overlap = -wall.gaps(position, radius)
        found[wall.name] = set((1 + np.flatnonzero(overlap > _ROUNDING * radius)).tolist())
    return found


def _unknown_wall(of_file: RestartWall, n_touching: int) -> Mismatch:
    """Return the fault of a wall of the file that is none of the case."""
    if not n_touching:
        text = f"dents in the wall of fix {of_file.fix}, which no sphere touches"
        return Mismatch(text, remedy="let the script end while spheres touch it, or without it")
    first = int(of_file.ids[of_file.touching][0])
    return Mismatch(
        f"{n_touching} spheres at the wall of fix {of_file.fix}, such as sphere {first}",
        "a wall of the case there",
        "give it in [boundary], and its place in packing.enclosure as the script has it",
    )


def _faults_of_file(assembly: Assembly, spheres: RestartSpheres) -> Iterator[tuple[str, Mismatch]]:
    """Give what the file has and the case cannot take over, or has otherwise."""
    case = assembly.case
    if spheres.contacts is None:
        found = "no contacts of pair_style gran/hysteretic"
        yield KEY, Mismatch(found, remedy="settle the bed with this pair style")
    for name, style in spheres.other_walls:
        found = f"fix {name} of style {style}"
        yield KEY, Mismatch(found, "walls of style wall/gran/hysteretic")
    if case.boundary.bottom_support is not None:
        yield KEY, Mismatch("with a bottom that moves", "a bottom at rest")
    if case.contact.initial_overlap:
        yield KEY, Mismatch("with contact.initial_overlap", remedy="the file has the dents")
    if spheres.walls and assembly.has_rate:
        yield KEY, Mismatch("walls of the file with a yield strength that depends on the rate")
    n = len(spheres.mass)
    masses = assembly.sphere_masses()[:n]
    worst = int(np.argmax(np.abs(spheres.mass / masses - 1)))
    if abs(spheres.mass[worst] / masses[worst] - 1) > _SAME_MASS:
        expected = f"{masses[worst]:.9g} kg by the density of the material"
        found = f"sphere {worst + 1} with a mass of {spheres.mass[worst]:.9g} kg"
        yield "material.density", Mismatch(found, expected)
