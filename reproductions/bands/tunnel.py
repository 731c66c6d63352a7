"""Infinite chain of spheres with a pair of cylinders in each gap between two walls (thesis 7.2), as
a lattice of springs.

In the static state the axial force is F, and each wall has moved inwards by a/2 D (7.5 to 7.7).
d0, d1 and d2 are the overlaps of two spheres, of sphere and cylinder, and of cylinder and wall; y
is the distance between the axis of the cylinder and the axis of the chain:

    F = kbb d0^1.5 + 2 cos kcs d1^1.5
    2 sin kcs d1^1.5 = F_wall(d2)
    y - d2 = sqrt((R + r)^2 - R^2) - a D/2

with the line law of Puttock and Thwaite at the wall. The two cylinders of a gap have the same
motion, and are replaced by one cylinder with twice the mass and twice the stiffness. Thesis 7.12
has a single cylinder in each gap, with the static state of two cylinders.
"""

import math

import numpy as np
from scipy.optimize import brentq

import granwave as gw

# diameter of the spheres, m; axial force, N
DIAMETER = 9.525e-3
FORCE = 1.0
MATERIALS = {  # density, kg/m^3, and Young's modulus, Pa
    "brass": (8500.0, 115e9), "steel": (7800.0, 210e9), "aluminium": (2700.0, 70e9),
    "light aluminium": (2100.0, 70e9),
}  # fmt: skip
POINTS = 61  # wave numbers from the middle to the edge of the zone
PAIR = 2  # cylinders in a gap


class Tunnel:
    """A tunnel whose walls approach by a fraction of the diameter; 0: all bodies just touch,
    without force.

    ``cylinders``: number of cylinders in each gap that move with the waves, two, or one as in
    thesis 7.12.
    """

    def __init__(
        self, approach, ratio=4.76 / 9.525, sphere="brass", cylinder="brass", cylinders=PAIR
    ):
        self.cylinders = cylinders
        self.radius = DIAMETER / 2
        self.small = ratio * DIAMETER / 2
        density, modulus = zip(MATERIALS[sphere], MATERIALS[cylinder], strict=True)
        elastic = [
            {"name": "body", "density": 1e3, "youngs_modulus": e, "poisson_ratio": 0.3}
            for e in modulus
        ]
        one = {"shape": "sphere", "radius": self.radius, "material": elastic[0]}
        two = {
            "shape": "cylinder",
            "radius": self.small,
            "length": DIAMETER,
            "material": elastic[1],
        }
        self.wall = two, "plane"
        self.constants = [
            gw.contact_force("hertz", pair, 1e-6) / 1e-9 for pair in ((one, one), (one, two))
        ]
        self.mass = density[0] * math.pi / 6 * DIAMETER**3
        self.side_mass = cylinders * density[1] * math.pi / 4 * (2 * self.small) ** 2 * DIAMETER
        self.alone = (
            math.sqrt((self.radius + self.small) ** 2 - self.radius**2) - approach * self.radius
        )  # y - d2, m
        most = (FORCE / self.constants[0]) ** (2 / 3)
        self.row_frequency = math.sqrt(
            1.5 * self.constants[0] * math.sqrt(most) / self.mass
        )  # sqrt(K/m), rad/s
        self.d0 = brentq(self.miss, 1e-6 * most, most * (1 - 1e-12), xtol=1e-22, rtol=1e-14)
        self.k = np.linspace(0, math.pi / DIAMETER, POINTS)
        self.omega = np.sqrt(
            np.maximum(np.linalg.eigvalsh(self.dynamical_matrix()), 0.0)
        )  # (wave numbers, bands)
        self.edges = np.stack(
            [self.omega.min(axis=0), self.omega.max(axis=0)], axis=1
        )  # frequencies of the bands, rad/s

    def geometry(self, d0):
        """Overlaps d1 and d2, and cosine of the contacts of the cylinder, for an overlap d0 of the
        spheres.
        """
        half = self.radius - d0 / 2
        reach = self.radius + self.small
        rest = max(FORCE - self.constants[0] * d0**1.5, 0.0)
        d1 = 0.0
        for _ in range(21):
            d1 = (rest / (2 * self.constants[1] * half / (reach - d1))) ** (2 / 3)
        return d1, math.sqrt((reach - d1) ** 2 - half**2) - self.alone, half / (reach - d1)

    def miss(self, d0):
        """Transverse force on the cylinder, N."""
        d1, d2, cosine = self.geometry(d0)
        at_wall = gw.contact_force("hertz", self.wall, max(d2, 0.0))
        return 2 * math.sqrt(1 - cosine**2) * self.constants[1] * d1**1.5 - at_wall

    def springs(self):
        """Yield the springs of a gap: bodies (0: sphere, 1: cylinders), cells between these, and
        stiffness in x and z: (2, 2), N/m.
        """
        d1, _, cosine = self.geometry(self.d0)
        sine = math.sqrt(1 - cosine**2)
        axial = self.constants[0] * self.d0**1.5
        beside = self.cylinders * self.constants[1] * d1**1.5
        reach = self.radius + self.small - d1
        for first, second, cells, normal, length, force, overlap in (
            (0, 0, 1, (0.0, 1.0), DIAMETER - self.d0, axial, self.d0),
            (0, 1, 0, (sine, cosine), reach, beside, d1),
            (1, 0, 1, (-sine, cosine), reach, beside, d1),
        ):
            along = np.outer(normal, normal)
            spring = 1.5 * force / overlap * along - force / length * (np.eye(2) - along)
            yield first, second, cells, spring

    def wall_spring(self):
        """Transverse stiffness of the walls for the cylinders of a gap, N/m."""
        _, d2, _ = self.geometry(self.d0)
        return self.cylinders * gw.contact_stiffness("hertz", self.wall, d2)

    def dynamical_matrix(self):
        """Matrix of the sphere along z and of the cylinders of a gap along x and z: (wave numbers,
        3, 3), s^-2.
        """
        # body, x or z
        matrix = np.zeros((POINTS, 2, 2, 2, 2), dtype=complex)
        for first, second, cells, spring in self.springs():
            shift = np.exp(1j * self.k * DIAMETER * cells)
            matrix[:, first, :, first] += spring
            matrix[:, second, :, second] += spring
            matrix[:, first, :, second] -= np.multiply.outer(shift, spring)
            matrix[:, second, :, first] -= np.multiply.outer(np.conj(shift), spring)
        matrix[:, 1, 0, 1, 0] += self.wall_spring()
        moves = matrix.reshape(POINTS, 4, 4)[:, 1:, 1:]
        masses = np.sqrt([self.mass, self.side_mass, self.side_mass])
        return moves / np.outer(masses, masses)
