"""The planes around a packing, each touching the outermost spheres of its side."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

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
    """

    name: str
    axis: int
    outward: int
    coordinate: float
    held_layer: bool = False


def walls(case: Case) -> tuple[Wall, ...]:
    """The walls of a case: the bottom first, then the sides."""
    low, high = case.lattice.bounds()
    radius = case.packing.diameter / 2
    found = []
    if case.boundary.bottom != "free":
        held = case.boundary.bottom == "fixed"
        found.append(Wall("bottom", 2, 1, float(high[2]) + radius, held))
    if case.boundary.sides == "wall":
        for axis, letter in enumerate("xy"):
            found.append(Wall(f"{letter}lo", axis, -1, float(low[axis]) - radius))
            found.append(Wall(f"{letter}hi", axis, 1, float(high[axis]) + radius))
    return tuple(found)
