"""Crystals in the x-z plane, whose straight rows are layers: sites and neighbours of grain (i, 0, k).

Rows alternate between n and n - 1 grains, so that both sides are straight, or all have n. The long rows begin at x = 0,
the short ones (or every second row of n) half a pitch further; ids count along the rows, from the struck one on.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.lattices import KINDS, Lattice, Offset

ROWS = ("long", "short", "equal")  # choices of `packing.top_row`
_IMAGE = 8.0  # period along y of a periodic crystal, diameters: its images are far apart


def is_plane_crystal(kind: str) -> bool:
    """Return True for a kind of packing in the x-z plane."""
    return kind in KINDS and KINDS[kind].axes == "xz"


@dataclasses.dataclass(frozen=True)
class PlaneLattice(Lattice):
    """A crystal in the x-z plane; see `granwave.lammps_inputs.lattices.Lattice`.

    Attributes
    ----------
    top_row
        Struck row: ``long`` (n grains) or ``short`` (n - 1); ``equal``: all rows have n.
    """

    top_row: str = "long"

    @cached_property
    def row_lengths(self) -> NDArray[np.int64]:
        """Numbers of grains of the rows: (n_layers,)."""
        n, layers = self.size
        shifted = self._shifted_rows(np.arange(layers))
        return np.where(shifted & (self.top_row != "equal"), n - 1, n)

    @cached_property
    def _before(self) -> NDArray[np.int64]:
        """Numbers of grains before each row, and of all: (n_layers + 1,)."""
        return np.concatenate([[0], np.cumsum(self.row_lengths)])

    @property
    def n_spheres(self) -> int:
        """Number of grains."""
        return int(self._before[-1])

    @property
    def top_layer(self) -> NDArray[np.int64]:
        """Ids of the grains of the struck row, in rising order."""
        return np.arange(1, self._before[1] + 1)

    @property
    def last_layer(self) -> NDArray[np.int64]:
        """Ids of the grains of the last row, in rising order."""
        return np.arange(self._before[-2] + 1, self._before[-1] + 1)

    @property
    def lengths(self) -> tuple[float, float]:
        """Periods of a periodic crystal along x and y, or the width of its long rows and the diameter, m."""
        n, pitch = self.size[0], self.rule.pitch[0]
        across = n * pitch if self.periodic else (n - 1) * pitch + 1
        return across * self.diameter, (_IMAGE if self.periodic else 1.0) * self.diameter

    @cached_property
    def n_contacts(self) -> int:
        """Number of touching pairs."""
        return sum(len(batch) for batch in self.pairs())

    def positions(self, first: int, last: int) -> NDArray[np.float64]:
        """Return the centres of the grains with ids ``first`` to ``last``, both included: (n, 3), m."""
        index = np.arange(first - 1, last)
        k = np.searchsorted(self._before, index, side="right") - 1
        i = index - self._before[k]
        x, y, _ = self.rule.site(i, np.zeros_like(i), self._shifted_rows(k) * 1)
        return np.stack([x, y, self.rule.site(i, np.zeros_like(i), k)[2]], axis=1) * self.diameter

    def bounds(self) -> NDArray[np.float64]:
        """Return the lowest and highest coordinates of centres along x, y, z: (2, 3), m."""
        ends = [self.positions(1, int(self._before[min(2, len(self.row_lengths))]))]
        ends.append(self.positions(int(self._before[-2]) + 1, int(self._before[-1])))
        sites = np.concatenate(ends)
        return np.stack([sites.min(axis=0), sites.max(axis=0)])

    def pairs(self) -> Iterator[NDArray[np.int64]]:
        """Iterate over the touching pairs, row by row: ids (n, 2), i < j."""
        for k, count in enumerate(self.row_lengths.tolist()):
            i = np.arange(count)
            own = 1 + self._before[k] + i
            for offset in self._steps(k):
                other, exists = self._moved(i, k, offset)
                keep = exists & (own < other)
                yield np.stack([own[keep], other[keep]], axis=1)

    def neighbours(self, sphere: int) -> list[int]:
        """Return the ids of the neighbours of a grain, in rising order."""
        i, _, k = self.indices(sphere)
        moved = [self._moved(np.asarray(i), k, offset) for offset in self._steps(k)]
        return sorted(int(other) for other, exists in moved if exists)

    def at_sides(self, ids: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return True for the grains at the ends of rows: (n,)."""
        return np.isin(ids, self._before[:-1] + 1) | np.isin(ids, self._before[1:])

    def indices(self, sphere: int) -> tuple[int, int, int]:
        """Return (i, 0, k) of the grain with this id."""
        k = int(np.searchsorted(self._before, sphere - 1, side="right")) - 1
        return sphere - 1 - int(self._before[k]), 0, k

    def _shifted_rows(self, k: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Select the rows that begin half a pitch further."""
        return (k + (self.top_row == "short")) % 2 == 1

    def _steps(self, k: int) -> list[Offset]:
        return self._offsets(0, k + (self.top_row == "short"))

    def _moved(self, i: NDArray[np.int64], k: int, offset: Offset) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return the ids of grains an offset away, and where there are any."""
        to, i = k + offset[2], i + offset[0]
        if not 0 <= to < len(self.row_lengths):
            return np.zeros_like(i), np.zeros(i.shape, dtype=bool)
        if self.periodic:
            i = i % self.row_lengths[to]
        return 1 + self._before[to] + i, (i >= 0) & (i < self.row_lengths[to])
