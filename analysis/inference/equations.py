"""Equations of measured grains: contact forces that give their motion and their average stress.

For each grain, with r from its centre to a contact and f the force there,

    sum f                = m a - known forces
    sum r x f            = I alpha
    sum sym(r f)         = V stress + m R^2/4 (w w - w^2 1)        (spheres: m R^2/5)

The last two are divided by R, and shear components are multiplied by sqrt(2): all rows are in newtons, and the sum of
their squares does not depend on the axes.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.analysis.inference.contacts import Contacts
from granwave.analysis.inference.grains import PAIRS, Array, Grains


@dataclasses.dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations for the contact forces.

    Attributes
    ----------
    motion, stress
        Matrices of the equations of motion and of the average stress: rows by grain, columns by contact and component
        (normal first). Sparse.
    motion_data
        Right-hand side of the first, N.
    stress_data
        Right-hand side of the second that is proportional to the moduli, N.
    spin_data
        Right-hand side of the second that is not, N.
    motion_grain, stress_grain
        Rows of the grains that the equations belong to.
    """

    motion: sparse.csr_array
    stress: sparse.csr_array
    motion_data: Array
    stress_data: Array
    spin_data: Array
    motion_grain: NDArray[np.int64]
    stress_grain: NDArray[np.int64]

    @property
    def n_equations(self) -> int:
        """Number of equations."""
        return len(self.motion_grain) + len(self.stress_grain)

    @property
    def matrix(self) -> sparse.csr_array:
        """Both matrices, one below the other."""
        return sparse.csr_array(sparse.vstack([self.motion, self.stress]))

    def data(self, factor: float = 1.0) -> Array:
        """Return both right-hand sides, with all moduli multiplied by a factor, N."""
        return np.concatenate([self.motion_data, factor * self.stress_data + self.spin_data])


def make_equations(grains: Grains, contacts: Contacts) -> Equations:
    """Set up the equations of all grains whose motion or stress was measured."""
    d, n, pairs = grains.dimension, len(grains), PAIRS[grains.dimension]
    turns = grains.spin.shape[1]
    both = contacts.second >= 0
    of = np.concatenate([contacts.first, contacts.second[both]])
    which = np.concatenate([np.arange(len(contacts)), np.flatnonzero(both)])
    arm = np.concatenate([contacts.arm, contacts.partner_arm[both]]) / grains.radius[of, None]
    force = np.concatenate([contacts.basis, -contacts.basis[both]])
    columns = which[:, None] * d + np.arange(d)

    def matrix(values: Array, n_rows: int) -> sparse.csr_array:
        """Sum blocks of (rows of a grain) x (components of a contact)."""
        rows = of[:, None] * n_rows + np.arange(n_rows)
        places = np.broadcast_arrays(rows[:, :, None], columns[:, None, :])
        shape = (n * n_rows, len(contacts) * d)
        return sparse.csr_array((values.ravel(), (places[0].ravel(), places[1].ravel())), shape=shape)

    moment = (
        arm[:, 0, None] * force[:, 1] - arm[:, 1, None] * force[:, 0]
        if d == 2
        else np.cross(arm[:, :, None], force, axis=1)
    )
    moment = moment.reshape(len(of), turns, d)
    scale = np.array([1.0 if a == b else np.sqrt(2) for a, b in pairs])
    dyads = [0.5 * (arm[:, a, None] * force[:, b] + arm[:, b, None] * force[:, a]) for a, b in pairs]
    motion = matrix(np.concatenate([force, moment], axis=1), d + turns)
    stress = matrix(scale[:, None] * np.stack(dyads, axis=1), len(pairs))
    motion_data = np.concatenate(
        [
            grains.mass[:, None] * grains.acceleration - grains.known_force,
            (grains.inertia / grains.radius)[:, None] * grains.angular_acceleration,
        ],
        axis=1,
    )
    per_length = scale / grains.radius[:, None]
    stress_data = per_length * grains.volume[:, None] * grains.stress
    spin_data = per_length * grains.spin_stress
    moving, strained = grains.has_motion, grains.has_stress
    rows_moving, rows_strained = np.repeat(moving, d + turns), np.repeat(strained, len(pairs))
    return Equations(
        motion[np.flatnonzero(rows_moving)],
        stress[np.flatnonzero(rows_strained)],
        motion_data[moving].ravel(),
        stress_data[strained].ravel(),
        spin_data[strained].ravel(),
        np.repeat(np.flatnonzero(moving), d + turns),
        np.repeat(np.flatnonzero(strained), len(pairs)),
    )


def unknown_columns(friction: Array, dimension: int) -> NDArray[np.int64]:
    """Return the columns of the unknowns: normal components, and tangential ones of contacts with friction."""
    columns = np.arange(len(friction) * dimension).reshape(len(friction), dimension)
    return np.sort(np.concatenate([columns[:, 0], columns[friction > 0, 1:].ravel()]))
