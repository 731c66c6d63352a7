"""Spheres that are struck, that move from the start, and that are held."""

from __future__ import annotations

import numpy as np

from granwave.lammps_inputs.case.bodies import Hold
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.struck_spheres import struck_spheres


def struck_of(assembly: Assembly) -> tuple[int, ...]:
    """Return the ids of the loaded spheres, the struck sphere first; for a load by strikers those that move."""
    case = assembly.case
    if case.load.index is not None:
        return case.load.index
    if case.load.hits_spheres:
        return struck_spheres(assembly.lattice, case.load.spheres)
    if case.load.kind == "plate":
        centre = struck_spheres(assembly.lattice, 1)
        return centre + tuple(one for one in assembly.lattice.top_layer.tolist() if one not in centre)
    if case.load.kind == "grains":
        return tuple(own_velocities(assembly))
    moving = [
        number for number, striker in enumerate(case.striker, start=assembly.lattice.n_spheres + 1) if striker.moves
    ]
    return tuple(moving)


def struck_site(assembly: Assembly) -> int | None:
    """Return the id of the struck sphere, or of the sphere that the first moving striker hits; None if none is."""
    struck = struck_of(assembly)
    sphere = struck[0] if struck else None
    while sphere is not None and sphere > assembly.lattice.n_spheres:
        sphere = assembly.case.striker[sphere - assembly.lattice.n_spheres - 1].touches[0]
    return sphere


def velocities_of(assembly: Assembly) -> dict[int, tuple[float, float, float]]:
    """Return the initial velocities by id of the spheres that have one, m/s."""
    case = assembly.case
    found = own_velocities(assembly)
    if case.load.kind == "impact":
        found |= dict.fromkeys(struck_of(assembly), case.load.initial_velocity)
    for number, striker in enumerate(case.striker, start=assembly.lattice.n_spheres + 1):
        if striker.moves:
            found[number] = striker.velocity
    return found


def own_velocities(assembly: Assembly) -> dict[int, tuple[float, float, float]]:
    """Return the velocities of the grains of a file that have one, by id, the fastest first, m/s."""
    if not isinstance(assembly.lattice, Places):
        return {}
    velocity = assembly.lattice.grains.velocity
    speed = np.linalg.norm(velocity, axis=1)
    moving = np.argsort(-speed, kind="stable")[: np.count_nonzero(speed)]
    return {row + 1: tuple(velocity[row].tolist()) for row in moving.tolist()}


def held_ids(case: Case, hold: Hold) -> tuple[int, ...]:
    """Return the ids of the grains that an entry ``[[hold]]`` holds, in rising order."""
    if hold.index is not None:
        return tuple(sorted(set(hold.index)))
    return case.packing.grains.of_group(hold.group or "") if case.packing.grains is not None else ()
