"""Spheres of the top layer that the load acts on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from granwave.lammps_inputs.lattices import KINDS, TOUCHING
from granwave.lammps_inputs.packing.places import Layout, layout_of

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.bodies import Striker
    from granwave.lammps_inputs.case.boundary import Boundary
    from granwave.lammps_inputs.case.packing import PackingSection


def struck_spheres(lattice: Layout, count: int) -> tuple[int, ...]:
    """Return the ids of the loaded spheres; the first one is the struck sphere.

    The struck sphere is the one of the top layer nearest to the centroid of that layer (ties within 1e-6 D:
    the lowest id). A ``count`` of 3 adds the two neighbours that rest with it on one sphere of the next layer (of
    several such pairs the one with the lowest ids), 7 its six neighbours in the layer.

    Raises
    ------
    ValueError
        The packing has no such neighbours.
    """
    centre = _central(lattice)
    if count == 1:
        return (centre,)
    if not lattice.rule.hexagonal:
        able = " or ".join(name for name, kind in KINDS.items() if kind.hexagonal)
        raise ValueError(f"{count} spheres need hexagonal layers ({able}), found {lattice.kind}")
    around = [other for other in lattice.neighbours(centre) if lattice.layer_of(other) == 0]
    if count == 7:
        if len(around) != 6:
            raise ValueError(f"the struck sphere has {len(around)} neighbours in the top layer, 7 spheres need 6")
        return (centre, *around)
    below = [other for other in lattice.neighbours(centre) if lattice.layer_of(other) == 1]
    resting = [[other for other in lattice.neighbours(support) if other in around] for support in below]
    pairs = [pair for pair in resting if len(pair) == 2]
    if not pairs:
        raise ValueError("no two neighbours of the struck sphere rest with it on one sphere below")
    return (centre, *min(pairs))


def centred(strikers: Sequence[Striker], packing: PackingSection, boundary: Boundary) -> tuple[Striker, ...]:
    """Return strikers, those that touch the sphere at the centre of the top with its id."""
    if all(striker.touches for striker in strikers):
        return tuple(strikers)
    centre = struck_spheres(layout_of(packing, boundary), 1)
    return tuple(one if one.touches else dataclasses.replace(one, touches=centre) for one in strikers)


def _central(lattice: Layout) -> int:
    ids = lattice.top_layer
    top = lattice.positions(1, int(ids[-1]))[ids - 1, :2]
    distance = np.linalg.norm(top - top.mean(axis=0), axis=1)
    return int(ids[np.flatnonzero(distance <= distance.min() + TOUCHING * lattice.diameter)[0]])
