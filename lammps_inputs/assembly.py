"""All bodies of a case: the spheres of its lattice, replaced ones, strikers, and the nodes of elastic bars.

Ids count from 1: the spheres of the lattice, then the strikers, then the nodes of the incident bar, then those of the
bar, each along +z. A packing of like spheres costs nothing, however large; see `granwave.lammps_inputs.lattices`.

A bar is a row of point masses, half a mass at either end, joined by springs E A / (element length). The node at the
chain's end is its face: a particle without radius, which the contact law takes as a flat (R* = R).
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.bodies import Bar, Striker
from granwave.lammps_inputs.lattices import TOUCHING, Lattice
from granwave.lammps_inputs.materials import Material, sphere_mass
from granwave.lammps_inputs.placing import place_strikers
from granwave.lammps_inputs.struck import struck_spheres

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case

INCIDENT_BAR, BAR = "incident_bar", "bar"  # names, as in the case


@dataclasses.dataclass(frozen=True)
class Species:
    """Particles of one LAMMPS type: spheres of one material, the face of a bar, or the rest of its nodes.

    Attributes
    ----------
    role
        ``sphere``, ``face`` or ``node``.
    bar
        Name of the bar that it belongs to; empty for spheres.
    """

    material: Material
    role: str = "sphere"
    bar: str = ""


@dataclasses.dataclass(frozen=True)
class PlacedBar:
    """A bar in its place.

    Attributes
    ----------
    name
        ``incident_bar`` or ``bar``.
    first, last
        Ids of its nodes; z rises with the id.
    face
        Id of the node that touches the chain.
    touches
        Id of the sphere that the face touches.
    position
        Of the nodes along z: (n_nodes,), m.
    mass
        Of the nodes: (n_nodes,), kg.
    """

    name: str
    section: Bar
    material: Material
    first: int
    face: int
    touches: int
    position: NDArray[np.float64]
    mass: NDArray[np.float64]

    @property
    def last(self) -> int:
        """Id of the last node."""
        return self.first + len(self.position) - 1

    @property
    def far(self) -> int:
        """Id of the node at the end away from the chain."""
        return self.first if self.face == self.last else self.last

    @property
    def pitch(self) -> float:
        """Length of an element, m."""
        return self.section.length / self.section.elements

    @property
    def stiffness(self) -> float:
        """Of an element, N/m."""
        return self.material.youngs_modulus * self.section.area / self.pitch

    @property
    def wave_speed(self) -> float:
        """sqrt(E/rho), m/s."""
        return math.sqrt(self.material.youngs_modulus / self.material.density)


@dataclasses.dataclass(frozen=True, eq=False)
class Assembly:
    """All bodies of a case; see `assemble`.

    Attributes
    ----------
    lattice
        Of the spheres of the packing.
    material
        Of spheres that are not replaced.
    diameters
        By id of spheres of the lattice that have another diameter, m.
    materials
        By id of spheres of the lattice that have another material.
    strikers
        Each with its centre (3,), m.
    bars
        In the order of their ids.
    species
        What the LAMMPS types 1, 2, ... are.
    """

    lattice: Lattice
    material: Material
    diameters: dict[int, float]
    materials: dict[int, Material]
    strikers: tuple[tuple[Striker, NDArray[np.float64]], ...]
    bars: tuple[PlacedBar, ...]
    species: tuple[Species, ...]

    @property
    def n_spheres(self) -> int:
        """Spheres of the lattice, and strikers."""
        return self.lattice.n_spheres + len(self.strikers)

    @property
    def n_particles(self) -> int:
        """Spheres and nodes of bars."""
        return self.n_spheres + sum(len(bar.position) for bar in self.bars)

    @property
    def plain(self) -> bool:
        """Like spheres of the lattice, nothing else."""
        return not (self.diameters or self.materials or self.strikers or self.bars)

    @property
    def n_contacts(self) -> int:
        """Pairs of spheres that touch at the start."""
        return self.lattice.n_contacts + sum(len(set(striker.touches)) for striker, _ in self.strikers)

    def diameter_of(self, sphere: int) -> float:
        """Diameter of the sphere with this id, m."""
        if sphere > self.lattice.n_spheres:
            return self.strikers[sphere - self.lattice.n_spheres - 1][0].diameter or self.lattice.diameter
        return self.diameters.get(sphere, self.lattice.diameter)

    def material_of(self, sphere: int) -> Material:
        """Material of the sphere with this id."""
        if sphere > self.lattice.n_spheres:
            return self.strikers[sphere - self.lattice.n_spheres - 1][0].material or self.material
        return self.materials.get(sphere, self.material)

    def mass_of(self, sphere: int) -> float:
        """Mass of the sphere with this id, kg."""
        return sphere_mass(self.material_of(sphere), self.diameter_of(sphere) / 2)

    def type_of(self, material: Material) -> int:
        """LAMMPS type of spheres of a material."""
        return 1 + self.species.index(Species(material))

    @cached_property
    def _stacked(self) -> NDArray[np.float64] | None:
        """Heights of the beads of a chain whose diameters differ: (n,), m."""
        if not self.diameters:
            return None
        radii = np.array([self.diameter_of(bead) / 2 for bead in range(1, self.lattice.n_spheres + 1)])
        return np.concatenate([[0.0], np.cumsum(radii[1:] + radii[:-1])])

    def lattice_positions(self, first: int, last: int) -> NDArray[np.float64]:
        """Centres of the spheres of the lattice with ids ``first`` to ``last``: (n, 3), m."""
        positions = self.lattice.positions(first, last)
        if self._stacked is not None:
            positions[:, 2] = self._stacked[first - 1 : last]
        return positions

    def positions(self) -> NDArray[np.float64]:
        """Centres of all spheres by id: (n_spheres, 3), m."""
        own = self.lattice_positions(1, self.lattice.n_spheres)
        return np.concatenate([own, *(centre[None] for _, centre in self.strikers)]) if self.strikers else own

    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest coordinate of a surface along x, y, z, nodes included: (2, 3), m."""
        low, high = self.lattice_bounds()
        radius = self.lattice.diameter / 2
        if self.diameters:
            radius = max(radius, *(diameter / 2 for diameter in self.diameters.values()))
        corners = [low - radius, high + radius]
        for number, (_, centre) in enumerate(self.strikers, start=self.lattice.n_spheres + 1):
            corners += [centre - self.diameter_of(number) / 2, centre + self.diameter_of(number) / 2]
        for bar in self.bars:
            corners += [np.array([low[0], low[1], z]) for z in (bar.position[0], bar.position[-1])]
        return np.stack([np.min(corners, axis=0), np.max(corners, axis=0)])

    def lattice_bounds(self) -> NDArray[np.float64]:
        """Lowest and highest centre of a sphere of the lattice along x, y, z: (2, 3), m."""
        bounds = self.lattice.bounds()
        if self._stacked is not None:
            bounds[1, 2] = self._stacked[-1]
        return bounds

    def echoes(self) -> dict[str, float]:
        """When an echo of the far end of each bar can first reach the chain, by name of the bar, s."""
        found, arrival = {}, 0.0
        for bar in self.bars:
            crossing = bar.section.length / bar.wave_speed
            if bar.name == INCIDENT_BAR:
                arrival = crossing  # of the load at the chain
            found[bar.name] = arrival + 2 * crossing
        return found

    def bottom(self) -> float:
        """Where a plane below the packing touches the spheres of its last layer, m."""
        return float(self.lattice_bounds()[1, 2]) + self.diameter_of(self.lattice.n_spheres) / 2

    def contacts(self) -> NDArray[np.int64]:
        """Pairs of ids of spheres that touch at the start, i < j, in no particular order: (n_contacts, 2)."""
        pairs = list(self.lattice.pairs())
        for number, (striker, _) in enumerate(self.strikers, start=self.lattice.n_spheres + 1):
            pairs.append(np.array([sorted((touched, number)) for touched in sorted(set(striker.touches))]))
        return np.concatenate(pairs) if pairs else np.empty((0, 2), dtype=np.int64)


