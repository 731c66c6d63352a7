"""Second, independent implementation of the contact law and of a network of spheres, in numpy: for
tests only.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import quad

CONSTANTS = (
    "pressure_limit", "pressure_rate", "area_switch", "area_slope", "area_offset",
    "residual_slope", "residual_offset", "residual_rate", "unloading_exponent",
)  # fmt: skip
PRINTED = (2.48, 0.098, 177.6, 2.37, 59.96, 0.95, 25.94, 0.015, 1.35)
#: Constants far from the printed ones, by name.
OTHER = {
    "pressure_limit": 2.9, "pressure_rate": 0.07, "area_switch": 140.0, "area_slope": 2.2, "area_offset": 45.0,
    "residual_slope": 0.93, "residual_offset": 20.0, "residual_rate": 0.02, "unloading_exponent": 1.42,
}  # fmt: skip


class LawTwin:
    """Elastoplastic law in normalized units, implemented from the equations (thesis 2.8 to 2.17),
    not from the header.
    """

    def __init__(
        self, variant: str = "continuous", factor: float = 1.6, **constants: float
    ) -> None:
        self.K = 1.5 / factor
        self.continuous = variant == "continuous"
        self.c = dict(zip(CONSTANTS, PRINTED, strict=True)) | constants
        self.c1, self.c2, self.joint, self.c4, self.c5, self.c6, self.c7, self.c8, self.n = (
            self.c.values()
        )
        self.cy = 2 * factor / 3 if self.continuous else 1.07
        self.c3 = (
            np.log(self.c4 * self.joint - self.c5) / np.log(self.joint) if self.continuous else 1.14
        )

    def loading(self, a: float) -> float:
        if a <= 0:
            return 0.0
        if a <= 1:
            return a**1.5
        area = a**self.c3 if a < self.joint else self.c4 * a - self.c5
        return self.K * (self.c1 - (self.c1 - self.cy) * np.exp(-self.c2 * (a - 1))) * area

    def work(self, a: float) -> float:
        parts = [0.0, *(x for x in (1.0, self.joint) if x < a), a]
        return sum(
            quad(self.loading, lo, hi, epsabs=0, epsrel=1e-12, limit=200)[0]
            for lo, hi in pairwise(parts)
        )

    def residual(self, peak: float) -> float:
        return (
            0.0
            if peak <= 1
            else self.c6 * peak - self.c7 + (self.c7 - self.c6) * np.exp(-self.c8 * (peak - 1))
        )

    def exponent(self, peak: float) -> float:
        if peak <= 1:
            return 1.5
        if not self.continuous:
            return self.n
        return max(self.n, self.loading(peak) * (peak - self.residual(peak)) / self.work(peak) - 1)

    def force(self, a: float, peak: float) -> float:
        if a >= peak:
            return self.loading(a)
        rest = self.residual(peak)
        return (
            0.0
            if a <= rest
            else self.loading(peak) * ((a - rest) / (peak - rest)) ** self.exponent(peak)
        )

    def dissipated(self, peak: float) -> float:
        if peak <= 1:
            return 0.0
        return self.work(peak) - self.loading(peak) * (peak - self.residual(peak)) / (
            self.exponent(peak) + 1
        )


def scales(
    radius: float,
    modulus: float = 115e9,
    ratio: float = 0.3,
    strength: float = 550e6,
    factor: float = 1.6,
):
    """alpha_y and F_y of two equal spheres."""
    e_star = modulus / (2 * (1 - ratio**2))
    r_star = radius / 2
    overlap = np.pi**2 / 4 * (factor * strength / e_star) ** 2 * r_star
    return overlap, 4 / 3 * e_star * np.sqrt(r_star) * overlap**1.5


class Network:
    """Point masses with true geometry and a fixed set of contacts; velocity Verlet in numpy.

    Parameters
    ----------
    positions
        (n, 3), m.
    pairs
        (n_pairs, 2), indices from 0.
    """

    def __init__(
        self,
        positions,
        pairs,
        radius,
        density=8500.0,
        floor=None,
        fixed_normals=False,
        law=None,
        **material,
    ):
        self.x = np.array(positions, float)
        self.pairs = np.asarray(pairs)
        self.radius = radius
        self.v = np.zeros_like(self.x)
        self.mass = density * 4 / 3 * np.pi * radius**3
        self.law = law or LawTwin()
        self.alpha_y, self.force_y = scales(radius, **material)
        self.peak = np.zeros(len(self.pairs))
        self.start = self.x.copy()
        self.fixed = fixed_normals
        gap = self.x[self.pairs[:, 0]] - self.x[self.pairs[:, 1]]
        self.normals = gap / np.linalg.norm(gap, axis=1)[:, None]
        self._cache: dict[int, tuple[float, float, float, float]] = {}

    def overlaps(self):
        """Overlap and unit normal (second to first) of every pair."""
        first, second = self.pairs.T
        if self.fixed:
            moved = self.x - self.start
            return -np.einsum("ij,ij->i", moved[first] - moved[second], self.normals), self.normals
        gap = self.x[first] - self.x[second]
        distance = np.linalg.norm(gap, axis=1)
        return 2 * self.radius - distance, gap / distance[:, None]

    def forces(self):
        """(n, 3) force on every sphere; updates the peaks."""
        overlap, normal = self.overlaps()
        a = overlap / self.alpha_y
        self.peak = np.maximum(self.peak, a)
        force = np.where(a > 0, np.maximum(a, 0) ** 1.5, 0.0)
        for k in np.nonzero((self.peak > 1) & (a > 0))[0]:
            force[k] = self._yielded(k, a[k])
        push = (self.force_y * force)[:, None] * normal
        total = np.zeros_like(self.x)
        np.add.at(total, self.pairs[:, 0], push)
        np.add.at(total, self.pairs[:, 1], -push)
        return total

    def _yielded(self, k: int, a: float) -> float:
        peak = self.peak[k]
        if a >= peak:
            return self.law.loading(a)
        kept = self._cache.get(k)
        if kept is None or kept[0] != peak:
            kept = (peak, self.law.loading(peak), self.law.residual(peak), self.law.exponent(peak))
            self._cache[k] = kept
        _, top, rest, n = kept
        return 0.0 if a <= rest else top * ((a - rest) / (peak - rest)) ** n

    def run(self, dt: float, steps: int):
        """Integrate."""
        force = self.forces()
        for _ in range(steps):
            self.v += 0.5 * dt / self.mass * force
            self.x += dt * self.v
            force = self.forces()
            self.v += 0.5 * dt / self.mass * force
        return self

    def dissipated(self) -> float:
        """Dissipated energy, J."""
        return self.force_y * self.alpha_y * sum(self.law.dissipated(p) for p in self.peak)
