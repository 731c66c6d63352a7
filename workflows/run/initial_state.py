"""Spheres at the start of a run, made by the ranks: each rank creates the spheres in its part of
the box.

LAMMPS would read data.granwave on one rank and send every row to every rank, which takes equally
long for any number of ranks. The spheres created here are bitwise identical, in the same order.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.material import density_as_sphere
from granwave.lammps_inputs.deck.deck import box_of
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import own_spins, own_velocities
from granwave.lammps_inputs.script_words import joined, num
from granwave.workflows.run.lammps_engine import Engine

_BATCH = 100_000  # sites processed at a time
_MARGIN = 1e-3  # margin in diameters of the centres passed to LAMMPS, which selects those inside
_SPHERE = 4.0 * math.pi / 3.0  # in the order of operations of LAMMPS, for the same bits


def make_spheres(engine: Engine, assembly: Assembly) -> None:
    """Make box and spheres of an assembly without bars, as ``read_data`` of its data file would.

    Raises
    ------
    RunError
        Spheres are lost, because no rank creates them.
    """
    box = joined(map(num, chain.from_iterable(box_of(assembly))))
    engine.commands(
        f"region packing block {box} units box\ncreate_box {len(assembly.species)} packing\nregion packing delete"
    )
    ids, centres = map(np.concatenate, zip(*_own(assembly, *engine.own_box()), strict=True))
    centres = centres - assembly.deck_origin
    velocities = np.zeros_like(centres)
    for number, velocity in own_velocities(assembly).items():
        velocities[np.searchsorted(ids, number)] = velocity
    images = _images(centres, assembly) if assembly.lattice.periodic else None
    engine.create_atoms(
        ids, 1 + assembly.body[ids - 1], centres, velocities, images, n_atoms=assembly.n_spheres
    )
    mine = engine.per_atom("id") - 1
    spins = own_spins(assembly)
    if spins:
        turning = np.zeros((assembly.last_sphere, 3))
        turning[np.array(list(spins)) - 1] = list(spins.values())
        engine.per_atom("omega")[:] = turning[mine]
    diameters = assembly.diameter[mine]
    bodies = assembly.body[mine]
    density = np.empty(len(mine))
    for body, species in enumerate(assembly.species):
        chosen = bodies == body
        density[chosen] = density_as_sphere(
            species.material.density, diameters[chosen], species.shape
        )
    radii = 0.5 * diameters
    engine.per_atom("radius")[:] = radii
    engine.per_atom("rmass")[:] = density * (_SPHERE * radii * radii * radii)


def _images(centres: NDArray[np.float64], assembly: Assembly) -> NDArray[np.int64]:
    """Return the number of periods along x, y, z by which LAMMPS will shift the centres: (n, 3)."""
    inside = centres.copy()
    images = np.zeros(centres.shape, dtype=np.int64)
    low, high = box_of(assembly)[:2].T
    while (beyond := (inside[:, :2] >= high) * 1 - (inside[:, :2] < low)).any():
        inside[:, :2] -= beyond * (high - low)
        images[:, :2] += beyond
    return images


def _own(
    assembly: Assembly, low: NDArray[np.float64], high: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """Iterate over ids and centres of the spheres between two corners, and of some outside, in
    batches by id.

    Ids of a lattice count its layers, so that most of its batches are skipped. Grains that are not
    on a lattice are all included.
    """
    n = assembly.lattice.n_spheres
    lattice = assembly.lattice
    box_low, box_high = box_of(assembly)[:2].T
    layered = isinstance(lattice, Lattice) and assembly.sites.leaning is None
    low = low - _MARGIN * lattice.diameter
    high = high + _MARGIN * lattice.diameter
    for first in range(1, n + 1, _BATCH):
        last = min(first + _BATCH - 1, n)
        top, bottom = (assembly.sites.positions(one, one)[0, 2] for one in (first, last))
        if layered and not (top < high[2] and bottom >= low[2]):
            continue
        centres = assembly.sites.positions(first, last)
        chosen = assembly.sites.present[first - 1 : last]
        if layered:
            inside = centres.copy()
            if lattice.periodic:
                inside[:, :2] = box_low + (inside[:, :2] - box_low) % (box_high - box_low)
            chosen = chosen & ((inside >= low) & (inside < high)).all(axis=1)
        here = np.flatnonzero(chosen)
        yield here + first, centres[here]
    yield (
        np.arange(n + 1, assembly.last_sphere + 1),
        np.array([centre for _, centre in assembly.strikers]).reshape(-1, 3),
    )
