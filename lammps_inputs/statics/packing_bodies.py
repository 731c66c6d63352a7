"""Grains of a packing for the search of its static state, with walls and loads."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Cylinder
from granwave.lammps_inputs.contact.static_load import dead_loads
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.walls import pressed_walls, touched_by, walls
from granwave.lammps_inputs.statics.bodies import Bodies
from granwave.lammps_inputs.statics.pair_laws import Body, PairLaws

_ALONG = 1e-9  # largest deviation of the cosine from 1 for a cylinder along x, y or z


def loaded_bodies(assembly: Assembly) -> Bodies:
    """Return all grains of a finite packing with their dead loads; grains of a held layer do not
    move.
    """
    case = assembly.case
    lattice = assembly.lattice
    bodies = packing_bodies(assembly)
    load = np.zeros_like(bodies.dead_load)
    if case.precompression is not None:
        ids, force = dead_loads(assembly)
        load[np.searchsorted(bodies.ids, ids)] = force
    moves = bodies.moves.copy()
    if case.boundary.bottom_rule.holds_layer:
        moves[np.isin(bodies.ids, lattice.last_layer)] = False
    axes = lattice.rule.axes or "xyz"
    periods = np.empty((0, 3))
    if lattice.periodic:
        across = [axis in axes for axis in "xy"]
        periods = np.diag([*lattice.lengths, 0.0])[:2][across]
    settling = [axis in axes or along.any() for axis, along in zip("xyz", load.T, strict=True)]
    return dataclasses.replace(
        bodies, dead_load=load, moves=moves & moving(axes, case), periods=periods,
        settles=moves[:, :3] & settling,
    )  # fmt: skip


def packing_bodies(assembly: Assembly) -> Bodies:
    """Return the grains of a packing in the order of their ids, without strikers and loads."""
    case = assembly.case
    sites = assembly.sites
    inside = assembly.ids <= assembly.lattice.n_spheres
    ids = assembly.ids[inside]
    numbers, kind = np.unique(sites.body[sites.present], return_inverse=True)
    kinds = [sites.bodies[number] for number in numbers.tolist()]
    kind = kind.astype(np.int64)
    fixed = _fixed_rotations(kinds)[kind]
    for entry in case.holds.values():
        chosen = np.searchsorted(ids, np.array(held_ids(case, entry), dtype=np.int64))
        for axis in entry.axes:
            fixed[chosen, "xyz".index(axis)] = True
        if entry.rotation:
            fixed[chosen, 3:] = True
    position = assembly.positions()[inside]
    around = walls(assembly)
    touched = {}
    for wall in around:
        rows = touched_by(assembly, wall)
        if rows is not None:
            touched[wall.name] = rows[ids - 1]
    return Bodies(
        assembly,
        PairLaws(case, tuple(kinds)),
        ids,
        position,
        radius=assembly.sphere_diameters()[inside] / 2,
        mass=assembly.sphere_masses()[inside],
        kind=kind,
        moves=~fixed & moving("xyz", case),
        periods=np.empty((0, 3)),
        walls=around,
        dead_load=np.zeros_like(position),
        touched=touched,
        presses=_presses(assembly),
    )


def _fixed_rotations(kinds: Sequence[Body]) -> NDArray[np.bool_]:
    """Return the directions in which kinds of grains cannot move: (n_kinds, 6).

    Cylinders turn about their axis only.
    """
    fixed = np.zeros((len(kinds), 6), dtype=bool)
    for row, (_, shape) in enumerate(kinds):
        if shape is not None:
            fixed[row, 3:] = ~turns_about(shape)
    return fixed


def turns_about(shape: Cylinder) -> NDArray[np.bool_]:
    """Return True for the axis x, y or z that a cylinder has and turns about: (3,)."""
    return np.asarray(np.abs(shape.vector) > 1 - _ALONG)


def _presses(assembly: Assembly) -> dict[tuple[str, ...], float]:
    """Return the forces that press walls on a packing, by the names of the walls, N."""
    stage = assembly.case.precompression
    if stage is None:
        return {}
    presses = {}
    for key, pressed in pressed_walls(assembly).items():
        names = tuple(wall.name for wall in pressed)
        presses[names] = len(pressed) * stage.presses[key]
    return presses


def moving(directions: str, case: Case) -> NDArray[np.bool_]:
    """Return True for the translations along these directions, and with friction for rotations
    that contacts along them resist: (1, 6).
    """
    translations = [axis in directions for axis in "xyz"]
    turns = [case.has_friction and sum(translations) - translations[axis] > 1 for axis in range(3)]
    return np.array([translations + turns])
