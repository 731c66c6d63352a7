"""States of a plane crystal of soft cylinders under a falling plate, with known contact forces,
from the solver in `plane_twin`.

Coordinates point across and down, as in that solver; SI units, per metre of length.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from tests.helpers.twins.plane_twin import Discs, crystal

Array = NDArray[np.float64]
RADIUS = 6.35e-3
DENSITY = 1130.0
MODULUS = 70e6
POISSON = 0.48
FRICTION = 0.3
LOSS = 12e-6
PLATE_MASS = 20.0
PLATE_SPEED = 6.0
MASS = np.pi * DENSITY * RADIUS**2
CRYSTALS = {
    "centred-square": crystal("centred-square", 6, 16, short_first=False),
    "hexagonal": crystal("hexagonal", 8, 14, short_first=False),
}


@dataclasses.dataclass(frozen=True, eq=False)
class Snapshot:
    """Grains and forces at one instant; forces are those on the first grain, as vectors.

    Attributes
    ----------
    second
        Indices of the partners, or -1, -2, -3, -4 for left wall, right wall, floor, plate.
    levels
        Positions of the side walls (across) and of floor and plate (down), m.
    """

    position: Array
    acceleration: Array
    spin: Array
    angular_acceleration: Array
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    force: Array
    normal: Array
    levels: tuple[float, float, float, float]

    def stress(self) -> Array:
        """Average stresses, tension positive, as symmetric matrices: (n, 2, 2), Pa."""
        total = np.zeros((len(self.position), 2, 2))
        for i, j, force, normal in zip(
            self.first, self.second, self.force, self.normal, strict=True
        ):
            if j >= 0:
                half = 0.5 * np.linalg.norm(self.position[i] - self.position[j])
                total[j] += np.outer(half * normal, -force)
            else:
                axis = 0 if j >= -2 else 1
                half = abs(self.position[i][axis] - self.levels[-1 - j])
            total[i] += np.outer(-half * normal, force)
        inertia = MASS * RADIUS**2 / 4 * self.spin**2
        total += inertia[:, None, None] * np.eye(2)
        return 0.5 * (total + total.transpose(0, 2, 1)) / (np.pi * RADIUS**2)


def snapshots(name: str, times: tuple[float, ...]) -> list[Snapshot]:
    """Drop the plate on a crystal, and return the states at these times, s."""
    discs = Discs(CRYSTALS[name], RADIUS, MODULUS, POISSON, DENSITY, FRICTION, LOSS, PLATE_MASS, PLATE_SPEED,
                  constant_spring=True, reach=3.0)  # fmt: skip
    return [
        _snapshot(discs, time - before) for before, time in zip((0.0, *times), times, strict=False)
    ]


def _snapshot(discs: Discs, later: float) -> Snapshot:
    discs.run(later)
    total, torque, _ = discs.forces(1e-15)  # springs within the limits of this instant
    left, right, floor, plate = discs.places
    second = np.concatenate([discs.j, *(np.full(discs.n, -1 - which) for which in discs.used)])
    meets = discs.touching
    return Snapshot(
        discs.x.copy(), total / discs.mass, discs.omega.copy(), torque / discs.inertia, discs.grain[meets], second[meets],
        discs.contact_forces[meets], discs.normals[meets], (left, -right, -floor, plate + discs.u),
    )  # fmt: skip
