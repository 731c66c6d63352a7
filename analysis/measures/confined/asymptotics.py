"""Asymptotic theory of confined rows for light small spheres (thesis 6.3), with the errata of its equations mended.

Lengths in units of a bead's distance, forces of k_bb, displacements of the wave's A (a bead's, by the wave). The small
spheres follow the beads to order zero, and the beads are a chain with a second, precompressed contact:

    k = (2 eta tan(theta)/gamma)^(2/3),  eta_hat = n eta/[2 (1 + k tan(theta))]^1.5,  delta_hat = 2 delta tan(theta)/A
    w_i'' = F(w_(i-1) - w_i) - F(w_i - w_(i+1)), F(r) = [r]^1.5 + eta_hat ([r + delta_hat]^1.5 - delta_hat^1.5)  (6.13)

A travelling wave w(x - c tau) with the difference r(z) = w(z - 1/2) - w(z + 1/2) obeys c^2 r = Lambda * F(r), with
Lambda = sinc^2(k/2) in Fourier space; its integral gives c. To first order the small
spheres are oscillators that the wave drives:

    eps w_1'' + 3 eta sqrt(beta) w_1 = -w_0'',    eps u_1'' + 1.5 gamma sqrt(k beta) (1 + k tan(theta)) u_1 = -u_0''
    beta = (w_i - w_(i+1) + delta_hat)/(2 (1 + k tan(theta)))                                          (6.16, 6.17)

What swings on behind the wave is lost to it: n eps^3 (w_1'^2 + u_1'^2), over the square of the beads'
largest velocity (6.18).
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from granwave.analysis.measures.signals import Array

_HALF, _PER_BEAD = 16, 32  # beads on either side of the crest, and grid points to a bead
_ROUNDS, _SETTLED = 3000, 1e-12
_ENDS = 6.0  # of the series: beads from the crest within which the residual counts; beyond, nothing is left
_INSTANTS = 6001
_TAIL = 30.0  # times of a bead's distance over which the small spheres are followed behind the wave


@dataclasses.dataclass(frozen=True)
class Limit:
    """A row in the limit of light small spheres, by its numbers (6.8); ``tangent`` is tan(theta)."""

    n: float
    eps: float
    eta: float
    gamma: float
    tangent: float

    @property
    def k(self) -> float:
        """Coefficient k of (6.12)."""
        return (2 * self.eta * self.tangent / self.gamma) ** (2 / 3)

    @property
    def soft(self) -> float:
        """1 + k tan(theta)."""
        return 1 + self.k * self.tangent

    @property
    def eta_hat(self) -> float:
        """Coefficient of (6.13); eta has cos^2.5(theta) already."""
        return self.n * self.eta / (2 * self.soft) ** 1.5


@dataclasses.dataclass(frozen=True)
class Series:
    """The wave as 1/(1 + exp(C1 z + C3 z^3 + ...)) (6.14), and its speed."""

    coefficients: tuple[float, ...]
    speed: float

    def __call__(self, z: Array) -> Array:
        """Displacement over A."""
        return _front(np.asarray(z, dtype=float), np.array(self.coefficients))


@dataclasses.dataclass(frozen=True)
class Travelling:
    """A wave of unit amplitude on the zeroth-order chain."""

    eta_hat: float
    delta_hat: float

    def force(self, r: Array) -> Array:
        """F(r), without the static part."""
        near, loaded = np.maximum(r, 0.0), np.maximum(r + self.delta_hat, 0.0)
        return np.asarray(near**1.5 + self.eta_hat * (loaded**1.5 - self.delta_hat**1.5))

    @cached_property
    def _solution(self) -> tuple[float, Array, Array]:
        """Speed, grid and difference of neighbours on it."""
        n = 2 * _HALF * _PER_BEAD
        z = (np.arange(n) - n // 2) / _PER_BEAD
        wave = 2 * np.pi * np.fft.rfftfreq(n, 1 / _PER_BEAD)
        kernel = np.sinc(wave / (2 * np.pi)) ** 2
        r = np.exp(-(z**2))
        r /= r.sum() / _PER_BEAD
        for _ in range(_ROUNDS):
            new = np.maximum(np.fft.irfft(kernel * np.fft.rfft(self.force(r)), n), 0.0)
            square = float(new.sum()) / _PER_BEAD
            new /= square
            change, r = float(np.abs(new - r).max()), new
            if change < _SETTLED:
                break
        return math.sqrt(square), z, r

    @property
    def speed(self) -> float:
        """Speed c of the wave on the lattice."""
        return self._solution[0]

    @cached_property
    def difference(self) -> CubicSpline:
        """The difference r(z) of neighbours around z, between the ends of the grid."""
        _, z, r = self._solution
        return CubicSpline(z, r)

    def displacement(self, z: Array) -> Array:
        """Displacement over A of a bead at z from the crest, on the lattice: the differences of all beads ahead."""
        ahead = np.asarray(z, dtype=float)[:, None] + 0.5 + np.arange(2 * _HALF)
        inside = np.abs(ahead) < _HALF - 0.1
        return np.asarray(np.where(inside, self.difference(np.clip(ahead, -_HALF, _HALF - 0.1)), 0.0).sum(axis=1))

    def series(self, terms: int = 3) -> Series:
        """The series of odd terms with the least square of the residual of (6.13)."""
        z = np.linspace(-_ENDS, _ENDS, int(2 * _ENDS * _PER_BEAD) + 1)
        odd = 2 * np.arange(terms) + 1

        def residual(values: Array) -> Array:
            coefficients, c = values[:-1], values[-1]
            w = _front(z, coefficients)
            pull = self.force(_front(z - 1, coefficients) - w) - self.force(w - _front(z + 1, coefficients))
            slope = (odd * coefficients * z[:, None] ** (odd - 1)).sum(axis=1)
            bend = (odd * (odd - 1) * coefficients * z[:, None] ** np.maximum(odd - 2, 0)).sum(axis=1)
            second = w * (1 - w) * ((1 - 2 * w) * slope**2 - bend)
            return np.asarray(c * c * second - pull)

        found = least_squares(residual, np.array([2.0, 0.1, *[0.0] * (terms - 2), self.speed]), xtol=1e-13, ftol=1e-13)
        return Series(tuple(map(float, found.x[:-1])), float(found.x[-1]))

    @property
    def bead_velocity(self) -> float:
        """Largest velocity of a bead, in A over the unit of tau."""
        z = np.linspace(-4, 4, 1601)
        return float(self.speed * np.abs(np.gradient(self.displacement(z), z)).max())


@dataclasses.dataclass(frozen=True, eq=False)
class FirstOrder:
    """First-order velocities of small spheres, in A over the unit of tau, at instants tau from the crest's passage."""

    time: Array
    axial: Array
    radial: Array
    axial_tail: float
    radial_tail: float


