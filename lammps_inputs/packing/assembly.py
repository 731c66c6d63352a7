"""All bodies of a case: spheres of the lattice, replaced spheres, strikers, and nodes of elastic
bars.

Ids count from 1: the sites of the lattice, then the strikers, then the nodes of the incident bar,
then the nodes of the bar, both along +z. A vacant site keeps its id, which no sphere has: the
spheres are rows in the order of `Assembly.ids`. A packing of identical spheres needs no memory,
however large; see `granwave.lammps_inputs.lattices`.
"""

from __future__ import annotations

import dataclasses
import inspect
import itertools
import math
from collections.abc import Callable, Sequence
from functools import cached_property, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import Striker
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material, Shape, mass_of
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.bodies import (
    BAR,
    INCIDENT_BAR,
    PlacedBar,
    place_bar,
    place_strikers,
)
from granwave.lammps_inputs.packing.cylinders import grains_called
from granwave.lammps_inputs.packing.places import Layout, Places, balanced_overlap, layout_of
from granwave.lammps_inputs.packing.sites import Sites, sites_of
from granwave.lammps_inputs.packing_kind import TOUCHING

Others = ParamSpec("Others")
Value = TypeVar("Value")


@dataclasses.dataclass(frozen=True)
class Species:
    """Particles of one LAMMPS type: grains of one material and shape, the face of a bar, or the
    other nodes of a bar.

    Attributes
    ----------
    role
        ``sphere``, ``face`` or ``node``.
    bar
        Name of the bar that it belongs to; empty for spheres.
    shape
        Shape of the grains; None for spheres.
    """

    material: Material
    role: str = "sphere"
    bar: str = ""
    shape: Shape = None


