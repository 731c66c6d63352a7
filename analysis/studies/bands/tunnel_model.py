"""Row of spheres with a pair of cylinders in each gap between two walls (thesis 7.2), as a network of springs.

Static state under the axial force F, walls moved in by a/2 D each (7.5 to 7.7): d0, d1, d2 are the overlaps of two
spheres, of sphere and cylinder, and of cylinder and wall, y the distance of the cylinder's axis from that of the row,

    F = kbb d0^1.5 + 2 cos kcs d1^1.5,   2 sin kcs d1^1.5 = F_wall(d2),   y - d2 = sqrt((R + r)^2 - R^2) - a D/2

with the line law of Puttock and Thwaite at the wall. The two cylinders of a gap move alike: one with twice the mass and
twice the springs stands for them. Thesis 7.12 has half of their springs, see the table of errata.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from granwave._contact_laws import LineContact, elliptic_radius
from granwave.analysis.spectra.bands import Bands, band_edges, solve_bands
from granwave.analysis.spectra.network import Array, Network, Springs, Supports
from granwave.analysis.spectra.stiffness import stiffness_of
from granwave.analysis.spectra.wave_vectors import make_path
from granwave.lammps_inputs.case.contact import Contact
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import law_between

_POINTS = 61


@dataclasses.dataclass(frozen=True, eq=False)
class Tunnel:
    """Endless tunnel.

    Attributes
    ----------
    sphere, cylinder
        Materials.
    diameter
        Of the spheres, and length of the cylinders, m.
    ratio
        Diameter of the cylinders over that of the spheres.
    force
        Axial force, N.
    approach
        Distance by which the two walls approach in all, over the diameter; 0: everything just touches without force.
    """

    sphere: Material
    cylinder: Material
    diameter: float = 9.525e-3
    ratio: float = 4.76 / 9.525
    force: float = 1.0
    approach: float = 0.0

    @cached_property
    def _constants(self) -> tuple[float, float, LineContact]:
        """Hertz's constants of two spheres, and of sphere and cylinder, N/m^1.5; the law at the wall."""
        big, small = self.diameter / 2, self.ratio * self.diameter / 2
        between = law_between(Contact(law="hertz"), (self.sphere, self.sphere), (big, big))
        beside = law_between(Contact(law="hertz"), (self.sphere, self.cylinder), (big, small))
        crossed = float(elliptic_radius(1 / big, 1 / big + 1 / small))
        wall = LineContact(
            youngs_modulus=(self.cylinder.youngs_modulus, math.inf),
            poisson_ratio=(self.cylinder.poisson_ratio, 0.0),
            diameter=2 * small,
            length=self.diameter,
        )
        of_spheres = 4 / 3 * between.effective_modulus * math.sqrt(between.effective_radius)
        return of_spheres, 4 / 3 * beside.effective_modulus * math.sqrt(crossed), wall

    @cached_property
    def overlaps(self) -> tuple[float, float, float]:
        """Static overlaps d0, d1, d2, m."""
        between, beside, wall = self._constants
        big, small = self.diameter / 2, self.ratio * self.diameter / 2

        def at(d0: float) -> tuple[float, float, float]:
            """Overlap d1, axial share and y of a tunnel whose spheres overlap by d0."""
            rest = self.force - between * d0**1.5
            half = big - d0 / 2
            d1 = (max(rest, 0.0) / (2 * beside * half / (big + small))) ** (2 / 3)
            for _ in range(20):
                d1 = (max(rest, 0.0) / (2 * beside * half / (big + small - d1))) ** (2 / 3)
            return d1, half / (big + small - d1), math.sqrt((big + small - d1) ** 2 - half**2)

        def miss(d0: float) -> float:
            d1, cosine, y = at(d0)
            d2 = y - math.sqrt((big + small) ** 2 - big**2) + self.approach * self.diameter / 2
            return float(2 * math.sqrt(1 - cosine**2) * beside * d1**1.5 - wall.force(max(d2, 0.0)))

        most = (self.force / between) ** (2 / 3)
        d0 = float(brentq(miss, 1e-6 * most, most * (1 - 1e-12), xtol=1e-22, rtol=1e-14))
        d1, _, y = at(d0)
        return d0, d1, y - math.sqrt((big + small) ** 2 - big**2) + self.approach * self.diameter / 2

    @property
    def static_overlap(self) -> float:
        """Overlap of two spheres outside of the tunnel, m."""
        return float((self.force / self._constants[0]) ** (2 / 3))

    @property
    def sphere_mass(self) -> float:
        """Mass of a sphere, kg."""
        return self.sphere.density * math.pi / 6 * self.diameter**3

    @property
    def row_frequency(self) -> float:
        """sqrt(K/m) of the row without cylinders, rad/s: half of its cut-off."""
        return math.sqrt(1.5 * self._constants[0] * math.sqrt(self.static_overlap) / self.sphere_mass)

    @cached_property
    def network(self) -> Network:
        """The springs of a cell: a sphere, and the pair of cylinders behind it."""
        between, beside, wall = self._constants
        d0, d1, d2 = self.overlaps
        big, small = self.diameter / 2, self.ratio * self.diameter / 2
        reach, half = big + small - d1, big - d0 / 2
        cosine = half / reach
        sine = math.sqrt(1 - cosine**2)
        mass = self.cylinder.density * math.pi / 4 * (2 * small) ** 2 * self.diameter
        force = np.array([between * d0**1.5, *[2 * beside * d1**1.5] * 2])
        springs = Springs(
            np.array([0, 0, 1]),
            np.array([0, 1, 0]),
            np.array([[1], [0], [1]]),
            np.array([[0, 0, 1.0], [sine, 0, cosine], [-sine, 0, cosine]]),
            np.array([2 * half, reach, reach]),
            force,
            1.5 * force / np.array([d0, d1, d1]),
            np.zeros(3),
            np.zeros((3, 2)),
        )
        one, none = np.ones(1), np.zeros(1)
        supports = Supports(
            np.array([1]), np.array(["wall"], dtype=object), np.array([[1.0, 0, 0]]),
            2 * wall.force(d2) * one, 2 * wall.stiffness(d2) * one, none, none, none, np.zeros((1, 3)),
        )  # fmt: skip
        moves = np.zeros((2, 6), dtype=bool)
        moves[:, 2] = True
        moves[1, 0] = True
        masses = np.array([self.sphere_mass, 2 * mass])
        places = np.array([[0, 0, 0], [math.sqrt((big + small) ** 2 - big**2), 0, big]])
        period = np.array([[0, 0, self.diameter]])
        return Network(np.array([1, 2]), places, masses, masses, moves, period, springs, supports)

    @cached_property
    def bands(self) -> Bands:
        """Bands from the middle to the edge of the zone."""
        return solve_bands(stiffness_of(self.network), make_path("G-X", self.network.periods, _POINTS))

    @property
    def edges(self) -> Array:
        """Edges of the three bands: (3, 2), rad/s."""
        return np.asarray(2 * np.pi * band_edges(self.bands))
