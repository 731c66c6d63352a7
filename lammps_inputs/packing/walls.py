"""Planes around a packing, rigid or of a material, each touching the outermost spheres of its side."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import elliptic_radius
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.assembly import Assembly, assemble

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.supports import Support


@dataclasses.dataclass(frozen=True)
class Wall:
    """A wall: a plane, or the last layer held in place.

    Attributes
    ----------
    name
        Name of the wall: bottom, xlo, xhi, ylo, yhi or tube.
    axis
        Axis of the normal: 0, 1 or 2 for x, y or z; 0 of a tube, whose first direction is radial.
    outward
        Sign of the outward normal: +1 if the packing lies at lower coordinates along ``axis``, -1 otherwise.
    coordinate
        Position of the plane along ``axis``, or radius of the tube, m; after it was moved in, where it is.
    tube
        True for a tube around the axis x = y = 0.
    held_layer
        True if there is no plane, and the last layer is held in place.
    material
        Material of the plane; None if rigid.
    support
        Support of a moving plane; None if it does not move.
    """

    name: str
    axis: int
    outward: int
    coordinate: float
    held_layer: bool = False
    tube: bool = False
    material: Material | None = None
    support: Support | None = None

    def gaps(self, positions: NDArray[np.float64], radii: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gaps between the wall and spheres at positions (n, 3), negative for overlaps: (n,), m."""
        reach = np.hypot(*positions.T[:2]) if self.tube else positions[:, self.axis] * self.outward
        return np.asarray(self.coordinate * self.outward - (reach + radii))

    def nearest(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the nearest points of the wall to positions (n, 3): (n, 3), m."""
        found = positions.copy()
        if self.tube:
            found[:, :2] *= (self.coordinate / np.hypot(*positions.T[:2]))[:, None]
        else:
            found[:, self.axis] = self.coordinate
        return found

    def effective_radii(self, radii: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the radii of spheres that are as stiff on a plane as these are on the wall: (n,), m."""
        return np.asarray(elliptic_radius(1 / radii, 1 / radii - 1 / self.coordinate)) if self.tube else radii


def walls(case: Case | Assembly) -> tuple[Wall, ...]:
    """Return the walls of a case: the bottom first, then the sides."""
    assembly = assemble(case)
    case = assembly.case
    found = []
    if case.boundary.bottom not in ("free", "periodic"):
        boundary, held = case.boundary, case.boundary.bottom == "fixed"
        material, support = boundary.bottom_material, boundary.bottom_support
        found.append(Wall("bottom", 2, 1, assembly.bottom(), held, material=material, support=support))
    material, moves = case.boundary.sides_material, case.precompression.moves if case.precompression else {}
    if case.boundary.sides_tube is not None:
        found.append(
            Wall("tube", 0, 1, case.boundary.sides_tube - moves.get("tube", 0.0), tube=True, material=material)
        )
    for axis, letter in enumerate("xy"):
        if case.boundary.has_planes(letter):
            (low, high), inwards = assembly.faces()[:, axis].tolist(), moves.get(letter, 0.0)
            found.append(Wall(f"{letter}lo", axis, -1, low + inwards, material=material))
            found.append(Wall(f"{letter}hi", axis, 1, high - inwards, material=material))
    return tuple(found)


def wall_fixes(assembly: Assembly, wall: Wall) -> list[tuple[str, str, Material]]:
    """Return the LAMMPS fixes of a plane, one for each material: name, group and material of the spheres.

    Walls act on the spheres of the packing; strikers, which are outside, can pass them.
    """
    case = assembly.case
    if case.packing.kind == "chain" and wall.name == "bottom":
        return [(wall.name, "all", assembly.material_of(assembly.lattice.n_spheres))]
    materials = [species.material for species in assembly.species if species.role == "sphere"]
    if len(materials) == 1 and not case.striker:
        return [(wall.name, "all", materials[0])]
    names = [wall.name, *(f"{wall.name}_{n}" for n in range(2, len(materials) + 1))]
    return [(name, f"species{n}", material) for n, (name, material) in enumerate(zip(names, materials, strict=True), 1)]


def wall_friction(case: Case, wall: Wall, material: Material) -> float:
    """Return the coefficient of friction between a wall and spheres of a material."""
    if case.boundary.friction is not None:
        return case.boundary.friction
    return case.contact_between(material, wall.material).friction


def materials_of_last_layer(assembly: Assembly) -> list[Material]:
    """Return the materials of the spheres in the last layer, each once."""
    case = assembly.case
    sites = assembly.sites
    if sites is None:
        return [case.material]
    last = assembly.lattice.last_layer - 1
    return list(dict.fromkeys(sites.materials[kind] for kind in sites.kind[last][sites.present[last]]))


def moving_fix(assembly: Assembly) -> str | None:
    """Return the name of the fix with the moving plane; None if no plane moves.

    Spheres of other materials than that of the last layer have a fix of their own, whose plane does not move.
    """
    for wall in walls(assembly):
        if wall.support is not None:
            resting = materials_of_last_layer(assembly)[0]
            return next(name for name, _, material in wall_fixes(assembly, wall) if material == resting)
    return None


def support_timestep(assembly: Assembly, stiffness: float) -> float:
    """Return the longest timestep that resolves the motion of the bottom, s; infinite if it does not move.

    Parameters
    ----------
    stiffness
        Stiffness of one contact with the bottom, N/m.
    """
    case = assembly.case
    boundary = case.boundary
    if boundary.bottom_support is None:
        return math.inf
    return boundary.bottom_support.longest_timestep(
        boundary.bottom_material, footprint_radius(assembly), len(assembly.lattice.last_layer) * stiffness
    )


def footprint_radius(assembly: Assembly) -> float:
    """Return the radius of the disc with the area of a layer of the packing, m."""
    return math.sqrt(math.prod(assembly.lattice.lengths) / math.pi)
