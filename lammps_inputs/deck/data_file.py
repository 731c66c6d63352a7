"""LAMMPS data file: spheres and nodes of bars in full double precision."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.shape import Shape, density_as_sphere
from granwave.lammps_inputs.deck.commands import joined, num
from granwave.lammps_inputs.packing.assembly import Assembly, Species
from granwave.lammps_inputs.packing.bars import PlacedBar
from granwave.lammps_inputs.packing.motion import own_velocities
from granwave.lammps_inputs.packing.places import Places

_STILL = (0.0, 0.0, 0.0)
_BATCH = 100_000  # spheres formatted at once
_PERIODIC_LOW = -0.1  # lower faces of a periodic box, diameters; no plane of centres coincides with a face
_PLAIN_TITLE = "Atoms # sphere: id type diameter density x y z"
_BAR_TITLE = "Atoms # hybrid: id type x y z diameter density molecule"


def write_data(assembly: Assembly, path: Path) -> None:
    """Write the LAMMPS data file of ``atom_style sphere``, with 17 significant digits.

    With bars it is ``atom_style hybrid sphere bond``; a node has diameter 0 and its mass in the density column.
    """
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(_header(assembly))
        for rows in _sphere_rows(assembly):
            file.write("".join(rows))
        for bar in assembly.bars:
            file.write("".join(_node_rows(assembly, bar)))
        if moving := own_velocities(assembly):
            file.write("\nVelocities # id, velocity, angular velocity\n\n")
            file.writelines(
                f"{number} {joined(map(num, moving.get(number, _STILL)))} 0 0 0\n" for number in assembly.ids
            )
        if assembly.bars:
            file.write("\nBonds\n\n" + "".join(_bonds(assembly)))


def _sphere_rows(assembly: Assembly) -> Iterator[list[str]]:
    n = assembly.lattice.n_spheres
    for first in range(1, n + 1, _BATCH):
        last = min(first + _BATCH - 1, n)
        yield _like_rows(assembly, first, last) if assembly.sites is None else _own_rows(assembly, first, last)
    yield [
        _row(assembly, assembly.material_of(number), f"{assembly.diameter_of(number):.17g}", assembly.shape_of(number))
        % (number, *centre)
        for number, (_, centre) in enumerate(assembly.strikers, start=n + 1)
    ]


def _like_rows(assembly: Assembly, first: int, last: int) -> list[str]:
    """Return the rows of the sites with these ids, for equal spheres."""
    row = _row(assembly, assembly.material, f"{assembly.lattice.diameter:.17g}", assembly.case.packing.of_grain)
    columns = assembly.lattice_positions(first, last).T.tolist()
    return [row % line for line in zip(range(first, last + 1), *columns, strict=True)]


def _own_rows(assembly: Assembly, first: int, last: int) -> list[str]:
    """Return the rows of the sites with these ids, for spheres of different materials and diameters."""
    sites = assembly.sites
    assert sites is not None
    here = np.flatnonzero(sites.present[first - 1 : last]) + first - 1
    place = assembly.lattice_positions(first, last)[here - first + 1].T.tolist()
    diameter = sites.diameter[here].tolist()
    columns = [*place, diameter] if assembly.bars else [diameter, *place]
    if assembly.has_cylinders:
        return [
            _row(assembly, material, f"{size:.17g}", shape) % (number, *centre)
            for number, size, centre, (material, shape) in zip(
                (here + 1).tolist(),
                diameter,
                assembly.lattice_positions(first, last)[here - first + 1].tolist(),
                [sites.bodies[body] for body in sites.body[here].tolist()],
                strict=True,
            )
        ]
    rows = [_row(assembly, material) for material in sites.materials]
    lines = zip((here + 1).tolist(), *columns, strict=True)
    return [rows[kind] % line for kind, line in zip(sites.kind[here].tolist(), lines, strict=True)]


def _row(assembly: Assembly, material: Material, diameter: str = "%.17g", shape: Shape = None) -> str:
    """Return the format of a grain's row, to be filled with id, x, y and z; in a hybrid style diameter follows z.

    LAMMPS reads the density of a sphere: that of a cylinder gives its mass to a sphere of its diameter.
    """
    density = material.density if shape is None else density_as_sphere(material.density, float(diameter), shape)
    kind, constants = assembly.type_of(material, shape), f"{diameter} {density:.17g}"
    if assembly.bars:
        return f"%d {kind} %.17g %.17g %.17g {constants} 0\n"
    return f"%d {kind} {constants} %.17g %.17g %.17g\n"


def _node_rows(assembly: Assembly, bar: PlacedBar) -> list[str]:
    node, face = (1 + assembly.species.index(Species(bar.material, role, bar.name)) for role in ("node", "face"))
    return [
        f"{number} {face if number == bar.face else node} 0 0 {z:.17g} 0 {mass:.17g} 0\n"
        for number, z, mass in zip(range(bar.first, bar.last + 1), bar.position, bar.mass, strict=True)
    ]


def _bonds(assembly: Assembly) -> list[str]:
    rows: list[str] = []
    for kind, bar in enumerate(assembly.bars, start=1):
        rows += [f"{len(rows) + n} {kind} {a} {a + 1}\n" for n, a in enumerate(range(bar.first, bar.last), start=1)]
    return rows


def _header(assembly: Assembly) -> str:
    lattice = assembly.lattice
    low, high = assembly.bounds()
    low, high = low - lattice.diameter / 2, high + lattice.diameter / 2
    if lattice.periodic:
        lowest = lattice.bounds()[0, :2] if isinstance(lattice, Places) else 0.0
        low[:2] = lowest + _PERIODIC_LOW * lattice.diameter
        high[:2] = low[:2] + np.array(lattice.lengths)
    box = "".join(f"{a:.17g} {b:.17g} {x}lo {x}hi\n" for a, b, x in zip(low, high, "xyz", strict=True))
    bars = assembly.bars
    n_bonds = sum(bar.section.elements for bar in bars)
    bonds = f"{n_bonds} bonds\n{len(bars)} bond types\n2 extra bond per atom\n" if bars else ""
    return (
        f"granwave: {lattice.kind} packing, SI units, struck layer at z = 0\n\n"
        f"{assembly.n_particles} atoms\n{len(assembly.species)} atom types\n{bonds}\n{box}\n"
        f"{_BAR_TITLE if bars else _PLAIN_TITLE}\n\n"
    )
