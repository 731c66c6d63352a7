"""Clumps: grains with a common number, which move as one rigid body.

A clump has the mass and the moments of inertia of its complete spheres: where spheres
overlap, their common volume counts for each of them, as in ``fix rigid`` of LAMMPS.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import nearest_image


def together(assembly: Assembly, centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centres of grains, (n, 3), m; the grains of a clump are at their images next to
    its first grain.

    Parameters
    ----------
    centres
        Centres of the grains of the packing: (n, 3), m.
    """
    lattice = assembly.lattice
    if not (assembly.clumps and lattice.periodic):
        return centres
    moved = centres.copy()
    for ids in assembly.clumps.values():
        rows = np.array(ids) - 1
        start = centres[rows[0]]
        moved[rows] = start + nearest_image(centres[rows] - start, lattice.lengths)
    return moved


def largest_extent(assembly: Assembly) -> float:
    """Return the largest distance of a grain from the grain of its clump that is nearest to the
    centre of mass, m; 0 without clumps.
    """
    n_spheres = assembly.lattice.n_spheres
    if not assembly.clumps:
        return 0.0
    centres = together(assembly, assembly.positions()[:n_spheres])
    masses = assembly.sphere_masses()[:n_spheres]
    largest = 0.0
    for ids in assembly.clumps.values():
        rows = np.array(ids) - 1
        places = centres[rows]
        centre = np.average(places, axis=0, weights=masses[rows])
        middle = places[np.argmin(np.linalg.norm(places - centre, axis=1))]
        largest = max(largest, float(np.linalg.norm(places - middle, axis=1).max()))
    return largest


def refuse_clumps(assembly: Assembly) -> None:
    """Raise InputError for a packing with clumps, where only single grains are supported."""
    for number, ids in assembly.clumps.items():
        raise InputError(
            f"{assembly.case.name}: packing: found clump {number} of {len(ids)} grains, expected "
            "single grains; remove the column clump"
        )
