"""Finished runs of rows of spheres with cylinders beside their gaps, as the studies of these see them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np

from granwave.analysis.document.model import Column, Table
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.tables import table_of

CYLINDERS = "cylinders"  # their group


class RowRun(FinishedRun):
    """A finished run of a row of spheres along z, with or without cylinders of a group of this name."""

    @cached_property
    def _is_cylinder(self) -> np.ndarray:
        grains = self.case.packing.grains
        n = int(np.prod(self.case.packing.size))
        return np.zeros(n, dtype=bool) if grains is None else np.array([one == CYLINDERS for one in grains.group])

    @property
    def n_cylinders(self) -> int:
        """Number of cylinders."""
        return int(self._is_cylinder.sum())

    @property
    def n_spheres(self) -> int:
        """Number of spheres."""
        return len(self._is_cylinder) - self.n_cylinders

    @cached_property
    def _places(self) -> Array:
        lattice = self.assembly.lattice
        return lattice.positions(1, lattice.n_spheres)

    @property
    def sphere_places(self) -> Array:
        """Places of the spheres along the row, in the order of their ids, m."""
        return self._places[~self._is_cylinder, 2]

    @property
    def cylinder_places(self) -> Array:
        """Places of the cylinders along the row, m."""
        return self._places[self._is_cylinder, 2]

    @property
    def cylinder_across(self) -> Array:
        """Distances of the cylinders' centres from the axis of the row, m."""
        return np.asarray(np.abs(self._places[self._is_cylinder, 0]))

    @property
    def cylinder_diameter(self) -> float:
        """Diameter of the cylinders, m."""
        return self.assembly.diameter_of(int(np.argmax(self._is_cylinder)) + 1)

    @property
    def cylinder_length(self) -> float:
        """Length of the cylinders, m."""
        shape = self.assembly.shape_of(int(np.argmax(self._is_cylinder)) + 1)
        return shape.length if shape is not None else np.nan

    @property
    def friction(self) -> float:
        """Coefficient of friction of the walls."""
        given = self.case.boundary.friction
        return self.case.contact.friction if given is None else given

    @cached_property
    def peaks(self) -> Array:
        """Largest force between neighbouring spheres, contact n in row n - 1, N: (n_spheres - 1,)."""
        with Result(self.directory) as result:
            i, j, force = (result[f"contacts/{name}"] for name in ("i", "j", "peak_force"))
        found = np.zeros(self.n_spheres - 1)
        row = (j == i + 1) & (j <= self.n_spheres)
        found[i[row] - 1] = force[row]
        return found


def errata_table(caption: str, errata: Iterable[tuple[str, str, str]]) -> Table:
    """A table of errata: where, what is printed, and what is right and why."""
    return table_of(caption, (Column("where"), Column("printed"), Column("right, and why")), errata)
