"""Second, independent implementation of the contact law and of a network of spheres, in numpy: for
tests only.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numba import njit
from scipy.integrate import quad
from scipy.spatial import cKDTree

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


def fcc(size: tuple[int, int, int], diameter: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3), m, and pairs that touch (n_pairs, 2), from 0, of a packing whose top layer is
    at z = 0: close-packed layers, depth along z.
    """
    nx, ny, nz = size
    k, j, i = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    shift = k % 3
    x = i + (j % 2) / 2 + shift / 2
    y = j * np.sqrt(3) / 2 + shift * np.sqrt(3) / 6
    z = k * np.sqrt(2 / 3)
    place = diameter * np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    pairs = cKDTree(place).query_pairs(diameter * (1 + 1e-6), output_type="ndarray")
    return place, pairs


def middle_of_top(place: np.ndarray) -> int:
    """Sphere of the top layer nearest its centroid; of equally near ones the first."""
    top = np.flatnonzero(place[:, 2] == 0)
    away = np.linalg.norm(place[top, :2] - place[top, :2].mean(axis=0), axis=1)
    return int(top[np.flatnonzero(away < away.min() + 1e-8)[0]])


@njit(cache=True)
def _approach(moved, first, second, normals):
    """Approach of the spheres of each pair along its normal."""
    nearer = np.empty(len(first))
    for k in range(len(first)):
        i = first[k]
        j = second[k]
        total = 0.0
        for axis in range(3):
            total -= (moved[i, axis] - moved[j, axis]) * normals[k, axis]
        nearer[k] = total
    return nearer


class Network:
    """Point masses with true geometry and a fixed set of contacts; velocity Verlet in numpy.

    Parameters
    ----------
    positions
        (n, 3), m.
    pairs
        (n_pairs, 2), indices from 0.
    fixed_normals
        True: contacts keep their initial normals.
    held
        Indices of spheres that do not move.
    """

    def __init__(
        self,
        positions,
        pairs,
        radius,
        density=8500.0,
        fixed_normals=False,
        held=(),
        law=None,
        **material,
    ):
        self.x = np.array(positions, float)
        self.first, self.second = np.asarray(pairs).T.copy()
        self.radius = radius
        self.v = np.zeros_like(self.x)
        self.mass = density * 4 / 3 * np.pi * radius**3
        self.law = law or LawTwin()
        self.alpha_y, self.force_y = scales(radius, **material)
        self.peak = np.zeros(len(self.first))
        self.start = self.x.copy()
        self.fixed = fixed_normals
        self.held = np.array(held, dtype=np.int64)
        gap = self.x[self.first] - self.x[self.second]
        self.normals = gap / np.linalg.norm(gap, axis=1)[:, None]
        self._cache: dict[int, tuple[float, float, float, float]] = {}

    def overlaps(self):
        """Overlap and unit normal (second to first) of every pair."""
        if self.fixed:
            moved = self.x - self.start
            return _approach(moved, self.first, self.second, self.normals), self.normals
        gap = self.x[self.first] - self.x[self.second]
        distance = np.linalg.norm(gap, axis=1)
        return 2 * self.radius - distance, gap / distance[:, None]

    def forces(self):
        """(n, 3) force on every sphere; updates the peaks."""
        overlap, normal = self.overlaps()
        closed = np.flatnonzero(overlap > 0)
        a = overlap[closed] / self.alpha_y
        self.peak[closed] = np.maximum(self.peak[closed], a)
        force = a**1.5
        for n in np.flatnonzero(self.peak[closed] > 1):
            force[n] = self._yielded(closed[n], a[n])
        push = (self.force_y * force)[:, None] * normal[closed]
        total = self._sum(self.first[closed], push) - self._sum(self.second[closed], push)
        total[self.held] = 0.0
        return total

    def _sum(self, spheres, push):
        """Sum vectors by sphere: (n, 3)."""
        n = len(self.x)
        return np.stack([np.bincount(spheres, push[:, axis], n) for axis in range(3)], axis=1)

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
        yielded = self.peak[self.peak > 1]
        return self.force_y * self.alpha_y * sum(self.law.dissipated(p) for p in yielded)

    def largest_force(self) -> float:
        """Largest force of a contact so far, N, at its largest overlap."""
        return self.force_y * self.law.loading(float(self.peak.max()))