@dataclasses.dataclass(frozen=True, eq=False)
class Assembly:
    """All bodies of a case; see `assemble`.

    Attributes
    ----------
    case
        Case that it was made from.
    lattice
        Lattice of the packing, or the positions of its grains.
    material
        Material of spheres that are not replaced.
    sites
        Diameters, materials and vacancies by site.
    strikers
        Strikers, each with its centre (3,), m.
    bars
        Bars in the order of their ids.
    species
        Particles of the LAMMPS types 1, 2, ...
    """

    case: Case
    lattice: Layout
    material: Material
    sites: Sites
    strikers: tuple[tuple[Striker, NDArray[np.float64]], ...]
    bars: tuple[PlacedBar, ...]
    species: tuple[Species, ...]
    _values: dict[Callable[..., Any], Any] = dataclasses.field(
        default_factory=dict, init=False, repr=False
    )  # results of functions that are `kept_by_assembly`

    def __reduce__(self) -> tuple[Any, ...]:
        """Send an assembly to another process as its case; the other process assembles it again."""
        return assemble, (self.case,)

    @property
    def n_spheres(self) -> int:
        """Number of spheres, strikers included."""
        return self.sites.count + len(self.strikers)

    @property
    def last_sphere(self) -> int:
        """Largest id of a sphere: the last striker, or the last site of the lattice."""
        return self.lattice.n_spheres + len(self.strikers)

    @property
    def ids(self) -> NDArray[np.int64]:
        """Ids of the spheres, in rising order: (n_spheres,)."""
        return 1 + np.flatnonzero(self.present)

    @property
    def n_particles(self) -> int:
        """Number of spheres and nodes of bars."""
        return self.n_spheres + sum(len(bar.position) for bar in self.bars)

    @property
    def plain(self) -> bool:
        """True if there are only equal spheres, without vacancies, strikers or bars."""
        return self.sites.uniform and not (self.strikers or self.bars)

    @property
    def like(self) -> bool:
        """True if all bodies are spheres of one material and nominal diameter; there may be
        vacancies and scatter.
        """
        return self.sites.like and not (self.strikers or self.bars)

    @property
    def has_rate(self) -> bool:
        """True if the yield strength of a material depends on the strain rate."""
        return any(one.material.rate_sensitivity for one in self.species)

    @property
    def n_contacts(self) -> int:
        """Number of pairs of spheres that touch at the start."""
        return self.sites.n_contacts + len(self.striker_contacts)

    @property
    def n_neighbours(self) -> int:
        """Number of pairs of spheres that touch or are at neighbouring sites."""
        return self.sites.n_neighbours + len(self.striker_contacts)

    @cached_property
    def present(self) -> NDArray[np.bool_]:
        """True for ids of spheres, False for ids of vacancies: (last_sphere,)."""
        return self._with_strikers(self.sites.present, [True] * len(self.strikers))

    @cached_property
    def diameter(self) -> NDArray[np.float64]:
        """Diameters by id, nominal diameters at vacancies: (last_sphere,), m."""
        diameters = [one.diameter or self.lattice.diameter for one, _ in self.strikers]
        return self._with_strikers(self.sites.diameter, diameters)

    @cached_property
    def body(self) -> NDArray[np.int16]:
        """LAMMPS types by id, from 0: (last_sphere,)."""
        bodies = [
            self.type_of(one.material or self.material, one.body) - 1 for one, _ in self.strikers
        ]
        return self._with_strikers(self.sites.body, bodies)

    def diameter_of(self, sphere: int) -> float:
        """Return the diameter of the sphere with this id, m."""
        return float(self.diameter[sphere - 1])

    def material_of(self, sphere: int) -> Material:
        """Return the material of the sphere with this id."""
        return self.species[self.body[sphere - 1]].material

    def mass_of(self, sphere: int) -> float:
        """Return the mass of the sphere with this id, kg."""
        return mass_of(
            self.material_of(sphere), self.diameter_of(sphere) / 2, self.shape_of(sphere)
        )

    def shape_of(self, sphere: int) -> Shape:
        """Return the shape of the grain or striker with this id."""
        return self.species[self.body[sphere - 1]].shape

    @property
    def clumps(self) -> dict[int, tuple[int, ...]]:
        """Ids of the grains of each clump, by its number; empty without clumps."""
        grains = self.case.packing.grains
        return {} if grains is None else grains.clumps

    @property
    def in_clumps(self) -> NDArray[np.int64]:
        """Ids of the grains of all clumps, in rising order."""
        return np.sort(np.array([*itertools.chain(*self.clumps.values())], dtype=np.int64))

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """Shapes of the grains of the packing, each once."""
        return tuple(dict.fromkeys(shape for _, shape in self.sites.bodies))

    @property
    def has_cylinders(self) -> bool:
        """True if any grain or striker is a cylinder."""
        return any(one.shape for one in self.species)

    @cached_property
    def n_cylinders(self) -> int:
        """Number of cylinders among grains and strikers."""
        return sum(bool(shape) for shape in self.grain_shapes()) if self.has_cylinders else 0

    @property
    def grains_called(self) -> str:
        """``spheres``, ``cylinders``, or ``grains`` if there are both."""
        return grains_called(self.n_spheres, self.n_cylinders)

    def grain_shapes(self) -> list[Shape]:
        """Return the shapes of all grains and strikers: n_spheres of them."""
        return [self.species[k].shape for k in self.body[self.present].tolist()]

    @property
    def plane_strain(self) -> bool:
        """True if cylinders touch along lines in plane strain, False if as half-spaces:
        ``contact.line``.
        """
        return self.case.contact.line == "plane-strain"

    def sphere_diameters(self) -> NDArray[np.float64]:
        """Return the diameters of all spheres: (n_spheres,), m."""
        return self.diameter[self.present]

    def sphere_masses(self) -> NDArray[np.float64]:
        """Return the masses of all spheres: (n_spheres,), kg."""
        body = self.body[self.present]
        radii = self.sphere_diameters() / 2
        densities = np.array([one.material.density for one in self.species])[body]
        masses = densities * 4 / 3 * math.pi * radii**3
        if self.has_cylinders:
            lengths = np.array([one.shape.length if one.shape else 0.0 for one in self.species])[
                body
            ]
            masses = np.where(lengths > 0, densities * math.pi * radii**2 * lengths, masses)
        return masses

    def type_of(self, material: Material, shape: Shape = None) -> int:
        """Return the LAMMPS type of grains of a material and shape."""
        return 1 + self.species.index(Species(material, shape=shape))

    def positions(self) -> NDArray[np.float64]:
        """Return the centres of all spheres: (n_spheres, 3), m."""
        return self._with_strikers(self.sites.centres, [centre for _, centre in self.strikers])

    def bounds(self) -> NDArray[np.float64]:
        """Return the bounds of all spheres and nodes along x, y, z: (2, 3), m."""
        low, high = self.lattice_bounds()
        radius = max(self.lattice.diameter, self.sites.largest) / 2
        corners = [low - radius, high + radius]
        for (_, centre), diameter in zip(
            self.strikers, self.diameter[self.lattice.n_spheres :], strict=True
        ):
            corners += [centre - diameter / 2, centre + diameter / 2]
        for bar in self.bars:
            corners += [np.array([low[0], low[1], z]) for z in (bar.position[0], bar.position[-1])]
        return np.stack([np.min(corners, axis=0), np.max(corners, axis=0)])

    @cached_property
    def deck_origin(self) -> NDArray[np.float64]:
        """Origin of the LAMMPS input in coordinates of the case: (3,), m.

        LAMMPS adds a step of some nanometres to each coordinate, whose rounding grows with the
        distance from the origin. Grains of a file at a distance from the origin larger than their
        extent are moved to the origin, along each axis; results are in the coordinates of the file.
        The axis of a tube or of bars, and packings with walls of regions, keep their position.
        """
        low, high = self.lattice_bounds()
        origin = np.zeros(3)
        if not isinstance(self.lattice, Places) or self.case.wall:
            return origin
        size = max(float((high - low).max()), self.lattice.diameter)
        outside = np.maximum(np.maximum(low, -high), 0.0)
        away = outside > size
        if self.case.boundary.sides_tube is not None or self.bars:
            away[:2] = False
        origin[away] = low[away]
        return origin

    def lattice_bounds(self) -> NDArray[np.float64]:
        """Return the lowest and highest coordinates of sites along x, y, z: (2, 3), m."""
        bounds = self.lattice.bounds()
        if self.sites.stacked is not None:
            bounds[1, 2] = self.sites.stacked[-1]
        return bounds

    def faces(self) -> NDArray[np.float64]:
        """Return the coordinates of the planes that enclose the packing, along x, y, z: (2, 3), m.

        They touch nominal spheres; smaller spheres leave a gap. In a chain the sides touch the
        largest bead.
        """
        if isinstance(self.lattice, Places):
            return self.lattice.faces()
        side = self.lattice.diameter / 2
        bottom = side
        if self.lattice.rule.is_chain and not self.sites.uniform:
            side = max(side, float(self.sites.nominal.max()) / 2)
            bottom = float(self.sites.nominal[-1]) / 2
        low, high = self.lattice_bounds()
        return np.stack([low - side, [*(high[:2] + side), high[2] + bottom]])

    def bottom(self) -> float:
        """Return the z at which a bottom plane or bar touches nominal spheres of the last layer,
        m.
        """
        return float(self.faces()[1, 2])

    def top(self) -> float:
        """Return the z at which a plate on the free top, or the incident bar, touches nominal
        spheres there, m.
        """
        if isinstance(self.lattice, Places):
            return float(self.lattice.faces()[0, 2])
        return float(self.lattice_bounds()[0, 2]) - float(self.sites.nominal[0]) / 2

    def contacts(self) -> NDArray[np.int64]:
        """Return the ids of touching pairs at the start, i < j, in no particular order:
        (n_contacts, 2).
        """
        pairs = list(self.lattice.pairs() if self.sites.uniform else self.sites.contacts())
        if self.striker_contacts:
            pairs.append(np.array(self.striker_contacts))
        return np.concatenate(pairs) if pairs else np.empty((0, 2), dtype=np.int64)

    @property
    def passing(self) -> tuple[int, ...]:
        """Ids of the strikers that walls do not hold."""
        first = self.lattice.n_spheres + 1
        return tuple(
            number for number, (one, _) in enumerate(self.strikers, start=first) if not one.walls
        )

    @cached_property
    def striker_contacts(self) -> list[tuple[int, int]]:
        """Pairs of ids in contact at the start: a sphere, and the striker that touches it.

        The case names the spheres; pairs with a gap, due to diameter scatter or a misaligned
        striker, are omitted.
        """
        found = []
        for number, (striker, centre) in enumerate(self.strikers, start=self.lattice.n_spheres + 1):
            for touched in sorted(set(striker.touches)):
                reach = (self.diameter_of(touched) + self.diameter_of(number)) / 2
                if (
                    abs(np.linalg.norm(self.centre_of(touched) - centre) - reach)
                    <= TOUCHING * self.lattice.diameter
                ):
                    found.append((touched, number))
        return found

    def centre_of(self, sphere: int) -> NDArray[np.float64]:
        """Return the centre of the sphere with this id: (3,), m."""
        if sphere > self.lattice.n_spheres:
            return self.strikers[sphere - self.lattice.n_spheres - 1][1]
        return np.asarray(self.sites.positions(sphere, sphere)[0])

    def _with_strikers(self, of_sites: NDArray[Any], of_strikers: Sequence[Any]) -> NDArray[Any]:
        """Append the values of strikers."""
        if not of_strikers:
            return of_sites
        return np.concatenate([of_sites, np.asarray(of_strikers, dtype=of_sites.dtype)])


