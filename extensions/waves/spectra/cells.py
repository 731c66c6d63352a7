"""Unit cells of periodic packings: lattices, chains, and grains of a file with a cell.

The cell of a lattice of identical spheres is its primitive cell, whatever the size and the
boundaries of the packing in the case; it represents the inside of the packing. The cell of a chain
is the shortest sequence of beads that the chain repeats. A packing with disorder, or a chain that
repeats no sequence, is its own cell if the case makes it periodic (``boundary.bottom =
"periodic"``); so are the grains of a file with ``packing.cell``.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.precompression import Precompression
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.clumps import refuse_clumps
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.walls import Wall, refuse_region_walls
from granwave.lammps_inputs.packing_kind import TOUCHING, PackingKind
from granwave.lammps_inputs.statics.bodies import Array, Bodies, Ints
from granwave.lammps_inputs.statics.packing_bodies import moving, packing_bodies, turns_about

_ZZ = (2, 2)  # uniaxial strain along z
_NO_GRAVITY = "gravity, which varies from layer to layer; use granwave modes for this packing"


class UnitCell(NamedTuple):
    """Rows of a packing that make a unit cell, (n,), and its periods, (n_periods, 3), m."""

    rows: Ints
    periods: Array


def primitive_vectors(kind: PackingKind) -> tuple[Array, int]:
    """Return the primitive vectors of a lattice, in diameters, and the number of spheres of the
    cell.

    They lie along its axes; the spheres are on the first sites of successive layers. If the
    supports of a sphere are three lattice vectors, these are used: the standard names of directions
    then fit the load along z.
    """
    vectors, n = _repeats(kind)
    primitive = n == 1 and len(kind.supports) == len(vectors) == 3
    return np.array(kind.supports if primitive else vectors), n


def vectors_of_layer(kind: PackingKind) -> Array:
    """Return the primitive vectors of a layer of a lattice, in diameters: (1 or 2, 3)."""
    vectors, _ = _repeats(kind)
    return np.array(vectors[: len(vectors) - ("z" in kind.axes)])


def _repeats(kind: PackingKind) -> tuple[list[Array], int]:
    """Return the shortest vectors along a row, to an equal row and to an equal layer, and the
    number of layers up to this layer.
    """

    def site(i: int, j: int, k: int) -> Array:
        coordinates = kind.site(np.asarray(i), np.asarray(j), np.asarray(k))
        return np.array([float(coordinate) for coordinate in coordinates])

    def around(j: int, k: int) -> set[tuple[float, ...]]:
        """Return the vectors from a sphere in row j of layer k to its touching neighbours."""
        here = site(6, 6 + j, 6 + k)
        neighbours = set()
        for di, dj, dk in itertools.product(range(-3, 4), range(-2, 3), range(-1, 2)):
            vector = site(6 + di, 6 + j + dj, 6 + k + dk) - here
            if abs(np.linalg.norm(vector) - 1) < TOUCHING:
                neighbours.add(tuple(np.round(vector, 6) + 0.0))
        return neighbours

    origin = site(0, 0, 0)
    own = around(0, 0)
    repeats = []
    n = 1
    if "x" in kind.axes:
        repeats.append(site(1, 0, 0) - origin)
    if "y" in kind.axes:
        repeats.append(site(0, next(j for j in (1, 2) if around(j, 0) == own), 0) - origin)
    if "z" in kind.axes:
        n = next(k for k in range(1, kind.layer_period + 1) if around(0, k) == own)
        repeats.append(site(0, 0, n) - origin)
    return repeats, n


def unit_cell(assembly: Assembly) -> UnitCell:
    """Return the unit cell of a packing.

    Raises
    ------
    InputError
        The packing is not periodic.
    """
    case = assembly.case
    lattice = assembly.lattice
    if assembly.bars:
        raise InputError(
            f"{case.name}: {assembly.bars[0].name}: found an elastic bar, which is not periodic"
        )
    refuse_clumps(assembly)
    refuse_region_walls(case)
    if not isinstance(lattice, Lattice):
        if case.packing.cell is None:
            raise InputError(
                f"{case.name}: packing.cell: missing; the grains of a file require lattice "
                "vectors, in the file (extxyz: Lattice and pbc) or in the case: packing.cell = "
                "[[0, 0, 0.01]]"
            )
        return UnitCell(np.arange(lattice.n_spheres), np.array(case.packing.cell))
    if lattice.rule.is_chain:
        return _cell_of_chain(assembly, lattice)
    if assembly.sites.uniform and not holds_some(case):
        return _cell_of_crystal(case, lattice)
    return _whole_packing(assembly, lattice)


def _cell_of_chain(assembly: Assembly, lattice: Lattice) -> UnitCell:
    """Return the unit cell of a chain: its shortest sequence of beads."""
    case = assembly.case
    n = lattice.n_spheres
    endless = case.boundary.bottom_rule.repeats
    period = 1
    length = lattice.diameter
    if not assembly.sites.uniform:
        if not assembly.sites.present.all():
            raise InputError(
                f"{case.name}: packing.vacancies: found a chain with gaps, which cannot carry a load"
            )
        period = assembly.sites.period_of_chain(whole=endless) or n
        length = float(assembly.sites.nominal[:period].sum())
        if period == n and not endless:
            raise InputError(
                f"{case.name}: packing: found {n} beads without a repeated sequence, expected a "
                'periodic chain; with boundary.bottom = "periodic" the whole chain is the unit cell'
            )
    start = 0
    if holds_some(case):  # beads at the ends may be held, beads in the middle are not
        middle = period * (n // (2 * period))
        start = middle if middle + period <= n else 0
    return UnitCell(np.arange(start, start + period), np.array([[0.0, 0.0, length]]))


def _cell_of_crystal(case: Case, lattice: Lattice) -> UnitCell:
    """Return the primitive cell of a packing of identical spheres."""
    vectors, n_spheres = primitive_vectors(lattice.rule)
    nx, ny, nz = lattice.shape
    if nz < n_spheres and not case.boundary.bottom_rule.repeats:
        raise InputError(
            f"{case.name}: packing.size: found {nz} layers, expected at least {n_spheres}, the "
            "number of layers of a unit cell"
        )
    return UnitCell(np.arange(n_spheres) * nx * ny, vectors * lattice.diameter)


def _whole_packing(assembly: Assembly, lattice: Lattice) -> UnitCell:
    """Return the unit cell of a periodic packing of dissimilar or held spheres: the complete
    packing.
    """
    case = assembly.case
    rule = lattice.rule
    repeats_sideways = "z" not in rule.axes and lattice.periodic
    if not case.boundary.bottom_rule.repeats and not repeats_sideways:
        what = "dissimilar spheres, or vacancies"
        if assembly.sites.uniform:
            what = "fixed grains"
        raise InputError(
            f"{case.name}: packing: found {what}, which are not periodic, expected a periodic "
            'packing; with boundary.sides = "periodic" and boundary.bottom = "periodic" the whole '
            "packing is the unit cell, and --slab keeps its ends above and below"
        )
    nz = lattice.shape[2]
    if nz % rule.layer_period and "z" in rule.axes:
        raise InputError(
            f"{case.name}: packing.size: found {nz} layers, expected a multiple of "
            f"{rule.layer_period} for a periodic {lattice.kind}"
        )
    periods = np.diag([*lattice.lengths, nz * rule.layer_spacing * lattice.diameter])
    has_axis = [axis in rule.axes for axis in "xyz"]
    return UnitCell(np.arange(assembly.sites.count), periods[has_axis])


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
        The packing is not periodic, or has no load or a non-uniform load.
    """
    case = assembly.case
    cell = unit_cell(assembly)
    stage = case.precompression
    if stage is None:
        raise InputError(
            f"{case.name}: precompression: missing; contacts without force have no stiffness, so "
            "small waves do not exist: add a static load, such as [precompression] kind = "
            '"uniaxial" with a force'
        )
    if stage.rule.grows_with_depth:
        raise InputError(f"{case.name}: precompression.kind: found {_NO_GRAVITY}")
    base = wave_bodies(assembly).part(cell.rows, cell.periods)
    planes = walls_along(base.walls, cell.periods)
    names = {wall.name for wall in planes}
    for pressed in base.presses:
        if not names.issuperset(pressed):
            raise InputError(
                f"{case.name}: precompression.{pressed[0].removesuffix('lo')}_force: found walls "
                "in a periodic direction, expected a direction in which the packing ends"
            )
    part = len(cell.rows) / np.count_nonzero(assembly.sites.present)
    bodies = dataclasses.replace(
        base,
        walls=planes,
        presses={names: force * part for names, force in base.presses.items()},
        stress=_stress(assembly, cell),
        moves=base.moves & moving(assembly.lattice.rule.axes or "xyz", case),
    )
    if not isinstance(assembly.lattice, Lattice):
        _refuse_overlaps(bodies, case.name)
    return bodies


