"""Static states at the end of the static stages of runs: of the complete packing, and averaged over
its unit cells.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from granwave.analysis.result.reader import Result
from granwave.extensions.waves.spectra.cells import (
    UnitCell,
    unit_cell,
    walls_along,
    wave_bodies,
)
from granwave.extensions.waves.spectra.finite import refuse_pushed, whole
from granwave.extensions.waves.spectra.network import Network, Springs
from granwave.extensions.waves.spectra.packing_springs import (
    network_of,
    network_with,
    springs_of,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.statics.bodies import Array, Bodies, Ints, NeighbourPairs, joined
from granwave.lammps_inputs.statics.packing_bodies import moving

# fraction of half the packing, along finite axes: where a run resembles an infinite packing
_INSIDE = 0.5
_ALIKE = 0.02  # relative difference of overlaps of equal contacts inside
_MEANS = (
    "normal", "distance", "force", "stiffness", "tangential", "lever", "turns", "rolling", "twisting",
)  # fmt: skip
_INTEGER = 1e-3  # tolerance over a period, for positions of a lattice


class AsLeft(NamedTuple):
    """State in which the static stage of a run left the packing.

    Attributes
    ----------
    bodies
        Grains before the load, between walls in their final positions.
    network
        Springs.
    peaks
        Function of `_peaks`.
    """

    bodies: Bodies
    network: Network
    peaks: Callable[[NeighbourPairs | Springs], Array]


def as_left(result: Result) -> AsLeft:
    """Return the state after the static stage of a run."""
    bodies = whole(result.assembly)
    stage = result.case.precompression
    names = [f"prestage/moved_{name}" for name in (stage.presses if stage else ())]
    if missing := [name for name in names if name not in result]:
        raise InputError(
            f"{result.case.name}: {missing[0]}: missing in the results, so the positions of the "
            "walls are unknown; use the case"
        )
    bodies = bodies.with_walls_in(float(result[name][-1]) for name in names)
    peaks = _peaks(result, bodies.ids)
    position = bodies.position + result.frame(0, "displacement")[result.rows(bodies.ids)]
    network = network_of(bodies, position, bodies.periods, peaks)
    refuse_pushed(result.assembly, network, position)
    return AsLeft(bodies, network, peaks)


def _peaks(result: Result, ids: Ints) -> Callable[[NeighbourPairs | Springs], Array]:
    """Return a function of contacts that gives their largest overlaps before the impact; the rows
    of the grains have these ids.
    """
    initial_overlaps = pd.Series(dtype=float)
    for group, names in (("contacts", ("i", "j")), ("wall_contacts", ("id", "wall"))):
        if f"{group}/initial_overlap" in result:
            keys = [result[f"{group}/{name}"] for name in names]
            keys = keys if group == "wall_contacts" else list(np.sort(np.stack(keys), axis=0))
            index = pd.MultiIndex.from_arrays([keys[0], keys[1].astype(str)])
            table = pd.Series(result[f"{group}/initial_overlap"], index)
            initial_overlaps = (
                table if initial_overlaps.empty else pd.concat([initial_overlaps, table])
            )

    def peaks(contacts: NeighbourPairs | Springs) -> Array:
        if initial_overlaps.empty:
            return np.zeros(len(contacts))
        low, high = np.sort([ids[contacts.first], ids[contacts.second]], axis=0)
        wall = contacts.second < 0
        partner = np.where(wall, contacts.wall, high.astype(str))
        index = pd.MultiIndex.from_arrays([np.where(wall, ids[contacts.first], low), partner])
        return initial_overlaps.reindex(index, fill_value=0.0).to_numpy()

    return peaks


class MeanCell(NamedTuple):
    """Mean springs of the unit cells inside a run, and the largest difference of an overlap from
    its mean, divided by the largest overlap.
    """

    network: Network
    spread: float


def mean_cell(result: Result) -> MeanCell:
    """Return the mean state of the unit cells inside a run.

    Raises
    ------
    InputError
        The packing is not periodic, there is no contact inside, or the state differs between cells.
    """
    case = result.case
    assembly = result.assembly
    cell = unit_cell(assembly)
    if not isinstance(assembly.lattice, Lattice):
        raise InputError(
            f"{case.name}: found a run of grains of a file, which is finite; use the case, which "
            "defines the cell"
        )
    left = as_left(result)
    bodies = left.bodies
    network = left.network
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
    row = np.searchsorted(bodies.ids, network.ids)
    first = row[network.springs.first]
    second = row[network.springs.second]
    springs = dataclasses.replace(network.springs, first=first, second=second)
    kept = inside[first] & (basis[first] >= 0) & (basis[second] >= 0)
    jump = np.rint(springs.image @ bodies.periods @ np.linalg.pinv(cell.periods)).astype(np.int64)
    image = place[second] + jump - place[first]
    # each contact of the cell is counted once, from its first grain
    leading = image[
        np.arange(len(image)), (image != 0).argmax(axis=1)
    ]  # first number other than zero
    swap = (basis[first] > basis[second]) | ((basis[first] == basis[second]) & (leading < 0))
    origin = np.where(swap, basis[second], basis[first])
    target = np.where(swap, basis[first], basis[second])
    overlap = bodies.radius[first] + bodies.radius[second] - springs.distance
    sign = np.where(swap, -1, 1)[:, None]
    keys = ["first", "second", *(f"image{axis}" for axis in range(image.shape[1]))]
    table = pd.DataFrame(np.column_stack([origin, target, sign * image]), columns=keys)
    table[["x", "y", "z"]] = sign * springs.normal * springs.distance[:, None]
    table["overlap"] = overlap
    table["peak"] = np.maximum(left.peaks(springs), overlap)
    cells = table[kept].groupby(keys)
    if not cells.ngroups:
        raise InputError(f"{case.name}: found no contact inside the packing; use a larger packing")
    mean = cells.mean().reset_index()
    spread = float(
        (table["overlap"] - cells["overlap"].transform("mean")).abs().max() / mean["overlap"].max()
    )
    if spread > _ALIKE:
        raise InputError(
            f"{case.name}: found overlaps of equal contacts that differ by {100 * spread:.2g} % "
            f"inside the run, expected equal overlaps in every cell (within {100 * _ALIKE:g} %); "
            "use granwave modes or granwave transmission for this packing"
        )
    grains = wave_bodies(assembly).part(cell.rows, cell.periods)
    moves = grains.moves & moving(assembly.lattice.rule.axes or "xyz", case)
    unit = dataclasses.replace(grains, moves=moves, walls=(), touched={}, presses={})
    i, j = (mean[name].to_numpy() for name in keys[:2])
    # the mean overlap, which the length of the mean vector differs from by rounding
    length = unit.radius[i] + unit.radius[j] - mean["overlap"].to_numpy()
    pairs, _ = unit.pairs(i, j, mean[keys[2:]].to_numpy(), mean[["x", "y", "z"]].to_numpy(), length)
    between = springs_of(unit, pairs, mean["peak"].to_numpy())
    names = [wall.name for wall in walls_along(bodies.walls, cell.periods)]
    at_walls = _mean_supports(left, np.where(inside, basis, -1), names, len(cell.periods))
    return MeanCell(network_with(unit, joined([between, at_walls])), spread)


def _mean_supports(left: AsLeft, basis: Ints, names: list[str], n_periods: int) -> Springs:
    """Return the mean contacts with walls of each grain of a unit cell.

    Parameters
    ----------
    basis
        Grain of the cell that each grain of the packing is an image of, -1 for none: (n,).
    names
        Names of the walls.
    """
    supports = left.network.supports
    grain = basis[np.searchsorted(left.bodies.ids, left.network.ids)[supports.first]]
    wall = np.asarray(supports.wall, dtype=str)
    kept = (grain >= 0) & np.isin(wall, names)
    image = np.zeros((np.count_nonzero(kept), n_periods), dtype=np.int64)
    supports = dataclasses.replace(joined([supports], kept), first=grain[kept], image=image)
    numbers = np.array([names.index(name) for name in wall[kept]], dtype=np.int64)
    code = supports.first * len(names) + numbers
    means = [joined([supports], slice(0))]
    for each in np.unique(code):
        own = joined([supports], code == each)
        columns = {name: getattr(own, name).mean(axis=0, keepdims=True) for name in _MEANS}
        means.append(dataclasses.replace(joined([own], slice(1)), **columns))
    return joined(means)


def _places(position: Array, basis: Array, cell: UnitCell) -> tuple[Ints, Ints]:
    """Grain of the cell of which each grain is an image, -1 for none, (n,), and the periods between
    them, (n, n_periods).
    """
    inverse = np.linalg.pinv(cell.periods)
    which = np.full(len(position), -1, dtype=np.int64)
    place = np.zeros((len(position), len(cell.periods)), dtype=np.int64)
    size = float(np.linalg.norm(cell.periods, axis=1).max())
    for number, origin in enumerate(basis):
        numbers = np.rint((position - origin) @ inverse).astype(np.int64)
        away = np.linalg.norm(position - origin - numbers @ cell.periods, axis=1)
        here = away < _INTEGER * size
        which[here] = number
        place[here] = numbers[here]
    return which, place
