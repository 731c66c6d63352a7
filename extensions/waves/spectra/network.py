"""Springs between grains: the model of a packing for small motions about its static state.

A contact of the grains i and j, with the unit vector e from i to j, the distance d of their
centres, the static force F and the normal and tangential stiffnesses k_n and k_t, stores for small
displacements u and rotations q

    E = k_n/2 (e.(u_j - u_i))^2 - F/(2 d) |T (u_j - u_i)|^2 + k_t/2 |P (u_i - u_j) + (l_i q_i + l_j
    q_j) x e|^2 + k_r/2 |P (q_i - q_j)|^2 + k_w/2 (e.(q_i - q_j))^2

with P = 1 - e e and the lever arms l; k_r and k_w resist rolling and twisting. The second term is
due to the static force, which turns with the contact: T = P for spheres, T = P - a a at the side of
a cylinder with the axis a, along which nothing turns (d is then the distance from the axis), and
T = 0 for crossed cylinders. A contact with a plane has no such term; in a tube of radius R the term
is + F/(2 (R - r)) times the square of the motion around the axis.

The stiffnesses come from a packing (`granwave.extensions.waves.spectra.packing_springs`), or from
any other system of springs.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.statics.bodies import Array, Ints, joined

FREEDOMS = ("x", "y", "z", "rx", "ry", "rz")  # displacements and rotations of a grain


@dataclasses.dataclass(frozen=True, eq=False)
class Springs:
    """Contacts of grains with each other and with walls; each array has a row for a contact.

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
    force
        Static forces, compression positive: (n,), N.
    stiffness, tangential
        Normal and tangential stiffnesses: (n,), N/m.
    lever
        Lever arms of both grains: (n, 2), m.
    turns
        Projections T, see the module; for spheres as from `across`, in a tube on the direction
        around it: (n, 3, 3).
    wall
        Names of the walls, empty for pairs: (n,); None if there are only pairs.
    rolling, twisting
        Stiffnesses against rolling and twisting: (n,), N m; None if nothing resists these.
    """

    first: Ints
    second: Ints
    image: Ints
    normal: Array
    distance: Array
    force: Array
    stiffness: Array
    tangential: Array
    lever: Array
    turns: Array
    wall: NDArray[np.object_] | None = None
    rolling: Array | None = None
    twisting: Array | None = None

    def __len__(self) -> int:
        return len(self.first)


@dataclasses.dataclass(frozen=True, eq=False)
class Network:
    """Grains and springs.

    Attributes
    ----------
    ids
        Ids of the grains: (n,).
    position
        Positions before the load, to which wave vectors refer: (n, 3), m.
    mass, inertia
        Masses and moments of inertia: (n,), kg and kg m^2.
    moves
        True for the directions in which a grain moves, in the order of `FREEDOMS`: (n, 6).
    periods
        Periods of the packing before the load: (n_periods, 3), m; a finite packing has none.
    contacts
        All contacts: ``springs`` between grains, and ``supports`` at walls.
    left_out
        Ids of grains without static load, which belong to no wave: (m,).
    """

    ids: Ints
    position: Array
    mass: Array
    inertia: Array
    moves: NDArray[np.bool_]
    periods: Array
    contacts: Springs
    left_out: Ints = dataclasses.field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @cached_property
    def springs(self) -> Springs:
        """Contacts of grains with each other."""
        return joined([self.contacts], self.contacts.second >= 0)

    @cached_property
    def supports(self) -> Springs:
        """Contacts with walls."""
        return joined([self.contacts], self.contacts.second < 0)

    @property
    def n_grains(self) -> int:
        """Number of grains."""
        return len(self.mass)

    @property
    def freedoms(self) -> tuple[Ints, Ints]:
        """Row of the grain and direction (a place in `FREEDOMS`) of each degree of freedom:
        (n_freedoms,) each.
        """
        grain, direction = np.nonzero(self.moves)
        return grain, direction

    @property
    def numbers(self) -> Ints:
        """Number of the degree of freedom of each grain and direction, -1 where it does not move:
        (n, 6).
        """
        return np.where(self.moves, np.cumsum(self.moves).reshape(self.moves.shape) - 1, -1)

    @property
    def n_freedoms(self) -> int:
        """Number of degrees of freedom."""
        return int(np.count_nonzero(self.moves))

    @property
    def masses(self) -> Array:
        """Mass or moment of inertia of each degree of freedom: (n_freedoms,), kg or kg m^2."""
        grain, direction = self.freedoms
        return np.where(direction < 3, self.mass[grain], self.inertia[grain])

    def turned_off(self, directions: str) -> Network:
        """Return the network with grains that move only in some of the directions "xyz", and turn
        only about axes across these directions.
        """
        x, y, z = (axis in directions for axis in "xyz")
        allowed = np.array([x, y, z, y or z, x or z, x or y])
        return dataclasses.replace(self, moves=self.moves & allowed)

    def without_idle(self) -> Network:
        """Return the network without the grains that carry no static load."""
        contacts = self.contacts
        present = np.zeros(self.n_grains + 1, dtype=bool)  # the last row is the walls
        present[contacts.first] = True
        present[contacts.second] = True
        present = present[:-1]
        row = np.append(np.cumsum(present) - 1, -1)
        own = {
            name: getattr(self, name)[present]
            for name in ("ids", "position", "mass", "inertia", "moves")
        }
        contacts = dataclasses.replace(
            contacts, first=row[contacts.first], second=row[contacts.second]
        )
        left_out = np.concatenate([self.left_out, self.ids[~present]])
        return dataclasses.replace(self, **own, contacts=contacts, left_out=left_out)