def _refuse_overlaps(bodies: Bodies, name: str) -> None:
    """Raise InputError if grains of a file overlap too far with each other, or with images."""
    shortest = float(np.linalg.norm(bodies.periods, axis=1).min())
    largest = float(bodies.radius.max())
    if not bodies.laws.has_cylinders and 2 * largest - shortest > LARGEST * largest / 2:
        raise InputError(
            f"{name}: packing.cell: found a period of {shortest:.3g} m, shorter than a grain with "
            f"a diameter of {2 * largest:.3g} m, so it would overlap its own image; use larger "
            "periods (m)"
        )
    near = bodies.near(bodies.position, bodies.periods, 0.0)
    relative = np.where(near.second >= 0, near.overlap * (1 / near.radii).sum(axis=1), 0.0)
    if relative.max(initial=0.0) <= LARGEST:
        return
    worst = int(np.argmax(relative))
    i = bodies.ids[near.first[worst]]
    j = bodies.ids[near.second[worst]]
    of = "an image of " if near.image[worst].any() else ""
    raise InputError(
        f"{name}: packing.cell: found grain {i} in {of}grain {j}: they overlap by "
        f"{near.overlap[worst]:.3g} m, expected at most {LARGEST} R*; use larger periods (m), or "
        "other positions"
    )