def first_order(limit: Limit, wave: Travelling) -> FirstOrder:
    """Drive the small spheres of one gap by a wave, from rest."""
    c, r = wave.speed, wave.difference
    reach = _HALF - 1.5
    time = np.linspace(-(reach - 1) / c, (reach - 1 + _TAIL) / c, _INSTANTS)

    def difference(z: Array) -> Array:
        return np.where(np.abs(z) < reach, r(np.clip(z, -reach, reach)), 0.0)

    here, behind, ahead = (difference(shift - c * time) for shift in (0.0, -1.0, 1.0))
    f = [wave.force(one) for one in (behind, here, ahead)]
    drive = np.array([-(f[0] - f[2]) / 2, -limit.k / (2 * limit.soft) * (f[0] - 2 * f[1] + f[2])]) / limit.eps
    root = np.sqrt((here + wave.delta_hat) / (2 * limit.soft))
    spring = np.array([3 * limit.eta * root, 1.5 * limit.gamma * math.sqrt(limit.k) * limit.soft * root]) / limit.eps
    axial, radial = _oscillators(time[1] - time[0], drive, spring)
    after = time > reach / c
    return FirstOrder(time, axial, radial, float(np.abs(axial[after]).max()), float(np.abs(radial[after]).max()))


def _oscillators(step: float, drive: Array, spring: Array) -> Array:
    """Velocities of oscillators of unit mass, from rest, by velocity Verlet; all (n_oscillators, n_times)."""
    place, velocity = np.zeros((2, len(drive)))
    found = np.zeros_like(drive)
    rate = drive[:, 0]
    for n in range(1, drive.shape[1]):
        velocity = velocity + 0.5 * step * rate
        place = place + step * velocity
        rate = drive[:, n] - spring[:, n] * place
        velocity = velocity + 0.5 * step * rate
        found[:, n] = velocity
    return found


def energy_decay(limit: Limit, wave: Travelling, tail: FirstOrder) -> float:
    """Decay of the wave's energy per bead (6.18)."""
    speeds = tail.axial_tail**2 + tail.radial_tail**2
    return limit.n * limit.eps**3 * speeds / wave.bead_velocity**2


def _front(z: Array, coefficients: Array) -> Array:
    odd = 2 * np.arange(len(coefficients)) + 1
    exponent = (coefficients * z[:, None] ** odd).sum(axis=1)
    return np.asarray(1 / (1 + np.exp(np.clip(exponent, -500.0, 500.0))))
