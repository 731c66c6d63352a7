"""Static states for small waves: of a case, by Newton's method, or of a finished run, as its static
stage left it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from granwave.analysis.result.reader import Result
from granwave.analysis.spectra.bodies import Bodies, Contacts
from granwave.analysis.spectra.cells import (
    UnitCell,
    cell_bodies,
    holds_some,
    moving,
    packing_bodies,
    unit_cell,
    vectors_of_layer,
)
from granwave.analysis.spectra.network import Array, Ints, Network, Springs
from granwave.analysis.spectra.relax import relax
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.static_load import dead_loads
from granwave.lammps_inputs.deck.static_stage import largest_move
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.cylinders import distances
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import PLATE

_INSIDE = 0.5  # of half the packing, along axes that end: where a run is like an endless packing
_ALIKE = 0.02  # by which overlaps of equal contacts may differ inside
_PUSHED = 1e-4  # overlap with a striker over the largest one in the packing
_INTEGER = 1e-3  # of a period, for places of a lattice


@dataclasses.dataclass(frozen=True, eq=False)
class State:
    """Springs of a static state.

    Attributes
    ----------
    name
        Name of the case.
    case
        The case.
    network
        The springs.
    source
        ``case``, or ``run``.
    residual
        Largest net force on a grain over the largest contact force; NaN of a run.
    periods
        Periods under the load: (n_periods, 3), m.
    spread
        Largest difference of overlaps from their means in cells of a run, over the largest; 0 of a
        case.
    """

    name: str
    case: Case
    network: Network
    source: str
    residual: float
    periods: Array
    spread: float = 0.0


def cell_state(source: Case | Path, *, slab: bool = False) -> State:
    """Return the state of the unit cell of a case, or the mean one inside a finished run.

    Parameters
    ----------
    slab
        True for a packing that ends above and below, as the case says, and repeats sideways alone.

    Raises
    ------
    InputError
        The packing does not repeat, bears no load, or the state of the run is not the same
        everywhere.
    """
    if slab:
        return _slab_state(source)
    if isinstance(source, Case):
        found = relax(cell_bodies(source))
        return _state(source, found.network, "case", found.residual, found.periods)
    with Result(source) as result:
        return _mean_cell(result)


def packing_state(source: Case | Path, *, damped: bool = False) -> State:
    """Return the state of the whole packing of a case or of a finished run.

    Parameters
    ----------
    damped
        True where a damper at the bottom is taken into account; in the static state it is a wall.

    Raises
    ------
    InputError
        It bears no load, or has parts that are no springs between grains.
    """
    if isinstance(source, Case):
        assembly = assemble(source)
        _refuse_parts(assembly, damped=damped)
        return _in_own_cell(assembly, _whole(assembly))
    with Result(source) as result:
        _refuse_parts(result.assembly, damped=damped)
        left = _as_left(result)
        periods = left.bodies.periods
        return _state(result.case, left.network, "run", np.nan, periods)


def _state(
    case: Case, network: Network, source: str, residual: float, periods: Array, spread: float = 0.0
) -> State:
    """Return a state; raise InputError if no contact bears a force."""
    if not len(network.contacts):
        raise InputError(
            f"{case.name}: precompression: no contact bears a force, and a Hertz contact without load has no "
            "stiffness; give a static load that closes the contacts"
        )
    if not network.n_freedoms and len(network.left_out):
        raise InputError(
            f"{case.name}: precompression: no grain that can move bears a force; give a static load "
            "that closes their contacts"
        )
    return State(case.name, case, network, source, residual, periods, spread)


def _in_own_cell(assembly: Assembly, bodies: Bodies) -> State:
    """Return the state of grains in the cell that they have."""
    case = assembly.case
    if case.precompression is None:
        raise InputError(
            f"{case.name}: precompression: missing; contacts that only touch have no stiffness: give a static load"
        )
    found = relax(bodies)
    network = found.network
    _refuse_moved(assembly, network, found.position - bodies.position)
    if len(bodies.ids) == np.count_nonzero(assembly.sites.present):
        _refuse_pushed(assembly, network, found.position)
    return _state(case, network, "case", found.residual, found.periods)


def _slab_state(source: Case | Path) -> State:
    """Return the state of a column of a packing that repeats sideways, or of all of it where its
    grains differ.
    """
    found = source if isinstance(source, Case) else packing_state(source)
    case = found if isinstance(found, Case) else found.case
    assembly = assemble(case)
    _refuse_parts(assembly)
    bodies = _whole(assembly)
    if not len(bodies.periods):
        raise InputError(
            f'{case.name}: --slab: found a packing that does not repeat sideways, expected boundary.sides = "periodic" '
            "(of a lattice with layers, or of grains with packing.cell)"
        )
    if isinstance(found, State):
        return found
    lattice = assembly.lattice
    if isinstance(lattice, Lattice) and assembly.sites.uniform and not holds_some(case):
        nx, ny, nz = lattice.shape
        bodies = bodies.part(
            np.arange(nz) * nx * ny, vectors_of_layer(lattice.rule) * lattice.diameter
        )
    return _in_own_cell(assembly, bodies)


def _refuse_parts(assembly: Assembly, *, damped: bool = False) -> None:
    case = assembly.case
    support = case.boundary.bottom_support
    if assembly.bars:
        raise InputError(
            f"{case.name}: {assembly.bars[0].name}: found an elastic bar, expected grains and walls alone"
        )
    if support is not None and not (damped and support.kind == "damper"):
        raise InputError(
            f"{case.name}: boundary.bottom: found a {support.kind} that moves; expected a bottom that stays, or "
            "--end matched; granwave transmission takes a damper too"
        )
    if case.boundary.bottom == "periodic":
        raise InputError(
            f'{case.name}: boundary.bottom: found "periodic", expected an end ("wall", "fixed" or "free"); '
            "granwave bands without --slab takes endless packings"
        )
    _refuse_loads(assembly)


def _refuse_loads(assembly: Assembly) -> None:
    """Refuse loads on an endless packing for one that ends."""
    case = assembly.case
    stage = case.precompression
    if stage is None or not isinstance(assembly.lattice, Places):
        return
    if stage.pressure is not None:
        raise InputError(
            f"{case.name}: precompression.pressure: found for grains at places of their own, which "
            "have no face; give a force, or find the bands of the endless packing"
        )
    if stage.force is not None and not case.bears_along_z:
        raise InputError(
            f"{case.name}: precompression.force: found a force on the top, which nothing bears; "
            "hold a grain along z, give a boundary.bottom, or find the bands of the endless packing"
        )


def _whole(assembly: Assembly) -> Bodies:
    """Return all grains of a finite packing with their dead loads; those of a held layer do not
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
    if case.boundary.bottom == "fixed":
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


