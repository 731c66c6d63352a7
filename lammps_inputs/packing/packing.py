"""Ordered packings: positions and contacts of all spheres, and walls."""

from __future__ import annotations

import dataclasses
from functools import cached_property

import ase
import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import distances
from granwave.lammps_inputs.packing.places import Layout
from granwave.lammps_inputs.packing.walls import Wall, walls
from granwave.lammps_inputs.packing_kind import TOUCHING


@dataclasses.dataclass(frozen=True, eq=False)
class Packing:
    """Spheres on a lattice and strikers; the impacted layer is at z = 0, depth along +z.

    Each row of an array is a sphere. With vacancies, row numbers are not ids minus one, see `rows`.

    Attributes
    ----------
    assembly
        Bodies that the packing is made from.
    atoms
        Spheres in the order of their ids, with the arrays ``diameters`` (n,), m, and ``ids`` (n,);
        positions in m (not angstrom).
    walls
        Planes around the packing.
    """

    assembly: Assembly
    atoms: ase.Atoms
    walls: tuple[Wall, ...] = ()

    @property
    def n_spheres(self) -> int:
        """Number of spheres."""
        return self.assembly.n_spheres

    @property
    def lattice(self) -> Layout:
        """Lattice of the spheres other than strikers, or the positions of grains."""
        return self.assembly.lattice

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres in the order of ids: (n_spheres, 3), m."""
        return self.atoms.positions

    @property
    def ids(self) -> NDArray[np.int64]:
        """Ids, counted from 1 over the sites with i fastest: (n_spheres,)."""
        return self.atoms.get_array("ids", copy=False)

    def rows(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the rows of the spheres with these ids, of the same shape."""
        return (
            np.searchsorted(self.ids, ids)
            if self.n_spheres < self.assembly.last_sphere
            else ids - 1
        )

    @cached_property
    def contacts(self) -> NDArray[np.int64]:
        """Touching pairs of ids, i < j, sorted: (n_contacts, 2).

        Raises
        ------
        RuntimeError
            A pair that should touch does not within 1e-6 D: the positions were changed.
        """
        pairs = self.assembly.contacts()
        first, second = pairs.T
        pairs = pairs[np.lexsort((second, first))]
        gaps = self.gaps(pairs)
        stage = self.assembly.case.precompression
        if stage is not None and stage.takes_overlaps:
            gaps = np.maximum(gaps, 0.0)
        if isinstance(self.lattice, Lattice):
            gaps = gaps + self.lattice.overlap * (pairs.max(axis=1) <= self.lattice.n_spheres)
        if gaps.size and np.abs(gaps).max() > TOUCHING * self.lattice.diameter:
            first, second = pairs[np.abs(gaps).argmax()]
            raise RuntimeError(
                f"spheres {first} and {second}: found a gap of {np.abs(gaps).max():.3g} m, expected contact"
            )
        return pairs

    @cached_property
    def coordination(self) -> NDArray[np.int8]:
        """Coordination numbers of the spheres: (n_spheres,); checked for packings of equal spheres.

        Raises
        ------
        RuntimeError
            A sphere touches more spheres than the lattice allows, or none of the interior ones as
            many as it should.
        """
        result = np.zeros(self.n_spheres, dtype=np.int8)
        np.add.at(result, self.rows(self.assembly.contacts().ravel()), 1)
        if not self.assembly.plain:
            return result
        expected = self.lattice.rule.coordination
        found = int(result.max())
        axes = zip(self.lattice.size, self.lattice.rule.axes, strict=True)
        inside = all(n >= 5 for n, axis in axes if axis == "z" or not self.lattice.periodic)
        if found > expected or (found < expected and inside):
            raise RuntimeError(
                f"{self.lattice.kind}: found {found} contacts inside, expected {expected}"
            )
        return result

    def gaps(self, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the gaps between the surfaces of pairs (n, 2) of ids, nearest images if periodic:
        (n,), m.
        """
        first, second = self.rows(pairs).T
        period = self.lattice.lengths if self.lattice.periodic else None
        diameter = self.assembly.sphere_diameters()
        apart = distances(
            self.positions, diameter, self.assembly.grain_shapes(), first, second, period
        )
        return apart - (diameter[first] + diameter[second]) / 2


def build_packing(assembly: Assembly) -> Packing:
    """Build a packing, with its walls."""
    lattice = assembly.lattice
    low, high = assembly.lattice_bounds()
    atoms = ase.Atoms(
        numbers=np.zeros(assembly.n_spheres, dtype=np.int8),
        positions=assembly.positions(),
        cell=np.append(lattice.lengths, high[2] - low[2] + lattice.diameter),
        pbc=(lattice.periodic, lattice.periodic, False),
    )
    atoms.set_array("diameters", assembly.sphere_diameters())
    atoms.set_array("ids", assembly.ids)
    return Packing(assembly, atoms, walls(assembly))
