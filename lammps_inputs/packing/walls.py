"""Planes around a packing, each touching the outermost spheres of its side, and faces of regions;
rigid or of a material.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import TriangleMesh, elliptic_radius
from granwave.lammps_inputs.case.boundary import Backing, Support, Touched
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.region_walls import RegionWall
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.cylinders import extents
from granwave.lammps_inputs.packing.mesh_faces import MeshFace
from granwave.lammps_inputs.packing.places import balanced_overlap
from granwave.lammps_inputs.packing.region_faces import RegionFace
from granwave.lammps_inputs.packing.sites import Sites
from granwave.lammps_inputs.packing_kind import TOUCHING

SIDE_WALLS = ("tube", "xlo", "xhi", "ylo", "yhi")
PLATE = "plate"  # name of the wall that is a plate on the free top, and of its fix


@dataclasses.dataclass(frozen=True)
class Wall:
    """A wall: a plane, a tube, a face of a region, or the last layer held in place.

    Attributes
    ----------
    name
        Name of the wall: bottom, plate, xlo, xhi, ylo, yhi or tube; for a face of a region the name
        of the region, with the name of the face if there are several.
    axis
        Axis of the normal: 0, 1 or 2 for x, y or z; 0 of a tube, whose first direction is radial,
        and of a face of a region, whose first direction is its normal.
    outward
        Sign of the outward normal: +1 if the packing lies at lower coordinates along ``axis``, -1
        otherwise.
    coordinate
        Position of the plane along ``axis``, or radius of the tube, m; after it was moved in, where
        it is.
    tube
        True for a tube around the axis x = y = 0.
    held_layer
        True if there is no plane, and the last layer is held in place.
    material
        Material of the plane; None if rigid.
    support
        Support of a moving plane; None if it is fixed.
    plate
        Mass (kg) and velocity (m/s) of a rigid plate on the free top; None for other walls.
    overlap
        Overlap of spheres that touch it, m; with cohesion the overlap at zero contact force.
    face
        Face of a region, or patch of a surface of triangles; None for other walls.
    friction
        Coefficient of friction of the wall; None for the coefficient of the boundary or contact
        law.
    fixes
        Its LAMMPS fixes, one for each material: name, group and material of the grains.
    """

    name: str
    axis: int
    outward: int
    coordinate: float
    held_layer: bool = False
    tube: bool = False
    material: Material | None = None
    support: Support | None = None
    plate: tuple[float, float] | None = None
    overlap: float = 0.0
    face: RegionFace | MeshFace | None = None
    friction: float | None = None
    fixes: tuple[tuple[str, str, Material], ...] = dataclasses.field(
        default=(), repr=False, compare=False
    )

    @property
    def key(self) -> str:
        """Key of ``[precompression]`` that moves it: x, y or tube; z for walls that stay."""
        if self.face is not None:
            return "z"
        return "tube" if self.tube else "xyz"[self.axis]

    @property
    def is_side(self) -> bool:
        """True for a tube, and for planes across x and y."""
        return self.name in SIDE_WALLS

    def moved_in(self, distance: float) -> Wall:
        """Return the wall after it has moved towards the packing by a distance, m."""
        return dataclasses.replace(self, coordinate=self.coordinate - self.outward * distance)

    def gaps(
        self, positions: NDArray[np.float64], radii: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the gaps between the wall and spheres at positions (n, 3), negative for overlaps:
        (n,), m.
        """
        if self.face is not None:
            return self.face.distances(positions) - radii
        reach = np.hypot(*positions.T[:2]) if self.tube else positions[:, self.axis] * self.outward
        return np.asarray(self.coordinate * self.outward - (reach + radii))

    def nearest(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the nearest points of the wall to positions (n, 3): (n, 3), m."""
        if self.face is not None:
            return self.face.nearest(positions)
        found = positions.copy()
        if self.tube:
            found[:, :2] *= (self.coordinate / np.hypot(*positions.T[:2]))[:, None]
        else:
            found[:, self.axis] = self.coordinate
        return found

    def effective_radii(self, radii: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the radii of spheres that are as stiff on a plane as the given spheres on the
        wall: (n,), m.
        """
        if self.face is not None:
            return self.face.effective_radii(radii)
        return (
            np.asarray(elliptic_radius(1 / radii, 1 / radii - 1 / self.coordinate))
            if self.tube
            else radii
        )


@kept_by_assembly
def walls(assembly: Assembly) -> tuple[Wall, ...]:
    """Return the walls of a packing: the bottom first, then a plate on the top, then the sides."""
    case = assembly.case
    found = []
    boundary = case.boundary
    moves = case.precompression.moves if case.precompression else {}
    if boundary.bottom_rule.stops:
        material = boundary.bottom_material
        support = boundary.bottom_support
        found.append(
            Wall(
                "bottom",
                2,
                1,
                assembly.bottom(),
                boundary.bottom_rule.holds_layer,
                material=material,
                support=support,
            )
        )
    if (plate := case.load.plate) is not None:
        found.append(Wall(PLATE, 2, -1, assembly.top(), plate=plate))
    material = boundary.sides_material
    if boundary.sides_tube is not None:
        found.append(
            Wall(
                "tube",
                0,
                1,
                boundary.sides_tube - moves.get("tube", 0.0),
                tube=True,
                material=material,
            )
        )
    for axis, letter in enumerate("xy"):
        # a crystal in the x-z plane has walls across y only where boundary.y says so
        across = letter == "x" or boundary.y is not None or not case.packing.rule.is_plane_crystal
        if boundary.has_planes(letter) and across:
            low, high = _faces(assembly, axis)
            inwards = moves.get(letter, 0.0) - max(boundary.gap, 0.0)
            found.append(Wall(f"{letter}lo", axis, -1, low + inwards, material=material))
            found.append(Wall(f"{letter}hi", axis, 1, high - inwards, material=material))
    found += _faces_of_regions(case)
    placed = []
    # with cohesion, at zero contact force; tubes, and sides with a gap, are unchanged
    for wall in found:
        as_it_is = (
            wall.held_layer
            or wall.tube
            or wall.face is not None
            or not case.packing.rule.is_lattice
            or (wall.axis < 2 and boundary.gap)
        )
        overlap = (
            0.0
            if as_it_is or not case.has_cohesion
            else balanced_overlap(case, wall.material, flat=True)
        )
        place = wall.coordinate - wall.outward * overlap
        placed.append(
            dataclasses.replace(
                wall, coordinate=place, overlap=overlap, fixes=_fixes(assembly, wall)
            )
        )
    return tuple(placed)


def _faces_of_regions(case: Case) -> list[Wall]:
    """Return the faces of ``[[wall]]``, without their fixes."""
    found = []
    for number, entry in enumerate(case.wall, start=1):
        region = f"wall{number}"
        faces = _faces_of(number, entry)
        for suffix, face in faces.items():
            name = region if len(faces) == 1 else f"{region}{suffix}"
            wall = Wall(name, 0, 1, 0.0, material=entry.material, face=face)
            found.append(dataclasses.replace(wall, friction=entry.friction))
    return found


def _faces_of(number: int, entry: RegionWall) -> Mapping[str, RegionFace | MeshFace]:
    """Return the faces of a region, or the patches of triangles, by name."""
    if entry.region is not None:
        region = f"wall{number}"
        shape = entry.shape
        return {face: RegionFace(region, entry.region, shape, face) for face in shape.faces}
    angle = entry.smooth_angle
    mesh = TriangleMesh(entry.corners, angle)
    patches = range(1, mesh.n_patches + 1)
    return {f"patch{patch}": MeshFace(number, patch, angle, mesh) for patch in patches}


def refuse_region_walls(case: Case) -> None:
    """Raise InputError for a case with walls of regions, where only planes and tubes are
    supported.
    """
    if case.wall:
        raise InputError(
            f"{case.name}: wall.1: found a region wall, expected walls of [boundary]; remove "
            "[[wall]]"
        )


def pressed_walls(assembly: Assembly) -> dict[str, list[Wall]]:
    """Return the walls that move in to a force, by x, y or tube."""
    stage = assembly.case.precompression
    names = stage.presses if stage else {}
    there = walls(assembly)
    return {name: [wall for wall in there if wall.key == name] for name in names}


def touched_by(assembly: Assembly, wall: Wall) -> NDArray[np.bool_] | None:
    """Select the sites of the packing on which a wall acts: (n_sites,); None if it acts on all."""
    only = assembly.case.boundary.sides_touch
    if only is None or wall.name == "bottom" or wall.face is not None:
        return None
    return touched(assembly.case, assembly.sites, only)


def untouched(assembly: Assembly) -> list[tuple[str, int, float]]:
    """Find grains that overlap with walls that do not act on them: wall, deepest grain, and its
    overlap, m.
    """
    found: list[tuple[str, int, float]] = []
    sites = assembly.sites
    moved = assembly.case.precompression.moves if assembly.case.precompression else {}
    for wall in walls(assembly):
        if (chosen := touched_by(assembly, wall)) is None:
            continue
        others = np.flatnonzero(sites.present & ~chosen)
        if not len(others):
            continue
        reach = sites.diameter[others] / 2 if wall.tube else _reach(assembly, others, wall.axis)
        gaps = wall.gaps(sites.positions(1, len(sites.present))[others], reach)
        deepest = int(np.argmin(gaps))
        depth = -float(gaps[deepest]) - moved.get(wall.key, 0.0)
        if depth > TOUCHING * assembly.case.packing.diameter:
            found.append((wall.name, int(others[deepest]) + 1, depth))
    return found


def _reach(assembly: Assembly, rows: NDArray[np.int64], axis: int) -> NDArray[np.float64]:
    """Return the half-widths along an axis of the grains at some sites: (n,), m."""
    shapes = [assembly.shape_of(one) for one in (rows + 1).tolist()]
    return extents(assembly.sites.diameter[rows] / 2, shapes)[:, axis]


def touched(case: Case, sites: Sites, only: Touched) -> NDArray[np.bool_]:
    """Select the sites of the packing with these materials or groups: (n_sites,)."""
    grains = case.packing.grains
    chosen = sites.made_of(
        *(material for material, _ in sites.bodies if material.name in only.material)
    )
    if grains is not None:
        chosen |= np.isin(np.array(grains.group, dtype=object), only.group)
    return chosen


def _faces(assembly: Assembly, axis: int) -> tuple[float, float]:
    """Return the coordinates of the two planes across an axis, which touch the outermost spheres on
    which they act.
    """
    only = assembly.case.boundary.sides_touch
    sites = assembly.sites
    if only is None:
        low, high = assembly.faces()[:, axis].tolist()
        return low, high
    rows = np.flatnonzero(touched(assembly.case, sites, only))
    place = sites.positions(1, len(sites.present))[rows, axis]
    reach = _reach(assembly, rows, axis)
    return float((place - reach).min()), float((place + reach).max())


def _fixes(assembly: Assembly, wall: Wall) -> tuple[tuple[str, str, Material], ...]:
    """Return the fixes of a wall; it acts on the packing, and on strikers that walls hold; other
    strikers pass it.
    """
    if wall.held_layer:
        return ()
    chosen = touched_by(assembly, wall)
    materials = list(
        dict.fromkeys(species.material for species in assembly.species if species.role == "sphere")
    )
    groups = [(f"species{n}", material) for n, material in enumerate(materials, start=1)]
    if chosen is not None:
        groups = [(group, material) for group, material, _ in touched_groups(assembly, chosen)]
    elif assembly.lattice.rule.is_chain and wall.name == "bottom":
        groups = [("all", assembly.material_of(assembly.lattice.n_spheres))]
    elif len(materials) == 1 and not assembly.passing:
        groups = [("all", materials[0])]
    elif wall.plate is not None:  # it moves with the spheres of the top layer, which it touches
        there = materials_at(assembly, assembly.lattice.top_layer)
        return tuple((wall.name, *one) for one in groups if one[1] in there)
    return tuple(
        (f"{wall.name}_{n}" if n > 1 else wall.name, *one) for n, one in enumerate(groups, start=1)
    )


def plane_fixes(assembly: Assembly) -> list[str]:
    """Return the names of the fixes of all planes and of a tube."""
    fixes = chain.from_iterable(wall.fixes for wall in walls(assembly))
    return [fix for fix, _, _ in fixes]


def touched_groups(
    assembly: Assembly, chosen: NDArray[np.bool_]
) -> list[tuple[str, Material, NDArray[np.int64]]]:
    """Return the groups of chosen spheres, one for each material: name, material and ids."""
    sites = assembly.sites
    materials = dict.fromkeys(material for material, _ in sites.bodies)
    found = [
        (material, 1 + np.flatnonzero(chosen & sites.made_of(material))) for material in materials
    ]
    found = [(material, ids) for material, ids in found if len(ids)]
    return [
        (f"touched{number}", material, ids) for number, (material, ids) in enumerate(found, start=1)
    ]


def wall_friction(case: Case, wall: Wall, material: Material) -> float:
    """Return the coefficient of friction between a wall and spheres of a material."""
    if wall.friction is not None:
        return wall.friction
    if case.boundary.friction is not None:
        return case.boundary.friction
    return case.contact_between(material, wall.material).friction


def materials_at(assembly: Assembly, ids: NDArray[np.int64]) -> list[Material]:
    """Return the materials of the spheres with these ids, each once."""
    return list(
        dict.fromkeys(assembly.material_of(one) for one in ids[assembly.present[ids - 1]].tolist())
    )


def moving_fix(assembly: Assembly) -> str | None:
    """Return the name of the fix with the moving plane; None if no plane moves.

    Spheres of other materials than the last layer have a separate fix, with a fixed plane.
    """
    for wall in walls(assembly):
        if wall.support is not None:
            resting = materials_at(assembly, assembly.lattice.last_layer)[0]
            return next(name for name, _, material in wall.fixes if material == resting)
    return None


def backing_of(assembly: Assembly, wall: Wall, material: Material) -> Backing | None:
    """Return the moving mass and support behind a wall loaded by grains of a material; None if it
    is fixed.
    """
    if wall.plate is not None:
        return Backing(wall.plate[0], 0.0)
    if wall.support is None or material != materials_at(assembly, assembly.lattice.last_layer)[0]:
        return None
    return wall.support.backing(wall.material, footprint_radius(assembly))


def support_of(assembly: Assembly) -> Backing | None:
    """Return the moving support of the bottom; None if it is fixed."""
    boundary = assembly.case.boundary
    if boundary.bottom_support is None:
        return None
    return boundary.bottom_support.backing(boundary.bottom_material, footprint_radius(assembly))


def support_timestep(assembly: Assembly, stiffness: float) -> float:
    """Return the longest timestep that resolves the motion of the bottom, s; infinite if it is
    fixed.

    Parameters
    ----------
    stiffness
        Stiffness of one contact with the bottom, N/m.
    """
    support = support_of(assembly)
    if support is None:
        return math.inf
    return support.longest_timestep(len(assembly.lattice.last_layer) * stiffness)


def footprint_radius(assembly: Assembly) -> float:
    """Return the radius of the disc with the area of a layer of the packing, m."""
    return math.sqrt(math.prod(assembly.lattice.lengths) / math.pi)
