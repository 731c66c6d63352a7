"""Grains of a unit cell or of a finite packing at places of their own, with walls and loads, and the contacts there."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.spectra.network import Array, Ints, Network, Springs, Supports, across, joined
from granwave.analysis.spectra.pair_laws import PairLaws
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.cylinders import nearest_vectors, turning_projection
from granwave.lammps_inputs.packing.walls import Wall

_OF_SPHERE, _OF_CYLINDER = 0.4, 0.5  # moments of inertia over m R^2, the second about the axis
_NEGLIGIBLE = 1e-12  # of the mean diameter: overlaps by rounding
_UNLOADED = 1e-7  # of the largest force: contacts that bear nothing but what the search for balance left


@dataclasses.dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of grains near each other, each once.

    Attributes
    ----------
    first, second, image, normal, turns
        As in `Springs`.
    distance, overlap
        Distances that overlaps count from, and overlaps: (n,), m.
    radii
        Radii of both grains: (n, 2), m.
    shift
        Vectors between their cells before the load: (n, 3), m.
    """

    first: Ints
    second: Ints
    image: Ints
    normal: Array
    turns: Array | None
    distance: Array
    overlap: Array
    radii: Array
    shift: Array


@dataclasses.dataclass(frozen=True, eq=False)
class Bodies:
    """Grains before they are loaded.

    Attributes
    ----------
    ids
        Ids: (n,).
    position
        Centres before the load: (n, 3), m.
    radius, mass
        (n,), m and kg.
    kind
        Places of their materials and shapes in ``laws.bodies``: (n,).
    moves
        As in `Network`.
    periods
        As in `Network`.
    walls
        Walls, in their final places.
    dead_load
        Constant forces: (n, 3), N.
    stress
        Load on the cell: forces times lengths for each strain that is free, ``{(2, 2): N m}``; compression positive.
    touched
        Grains on which a wall acts, by its name: (n,); of walls that are not there: all.
    """

    case: Case
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

    @property
    def inertia(self) -> Array:
        """Moments of inertia, of cylinders about their axis: (n,), kg m^2."""
        factor = np.array([_OF_SPHERE if shape is None else _OF_CYLINDER for shape in self.laws.shapes])[self.kind]
        return np.asarray(factor * self.mass * self.radius**2)

    def at_walls(self, position: Array, gap: float) -> Iterator[tuple[Wall, Ints, Array, Array]]:
        """Give each wall with the rows of the grains whose gap to it is less than ``gap``, m, overlaps and normals.

        Overlaps are (n,), m, and unit vectors to the wall (n, 3). The ends of cylinders do not touch.
        """
        for wall in self.walls:
            if wall.held_layer:
                continue
            gaps = wall.gaps(position, self.radius)
            near = gaps < gap
            if wall.name in self.touched:
                near &= self.touched[wall.name]
            if self.laws.has_cylinders and not wall.tube:
                ends = [shape is not None and abs(shape.axis[wall.axis]) > 0.5 for shape in self.laws.shapes]
                near &= ~np.array(ends)[self.kind]
            rows = np.flatnonzero(near)
            normal = np.zeros((len(rows), 3))
            if wall.tube:
                reach = np.maximum(np.hypot(*position[rows].T[:2]), 1e-300)
                normal[:, :2] = position[rows, :2] / reach[:, None]
            else:
                normal[:, wall.axis] = wall.outward
            yield wall, rows, -gaps[rows], normal

    def pairs(
        self, first: Ints, second: Ints, image: Ints, step: Array, lengths: Array | None = None
    ) -> tuple[Pairs, NDArray[np.bool_]]:
        """Return pairs of rows from the vectors between their centres (n, 3), m, and True where nothing touches.

        That is where the nearest places are beyond the end of a cylinder. Distances may be given: (n,), m.
        """
        apart, turns, beyond = step, None, np.zeros(len(first), dtype=bool)
        if self.laws.has_cylinders:
            apart, turns = np.empty_like(step), np.empty((len(first), 3, 3))
            shapes = self.laws.shapes
            code = self.kind[first] * len(shapes) + self.kind[second]
            for each in np.unique(code).tolist():
                rows, pair = np.flatnonzero(code == each), (shapes[each // len(shapes)], shapes[each % len(shapes)])
                apart[rows], past = nearest_vectors(step[rows], *pair)
                beyond[rows] = past > -_NEGLIGIBLE * self.spacing
                normal = apart[rows] / np.maximum(np.linalg.norm(apart[rows], axis=1), 1e-300)[:, None]
                turns[rows] = turning_projection(normal, *pair)
        distance = np.linalg.norm(apart, axis=1)
        radii = np.stack([self.radius[first], self.radius[second]], axis=1)
        if lengths is not None:
            apart, distance = apart * (lengths / distance)[:, None], lengths
        with np.errstate(invalid="ignore"):
            normal = apart / distance[:, None]
        overlap = radii.sum(axis=1) - distance
        return Pairs(first, second, image, normal, turns, distance, overlap, radii, image @ self.periods), beyond

    @property
    def spacing(self) -> float:
        """Mean diameter, m."""
        return float(2 * self.radius.mean())

    def near(self, position: Array, periods: Array, gap: float) -> Pairs:
        """Find the pairs of grains whose surfaces are at most ``gap`` apart, m."""
        from scipy.spatial import KDTree  # takes longer to load than most commands need

        half = np.array([0.0 if shape is None else shape.length / 2 for shape in self.laws.shapes])[self.kind]
        around = np.where(half > 0, np.hypot(self.radius, half), self.radius)  # radii of spheres around the grains
        reach = 2 * float(around.max()) + gap
        tree = KDTree(position)
        pairs = tree.query_pairs(reach, output_type="ndarray").astype(np.int64)
        found = [(pairs.min(axis=1), pairs.max(axis=1), np.zeros((len(pairs), len(periods)), dtype=np.int64))]
        low, high = position.min(axis=0) - reach, position.max(axis=0) + reach
        for image in _images(position, periods, reach):
            shifted = position + np.array(image) @ periods
            inside = np.flatnonzero(((shifted >= low) & (shifted <= high)).all(axis=1))
            if not len(inside):
                continue
            table = tree.sparse_distance_matrix(KDTree(shifted[inside]), reach, output_type="coo_matrix")
            first, second = np.asarray(table.row, dtype=np.int64), inside[table.col]
            found.append((first, second, np.tile(np.array(image, dtype=np.int64), (len(first), 1))))
        first, second, shifts = (np.concatenate(part) for part in zip(*found, strict=True))
        near, beyond = self.pairs(first, second, shifts, position[second] - position[first] + shifts @ periods)
        return joined([near], (-near.overlap <= gap) & ~beyond)

    def network(
        self, position: Array, periods: Array, peak: Callable[[Ints, Ints], Array] | None = None,
        wall_peak: Callable[[str, Ints], Array] | None = None,
    ) -> Network:  # fmt: skip
        """Return the springs of the contacts that bear force in a state.

        Parameters
        ----------
        position
            Centres in the static state: (n, 3), m.
        periods
            Periods in the static state: (n_periods, 3), m.
        peak, wall_peak
            Functions that give the largest overlaps so far, m, of pairs of rows, and of rows at a wall; by default
            those of the state.
        """
        slack = -_NEGLIGIBLE * self.spacing
        near = self.near(position, periods, slack)
        springs = self.springs(near, None if peak is None else peak(near.first, near.second))
        supports = self._supports(position, slack, wall_peak)
        least = _UNLOADED * max(springs.force.max(initial=0.0), supports.force.max(initial=0.0))
        springs = joined([springs], (springs.force > least) & (springs.stiffness > 0))
        return self.with_springs(springs, joined([supports], (supports.force > least) & (supports.stiffness > 0)))

    def with_springs(self, springs: Springs, supports: Supports) -> Network:
        """Return the network of these contacts, without grains that nothing touches."""
        given = self.ids, self.position, self.mass, self.inertia, self.moves, self.periods
        return Network(*given, springs, supports).without_idle()

    def springs(self, pairs: Pairs, peak: Array | None = None) -> Springs:
        """Return the springs of pairs; ``peak`` are the largest overlaps so far, (n,), m, by default those now."""
        most = pairs.overlap if peak is None else np.maximum(pairs.overlap, peak)
        force, stiffness, tangential = np.zeros((3, len(most)))
        for law, rows, scale in self.laws.pairs(self.kind[pairs.first], self.kind[pairs.second], pairs.radii):
            force[rows], stiffness[rows], tangential[rows] = law.small(pairs.overlap[rows], most[rows], scale)
        return Springs(
            pairs.first, pairs.second, pairs.image, pairs.normal, pairs.distance, force, stiffness, tangential,
            pairs.radii - pairs.overlap[:, None] / 2, across(pairs.normal) if pairs.turns is None else pairs.turns,
        )  # fmt: skip

    def _supports(self, position: Array, gap: float, wall_peak: Callable[[str, Ints], Array] | None) -> Supports:
        tables = [Supports.none()]
        for wall, grain, overlap, normal in self.at_walls(position, gap):
            most = overlap if wall_peak is None else np.maximum(overlap, wall_peak(wall.name, grain))
            force, stiffness, tangential, turning = np.zeros((4, len(grain)))
            for law, rows, scale in self.laws.wall(wall, self.kind[grain], self.radius[grain]):
                force[rows], stiffness[rows], tangential[rows] = law.small(overlap[rows], most[rows], scale)
            around = np.zeros_like(normal)
            if wall.tube:
                around[:, 0], around[:, 1] = -normal[:, 1], normal[:, 0]
                turning = force / np.hypot(*position[grain].T[:2])
            names = np.full(len(grain), wall.name, dtype=object)
            lever = self.radius[grain] - overlap / 2
            tables.append(Supports(grain, names, normal, force, stiffness, tangential, lever, turning, around))
        return joined(tables)


def _images(position: Array, periods: Array, reach: float) -> list[tuple[int, ...]]:
    """Whole numbers of periods to cells that may hold neighbours, of each pair of opposite ones only the first."""
    if not len(periods):
        return []
    inverse = np.linalg.pinv(periods)  # rows of the cell to numbers of periods
    extent = np.ptp(position @ inverse, axis=0)
    most = np.ceil(extent + reach * np.linalg.norm(inverse, axis=0)).astype(int)
    steps = itertools.product(*(range(-n, n + 1) for n in most))
    return [image for image in steps if image > (0,) * len(periods)]
