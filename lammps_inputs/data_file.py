"""The LAMMPS data file: where the spheres are, in full double precision."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from granwave.lammps_inputs.case import Case
from granwave.lammps_inputs.lattices import Lattice

_BATCH = 100_000  # spheres formatted at once
_PERIODIC_LOW = -0.1  # in diameters; no plane of centres coincides with the faces of the periodic box


def write_data(case: Case, path: Path) -> None:
    """Write the spheres as a LAMMPS data file of ``atom_style sphere``, 17 significant digits."""
    lattice = case.lattice
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(_header(case, lattice))
        diameter, density = (f"{value:.17g}" for value in (case.packing.diameter, case.material.density))
        row = f"%d 1 {diameter} {density} %.17g %.17g %.17g\n"
        for first in range(1, lattice.n_spheres + 1, _BATCH):
            last = min(first + _BATCH - 1, lattice.n_spheres)
            columns = lattice.positions(first, last).T.tolist()
            file.write("".join([row % line for line in zip(range(first, last + 1), *columns, strict=True)]))


def _header(case: Case, lattice: Lattice) -> str:
    low, high = lattice.bounds()
    low, high = low - lattice.diameter, high + lattice.diameter
    if lattice.periodic:
        low[:2] = _PERIODIC_LOW * lattice.diameter
        high[:2] = low[:2] + np.array(lattice.lengths)
    box = "".join(f"{a:.17g} {b:.17g} {x}lo {x}hi\n" for a, b, x in zip(low, high, "xyz", strict=True))
    return (
        f"granwave: {lattice.kind} packing, SI units, struck layer at z = 0\n\n"
        f"{lattice.n_spheres} atoms\n1 atom types\n\n{box}\n"
        "Atoms # sphere: id type diameter density x y z\n\n"
    )