class _AsLeft(NamedTuple):
    """State in which the static stage of a run left the packing.

    Attributes
    ----------
    bodies
        Grains before the load, between walls in their final places.
    network
        Springs.
    peaks
        Function of `_peaks`.
    """

    bodies: Bodies
    network: Network
    peaks: Callable[[Contacts | Springs], Array]


def _as_left(result: Result) -> _AsLeft:
    """Return the state after the static stage of a run."""
    bodies = _whole(result.assembly)
    stage = result.case.precompression
    names = [f"prestage/moved_{name}" for name in (stage.presses if stage else ())]
    if missing := [name for name in names if name not in result]:
        raise InputError(
            f"{result.case.name}: {missing[0]}: missing in the results, so that the places of the "
            "walls are unknown; give the case"
        )
    bodies = bodies.with_walls_in(float(result[name][-1]) for name in names)
    peaks = _peaks(result, bodies.ids)
    position = bodies.position + result.frame(0, "displacement")[result.rows(bodies.ids)]
    network = bodies.network(position, bodies.periods, peaks)
    _refuse_pushed(result.assembly, network, position)
    return _AsLeft(bodies, network, peaks)


def _refuse_moved(assembly: Assembly, network: Network, displacement: Array) -> None:
    """Refuse a state that a static stage would not accept, since grains rearrange on the way.

    Parameters
    ----------
    displacement
        Of all grains: (n, 3), m.
    """
    case = assembly.case
    inside = np.isin(assembly.ids[: len(displacement)], network.ids)
    moved = float(np.linalg.norm(displacement[inside], axis=1).max(initial=0.0))
    most = largest_move(assembly)
    if moved > most:
        raise RunError(
            f"{case.name}: precompression: a grain moves by {moved / case.packing.diameter:.2g} "
            f"diameters, expected at most {most / case.packing.diameter:.2g}: the packing "
            "rearranges; confine it, or give a smaller load"
        )