def walls_along(around: Iterable[Wall], periods: Array) -> tuple[Wall, ...]:
    """Return the walls along the periods of an infinite packing; there are no walls across them."""
    cut = np.abs(periods).max(axis=0) > 0
    return tuple(wall for wall in around if wall.is_side and (wall.tube or not cut[wall.axis]))


def wave_bodies(assembly: Assembly) -> Bodies:
    """Return the spheres of a packing, without strikers and dead loads.

    Raises
    ------
    InputError
        They do not act as springs between grains, see `refuse_resistance`.
    """
    refuse_resistance(assembly)
    return packing_bodies(assembly)


def refuse_resistance(assembly: Assembly) -> None:
    """Reject features that prevent linear small motions.

    Raises
    ------
    InputError
        A guide has friction, the axis of a cylinder with friction is not along x, y or z, or dents
        are from a file or given by regions.
    """
    case = assembly.case
    if case.has_holder_friction:
        raise InputError(
            f"{case.name}: boundary.holder_friction: found {case.boundary.holder_friction:g}, "
            "expected 0: friction of the guide prevents small motions of the beads"
        )
    sites = assembly.sites
    for number in np.unique(sites.body[sites.present]).tolist():
        _, shape = sites.bodies[number]
        if shape is not None and case.has_friction and not turns_about(shape).any():
            raise InputError(
                f"{case.name}: found cylinders along {show(list(shape.axis))} that rotate by "
                "friction, expected an axis along x, y or z, or contact.friction = 0"
            )
    overlap = case.contact.initial_overlap
    regions = overlap if isinstance(overlap, tuple) else ()
    if isinstance(overlap, str) or any(limit.low or limit.high for limit in regions):
        raise InputError(
            f"{case.name}: contact.initial_overlap: found non-uniform plastic indentations; run "
            "the case, and use the directory of the run"
        )


def _stress(assembly: Assembly, cell: UnitCell) -> dict[tuple[int, int], float]:
    """Return the load on the cell for each strain that is free, N m; see `Bodies`."""
    stage = assembly.case.precompression
    assert stage is not None
    fault = _fault_of_load(assembly, stage, cell)
    if fault:
        raise InputError(f"{assembly.case.name}: precompression.{fault}")
    lengths = np.abs(cell.periods).max(axis=0)
    if stage.moves_walls or len(cell.periods) == 1:
        return {} if stage.force is None else {_ZZ: stage.force * float(lengths[2])}
    if stage.rule.on_top and stage.force is not None:
        return {_ZZ: stage.force * _length_per_force(assembly, cell)}
    load = (stage.pressure or 0.0) * _volume(assembly, cell)
    if stage.rule.on_top:
        return {_ZZ: load}
    axes = np.flatnonzero(lengths > 0).tolist()
    loads = {(axis, axis): load for axis in axes}
    return loads | dict.fromkeys(itertools.combinations(axes, 2), 0.0)


def _fault_of_load(assembly: Assembly, stage: Precompression, cell: UnitCell) -> str:
    """Return the key and the expected value of an unsuitable load; empty for a suitable load."""
    is_row = len(cell.periods) == 1
    ends_along_z = not cell.periods[:, 2].any()
    force = stage.force
    uniaxial = stage.rule.on_top
    if stage.moves_walls:
        if force is not None and (not is_row or ends_along_z):
            return (
                f"force: found {force:g} N together with walls, expected a packing that is "
                "periodic only along z"
            )
        return ""
    if is_row and not uniaxial:
        return f'kind: found {show(stage.kind)} for a chain, expected "uniaxial"'
    if uniaxial and ends_along_z:
        return 'kind: found "uniaxial", but the packing ends along z'
    if is_row and force is None:
        return "pressure: found a pressure on a chain, expected a force (N)"
    is_file = not isinstance(assembly.lattice, Lattice)
    if uniaxial and not is_row and force is not None and is_file:
        return (
            f"force: found {force:g} N on a packing that is infinite perpendicular to z, expected "
            "precompression.pressure (Pa)"
        )
    return ""


def _length_per_force(assembly: Assembly, cell: UnitCell) -> float:
    """Return the load of a crystal's cell against uniaxial strain divided by the force on each
    sphere of a layer, m.
    """
    lattice = assembly.lattice
    if assembly.sites.uniform:  # the cell has a sphere in each of its layers
        n_layers = len(cell.rows) if len(cell.periods) == 3 else 1
        return float(n_layers * lattice.rule.layer_spacing * assembly.case.packing.diameter)
    nx, ny, _ = lattice.shape
    return nx * ny * float(np.abs(cell.periods[:, 2]).max())


def _volume(assembly: Assembly, cell: UnitCell) -> float:
    """Return the volume of a cell, m^3; with two periods, of a layer as thick as a diameter."""
    if len(cell.periods) == 3:
        return abs(float(np.linalg.det(cell.periods)))
    return float(np.linalg.norm(np.cross(*cell.periods))) * assembly.lattice.diameter
