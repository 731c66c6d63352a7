"""Beads in a row with a ring of ``n`` small spheres around each contact, in a tube (thesis 6.1): sizes and balance.

    d = 2 D tan^2(pi/n)                      diameter of small spheres that touch two beads and both neighbours (6.2)
    rho = sqrt(d^2 + 2 d D)/2,  Rc = rho + d/2               radius of the ring, and of the tube around it
    tan(theta) = 2 rho/D,  cos(theta) = D/(D + d)            of the line from a bead to a small sphere, against the axis
    eps = m_s/m_b,  eta = k_sb cos^2.5(theta)/k_bb,  gamma = k_w/k_bb                                              (6.8)

All contacts are Hertz's, F = k alpha^1.5. The thesis takes k_w = 1.2 E sqrt(d/2)/(1 - nu^2) (6.4), softer than a flat
wall (4/3) and than the inside of the tube, whose contact is an ellipse; `Row.k_wall` is that of the ellipse. Nor has it
contacts in the ring: 2 k_ss [2 u sin(pi/n)]^1.5 sin(pi/n) outward on a sphere that has moved in by u.

Arrays hold one row each: (n_rows,). A fraction as ``n`` makes a row that only the equations have.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from granwave._contact_laws import elliptic_radius
from granwave.analysis.measures.signals import Array

THESIS_WALL = 1.2  # factor of k_w in (6.4); 4/3 of a flat wall


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Row:
    """Rows that just touch everywhere, and the distance by which their tube then shrinks.

    Attributes
    ----------
    n
        Small spheres of a ring.
    bead, small, tube, shrinks
        Diameters of beads and small spheres, radius of the tube, and what is taken off it, m.
    modulus, small_modulus
        Plane-strain moduli E/(1 - nu^2) of beads and small spheres, Pa.
    density, small_density
        kg/m^3.
    """

    n: Array
    bead: Array
    small: Array
    tube: Array
    shrinks: Array
    modulus: Array
    small_modulus: Array
    density: Array
    small_density: Array

    @classmethod
    def fitting(
        cls,
        n: ArrayLike,
        bead: ArrayLike,
        shrinks: ArrayLike,
        modulus: ArrayLike,
        density: ArrayLike,
        density_ratio: ArrayLike = 1.0,
    ) -> Row:
        """Rows whose small spheres touch two beads, both neighbours and the tube; ``density_ratio``: theirs."""
        n, bead, shrinks, modulus, density, ratio = np.broadcast_arrays(
            *(
                np.atleast_1d(np.asarray(one, dtype=float))
                for one in (n, bead, shrinks, modulus, density, density_ratio)
            )
        )
        small = fitting_diameter(n, bead)
        tube = np.sqrt(small**2 + 2 * small * bead) / 2 + small / 2
        return cls(n=n, bead=bead, small=small, tube=tube, shrinks=shrinks, modulus=modulus, small_modulus=modulus,
                   density=density, small_density=ratio * density)  # fmt: skip

    def part(self, which: NDArray[Any] | slice) -> Row:
        """Some of the rows."""
        return Row(**{field.name: getattr(self, field.name)[which] for field in dataclasses.fields(self)})

    @property
    def a(self) -> Array:
        """Precompression of the thesis: change of the tube's diameter over that of a bead."""
        return 2 * self.shrinks / self.bead

    @property
    def ring(self) -> Array:
        """Radius of the ring of centres, m."""
        return np.asarray(self.tube - self.small / 2)

    @property
    def tangent(self) -> Array:
        """tan(theta)."""
        return 2 * self.ring / self.bead

    @property
    def cosine(self) -> Array:
        """cos(theta)."""
        return self.bead / (self.bead + self.small)

    @property
    def bead_mass(self) -> Array:
        """Mass of a bead, kg."""
        return self.density * np.pi / 6 * self.bead**3

    @property
    def small_mass(self) -> Array:
        """Mass of a small sphere, kg."""
        return self.small_density * np.pi / 6 * self.small**3

    @property
    def k_beads(self) -> Array:
        """Contact constant of two beads, N/m^1.5."""
        return 4 / 3 * self.modulus / 2 * np.sqrt(self.bead / 4)

    @property
    def k_side(self) -> Array:
        """Contact constant of a bead and a small sphere, N/m^1.5."""
        modulus = 1 / (1 / self.modulus + 1 / self.small_modulus)
        return 4 / 3 * modulus * np.sqrt(self.bead * self.small / 2 / (self.bead + self.small))

    @property
    def k_ring(self) -> Array:
        """Contact constant of two small spheres, N/m^1.5."""
        return 4 / 3 * self.small_modulus / 2 * np.sqrt(self.small / 4)

    @cached_property
    def k_wall(self) -> Array:
        """Contact constant of a small sphere inside the rigid tube, N/m^1.5."""
        r = self.small / 2
        radius = np.asarray(elliptic_radius(1 / r, 1 / r - 1 / (self.tube - self.shrinks)))
        return 4 / 3 * self.small_modulus * np.sqrt(radius)

    @property
    def k_thesis_wall(self) -> Array:
        """Contact constant of the same as the thesis has it (6.4), N/m^1.5."""
        return THESIS_WALL * self.small_modulus * np.sqrt(self.small / 2)

    @property
    def eps(self) -> Array:
        """Mass of a small sphere over that of a bead."""
        return self.small_mass / self.bead_mass

    @property
    def eta(self) -> Array:
        """Stiffness of the side contacts along the row over that of the beads, eta of (6.8)."""
        return self.k_side * self.cosine**2.5 / self.k_beads

    @property
    def force_unit(self) -> Array:
        """E* R*^2 of two beads, N."""
        return self.modulus / 2 * (self.bead / 4) ** 2

    @property
    def thesis_time(self) -> Array:
        """sqrt(m_b/k_bb), s times m^(-1/4): what the thesis divides times by, in SI."""
        return np.sqrt(self.bead_mass / self.k_beads)

    @cached_property
    def inward(self) -> Array:
        """Distance by which the small spheres move in until they are in balance, m."""
        found = []
        for k in range(len(self.n)):
            one = self.part(slice(k, k + 1))
            limit = float(one.shrinks[0])
            found.append(
                brentq(lambda u, one=one: float(one.outward_force(u)[0]), 0.0, limit, xtol=1e-18) if limit else 0.0
            )
        return np.array(found)

    def outward_force(self, inward: ArrayLike) -> Array:
        """Force on small spheres that have moved in, in an undisturbed row, N."""
        u = np.asarray(inward)
        across, along = self.ring - u, self.bead / 2
        apart = np.hypot(across, along)
        overlap = np.maximum((self.bead + self.small) / 2 - apart, 0.0)
        chord = np.sin(np.pi / self.n)
        ring = 2 * self.k_ring * (2 * u * chord) ** 1.5 * chord
        wall = self.k_wall * np.maximum(self.shrinks - u, 0.0) ** 1.5
        return np.asarray(2 * self.k_side * overlap**1.5 * across / apart + ring - wall)

    def thesis_shrinks(self, inward: ArrayLike, *, printed_ring: bool = False, right_ring: bool = False) -> Array:
        """Shrinkage that moves the small spheres in by ``inward`` (m) in the thesis's balance and with its wall, m.

        Parameters
        ----------
        printed_ring
            True for the balance as it is printed, with ``2 k_bb [2 u cos(pi/n)]^1.5 sin(pi/n)`` of the ring; False for
            the one that its figures follow, without the ring.
        right_ring
            True for the balance with ``2 k_ss [2 u sin(pi/n)]^1.5 sin(pi/n)``, as the ring needs it.
        """
        u = np.asarray(inward)
        sine = np.sqrt(1 - self.cosine**2)
        force = 2 * self.k_side * (u * sine) ** 1.5 * sine
        if printed_ring:
            angle = np.pi / self.n
            force = force + 2 * self.k_beads * (2 * u * np.cos(angle)) ** 1.5 * np.sin(angle)
        if right_ring:
            chord = np.sin(np.pi / self.n)
            force = force + 2 * self.k_ring * (2 * u * chord) ** 1.5 * chord
        return np.asarray(u + (force / self.k_thesis_wall) ** (2 / 3))


def fitting_diameter(n: ArrayLike, bead: ArrayLike) -> Array:
    """Diameter of the small spheres of a ring around beads (6.2), m."""
    return np.asarray(2 * np.asarray(bead) * np.tan(np.pi / np.asarray(n)) ** 2)