def _refuse_pushed(assembly: Assembly, network: Network, position: Array) -> None:
    """Refuse a state in which grains press on a plate or on a striker, which nothing holds.

    Parameters
    ----------
    position
        Centres of the grains of the packing in the static state: (n, 3), m.
    """
    case = assembly.case
    on_plate = network.supports.wall == PLATE
    if on_plate.any():
        force = float(network.supports.force[on_plate].sum())
        raise InputError(
            f"{case.name}: load.kind: found a plate on which the packing presses with {force:.3g} N "
            "before the impact, and which nothing holds; give another load"
        )
    if not assembly.strikers:
        return
    centres = np.concatenate([position, [centre for _, centre in assembly.strikers]])
    diameter = assembly.sphere_diameters()
    grains = np.arange(len(position))
    shapes = assembly.grain_shapes()
    lattice = assembly.lattice
    period = lattice.lengths if lattice.periodic else None
    contacts = network.contacts
    deepest = float((contacts.force / contacts.stiffness).max(initial=0.0))
    for number in range(len(assembly.strikers)):
        row = len(position) + number
        striker = np.full(len(grains), row)
        apart = distances(centres, diameter, shapes, grains, striker, period)
        overlap = (diameter[grains] + diameter[row]) / 2 - apart
        if overlap.max() > _PUSHED * deepest:
            raise InputError(
                f"{case.name}: striker.{number + 1}: found a striker on which grain "
                f"{assembly.ids[np.argmax(overlap)]} presses before the impact, and which nothing "
                "holds; place it elsewhere, or give another load"
            )


def _peaks(result: Result, ids: Ints) -> Callable[[Contacts | Springs], Array]:
    """Return a function that gives the largest overlaps of contacts before the impact, given rows
    of these ids.
    """
    known = pd.Series(dtype=float)
    for group, names in (("contacts", ("i", "j")), ("wall_contacts", ("id", "wall"))):
        if f"{group}/initial_overlap" in result:
            keys = [result[f"{group}/{name}"] for name in names]
            keys = keys if group == "wall_contacts" else list(np.sort(np.stack(keys), axis=0))
            index = pd.MultiIndex.from_arrays([keys[0], keys[1].astype(str)])
            table = pd.Series(result[f"{group}/initial_overlap"], index)
            known = table if known.empty else pd.concat([known, table])

    def peaks(contacts: Contacts | Springs) -> Array:
        if known.empty:
            return np.zeros(len(contacts))
        low, high = np.sort([ids[contacts.first], ids[contacts.second]], axis=0)
        wall = contacts.second < 0
        partner = np.where(wall, contacts.wall, high.astype(str))
        index = pd.MultiIndex.from_arrays([np.where(wall, ids[contacts.first], low), partner])
        return known.reindex(index, fill_value=0.0).to_numpy()

    return peaks


