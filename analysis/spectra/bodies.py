"""Grains of a unit cell or of a finite packing at places of their own, with walls and loads, and the contacts there."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.spectra.network import Array, Ints, Network, Springs, Supports, no_supports
from granwave.analysis.spectra.pair_laws import PairLaws, Part
from granwave.lammps_inputs.packing.cylinders import nearest_vectors, turning_projection

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.packing.walls import Wall

_OF_SPHERE, _OF_CYLINDER = 0.4, 0.5  # moments of inertia over m R^2, the second about the axis
_NEGLIGIBLE = 1e-12  # of the mean diameter: overlaps by rounding
_UNLOADED = 1e-7  # of the largest force: contacts that bear nothing but what the search for balance left


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

    def at_wall(self, wall: Wall, position: Array, gap: float) -> Ints:
        """Find the rows of the grains whose gap to a wall is less than ``gap``, m.

        The ends of cylinders do not touch.
        """
        near = wall.gaps(position, self.radius) < gap
        if wall.name in self.touched:
            near &= self.touched[wall.name]
        if self.laws.has_cylinders and not wall.tube:
            ends = [shape is not None and abs(shape.axis[wall.axis]) > 0.5 for shape in self.laws.shapes]
            near &= ~np.array(ends)[self.kind]
        return np.flatnonzero(near)

    def separations(self, first: Ints, second: Ints, step: Array) -> tuple[Array, NDArray[np.bool_], Array | None]:
        """Return how pairs of rows are apart, from vectors between their centres (n, 3), m.

        Returns
        -------
        apart
            Vectors from the first to the second whose lengths are the distances that overlaps count from: (n, 3), m.
        beyond
            True where the nearest places are beyond the end of a cylinder, and nothing touches: (n,).
        turns
            As in `Springs`.
        """
        if not self.laws.has_cylinders:
            return step, np.zeros(len(first), dtype=bool), None
        apart, turns = np.empty_like(step), np.empty((len(first), 3, 3))
        beyond = np.zeros(len(first), dtype=bool)
        shapes = self.laws.shapes
        code = self.kind[first] * len(shapes) + self.kind[second]
        for each in np.unique(code).tolist():
            rows, pair = np.flatnonzero(code == each), (shapes[each // len(shapes)], shapes[each % len(shapes)])
            apart[rows], past = nearest_vectors(step[rows], *pair)
            beyond[rows] = past > -_NEGLIGIBLE * self.spacing
            normal = apart[rows] / np.maximum(np.linalg.norm(apart[rows], axis=1), 1e-300)[:, None]
            turns[rows] = turning_projection(normal, *pair)
        return apart, beyond, turns

    @property
    def spacing(self) -> float:
        """Mean diameter, m."""
        return float(2 * self.radius.mean())

    def near(self, position: Array, periods: Array, gap: float) -> tuple[Ints, Ints, Ints]:
        """Find the pairs of grains whose surfaces are at most ``gap`` apart, m.

        Returns
        -------
        first, second, image
            As in `Springs`; each pair once.
        """
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
        step = position[second] + shifts @ periods - position[first] if len(periods) else (
            position[second] - position[first]
        )  # fmt: skip
        apart, beyond, _ = self.separations(first, second, step)
        close = (np.linalg.norm(apart, axis=1) - self.radius[first] - self.radius[second] <= gap) & ~beyond
        return first[close], second[close], shifts[close]

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
        slack = _NEGLIGIBLE * self.spacing
        first, second, image = self.near(position, periods, -slack)
        step = position[second] - position[first] + (image @ periods if len(periods) else 0.0)
        apart, _, turns = self.separations(first, second, step)
        springs = self.springs(first, second, image, apart, turns, None if peak is None else peak(first, second))
        force, stiffness = springs.force, springs.stiffness
        supports = self._supports(position, wall_peak)
        largest = max(force.max(initial=0.0), supports.force.max(initial=0.0))
        network = Network(
            self.ids,
            self.position,
            self.mass,
            self.inertia,
            self.moves,
            self.periods,
            springs.where((force > _UNLOADED * largest) & (stiffness > 0)),
            supports.where((supports.force > _UNLOADED * largest) & (supports.stiffness > 0)),
        )
        return network.without_idle()

    def springs(
        self, first: Ints, second: Ints, image: Ints, apart: Array, turns: Array | None, peak: Array | None = None
    ) -> Springs:
        """Return the springs of pairs of rows.

        Parameters
        ----------
        image
            As in `Springs`.
        apart, turns
            As `separations` returns them.
        peak
            Largest overlaps so far: (n,), m; by default those of the state.
        """
        distance = np.linalg.norm(apart, axis=1)
        radii = np.stack([self.radius[first], self.radius[second]], axis=1)
        overlap = radii.sum(axis=1) - distance
        most = overlap if peak is None else np.maximum(overlap, peak)
        laws = self.laws.pairs(self.kind[first], self.kind[second], radii)
        force, stiffness, tangential = _small(laws, overlap, most)
        return Springs(
            first, second, image, apart / distance[:, None], distance, force, stiffness, tangential,
            radii - overlap[:, None] / 2, turns,
        )  # fmt: skip

    def _supports(self, position: Array, wall_peak: Callable[[str, Ints], Array] | None) -> Supports:
        slack, tables = _NEGLIGIBLE * self.spacing, []
        for wall in self.walls:
            if wall.held_layer:
                continue
            grain = self.at_wall(wall, position, -slack)
            overlap = -wall.gaps(position[grain], self.radius[grain])
            most = overlap if wall_peak is None else np.maximum(overlap, wall_peak(wall.name, grain))
            force, stiffness, tangential = _small(
                self.laws.wall(wall, self.kind[grain], self.radius[grain]), overlap, most
            )
            normal = np.zeros((len(grain), 3))
            around, turning = np.zeros((len(grain), 3)), np.zeros(len(grain))
            if wall.tube:
                reach = np.hypot(*position[grain].T[:2])
                normal[:, :2] = position[grain, :2] / reach[:, None]
                around[:, 0], around[:, 1] = -normal[:, 1], normal[:, 0]
                turning = force / reach
            else:
                normal[:, wall.axis] = wall.outward
            tables.append(
                Supports(
                    grain, np.full(len(grain), wall.name, dtype=object), normal, force, stiffness, tangential,
                    self.radius[grain] - overlap / 2, turning, around,
                )
            )  # fmt: skip
        if not tables:
            return no_supports()
        return Supports(
            **{
                field.name: np.concatenate([getattr(table, field.name) for table in tables])
                for field in dataclasses.fields(Supports)
            }
        )


def _small(laws: Sequence[Part], overlap: Array, peak: Array) -> tuple[Array, Array, Array]:
    found = np.zeros((3, len(overlap)))
    for law, rows, scale in laws:
        found[:, rows] = law.small(overlap[rows], peak[rows], scale)
    return found[0], found[1], found[2]


def _images(position: Array, periods: Array, reach: float) -> list[tuple[int, ...]]:
    """Whole numbers of periods to cells that may hold neighbours, of each pair of opposite ones only the first."""
    if not len(periods):
        return []
    inverse = np.linalg.pinv(periods)  # rows of the cell to numbers of periods
    extent = np.ptp(position @ inverse, axis=0)
    most = np.ceil(extent + reach * np.linalg.norm(inverse, axis=0)).astype(int)
    steps = itertools.product(*(range(-n, n + 1) for n in most))
    return [image for image in steps if image > (0,) * len(periods)]
