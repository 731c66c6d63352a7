"""Unit cells of the packings that are endless: lattices, chains, grains of a file with a cell.

A lattice of like spheres has its primitive cell, whatever its size and boundaries in the case are:
it stands for the inside of the packing. A chain has the shortest sequence of beads that it repeats.
Packings with disorder, and chains that repeat nothing, are their own cell where the case makes them
endless (``boundary.bottom = "periodic"``), and so are the grains of a file with ``packing.cell``.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.waves.spectra.bodies import Bodies
from granwave.extensions.waves.spectra.network import Array, Ints
from granwave.extensions.waves.spectra.pair_laws import PairLaws
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.walls import Wall, pressed_walls, touched_by, walls
from granwave.lammps_inputs.packing_kind import TOUCHING, PackingKind

# 1 minus the cosine of the angle between an axis and x, y or z up to which it counts as along it
_ALONG = 1e-9
_NO_GRAVITY = "gravity, which differs from layer to layer; granwave modes takes such a packing"


class UnitCell(NamedTuple):
    """Rows of the packing that make a unit cell, (n,), and the vectors after which it repeats,
    (n_periods, 3), m.
    """

    rows: Ints
    periods: Array


def primitive_vectors(kind: PackingKind) -> tuple[Array, int]:
    """Return the primitive vectors of a lattice, in diameters, and the number of spheres of the
    cell.

    Along the axes that it has; the spheres are those of the first sites of successive layers. Where
    the supports of a sphere are three lattice vectors, they are taken: the standard names of
    directions then fit the load along z.
    """
    found, n = _repeats(kind)
    primitive = n == 1 and len(kind.supports) == len(found) == 3
    return np.array(kind.supports if primitive else found), n


def vectors_of_layer(kind: PackingKind) -> Array:
    """Return the primitive vectors of a layer of a lattice, in diameters: (1 or 2, 3)."""
    found, _ = _repeats(kind)
    return np.array(found[: len(found) - ("z" in kind.axes)])


def _repeats(kind: PackingKind) -> tuple[list[Array], int]:
    """Shortest vectors along a row, to an equal row and to an equal layer, and the layers before
    that one.
    """

    def site(i: int, j: int, k: int) -> Array:
        return np.array([float(one) for one in kind.site(*(np.asarray(n) for n in (i, j, k)))])

    def around(j: int, k: int) -> set[tuple[float, ...]]:
        base = (6, 6 + j, 6 + k)
        here = site(*base)
        steps = itertools.product(range(-3, 4), range(-2, 3), range(-1, 2))
        places = (site(*(a + b for a, b in zip(base, step, strict=True))) - here for step in steps)
        return {
            tuple(np.round(one, 6) + 0.0)
            for one in places
            if abs(np.linalg.norm(one) - 1) < TOUCHING
        }

    origin = site(0, 0, 0)
    own = around(0, 0)
    found = []
    n = 1
    if "x" in kind.axes:
        found.append(site(1, 0, 0) - origin)
    if "y" in kind.axes:
        found.append(site(0, next(j for j in (1, 2) if around(j, 0) == own), 0) - origin)
    if "z" in kind.axes:
        n = next(k for k in range(1, kind.layer_period + 1) if around(0, k) == own)
        found.append(site(0, 0, n) - origin)
    return found, n


def unit_cell(assembly: Assembly) -> UnitCell:
    """Return the unit cell of a packing.

    Raises
    ------
    InputError
        The packing does not repeat.
    """
    case = assembly.case
    lattice = assembly.lattice
    n = lattice.n_spheres
    if assembly.bars:
        raise InputError(
            f"{case.name}: {assembly.bars[0].name}: found an elastic bar, which does not repeat"
        )
    endless = case.boundary.bottom_rule.repeats
    if not isinstance(lattice, Lattice):
        if case.packing.cell is None:
            raise InputError(
                f"{case.name}: packing.cell: missing; the grains of a file repeat if it gives the vectors after which "
                "they do (extxyz: Lattice and pbc), or the case does: packing.cell = [[0, 0, 0.01]]"
            )
        return UnitCell(np.arange(n), np.array(case.packing.cell))
    if lattice.rule.is_chain:
        period = 1
        length = lattice.diameter
        if not assembly.sites.uniform:
            if not assembly.sites.present.all():
                raise InputError(
                    f"{case.name}: packing.vacancies: found a chain with gaps, which bears no load"
                )
            period = assembly.sites.period_of_chain(whole=endless) or n
            length = float(assembly.sites.nominal[:period].sum())
            if period == n and not endless:
                raise InputError(
                    f"{case.name}: packing: found {n} beads that repeat no sequence, expected a chain that does; with "
                    'boundary.bottom = "periodic" the whole chain is the unit cell'
                )
        start = (
            period * (n // (2 * period)) if holds_some(case) else 0
        )  # in the middle, where some beads are held
        start = start if start + period <= n else 0
        return UnitCell(np.arange(start, start + period), np.array([[0.0, 0.0, length]]))
    if assembly.sites.uniform and not holds_some(case):
        vectors, spheres = primitive_vectors(lattice.rule)
        nx, ny, nz = lattice.shape
        if nz < spheres and not endless:
            raise InputError(
                f"{case.name}: packing.size: found {nz} layers, expected at least {spheres}, those of a unit cell"
            )
        return UnitCell(np.arange(spheres) * nx * ny, vectors * lattice.diameter)
    if not endless and not ("z" not in lattice.rule.axes and lattice.periodic):
        what = (
            "grains that are held"
            if assembly.sites.uniform
            else "spheres that differ, or vacancies"
        )
        raise InputError(
            f"{case.name}: packing: found {what}, which repeat nowhere, expected a packing that does; with "
            'boundary.sides = "periodic" and boundary.bottom = "periodic" the whole packing is the unit cell, and with '
            "--slab it ends above and below"
        )
    nx, ny, nz = lattice.shape
    if nz % lattice.rule.layer_period and "z" in lattice.rule.axes:
        raise InputError(
            f"{case.name}: packing.size: found {nz} layers, expected a multiple of {lattice.rule.layer_period} for an "
            f"endless {lattice.kind}"
        )
    periods = np.diag([*lattice.lengths, nz * lattice.rule.layer_spacing * lattice.diameter])
    return UnitCell(
        np.arange(assembly.sites.count), periods[[axis in lattice.rule.axes for axis in "xyz"]]
    )


def holds_some(case: Case) -> bool:
    """Return True if some grains are held or guided, and others not."""
    return any(
        hold.axes and len(held_ids(case, hold)) < math.prod(case.packing.size)
        for hold in case.holds.values()
    )


def cell_bodies(assembly: Assembly) -> Bodies:
    """Return the grains of the unit cell of a packing, with their loads.

    Raises
    ------
    InputError
        The packing does not repeat, or its load is not the same everywhere, or there is none.
    """
    case = assembly.case
    cell = unit_cell(assembly)
    stage = case.precompression
    if stage is None:
        raise InputError(
            f"{case.name}: precompression: missing; contacts that only touch have no stiffness, so that there are no "
            'waves of small amplitude: give a static load, such as [precompression] kind = "uniaxial" with a force'
        )
    if stage.rule.grows_with_depth:
        raise InputError(f"{case.name}: precompression.kind: found {_NO_GRAVITY}")
    base = packing_bodies(assembly).part(cell.rows, cell.periods)
    planes = walls_along(base.walls, cell.periods)
    names = {wall.name for wall in planes}
    if lost := [pressed for pressed in base.presses if not names.issuperset(pressed)]:
        raise InputError(
            f"{case.name}: precompression.{lost[0][0].removesuffix('lo')}_force: found walls across "
            "a direction in which the packing repeats; expected a direction in which it ends"
        )
    of_file = not isinstance(assembly.lattice, Lattice)
    part = len(cell.rows) / np.count_nonzero(assembly.sites.present)
    bodies = dataclasses.replace(
        base,
        walls=planes,
        presses={names: force * part for names, force in base.presses.items()},
        stress=_stress(assembly, cell),
        moves=base.moves & moving(assembly.lattice.rule.axes or "xyz", case),
    )
    if not of_file:
        return bodies
    # grains of a file may overlap each other, or images of each other
    shortest = float(np.linalg.norm(bodies.periods, axis=1).min())
    largest = float(bodies.radius.max())
    if not bodies.laws.has_cylinders and 2 * largest - shortest > LARGEST * largest / 2:
        raise InputError(
            f"{case.name}: packing.cell: found a period of {shortest:.3g} m, shorter than a grain with a "
            f"diameter of {2 * largest:.3g} m, which its own image would lie in; give larger periods (m)"
        )
    near = bodies.near(bodies.position, bodies.periods, 0.0)
    share = np.where(near.second >= 0, near.overlap * (1 / near.radii).sum(axis=1), 0.0)
    if share.max(initial=0.0) <= LARGEST:
        return bodies
    worst = int(np.argmax(share))
    i = bodies.ids[near.first[worst]]
    j = bodies.ids[near.second[worst]]
    of = "an image of " * bool(near.image[worst].any())
    raise InputError(
        f"{case.name}: packing.cell: found grain {i} in {of}grain {j}: they overlap by "
        f"{near.overlap[worst]:.3g} m, expected at most {LARGEST} R*; give larger periods (m), or other places"
    )


def walls_along(around: Iterable[Wall], periods: Array) -> tuple[Wall, ...]:
    """Return the walls that an endless packing with these periods has: those that do not cut it."""
    cut = np.abs(periods).max(axis=0) > 0
    return tuple(wall for wall in around if wall.is_side and (wall.tube or not cut[wall.axis]))


def packing_bodies(assembly: Assembly) -> Bodies:
    """Return the spheres of a packing, without strikers and without dead loads, in the order of
    their ids.

    Raises
    ------
    InputError
        There is friction, and the axis of a cylinder is not along x, y or z; or a holder rubs.
    """
    case = assembly.case
    if case.has_holder_friction:
        raise InputError(
            f"{case.name}: boundary.holder_friction: found {case.boundary.holder_friction:g}, "
            "expected 0: friction of the holder keeps beads in place in small motions"
        )
    sites = assembly.sites
    inside = assembly.ids <= assembly.lattice.n_spheres
    ids = assembly.ids[inside]
    there, kind = np.unique(sites.body[sites.present], return_inverse=True)
    kinds = [sites.bodies[number] for number in there.tolist()]
    kind = kind.astype(np.int64)
    lacking = np.zeros((len(kinds), 6), dtype=bool)  # cylinders turn about their axis alone
    for row, (_, shape) in enumerate(kinds):
        if shape is not None:
            along = np.abs(shape.vector) > 1 - _ALONG
            if case.has_friction and not along.any():
                raise InputError(
                    f"{case.name}: found cylinders along {show(list(shape.axis))} that turn by friction, expected an "
                    "axis along x, y or z, or contact.friction = 0"
                )
            lacking[row, 3:] = ~along
    held = lacking[kind]
    for entry in case.holds.values():
        chosen = np.searchsorted(ids, np.array(held_ids(case, entry), dtype=np.int64))
        for axis in entry.axes:
            held[chosen, "xyz".index(axis)] = True
        if entry.rotation:
            held[chosen, 3:] = True
    position = assembly.positions()[inside]
    around = walls(assembly)
    stage = case.precompression
    presses = {
        tuple(wall.name for wall in pressed): len(pressed) * stage.presses[name]
        for name, pressed in pressed_walls(assembly).items()
    } if stage else {}  # fmt: skip
    acts = {wall.name: touched_by(assembly, wall) for wall in around}
    return Bodies(
        assembly, PairLaws(case, tuple(kinds)), ids, position,
        assembly.sphere_diameters()[inside] / 2, assembly.sphere_masses()[inside], kind, ~held & moving("xyz", case), np.empty((0, 3)), around,
        np.zeros_like(position), touched={name: one[ids - 1] for name, one in acts.items() if one is not None},
        presses=presses,
    )  # fmt: skip


def moving(directions: str, case: Case) -> NDArray[np.bool_]:
    """Degrees of freedom: those directions; with friction, rotations that contacts along them
    resist.
    """
    there = [axis in directions for axis in "xyz"]
    turns = [case.has_friction and sum(there) - there[axis] > 1 for axis in range(3)]
    return np.array([there + turns])


def _stress(assembly: Assembly, cell: UnitCell) -> dict[tuple[int, int], float]:
    """Return the load on the cell for each strain that is free, N m; see `Bodies`."""
    case = assembly.case
    stage = assembly.case.precompression
    lattice = assembly.lattice
    assert stage is not None
    lengths = np.abs(cell.periods).max(axis=0)
    row = len(cell.periods) == 1
    along_z = float(lengths[2])
    force = stage.force
    uniaxial = stage.rule.on_top
    fault = ""
    if stage.moves_walls:
        if force is not None and (not row or along_z == 0):
            fault = (f"force: found {force:g} N beside walls on a packing that does not repeat along z alone, expected "
                     "one that does")  # fmt: skip
    elif row and not uniaxial:
        fault = f'kind: found {show(stage.kind)} for a row, expected "uniaxial"'
    elif uniaxial and along_z == 0:
        fault = 'kind: found "uniaxial", but the packing ends along z'
    elif row and force is None:
        fault = "pressure: found a pressure on a row, expected a force (N)"
    elif uniaxial and not row and force is not None and not isinstance(lattice, Lattice):
        fault = (f"force: found {force:g} N on a packing that is endless across z, expected precompression.pressure "
                 "(Pa)")  # fmt: skip
    if fault:
        raise InputError(f"{case.name}: precompression.{fault}")
    if stage.moves_walls or row:
        return {} if force is None else {(2, 2): force * along_z}
    if uniaxial and force is not None:
        if (
            assembly.sites.uniform
        ):  # a force on each sphere of a layer, of which the cell has one in each of its layers
            spheres = len(cell.rows) if len(cell.periods) == 3 else 1
            return {(2, 2): force * spheres * lattice.rule.layer_spacing * case.packing.diameter}
        nx, ny, _ = lattice.shape
        return {(2, 2): force * nx * ny * along_z}
    volume = abs(float(np.linalg.det(cell.periods))) if len(cell.periods) == 3 else (
        float(np.linalg.norm(np.cross(*cell.periods))) * lattice.diameter
    )  # fmt: skip
    load = (stage.pressure or 0.0) * volume
    if uniaxial:
        return {(2, 2): load}
    axes = np.flatnonzero(lengths > 0).tolist()
    return {(axis, axis): load for axis in axes} | {
        pair: 0.0 for pair in itertools.combinations(axes, 2)
    }
