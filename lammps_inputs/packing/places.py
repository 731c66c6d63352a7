"""Grains at user-defined positions, with the properties of a lattice, and the impacted spheres of
any packing.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import combinations_with_replacement
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.bodies import Striker
from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.case.packing.values import Enclosure
from granwave.lammps_inputs.lattices import FILE, Lattice, kind_of, lattice_kinds, middle_of
from granwave.lammps_inputs.packing.cylinders import distances, extents, nearest_image, reaches
from granwave.lammps_inputs.packing_kind import TOUCHING, PackingKind

_AROUND = 10  # largest distance from the middle of a grain to touch, in sums of the radii


@dataclasses.dataclass(frozen=True, eq=False)
class Places:
    """Positions of grains, in the order of their ids; see
    `granwave.lammps_inputs.lattices.Lattice`.

    Attributes
    ----------
    grains
        The grains.
    diameter
        Nominal diameter, m: a gap of 1e-6 of it still counts as touching.
    period
        Periods along x and y, m; None if the packing is not periodic.
    enclosure
        Planes of its walls; None: they touch the outermost grains.
    """

    grains: Grains
    diameter: float
    period: tuple[float, float] | None = None
    enclosure: Enclosure | None = None
    kind: str = FILE

    @property
    def periodic(self) -> bool:
        """True if the packing is periodic along x and y."""
        return self.period is not None

    @property
    def rule(self) -> PackingKind:
        """Properties of the kind."""
        return kind_of(self.kind)

    @property
    def n_spheres(self) -> int:
        """Number of grains."""
        return len(self.grains)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of grains, 1, 1: there are neither rows nor layers."""
        return self.n_spheres, 1, 1

    @property
    def size(self) -> tuple[int, ...]:
        """Number of grains."""
        return (self.n_spheres,)

    @property
    def n_layers(self) -> int:
        """One: there are no layers."""
        return 1

    @property
    def lengths(self) -> tuple[float, float]:
        """Periods along x and y, or without them the extent, grains included, m."""
        width, depth, _ = np.ptp(self.faces(), axis=0).tolist()
        return self.period or (width, depth)

    @property
    def top_layer(self) -> NDArray[np.int64]:
        """Ids of the grains with the uppermost centres (the lowest z), in rising order."""
        depth = self.grains.position[:, 2]
        return 1 + np.flatnonzero(depth - depth.min() <= TOUCHING * self.diameter)

    @cached_property
    def middle_of_top(self) -> int:
        """Id of the grain of the top layer nearest to the centroid of this layer, see
        `granwave.lammps_inputs.lattices.middle_of`.
        """
        ids = self.top_layer
        return middle_of(ids, self.grains.position[ids - 1], self.diameter)

    def within_reach(self, radius: float) -> int:
        """Return the id of the grain nearest to the middle of the packing on whose top a sphere of
        this radius (m) rests without touching another grain.
        """
        position = self.grains.position
        radii = self.grains.diameter / 2
        faces = self.faces()[:, :2]
        middle = (faces.min(axis=0) + faces.max(axis=0)) / 2
        aside = np.linalg.norm(position[:, :2] - middle, axis=1)
        touching = radius + radii.max()
        nearest = np.argsort(aside, kind="stable")
        around = nearest[: np.searchsorted(aside[nearest], _AROUND * touching)]
        for grain in around:
            centre = position[grain] - [0.0, 0.0, radii[grain] + radius]
            near = np.flatnonzero(aside <= aside[grain] + touching)
            apart = np.linalg.norm(nearest_image(position[near] - centre, self.period), axis=1)
            free = apart - radii[near] - radius > -TOUCHING * self.diameter
            if free[near != grain].all():
                return int(grain) + 1
        return int(self.top_layer[0])  # nothing is above the uppermost grain

    @property
    def last_layer(self) -> NDArray[np.int64]:
        """Ids of the grains that a plane below would touch, in rising order."""
        below = (
            self.grains.position[:, 2] + extents(self.grains.diameter / 2, self.grains.shape)[:, 2]
        )
        return 1 + np.flatnonzero(below.max() - below <= TOUCHING * self.diameter)

    @property
    def n_contacts(self) -> int:
        """Number of touching pairs."""
        return len(self._near[0])

    def positions(self, first: int, last: int) -> NDArray[np.float64]:
        """Return the centres of the grains with ids ``first`` to ``last``, both included: (n, 3),
        m.
        """
        return self.grains.position[first - 1 : last].copy()

    def bounds(self) -> NDArray[np.float64]:
        """Return the lowest and highest coordinates of centres along x, y, z: (2, 3), m."""
        return np.stack([self.grains.position.min(axis=0), self.grains.position.max(axis=0)])

    def faces(self) -> NDArray[np.float64]:
        """Return the coordinates of the planes that enclose the grains along x, y, z: (2, 3), m."""
        extent = extents(self.grains.diameter / 2, self.grains.shape)
        surfaces = np.stack(
            [
                (self.grains.position - extent).min(axis=0),
                (self.grains.position + extent).max(axis=0),
            ]
        )
        return surfaces if self.enclosure is None else self.enclosure.around(surfaces)

    def pairs(self) -> Iterator[NDArray[np.int64]]:
        """Iterate over the touching pairs in batches of ids (n, 2), i < j; every pair once."""
        yield self._near[0]

    def apart(self, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the distances of pairs of ids (n, 2), from which overlaps are computed: (n,), m;
        see `distances`.
        """
        grains = self.grains
        first, second = pairs.T - 1
        return distances(grains.position, grains.diameter, grains.shape, first, second, self.period)

    def overlapping(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the pairs that overlap at the start, deepest first: ids (n, 2), i < j, and
        overlaps (n,), m.
        """
        pairs, gaps = self._near
        deep = gaps < -TOUCHING * self.diameter
        order = np.argsort(gaps[deep], kind="stable")
        return pairs[deep][order], -gaps[deep][order]

    def neighbours(self, sphere: int) -> list[int]:
        """Return the ids of the neighbours of a grain, in rising order."""
        pairs = self._near[0]
        return np.sort(pairs[:, ::-1][pairs == sphere]).tolist()

    def layer_of(self, sphere: int) -> int:
        """Return 0: there are no layers."""
        return 0

    @cached_property
    def _near(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Touching and overlapping pairs, sorted: ids (n, 2), i < j, and gaps (n,), m."""
        slack = TOUCHING * self.diameter
        rows = near_pairs(self.grains.position, reaches(self.grains), slack, self.period)
        pairs = 1 + rows[self.grains.of_different_clumps(rows)]
        gaps = self.apart(pairs) - self.grains.diameter[pairs - 1].sum(axis=1) / 2
        close = gaps <= slack
        pairs = pairs[close]
        gaps = gaps[close]
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        return pairs[order], gaps[order]


def near_pairs(
    position: NDArray[np.float64],
    radius: NDArray[np.float64],
    slack: float,
    period: tuple[float, float] | None = None,
) -> NDArray[np.int64]:
    """Find all pairs of rows with surfaces at most ``slack`` apart, and some wider pairs: (n, 2), i
    < j.

    Classes of size keep the search short if a few grains are much larger than the others.

    Parameters
    ----------
    period
        Periods along x and y, m.
    """
    from scipy.spatial import KDTree  # imported on demand: slow to load

    box = None
    if period is not None:
        # 0: not periodic along z
        box = np.array([*period, 0.0])
        position = position.copy()
        position[:, :2] = np.mod(position[:, :2], period)
        # rounding of the remainder
        position[:, :2][position[:, :2] >= period] = 0.0
    found = [np.empty((0, 2), dtype=np.int64)]
    classes = np.floor(np.log2(radius / radius.min()) + 1e-9)
    members = [np.flatnonzero(classes == one) for one in np.unique(classes)]
    trees = [KDTree(position[rows], boxsize=box) for rows in members]
    for one, other in combinations_with_replacement(range(len(members)), 2):
        reach = radius[members[one]].max() + radius[members[other]].max() + slack
        if one == other:
            near = trees[one].query_pairs(reach, output_type="ndarray")
        else:
            table = trees[one].sparse_distance_matrix(trees[other], reach, output_type="coo_matrix")
            near = np.stack([table.row, table.col], axis=1)
        found.append(np.stack([members[one][near[:, 0]], members[other][near[:, 1]]], axis=1))
    return np.sort(np.concatenate(found).astype(np.int64), axis=1)


Layout: TypeAlias = Lattice | Places  # arrangement of the spheres of a packing


def layout_of(packing: PackingSection, boundary: Boundary) -> Layout:
    """Return the lattice of a packing, or the positions of its grains."""
    periodic = boundary.periodic
    if packing.grains is None:
        return packing.lattice(periodic=periodic)
    period = packing.period if periodic else None
    return Places(packing.grains, packing.diameter, period, packing.enclosure)


def cohesive_law(case: Case, partner: Material | None, *, flat: bool = False) -> ContactLaw:
    """Return the law of spheres of the packing with each other, or a flat, of a material (None:
    rigid).
    """
    contact = case.contact_between(case.material, partner)
    radius = case.packing.diameter / 2
    return contact.between((case.material, partner), (radius, math.inf if flat else radius))


def balanced_overlap(case: Case, partner: Material | None, *, flat: bool = False) -> float:
    """Return the overlap at which spheres with the law of `cohesive_law` carry no force, m; 0
    without cohesion.
    """
    coheres = case.contact_between(case.material, partner).coheres
    return float(cohesive_law(case, partner, flat=flat).balanced_overlap) if coheres else 0.0


def struck_spheres(lattice: Layout, count: int) -> tuple[int, ...]:
    """Return the ids of the loaded spheres; the first one is the impacted sphere.

    The impacted sphere is in the middle of the top layer, see `middle_of_top`. A ``count`` of 3 adds the two neighbours that rest with it on the
    same sphere of the next layer (the pair with the lowest ids if there are several), 7 its six
    neighbours in the layer.

    Raises
    ------
    ValueError
        The packing has no such neighbours.
    """
    centre = lattice.middle_of_top
    if count == 1:
        return (centre,)
    if not lattice.rule.hexagonal:
        able = " or ".join(name for name, kind in lattice_kinds().items() if kind.hexagonal)
        raise ValueError(f"{count} spheres require hexagonal layers ({able}), found {lattice.kind}")
    neighbours = lattice.neighbours(centre)
    around = [sphere for sphere in neighbours if lattice.layer_of(sphere) == 0]
    below = [sphere for sphere in neighbours if lattice.layer_of(sphere) == 1]
    if count == 7:
        if len(around) != 6:
            raise ValueError(
                f"the impacted sphere has {len(around)} neighbours in the top layer, 7 spheres "
                "require 6"
            )
        return (centre, *around)
    pairs = []
    for support in below:
        resting = [sphere for sphere in lattice.neighbours(support) if sphere in around]
        if len(resting) == 2:
            pairs.append(resting)
    if not pairs:
        raise ValueError(
            "no two neighbours of the impacted sphere rest with it on one sphere below"
        )
    return (centre, *min(pairs))


def centred(
    strikers: Sequence[Striker], packing: PackingSection, boundary: Boundary
) -> tuple[Striker, ...]:
    """Return strikers; if they touch the sphere at the centre of the top, its id is filled in."""
    if all(striker.touches for striker in strikers):
        return tuple(strikers)
    layout = layout_of(packing, boundary)
    centre = struck_spheres(layout, 1)
    placed = []
    for striker in strikers:
        touches = striker.touches or centre
        if not striker.touches and isinstance(layout, Places) and len(layout.top_layer) == 1:
            radius = (striker.diameter or layout.diameter) / 2
            touches = (layout.within_reach(radius),)
        placed.append(dataclasses.replace(striker, touches=touches))
    return tuple(placed)