def assemble(case: Case) -> Assembly:
    """All bodies of a case.

    Raises
    ------
    ValueError
        A striker does not find a place.
    """
    lattice = case.lattice
    diameters: dict[int, float] = {}
    materials: dict[int, Material] = {}
    for entry in case.replace:
        for sphere in entry.index:
            diameters[sphere] = entry.diameter or case.packing.diameter
            materials[sphere] = entry.material or case.material
    diameters = {sphere: d for sphere, d in diameters.items() if d != case.packing.diameter}
    materials = {sphere: found for sphere, found in materials.items() if found != case.material}
    spheres = dict.fromkeys(
        [case.material, *materials.values(), *(striker.material or case.material for striker in case.striker)]
    )
    assembly = Assembly(lattice, case.material, diameters, materials, (), (), tuple(Species(one) for one in spheres))
    if case.striker:
        centres = place_strikers(assembly, case.striker)
        assembly = dataclasses.replace(assembly, strikers=tuple(zip(case.striker, centres, strict=True)))
    bars: list[PlacedBar] = []
    first = assembly.n_spheres + 1
    for name, section in ((INCIDENT_BAR, case.incident_bar), (BAR, case.bar)):
        if section is not None:
            bars.append(_place_bar(assembly, name, section, section.material or case.material, first))
            first = bars[-1].last + 1
    ends = [Species(bar.material, role, bar.name) for bar in bars for role in ("node", "face")]
    return dataclasses.replace(assembly, bars=tuple(bars), species=(*assembly.species, *ends))


def struck_of(case: Case) -> tuple[int, ...]:
    """Ids of the spheres that the load acts on, the struck sphere first; of strikers alone those that move."""
    if case.load.kind != "striker":
        return struck_spheres(case.lattice, case.load.spheres)
    moving = [number for number, striker in enumerate(case.striker, start=case.lattice.n_spheres + 1) if striker.moves]
    return tuple(moving)


def velocities_of(case: Case) -> dict[int, tuple[float, float, float]]:
    """Initial velocities of the spheres that have one, by id, m/s."""
    found: dict[int, tuple[float, float, float]] = {}
    if case.load.kind == "impact":
        found = dict.fromkeys(struck_of(case), (0.0, 0.0, case.load.velocity))
    for number, striker in enumerate(case.striker, start=case.lattice.n_spheres + 1):
        if striker.moves:
            found[number] = striker.velocity
    return found


def _place_bar(assembly: Assembly, name: str, section: Bar, material: Material, first: int) -> PlacedBar:
    n = section.elements
    ahead = name == INCIDENT_BAR
    face = -assembly.diameter_of(1) / 2 if ahead else assembly.bottom()
    position = face + np.linspace(-section.length if ahead else 0.0, 0.0 if ahead else section.length, n + 1)
    mass = np.full(n + 1, material.density * section.area * section.length / n)
    mass[[0, -1]] /= 2
    return PlacedBar(
        name, section, material, first, first + n if ahead else first, 1 if ahead else assembly.lattice.n_spheres,
        position, mass,
    )  # fmt: skip


def gap_tolerance(case: Case) -> float:
    """Gap up to which two spheres count as touching at the start, m."""
    return TOUCHING * case.packing.diameter
