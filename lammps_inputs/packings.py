"""Ordered packings: every sphere of a lattice with its position, its contacts and the walls around it."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TYPE_CHECKING

import ase
import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.assembly import Assembly
from granwave.lammps_inputs.lattices import TOUCHING, Lattice
from granwave.lammps_inputs.walls import Wall, walls

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case


@dataclasses.dataclass(frozen=True, eq=False)
class Packing:
    """Spheres on a lattice, and strikers, the struck layer at z = 0 and depth along +z.

    Attributes
    ----------
    assembly
        The rule behind the positions.
    atoms
        The spheres in the order of their ids, with the array ``diameters`` (n,), m; positions in m (not
        angstrom).
    walls
        The planes around the packing.
    """

    assembly: Assembly
    atoms: ase.Atoms
    walls: tuple[Wall, ...] = ()

    @property
    def n_spheres(self) -> int:
        """How many spheres there are."""
        return self.assembly.n_spheres

    @property
    def lattice(self) -> Lattice:
        """Of the spheres but for strikers."""
        return self.assembly.lattice

    @property
    def n_layers(self) -> int:
        """Layers along the impact direction."""
        return self.lattice.shape[2]

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres by id: (n_spheres, 3), m."""
        return self.atoms.positions

    @property
    def ids(self) -> NDArray[np.int64]:
        """Ids from 1, i fastest: (n_spheres,)."""
        return np.arange(1, self.n_spheres + 1)

    @cached_property
    def contacts(self) -> NDArray[np.int64]:
        """Touching pairs of ids, i < j, sorted: (n_contacts, 2).

        Raises
        ------
        RuntimeError
            A pair that should touch does not within 1e-6 D: the positions were changed.
        """
        pairs = self.assembly.contacts()
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        gaps = self.gaps(pairs)
        if gaps.size and np.abs(gaps).max() > TOUCHING * self.lattice.diameter:
            first, second = pairs[np.abs(gaps).argmax()]
            raise RuntimeError(
                f"spheres {first} and {second}: found a gap of {np.abs(gaps).max():.3g} m, expected contact"
            )
        return pairs

    @cached_property
    def coordination(self) -> NDArray[np.int8]:
        """Touching spheres of each sphere: (n_spheres,).

        Raises
        ------
        RuntimeError
            A sphere touches more spheres than the lattice allows, or none of the inner ones as many as it
            should.
        """
        result = np.zeros(self.n_spheres, dtype=np.int8)
        np.add.at(result, self.assembly.contacts().ravel() - 1, 1)
        if self.assembly.strikers:
            return result
        expected = self.lattice.rule.coordination
        found = int(result.max())
        if found > expected or (found < expected and self._has_inside()):
            raise RuntimeError(f"{self.lattice.kind}: found {found} contacts inside, expected {expected}")
        return result

    def gaps(self, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
        """Distance between the surfaces of each pair (n, 2) of ids, the nearest image counting: (n,), m."""
        result, radii = np.empty(len(pairs)), self.atoms.get_array("diameters") / 2
        for start in range(0, len(pairs), 1_000_000):
            part = slice(start, start + 1_000_000)
            step = self.positions[pairs[part, 1] - 1] - self.positions[pairs[part, 0] - 1]
            if self.lattice.periodic:
                for axis, length in enumerate(self.lattice.lengths):
                    step[:, axis] -= length * np.round(step[:, axis] / length)
            reach = radii[pairs[part, 0] - 1] + radii[pairs[part, 1] - 1]
            result[part] = np.sqrt(np.einsum("ij,ij->i", step, step)) - reach
        return result

    def _has_inside(self) -> bool:
        sides = [n for n, axis in zip(self.lattice.size, self.lattice.rule.axes, strict=True)
                 if axis == "z" or not self.lattice.periodic]  # fmt: skip
        return all(n >= 5 for n in sides)


def build_packing(case: Case) -> Packing:
    """The packing of a case, with its walls."""
    assembly, lattice = case.assembly, case.lattice
    low, high = assembly.lattice_bounds()
    atoms = ase.Atoms(
        numbers=np.zeros(assembly.n_spheres, dtype=np.int8),
        positions=assembly.positions(),
        cell=np.append(lattice.lengths, high[2] - low[2] + lattice.diameter),
        pbc=(lattice.periodic, lattice.periodic, False),
    )
    atoms.set_array("diameters", _diameters(assembly))
    return Packing(assembly, atoms, walls(case))


def _diameters(assembly: Assembly) -> NDArray[np.float64]:
    result = np.full(assembly.n_spheres, assembly.lattice.diameter)
    for sphere in {*assembly.diameters, *range(assembly.lattice.n_spheres + 1, assembly.n_spheres + 1)}:
        result[sphere - 1] = assembly.diameter_of(sphere)
    return result
