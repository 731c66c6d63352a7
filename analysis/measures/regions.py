"""Regions of a packing, and the energy in each of them against time.

Regions are the strikers, and parts of the packing: groups of a file of grains, stretches of a chain
with one material and diameter, or equal parts along the load. Strikers, walls and the dissipated
energy have separate fractions.

The input is measured from the static state. Under a static load it therefore does not contain the
elastic energy of a region, and fractions are of the kinetic energy only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.impact import energy_by_region
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.contact.law import pair_contact
from granwave.lammps_inputs.packing.assembly import Assembly

_MILLI = 1e3  # millimetres in a metre
_PARTS = 4  # equal parts along the load, of a packing without groups
_MOST_STRETCHES = 6  # most stretches of a chain; more are joined by material and diameter
_SAME_SIZE = 1e-6  # tolerance of equal diameters / diameter of the packing
_FEWEST_TIMES = 3
_SAME_INSTANT = 1e-9  # tolerance of equal instants, over the end time
_DOWN = 0.9  # z component of a unit vector, above which a load goes down
OTHERS = "other spheres"
WALLS = "walls"
WHOLE = "packing"  # of a single layer, which has no parts along the load
DISSIPATED = "dissipated"
#: Energies of the ledger that belong to no sphere: name and column.
_WITHOUT_SPHERES = {"rotation": "rotational", "plate": "plate", "support": "support"}

Ids = NDArray[np.int64]


@dataclasses.dataclass(frozen=True, eq=False)
class EnergyByRegion:
    """Fractions of the input in regions of a packing.

    Attributes
    ----------
    time
        Instants: (n_times,), s.
    share
        Energy / input by name of the region: (n_times,) each.
    kinetic_only
        True where the elastic energy is omitted, as under a static load.
    """

    time: Array
    share: Mapping[str, Array]
    kinetic_only: bool


def energy_of_regions(result: Result, regions: Mapping[str, ArrayLike]) -> EnergyByRegion | None:
    """Return the energy in regions of a packing; None without energy or for fewer than three
    instants.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    regions
        Ids of the spheres of each region, by name, as `usual_regions` returns them.
    """
    if not result.energy_input or not regions:
        return None
    kinetic_only = result.case.precompression is not None
    of_chain = "chain" in result
    time = result["chain/time"][_rows_of_chain(result)] if of_chain else result.frame_times
    if len(time) < _FEWEST_TIMES:
        return None
    if of_chain:
        share = _of_chain(result, regions, kinetic_only)
    elif kinetic_only:
        share = _summed(_kinetic(result), result["spheres/id"], regions, result.energy_input)
    else:
        share = energy_by_region(result, regions)
    if not kinetic_only:
        share |= _without_spheres(result, time)
    return EnergyByRegion(
        time, {name: part for name, part in share.items() if part.any()}, kinetic_only
    )


def usual_regions(result: Result, direction: Array) -> dict[str, Ids]:
    """Return ids of the spheres of each region by name, as defined at the top of this module.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    direction
        Direction of the load, a unit vector: (3,).
    """
    ids = result["spheres/id"]
    strikers = ids[~result.in_packing]
    regions = {}
    if len(strikers):
        regions["striker" if len(strikers) == 1 else "strikers"] = strikers
    return regions | (_groups(result) or stretches(result) or _parts(result, direction))


def _groups(result: Result) -> dict[str, Ids]:
    """Return the groups of the grains of a file, if there are several."""
    grains = result.case.packing.grains
    if grains is None:
        return {}
    names = dict.fromkeys(name for name in grains.group if name)
    if len(names) < 2:
        return {}
    return {f"group {name}": np.array(grains.of_group(name)) for name in names}


def stretches(result: Result) -> dict[str, Ids]:
    """Return the stretches of a chain of one material and diameter, if there are several.

    Diameters that scatter, or that differ from bead to bead as in a tapered chain, make no
    stretches.
    """
    if "chain" not in result:
        return {}
    assembly = result.assembly
    ids = result["chain/id"]
    ids = ids[ids <= assembly.lattice.n_spheres]
    sizes = _kinds_of_size(assembly, ids)
    kinds = assembly.body[ids - 1] * (sizes.max(initial=0) + 1) + sizes
    has_sizes = bool(sizes.any())
    starts = np.flatnonzero(np.diff(kinds, prepend=-1))
    if len(starts) < 2:
        return {}
    if len(starts) > _MOST_STRETCHES:
        return {
            _kind_of(assembly, int(ids[kinds == kind][0])): ids[kinds == kind]
            for kind in dict.fromkeys(kinds.tolist())
        }
    stretches = np.split(ids, starts[1:])
    return {
        _name_of(assembly, int(start), stretch, with_diameter=has_sizes): stretch
        for start, stretch in zip(starts, stretches, strict=True)
    }


def _kinds_of_size(assembly: Assembly, ids: Ids) -> Ids:
    """Return the number of the diameter of each bead, from 0; only zeros if diameters scatter, or
    if there are many: (n_beads,).
    """
    diameter = assembly.diameter[ids - 1]
    unit = _SAME_SIZE * assembly.case.packing.diameter
    sizes, numbers = np.unique(np.round(diameter / unit), return_inverse=True)
    if assembly.case.packing.diameter_scatter or len(sizes) > _MOST_STRETCHES:
        return np.zeros(len(ids), dtype=np.int64)
    return numbers.ravel()


def _kind_of(assembly: Assembly, bead: int) -> str:
    """Return material and diameter of a bead in words."""
    diameter = f"{assembly.diameter_of(bead) * _MILLI:.4g} mm"
    material = assembly.material_of(bead).name
    return f"beads of {material}, {diameter}" if material else f"beads of {diameter}"


def _name_of(assembly: Assembly, start: int, stretch: Ids, *, with_diameter: bool) -> str:
    """Return the name of a part of a chain whose first bead has the number ``start``, from 0."""
    end = start + len(stretch)
    parts = [f"beads {start + 1} to {end}" if len(stretch) > 1 else f"bead {end}"]
    bead = int(stretch[0])
    if material := assembly.material_of(bead).name:
        parts.append(material)
    if with_diameter:
        parts.append(f"{assembly.diameter_of(bead) * _MILLI:.4g} mm")
    return ", ".join(parts)


def _parts(result: Result, direction: Array) -> dict[str, Ids]:
    """Return equal parts of the packing along the load, of whole layers."""
    inside = result.in_packing
    ids = result["spheres/id"][inside]
    along = (result["spheres/position"][inside] - result.origin) @ direction
    radius = result["spheres/radius"][inside]
    mean, layer = layers(along, radius, result.case.packing.diameter)
    number = min(_PARTS, len(mean))
    if number == 1:
        return {WHOLE: ids}
    part = layer * number // len(mean)
    first = np.searchsorted(np.arange(len(mean)) * number // len(mean), np.arange(1, number))
    edges = [along.min(), *(0.5 * (mean[first] + mean[first - 1])), along.max()]
    far = "deep" if direction[2] > _DOWN else "away"
    return {
        f"{low * _MILLI:.0f} to {high * _MILLI:.0f} mm {far}": ids[part == n]
        for n, (low, high) in enumerate(pairwise(edges))
    }


def _of_chain(
    result: Result, regions: Mapping[str, ArrayLike], kinetic_only: bool
) -> dict[str, Array]:
    """Return the fractions of regions of a chain at the instants of its history."""
    ids = result["chain/id"]
    mass = result["spheres/mass"][result.rows(ids)]
    energy = 0.5 * mass * result["chain/velocity"] ** 2
    if not kinetic_only:
        energy = energy + _stored_in_beads(result)
    rows = _rows_of_chain(result)
    share = _summed(energy[rows], ids, regions, result.energy_input)
    if kinetic_only:
        return share
    time = result["chain/time"][rows]
    for name, column in ((WALLS, "elastic_wall"), (DISSIPATED, "dissipated")):
        share[name] = _of_ledger(result, column, time)
    for bar in result.assembly.bars:
        share[bar.name.replace("_", " ")] = _of_ledger(result, bar.name, time)
    return share


def _rows_of_chain(result: Result) -> Ids:
    """Return the rows of the history of a chain at instants of the energy record: (n_rows,).

    Between these instants the energy record would be interpolated, with an error of 1 % of the
    input during an impact on a wall. All rows are returned if fewer than three instants coincide.
    """
    time = result["chain/time"]
    ledger = result["energy/time"]
    after = np.clip(np.searchsorted(ledger, time), 1, len(ledger) - 1)
    distance = np.minimum(np.abs(ledger[after] - time), np.abs(ledger[after - 1] - time))
    rows = np.flatnonzero(distance <= _SAME_INSTANT * time[-1])
    return rows if len(rows) >= _FEWEST_TIMES else np.arange(len(time))


def _stored_in_beads(result: Result) -> Array:
    """Return half the elastic energy of the contacts between beads for each of the two:
    (n_times, n_beads), J.

    For contacts that yielded, the largest overlap at recorded instants and before the run is taken
    into account.
    """
    place = result["chain/position"] + result["chain/displacement"]
    radius = result["spheres/radius"][result.rows(result["chain/id"])]
    overlap = radius[1:] + radius[:-1] - np.diff(place, axis=1)
    overlap = np.maximum(overlap, 0.0)
    peak = np.maximum.accumulate(overlap, axis=0)
    ids = result["chain/id"]
    if result.has("contacts/initial_overlap"):
        peak = np.maximum(peak, result.of_pairs("initial_overlap", ids[:-1], ids[1:]))
    stored = np.zeros(place.shape)
    for n, (first, second) in enumerate(pairwise(ids.tolist())):
        law = pair_contact(result.assembly, first, second)
        half = 0.5 * np.asarray(law.elastic_energy(overlap[:, n], peak[:, n]))
        stored[:, n] += half
        stored[:, n + 1] += half
    return stored


def _kinetic(result: Result) -> Array:
    """Return the kinetic energy of each sphere at the snapshots: (n_frames, n_spheres), J."""
    mass = result["spheres/mass"]
    squares = [
        np.sum(result.frame(number, "velocity") ** 2, axis=1) for number in range(result.n_frames)
    ]
    return 0.5 * mass * np.stack(squares)


def _summed(
    energy: Array, ids: Ids, regions: Mapping[str, ArrayLike], given: float
) -> dict[str, Array]:
    """Return the fractions of an energy by sphere (n_times, n_spheres), J, in regions."""
    share = {}
    rest = np.ones(len(ids), dtype=bool)
    for name, own in regions.items():
        inside = np.isin(ids, np.asarray(own))
        rest &= ~inside
        share[name] = energy[:, inside].sum(axis=1) / given
    share[OTHERS] = energy[:, rest].sum(axis=1) / given
    return share


def _without_spheres(result: Result, time: Array) -> dict[str, Array]:
    """Return the fractions of energies that do not belong to spheres."""
    return {
        name: _of_ledger(result, column, time)
        for name, column in _WITHOUT_SPHERES.items()
        if result.has(f"energy/{column}")
    }


def _of_ledger(result: Result, column: str, time: Array) -> Array:
    """Return a fraction of the energy record at instants."""
    values = np.interp(time, result["energy/time"], result[f"energy/{column}"])
    return np.asarray(values / result.energy_input)
