"""Sites of a lattice with different spheres: diameters, materials, vacancies.

Spheres are centred on the sites of the lattice of nominal spheres: smaller spheres leave gaps,
larger spheres need space. The beads of a chain, including those of `[[replace]]`, are stacked in
contact by their nominal diameters; diameters below nominal by the tolerance leave gaps. The
tolerance counts from the nominal diameter of each sphere. On a tilted floor the spheres of a square
packing lean on each other instead (`granwave.lammps_inputs.packing.disorder`).
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import Replace
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material, Shape
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.disorder import (
    diameter_losses,
    lean,
    random_share,
    vacant_sites,
)
from granwave.lammps_inputs.packing.places import Layout, Places, struck_spheres
from granwave.lammps_inputs.packing_kind import TOUCHING


@dataclasses.dataclass(frozen=True, eq=False)
class Sites:
    """Sites of a lattice in the order of their ids; every array is (n_sites,).

    Attributes
    ----------
    nominal
        Nominal diameters, without the scatter, m.
    diameter
        Diameters, m.
    body
        Index of material and shape in ``bodies``.
    bodies
        Materials and shapes, those of the packing first.
    present
        True for sites with a sphere.
    leaning
        Centres of spheres that lean on each other: (n_sites, 3), m; None: they are at the sites.
    uniform
        True if all spheres are equal and none is missing: arrays of a single value, which need no
        memory.
    """

    lattice: Layout
    nominal: NDArray[np.float64]
    diameter: NDArray[np.float64]
    body: NDArray[np.int16]
    bodies: tuple[tuple[Material, Shape], ...]
    present: NDArray[np.bool_]
    leaning: NDArray[np.float64] | None = None
    uniform: bool = False

    def period_of_chain(self, *, whole: bool = False) -> int | None:
        """Return the smallest number of beads that a chain repeats at least twice; None without a
        period.

        Parameters
        ----------
        whole
            True for sequences that fill the chain without a remainder.
        """
        beads = np.stack([self.diameter, self.nominal, self.body], axis=1)
        n = len(self.body)
        periods = (p for p in range(1, n // 2 + 1) if (beads[p:] == beads[:-p]).all())
        return next((p for p in periods if not (whole and n % p)), None)

    def made_of(self, *materials: Material) -> NDArray[np.bool_]:
        """Select the spheres of these materials: (n_sites,)."""
        return self.present & np.isin(
            self.body, [n for n, (one, _) in enumerate(self.bodies) if one in materials]
        )

    @cached_property
    def count(self) -> int:
        """Number of spheres."""
        return len(self.present) if self.uniform else int(np.count_nonzero(self.present))

    @cached_property
    def like(self) -> bool:
        """True if all spheres are of the first material and the nominal diameter of the lattice."""
        return self.uniform or (
            not self.body.any() and bool((self.nominal == self.lattice.diameter).all())
        )

    @cached_property
    def stacked(self) -> NDArray[np.float64] | None:
        """Positions along z of the beads of a chain with different nominal diameters: (n_sites,),
        m; None otherwise.
        """
        if (
            self.uniform
            or not self.lattice.rule.is_chain
            or (self.nominal == self.lattice.diameter).all()
        ):
            return None
        radii = self.nominal / 2
        return np.concatenate([[0.0], np.cumsum(radii[1:] + radii[:-1])])

    @cached_property
    def largest(self) -> float:
        """Diameter of the largest sphere, m."""
        return float(self.diameter[0] if self.uniform else self.diameter[self.present].max())

    @property
    def least_reach(self) -> float:
        """Smallest over all materials of their largest diameter, m: the shortest contact distance
        of such spheres.
        """
        return min(
            float(self.diameter[self.present & (self.body == k)].max())
            for k in np.unique(self.body)
        )

    @property
    def centres(self) -> NDArray[np.float64]:
        """Centres of the spheres: (count, 3), m."""
        every = self.positions(1, len(self.present))
        return every if self.count == len(every) else every[self.present]

    def positions(self, first: int, last: int) -> NDArray[np.float64]:
        """Return the centres of the sites with ids ``first`` to ``last``: (n, 3), m."""
        if self.leaning is not None:
            return self.leaning[first - 1 : last].copy()
        positions = self.lattice.positions(first, last)
        if self.stacked is not None:
            positions[:, 2] = self.stacked[first - 1 : last]
        return positions

    def neighbours(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """Iterate over pairs of spheres at neighbouring sites, in batches: ids (n, 2), i < j, and
        gaps (n,), m.
        """
        for pairs in self.lattice.pairs():
            if self.count < len(self.present):
                pairs = pairs[self.present[pairs - 1].all(axis=1)]
            apart: float | NDArray[np.float64]
            if isinstance(self.lattice, Places):
                apart = self.lattice.apart(pairs)
            elif self.leaning is not None:
                first, second = pairs.T - 1
                apart = np.linalg.norm(self.leaning[second] - self.leaning[first], axis=1)
            elif self.stacked is not None:
                apart = self.nominal[pairs - 1].sum(axis=1) / 2
            else:
                apart = self.lattice.spacing
            yield pairs, apart - self.diameter[pairs - 1].sum(axis=1) / 2

    @cached_property
    def _counts(self) -> tuple[int, int]:
        """Return the numbers of neighbouring and of touching pairs."""
        stacked = self.nominal if self.lattice.rule.is_chain else self.lattice.diameter
        if self.uniform or (self.count == len(self.present) and (self.diameter == stacked).all()):
            return (
                self.lattice.n_contacts,
                self.lattice.n_contacts,
            )  # only the materials differ
        sizes = [
            (len(pairs), int(np.count_nonzero(self._touch(pairs, gaps))))
            for pairs, gaps in self.neighbours()
        ]
        n_neighbours, n_touching = np.sum(sizes, axis=0, dtype=int).tolist() if sizes else (0, 0)
        return n_neighbours, n_touching + len(self._contacts_of_larger())

    @property
    def n_neighbours(self) -> int:
        """Number of pairs of spheres at neighbouring sites."""
        return self._counts[0]

    @property
    def n_contacts(self) -> int:
        """Number of touching pairs."""
        return self._counts[1]

    def contacts(self) -> Iterator[NDArray[np.int64]]:
        """Iterate over the ids of touching pairs (n, 2), i < j, in batches."""
        for pairs, gaps in self.neighbours():
            yield pairs[self._touch(pairs, gaps)]
        yield self._contacts_of_larger()

    def _touch(self, pairs: NDArray[np.int64], gaps: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Select the touching pairs; pairs with larger spheres are found by `near_larger`."""
        slack = TOUCHING * self.lattice.diameter
        if isinstance(self.lattice, Places):
            return gaps <= slack  # initial overlaps are contacts too, where they are requested
        touching = np.abs(gaps + self.lattice.overlap) <= slack
        return touching & ~self.larger[pairs - 1].any(axis=1) if self.larger.any() else touching

    def _contacts_of_larger(self) -> NDArray[np.int64]:
        pairs, gaps = self.near_larger()
        return pairs[np.abs(gaps) <= TOUCHING * self.lattice.diameter]

    def near_larger(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Find the touching and overlapping pairs with a sphere larger than the lattice spacing;
        none in chains.

        Returns ids (n, 2), i < j, and gaps (n,), m, negative for overlaps. Such spheres may reach
        beyond the neighbouring sites. A pair of equal ids is a sphere and its own image.
        """
        present = np.flatnonzero(self.present)
        large = np.flatnonzero(self.larger & self.present)
        if not large.size:
            return np.empty((0, 2), dtype=np.int64), np.empty(0)
        from scipy.spatial import KDTree  # imported on demand: slow to load

        centres = self.positions(1, len(self.present))
        tree = KDTree(centres[present])
        slack = TOUCHING * self.lattice.diameter
        reach = (self.diameter[large] + self.diameter[present].max()) / 2 + slack
        pairs_of_shifts = []
        gaps_of_shifts = []
        for shift in self._shifts():
            around = tree.query_ball_point(centres[large] + shift, reach)
            rows = np.repeat(large, [len(neighbours) for neighbours in around])
            others = present[np.concatenate([np.asarray(n, dtype=np.int64) for n in around])]
            apart = np.linalg.norm(centres[rows] + shift - centres[others], axis=1)
            gaps = apart - (self.diameter[rows] + self.diameter[others]) / 2
            keep = (gaps <= slack) & ((rows != others) | bool(shift.any()))
            pairs = np.stack([np.minimum(rows, others) + 1, np.maximum(rows, others) + 1], axis=1)
            pairs_of_shifts.append(pairs[keep])
            gaps_of_shifts.append(gaps[keep])
        pairs = np.concatenate(pairs_of_shifts)
        gaps = np.concatenate(gaps_of_shifts)
        order = np.argsort(gaps, kind="stable")  # the smallest gap of a pair counts
        pairs, first = np.unique(pairs[order], axis=0, return_index=True)
        return pairs, gaps[order][first]

    def _shifts(self) -> Iterator[NDArray[np.float64]]:
        """Iterate over the shifts of the images of the packing, first the shift 0: (3,), m."""
        x, y = self.lattice.lengths
        steps = (0, -1, 1) if self.lattice.periodic else (0,)
        for along_x, along_y in itertools.product(steps, steps):
            yield np.array([along_x * x, along_y * y, 0.0])

    @cached_property
    def larger(self) -> NDArray[np.bool_]:
        """True for spheres larger than the lattice spacing: (n_sites,); none in a chain and among
        grains of a file.
        """
        rule = self.lattice.rule
        if self.uniform or rule.is_chain or not rule.is_lattice:
            return np.zeros(len(self.present), dtype=bool)
        return self.diameter > self.lattice.diameter


def sites_of(case: Case, lattice: Layout) -> Sites:
    """Return the sites of the lattice of a case.

    Raises
    ------
    ValueError
        A fraction of vacancies leaves too few spheres, or spheres on a tilted floor do not fit.
    """
    packing = case.packing
    n = lattice.n_spheres
    if isinstance(lattice, Places):
        return _sites_of_grains(case, lattice)
    like = np.broadcast_to(packing.diameter, n)
    uniform = Sites(
        lattice, like, like, np.broadcast_to(np.int16(0), n), ((case.material, packing.of_grain),),
        np.broadcast_to(True, n), uniform=True,
    )  # fmt: skip
    if not (packing.diameter_scatter or packing.vacancies or case.replace):
        return uniform
    kept = named_spheres(case, lattice)
    present = np.ones(n, dtype=bool)
    present[vacant_sites(packing, n, kept)] = False
    nominal = np.full(n, packing.diameter)
    kind = np.zeros(n, dtype=np.int16)
    materials = [case.material]
    for place, entry in enumerate(case.replace, start=1):
        chosen = chosen_sites(packing, lattice, entry, place, present)
        material = entry.material or case.material
        if material not in materials:
            materials.append(material)
        nominal[chosen] = entry.diameter or packing.diameter
        kind[chosen] = materials.index(material)
    diameter = nominal - diameter_losses(packing, n) if packing.diameter_scatter else nominal
    used = np.union1d([0], kind[present])
    kind = np.searchsorted(used, np.where(present, kind, 0)).astype(np.int16)
    leaning = None
    if packing.tilt is not None and (diameter < packing.diameter).any():
        leaning = lean(packing.size, packing.diameter, diameter, packing.tilt)
    bodies = tuple((materials[k], packing.of_grain) for k in used)
    found = Sites(lattice, nominal, diameter, kind, bodies, present, leaning)
    return uniform if found.like and diameter is nominal and present.all() else found


def _sites_of_grains(case: Case, places: Places) -> Sites:
    """Return the sites of grains of a file, each with its own diameter, material and shape."""
    grains = places.grains
    found = {name: case.named_material(name) for name in dict.fromkeys(grains.material)}
    each = list(zip(grains.material, grains.shape, strict=True))
    distinct = {(name, shape): (found[name], shape) for name, shape in each}
    shapes = dict.fromkeys(grains.shape)
    order = []
    for material in dict.fromkeys([case.material, *found.values()]):
        for shape in shapes:
            order.append((material, shape))
    bodies = [one for one in order if len(shapes) == 1 or one in distinct.values()]
    number = {key: bodies.index(one) for key, one in distinct.items()}
    body = np.array([number[key] for key in each], dtype=np.int16)
    return Sites(
        places,
        grains.diameter,
        grains.diameter,
        body,
        tuple(bodies),
        np.ones(len(grains), dtype=bool),
    )


def named_spheres(case: Case, lattice: Lattice) -> dict[int, str]:
    """Return the spheres that a case names, with the keys that name them; they are never vacant."""
    names = [case.load.named(partial(struck_spheres, lattice))]
    probed = itertools.chain.from_iterable(probe.spheres for probe in case.output.probes)
    names += [("output.probes", [*probed])]
    names += [
        (f"sensor.{place}.id", (sensor.id,)) for place, sensor in enumerate(case.sensor, start=1)
    ]
    names += [
        (f"striker.{place}.touches", striker.touches)
        for place, striker in enumerate(case.striker, start=1)
    ]
    names += [
        (f"replace.{place}.index", entry.index or ())
        for place, entry in enumerate(case.replace, start=1)
    ]
    keys = dict[int, str]()
    for key, spheres in reversed(names):
        keys |= {sphere: key for sphere in spheres if sphere <= lattice.n_spheres}
    return keys


def chosen_sites(
    packing: PackingSection, lattice: Layout, entry: Replace, place: int, present: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Return the sites, from 0, that a ``[[replace]]`` entry changes; ``place`` is its number from
    1.

    A box is compared with the sites of the lattice of equal spheres, with a margin of ``TOUCHING``.
    """
    if entry.index is not None:
        return np.array(entry.index, dtype=np.int64) - 1
    if entry.share is not None:
        return random_share(packing, entry, place, present)
    centres = lattice.positions(1, lattice.n_spheres)
    slack = TOUCHING * lattice.diameter
    low = np.array(entry.low)
    high = np.array(entry.high)
    return np.flatnonzero(((centres >= low - slack) & (centres <= high + slack)).all(axis=1))
