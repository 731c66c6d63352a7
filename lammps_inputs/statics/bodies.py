"""Grains of a unit cell or of a finite packing at their positions, with walls and loads, and their
contacts.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import elastic_case
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import nearest_vectors, turning_projection
from granwave.lammps_inputs.packing.walls import Wall
from granwave.lammps_inputs.statics.pair_laws import PairLaws, Part

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_Table = TypeVar("_Table", bound=Any)

_OF_SPHERE = 0.4  # moment of inertia / (m R^2)
_OF_CYLINDER = 0.5  # moment of inertia about the axis / (m R^2)
_NEGLIGIBLE = 1e-12  # overlap / mean diameter due to rounding


@dataclasses.dataclass(frozen=True, eq=False)
class NeighbourPairs:
    """Grains near each other, each pair once, or near walls.

    Attributes
    ----------
    first, second
        Rows of the grains; -1 for a wall: (n,).
    image
        Whole numbers of periods between the cells of the first and the second: (n, n_periods).
    normal
        Unit vectors from the first to the second: (n, 3).
    distance
        Distances of the centres, infinite at a plane; in a tube minus the distance from its axis:
        (n,), m.
    turns
        Projections of motions that turn the contact; for spheres as from `across`, in a tube on
        the direction around it: (n, 3, 3).
    wall
        Names of the walls, empty for pairs: (n,).
    overlap
        (n,), m.
    radii
        Radii of both grains, infinite for a wall: (n, 2), m.
    shift
        Vectors between their cells before the load: (n, 3), m.
    """

    first: Ints
    second: Ints
    image: Ints
    normal: Array
    distance: Array
    turns: Array
    wall: NDArray[np.object_]
    overlap: Array
    radii: Array
    shift: Array

    def __len__(self) -> int:
        return len(self.first)


@dataclasses.dataclass(frozen=True, eq=False)
class Bodies:
    """Grains before they are loaded.

    Attributes
    ----------
    assembly
        All bodies of their case.
    ids
        Ids: (n,).
    position
        Centres before the load: (n, 3), m.
    radius, mass
        (n,), m and kg.
    kind
        Positions of their materials and shapes in ``laws.bodies``: (n,).
    moves
        True for the directions x, y, z, rx, ry, rz in which a grain moves: (n, 6).
    periods
        Periods of the packing before the load: (n_periods, 3), m; a finite packing has none.
    walls
        Walls, in their final positions.
    dead_load
        Constant forces: (n, 3), N.
    stress
        Load on the cell: forces times lengths for each strain that is free, ``{(2, 2): N m}``;
        compression positive.
    touched
        Grains on which a wall acts, by its name: (n,); of walls that are not there: all.
    presses
        Forces to which walls move in, by the names of these walls: on all of them together, N.
    settles
        Directions in which grains move under the static load: (n, 3); None: as ``moves``.
    """

    assembly: Assembly
    laws: PairLaws
    ids: Ints
    position: Array
    radius: Array
    mass: Array
    kind: Ints
    moves: NDArray[np.bool_]
    periods: Array
    walls: tuple[Wall, ...]
    dead_load: Array
    stress: dict[tuple[int, int], float] = dataclasses.field(default_factory=dict)
    touched: dict[str, NDArray[np.bool_]] = dataclasses.field(default_factory=dict)
    presses: dict[tuple[str, ...], float] = dataclasses.field(default_factory=dict)
    settles: NDArray[np.bool_] | None = None

    @property
    def case(self) -> Case:
        """Their case."""
        return self.assembly.case

    @property
    def inertia(self) -> Array:
        """Moments of inertia, for cylinders about their axis: (n,), kg m^2."""
        factor = np.array(
            [_OF_SPHERE if shape is None else _OF_CYLINDER for shape in self.laws.shapes]
        )[self.kind]
        return np.asarray(factor * self.mass * self.radius**2)

    def part(self, rows: Ints, periods: Array) -> Bodies:
        """Return some of the grains, in a cell of these periods."""
        names = ("ids", "position", "radius", "mass", "kind", "moves", "dead_load")
        own: dict[str, Any] = {name: getattr(self, name)[rows] for name in names}
        if self.settles is not None:
            own["settles"] = self.settles[rows]
        touched = {name: values[rows] for name, values in self.touched.items()}
        return dataclasses.replace(self, **own, periods=periods, touched=touched)

    def elastic(self) -> Bodies:
        """Return the grains with the elastic contacts of the first half of a static stage."""
        laws = PairLaws(elastic_case(self.case), self.laws.bodies)
        return dataclasses.replace(self, laws=laws)

    def with_walls_in(self, distances: Iterable[float]) -> Bodies:
        """Return the grains between walls that moved in, by the distances of ``presses``, m."""
        moves: dict[str, float] = {}
        for names, distance in zip(self.presses, distances, strict=True):
            moves |= dict.fromkeys(names, distance)
        walls = tuple(wall.moved_in(moves.get(wall.name, 0.0)) for wall in self.walls)
        return dataclasses.replace(self, walls=walls)

    def pairs(
        self, first: Ints, second: Ints, image: Ints, step: Array, lengths: Array | None = None
    ) -> tuple[NeighbourPairs, NDArray[np.bool_]]:
        """Return pairs of rows from the vectors between their centres (n, 3), m, and True for
        grains that cannot touch because their nearest positions are beyond the end of a cylinder.
        Distances may be given: (n,), m.
        """
        apart = step
        turns = np.empty((len(first), 3, 3))
        beyond = np.zeros(len(first), dtype=bool)
        if self.laws.has_cylinders:
            apart = np.empty_like(step)
            shapes = self.laws.shapes
            code = self.kind[first] * len(shapes) + self.kind[second]
            for each in np.unique(code).tolist():
                rows = np.flatnonzero(code == each)
                pair = (shapes[each // len(shapes)], shapes[each % len(shapes)])
                apart[rows], past = nearest_vectors(step[rows], *pair)
                beyond[rows] = past > -_NEGLIGIBLE * self.spacing
                normal = (
                    apart[rows] / np.maximum(np.linalg.norm(apart[rows], axis=1), 1e-300)[:, None]
                )
                turns[rows] = turning_projection(normal, *pair)
        distance = np.linalg.norm(apart, axis=1)
        radii = np.stack([self.radius[first], self.radius[second]], axis=1)
        if lengths is not None:
            apart = apart * (lengths / distance)[:, None]
            distance = lengths
        with np.errstate(invalid="ignore"):
            normal = apart / distance[:, None]
        if not self.laws.has_cylinders:
            turns = across(normal)
        names = np.full(len(first), "", dtype=object)
        overlap = radii.sum(axis=1) - distance
        shift = image @ self.periods
        return NeighbourPairs(
            first, second, image, normal, distance, turns, names, overlap, radii, shift
        ), beyond

    @property
    def spacing(self) -> float:
        """Mean diameter, m."""
        return float(2 * self.radius.mean())

    def _at_walls(self, position: Array, gap: float) -> Iterator[NeighbourPairs]:
        """Yield the grains whose gap to a wall is less than ``gap``, m; the ends of cylinders do
        not touch.
        """
        for wall in self.walls:
            if wall.held_layer:
                continue
            gaps = wall.gaps(position, self.radius)
            near = gaps < gap
            if wall.name in self.touched:
                near &= self.touched[wall.name]
            if self.laws.has_cylinders and not wall.tube:
                ends = [
                    shape is not None and abs(shape.axis[wall.axis]) > 0.5
                    for shape in self.laws.shapes
                ]
                near &= ~np.array(ends)[self.kind]
            rows = np.flatnonzero(near)
            n = len(rows)
            normal = np.zeros((n, 3))
            around = np.zeros((n, 3))
            distance = np.full(n, np.inf)
            if wall.tube:
                distance = -np.maximum(np.hypot(*position[rows].T[:2]), 1e-300)
                normal[:, :2] = position[rows, :2] / -distance[:, None]
                around[:, 0] = -normal[:, 1]
                around[:, 1] = normal[:, 0]
            else:
                normal[:, wall.axis] = wall.outward
            yield NeighbourPairs(
                rows,
                np.full(n, -1),
                np.zeros((n, len(self.periods)), dtype=np.int64),
                normal,
                distance,
                around[:, :, None] * around[:, None, :],
                np.full(n, wall.name, dtype=object),
                -gaps[rows],
                np.stack([self.radius[rows], np.full(n, np.inf)], axis=1),
                np.zeros((n, 3)),
            )

    def near(
        self, position: Array, periods: Array, gap: float, wall_gap: float | None = None
    ) -> NeighbourPairs:
        """Find pairs of grains with gaps up to ``gap``, m, and grains with gaps below ``wall_gap``
        to walls, by default the same.
        """
        from scipy.spatial import KDTree  # imported on demand: slow to load

        half_lengths = np.array(
            [0.0 if shape is None else shape.length / 2 for shape in self.laws.shapes]
        )
        half = half_lengths[self.kind]
        around = np.where(half > 0, np.hypot(self.radius, half), self.radius)  # enclosing spheres
        reach = 2 * float(around.max()) + gap
        tree = KDTree(position)
        pairs = tree.query_pairs(reach, output_type="ndarray").astype(np.int64)
        blocks = [
            (
                pairs.min(axis=1),
                pairs.max(axis=1),
                np.zeros((len(pairs), len(periods)), dtype=np.int64),
            )
        ]
        low = position.min(axis=0) - reach
        high = position.max(axis=0) + reach
        for image in _images(position, periods, reach):
            shifted = position + np.array(image) @ periods
            inside = np.flatnonzero(((shifted >= low) & (shifted <= high)).all(axis=1))
            if not len(inside):
                continue
            table = tree.sparse_distance_matrix(
                KDTree(shifted[inside]), reach, output_type="coo_matrix"
            )
            first = np.asarray(table.row, dtype=np.int64)
            second = inside[table.col]
            blocks.append(
                (first, second, np.tile(np.array(image, dtype=np.int64), (len(first), 1)))
            )
        first, second, shifts = (np.concatenate(part) for part in zip(*blocks, strict=True))
        near, beyond = self.pairs(
            first, second, shifts, position[second] - position[first] + shifts @ periods
        )
        at_walls = self._at_walls(position, gap if wall_gap is None else wall_gap)
        return joined([joined([near], (-near.overlap <= gap) & ~beyond), *at_walls])

    def laws_of(self, contacts: NeighbourPairs) -> Iterator[Part]:
        """Yield the laws of contacts, each with its rows and their scales."""
        pairs = np.flatnonzero(contacts.second >= 0)
        kind = self.kind[contacts.first]
        radii = contacts.radii
        for law, rows, scale in self.laws.pairs(
            kind[pairs], self.kind[contacts.second[pairs]], radii[pairs]
        ):
            yield law, pairs[rows], scale
        for wall in self.walls:
            own = np.flatnonzero(contacts.wall == wall.name)
            for law, rows, scale in self.laws.wall(wall, kind[own], radii[own, 0]):
                yield law, own[rows], scale


def across(normal: Array) -> Array:
    """Return the projections 1 - e e across unit vectors (n, 3): (n, 3, 3)."""
    return np.asarray(np.eye(3) - normal[:, :, None] * normal[:, None, :])


def joined(tables: Sequence[_Table], kept: NDArray[np.bool_] | slice = slice(None)) -> _Table:
    """Concatenate tables of arrays, and return the rows that are kept."""
    columns: dict[str, Any] = {}
    for field in dataclasses.fields(tables[0]):
        parts = [getattr(table, field.name) for table in tables]
        columns[field.name] = None if parts[0] is None else np.concatenate(parts)[kept]
    return type(tables[0])(**columns)


def _images(position: Array, periods: Array, reach: float) -> list[tuple[int, ...]]:
    """Whole numbers of periods to cells that may hold neighbours; of each pair of opposite cells
    only the first.
    """
    if not len(periods):
        return []
    inverse = np.linalg.pinv(periods)  # rows of the cell to numbers of periods
    extent = np.ptp(position @ inverse, axis=0)
    most = np.ceil(extent + reach * np.linalg.norm(inverse, axis=0)).astype(int)
    steps = itertools.product(*(range(-n, n + 1) for n in most))
    return [image for image in steps if image > (0,) * len(periods)]
