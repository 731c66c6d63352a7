"""The planes around a packing, each touching the outermost spheres of its side; rigid, or of a material."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from granwave.lammps_inputs.materials import Material

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case


@dataclasses.dataclass(frozen=True)
class Wall:
    """A plane that spheres cannot pass, or the held last layer that acts as one.

    Attributes
    ----------
    name
        bottom, xlo, xhi, ylo or yhi.
    axis
        0, 1 or 2 for x, y or z: the normal.
    outward
        +1 if the packing lies below the plane along ``axis``, -1 if above.
    coordinate
        Where the plane is along ``axis``, m.
    held_layer
        There is no plane: the last layer itself is held in place.
    material
        Of the plane; None for a rigid one.
    """

    name: str
    axis: int
    outward: int
    coordinate: float
    held_layer: bool = False
    material: Material | None = None


def walls(case: Case) -> tuple[Wall, ...]:
    """The walls of a case: the bottom first, then the sides."""
    assembly, found = case.assembly, []
    if case.boundary.bottom != "free":
        held = case.boundary.bottom == "fixed"
        found.append(Wall("bottom", 2, 1, assembly.bottom(), held, case.boundary.bottom_material))
    if case.boundary.sides == "wall":
        low, high = assembly.lattice_bounds()
        radius = max([case.packing.diameter, *assembly.diameters.values()]) / 2
        for axis, letter in enumerate("xy"):
            material = case.boundary.sides_material
            found.append(Wall(f"{letter}lo", axis, -1, float(low[axis]) - radius, material=material))
            found.append(Wall(f"{letter}hi", axis, 1, float(high[axis]) + radius, material=material))
    return tuple(found)


def wall_fixes(case: Case, wall: Wall) -> list[tuple[str, str, Material]]:
    """The LAMMPS fixes of a plane: name, group and material of the spheres that it is for; one for each material.

    Walls are those of the packing: strikers, which are outside, pass them.
    """
    if case.packing.kind == "chain" and wall.name == "bottom":
        return [(wall.name, "all", case.assembly.material_of(case.lattice.n_spheres))]
    materials = [species.material for species in case.assembly.species if species.role == "sphere"]
    if len(materials) == 1 and not case.striker:
        return [(wall.name, "all", materials[0])]
    names = [wall.name, *(f"{wall.name}_{n}" for n in range(2, len(materials) + 1))]
    return [(name, f"species{n}", material) for n, (name, material) in enumerate(zip(names, materials, strict=True), 1)]