def kept_by_assembly(function: Callable[[Assembly], Value]) -> Callable[[Assembly], Value]:
    """Make a function whose value an assembly keeps: it is computed once for each assembly.

    It is used for values of higher-level packages, which cannot be properties of `Assembly`.
    """

    @wraps(function)
    def kept(assembly: Assembly) -> Value:
        if function not in assembly._values:
            assembly._values[function] = function(assembly)
        value: Value = assembly._values[function]
        return value

    return kept


def assemble(case: Case) -> Assembly:
    """Place all bodies of a case.

    Code that needs them more than once keeps the assembly, and passes it on.

    Raises
    ------
    ValueError
        A striker cannot be placed, or vacancies leave too few spheres.
    """
    lattice = layout_of(case.packing, case.boundary)
    if isinstance(lattice, Lattice) and case.has_cohesion:  # at rest, where contact forces are zero
        lattice = dataclasses.replace(lattice, overlap=balanced_overlap(case, case.material))
    sites = sites_of(case, lattice)
    kinds = dict.fromkeys(
        [*sites.bodies, *((one.material or case.material, one.body) for one in case.striker)]
    )
    species = [Species(material, shape=shape) for material, shape in kinds]
    strikers = tuple(zip(case.striker, place_strikers(case, sites), strict=True))
    assembly = Assembly(case, lattice, case.material, sites, strikers, (), tuple(species))
    if case.incident_bar is None and case.bar is None:
        return assembly
    bars = list[PlacedBar]()
    first = assembly.last_sphere + 1
    if case.incident_bar is not None:
        bars.append(place_bar(case, INCIDENT_BAR, first, assembly.top(), 1))
        first = bars[0].last + 1
    if case.bar is not None:
        bars.append(place_bar(case, BAR, first, assembly.bottom(), lattice.n_spheres))
    for bar in bars:
        for role in ("node", "face"):
            species.append(Species(bar.material, role, bar.name))
    return dataclasses.replace(assembly, bars=tuple(bars), species=tuple(species))


def of_case(
    function: Callable[Concatenate[Assembly, Others], Value],
) -> Callable[Concatenate[Case, Others], Value]:
    """Make a function of a case, for users, from a function of its assembly."""

    @wraps(function)
    def assembled(case: Case, *args: Others.args, **kwargs: Others.kwargs) -> Value:
        return function(assemble(case), *args, **kwargs)

    signature = inspect.signature(function)
    _, *others = signature.parameters.values()
    first = inspect.Parameter("case", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation="Case")
    cast(Any, assembled).__signature__ = signature.replace(parameters=[first, *others])
    return assembled