def _mean_cell(result: Result) -> State:
    """Return the mean state of the unit cells inside a run."""
    case = result.case
    assembly = result.assembly
    cell = unit_cell(assembly)
    if not isinstance(assembly.lattice, Lattice):
        raise InputError(
            f"{case.name}: found a run of grains of a file, which ends; give the case, for its cell"
        )
    left = _as_left(result)
    bodies = left.bodies
    whole = left.network
    _state(case, whole, "run", np.nan, bodies.periods)  # bears forces
    basis, place = _places(bodies.position, bodies.position[cell.rows], cell)
    # grains far from the faces at which the packing ends
    low = bodies.position.min(axis=0)
    high = bodies.position.max(axis=0)
    ends = ~np.abs(bodies.periods).any(axis=0) if len(bodies.periods) else np.ones(3, dtype=bool)
    near_middle = (
        np.abs(bodies.position - (high + low) / 2)
        <= _INSIDE * (high - low) / 2 + 0.5 * bodies.spacing
    )
    inside = (near_middle | ~ends).all(axis=1)
    row = np.searchsorted(bodies.ids, whole.ids)
    first = row[whole.springs.first]
    second = row[whole.springs.second]
    springs = dataclasses.replace(whole.springs, first=first, second=second)
    kept = inside[first] & (basis[first] >= 0) & (basis[second] >= 0)
    jump = np.rint(springs.image @ bodies.periods @ np.linalg.pinv(cell.periods)).astype(np.int64)
    image = place[second] + jump - place[first]
    # each contact of the cell once, from its first grain
    leading = image[
        np.arange(len(image)), (image != 0).argmax(axis=1)
    ]  # first number other than zero
    swap = (basis[first] > basis[second]) | ((basis[first] == basis[second]) & (leading < 0))
    one = np.where(swap, basis[second], basis[first])
    other = np.where(swap, basis[first], basis[second])
    overlap = bodies.radius[first] + bodies.radius[second] - springs.distance
    sign = np.where(swap, -1, 1)[:, None]
    keys = ["first", "second", *(f"image{axis}" for axis in range(image.shape[1]))]
    table = pd.DataFrame(np.column_stack([one, other, sign * image]), columns=keys)
    table[["x", "y", "z"]] = sign * springs.normal * springs.distance[:, None]
    table["overlap"], table["peak"] = overlap, np.maximum(left.peaks(springs), overlap)
    cells = table[kept].groupby(keys)
    if not cells.ngroups:
        raise InputError(f"{case.name}: found no contact inside the packing; give a larger one")
    mean = cells.mean().reset_index()
    spread = float(
        (table["overlap"] - cells["overlap"].transform("mean")).abs().max() / mean["overlap"].max()
    )
    if spread > _ALIKE:
        raise InputError(
            f"{case.name}: found overlaps of equal contacts that differ by {100 * spread:.2g} % inside the run, "
            f"expected the same in every cell ({100 * _ALIKE:g} %); granwave modes and granwave transmission take such "
            "a packing"
        )
    moves = np.broadcast_to(bodies.moves.any(axis=0), (len(cell.rows), 6))
    unit = dataclasses.replace(
        bodies.part(cell.rows, cell.periods), moves=moves, walls=(), touched={}
    )
    i, j = (mean[name].to_numpy() for name in keys[:2])
    # the mean overlap, which the length of the mean vector differs from by rounding
    length = unit.radius[i] + unit.radius[j] - mean["overlap"].to_numpy()
    pairs, _ = unit.pairs(i, j, mean[keys[2:]].to_numpy(), mean[["x", "y", "z"]].to_numpy(), length)
    network = unit.with_springs(unit.springs(pairs, mean["peak"].to_numpy()))
    return _state(case, network, "run", np.nan, cell.periods, spread)


def _places(position: Array, basis: Array, cell: UnitCell) -> tuple[Ints, Ints]:
    """Grain of the cell that each grain is an image of, -1 for none, and the periods between: (n,),
    (n, n_periods).
    """
    inverse = np.linalg.pinv(cell.periods)
    which = np.full(len(position), -1, dtype=np.int64)
    place = np.zeros((len(position), len(cell.periods)), dtype=np.int64)
    size = float(np.linalg.norm(cell.periods, axis=1).max())
    for number, origin in enumerate(basis):
        numbers = np.rint((position - origin) @ inverse).astype(np.int64)
        away = np.linalg.norm(position - origin - numbers @ cell.periods, axis=1)
        here = away < _INTEGER * size
        which[here], place[here] = number, numbers[here]
    return which, place
