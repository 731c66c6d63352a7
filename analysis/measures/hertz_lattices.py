"""Closed forms and waves of lines of Hertz contacts, loose and under a static force.

Hertz's chain of identical beads has no intrinsic length or force, so every result is a curve in the
units E* R*^2 (force), tau = sqrt(pi rho R*^2/(4 E*)) (time) and R* (length).

A line under a static force, chain or stack of lattice layers, has bodies of mass m at a spacing h,
and springs that are linear for small waves:

    chain         k = 3/2 F0/alpha0, of a Hertz contact with the overlap alpha0 under F0
    fcc and hcp   along [111] and c: layers D sqrt(2/3) apart; a sphere has three contacts in each
                  of the next layers, inclined with cos^2 = 2/3, so that
                  K = 3 cos^2 k - 3 sin^2 f/D = 2 k - f/D for layers as wholes, with the static
                  force f of a contact. The second term, of contacts that turn, is alpha/(3 D) of
                  the first.

Long waves have the speed c0 = h sqrt(K/m). For a chain of identical spheres of diameter a and with
Hertz's k this is

    c0 = 0.93146 (4 E^2 F0/(a^2 rho^3 (1 - nu^2)^2))^(1/6),    0.93146 = sqrt(9/pi) 3^(-1/3) 4^(-1/6)

(Nesterenko's). The travelling wave of the lattice with the largest force f = F_m/F0 increases from
c0 for f -> 1 to about sqrt(8/15) f^(1/6) c0, the speed in an uncompressed chain.

An impact of velocity v on the first of a half-infinite line makes the velocities (with J of Bessel,
omega^2 = K/m)

    v_n(t) = v (2 (2 n - 1)/tau) J_(2n-1)(tau),   force n  F_n(t) = v sqrt(K m) (4 n/tau) J_2n(tau),   tau = 2 omega t

(from v_n = J_(2n-2) + J_2n, which satisfies the equation of motion and the free end). The leading
crest falls as n^(-1/3) and is always slower than c0.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import jv, jvp

from granwave._contact_laws import ContactLaw
from granwave.analysis.measures.signals import Array, width
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.material import material as preset
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import force_of_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.roots import brentq

Values = TypeVar("Values", float, Array)

_REACH = 5  # diameters ahead and behind of the travelling wave
# V = 0.6802 (2 E/(D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6) of Nesterenko's wave, D the diameter
_NESTERENKO = 0.6802

_GEOMETRY_ROUNDS = 20
_PER_BODY = 64  # grid points of the travelling wave
_ROUNDS = 1000
_SETTLED = 1e-11


class ChainScales:
    """Units and closed forms of a chain of identical beads.

    Parameters
    ----------
    case
        Case of the chain.

    Attributes
    ----------
    diameter
        Of a bead, m.
    force
        E* R*^2, N.
    time
        tau, s.
    velocity
        R*/tau, m/s.
    impulse
        E* R*^2 tau, N s.
    """

    def __init__(self, case: Case) -> None:
        self._law = law = sphere_contact(case)
        self.diameter = case.packing.diameter
        self._mass = case.sphere_mass
        self._density = case.material.density
        self._modulus = law.effective_modulus
        self._radius = law.effective_radius
        self.force = self._modulus * self._radius**2
        self.time = math.sqrt(math.pi * self._density * self._radius**2 / (4 * self._modulus))
        self.velocity = self._radius / self.time
        self.impulse = self.force * self.time

    def overlap(self, force: Array) -> Array:
        """Hertz's overlap, m, at forces in N."""
        return static_overlap(self._law, force)

    def impulse_force(self, impulse: float) -> float:
        """(E*^2 R* I^6/m^3)^(1/5), to which the peak force of an impulse I is proportional, N."""
        return (self._modulus**2 * self._radius * impulse**6 / self._mass**3) ** 0.2

    def nesterenko(self, force: float) -> float:
        """Speed of Nesterenko's wave of that peak force, m/s."""
        return self._speed_at_one_newton * force ** (1 / 6)

    def force_at_speed(self, speed: float) -> float:
        """Peak force of Nesterenko's wave of that speed, N."""
        return (speed / self._speed_at_one_newton) ** 6

    @property
    def _speed_at_one_newton(self) -> float:
        return _NESTERENKO * (4 * self._modulus / (self.diameter * self._density**1.5)) ** (1 / 3)


@cache
def discrete_speed() -> float:
    """Speed of the travelling wave of the discrete Hertz chain divided by Nesterenko's speed at the
    same force: 1.01246.
    """
    # V = D sqrt(factor/m) k^(1/3) F^(1/6), with k = E sqrt(D)/(3 (1 - nu^2)) and m = pi rho D^3/6
    return math.sqrt(6 * _discrete_wave()[2] / math.pi) / 6 ** (1 / 3) / _NESTERENKO


@cache
def discrete_width() -> float:
    """Full width at half maximum of the bead velocity in the travelling wave of the discrete chain:
    1.579 diameters.
    """
    return width(*_bead_velocity())


@dataclasses.dataclass(frozen=True)
class SolitaryWave:
    """Travelling wave of a loose chain of identical elastic spheres.

    Attributes
    ----------
    force
        Peak force of the contacts, N.
    speed
        Speed of the wave, m/s.
    overlap
        Largest overlap of the contacts, m.
    velocity
        Largest velocity of the beads, m/s.
    width
        Full width at half maximum of the bead velocity, m.
    duration
        Time in which this width passes a bead, s.
    """

    force: float
    speed: float
    overlap: float
    velocity: float
    width: float
    duration: float


def solitary_wave(
    material: str | Material,
    diameter: float,
    *,
    force: float | None = None,
    speed: float | None = None,
) -> SolitaryWave:
    """Return the travelling wave of the discrete Hertz chain at a peak force, or at a speed.

    Parameters
    ----------
    material
        Material of the spheres, or the name of a preset, such as ``"steel"``.
    diameter
        Diameter of the spheres, m.
    force
        Peak force of the contacts, N.
    speed
        Speed of the wave, m/s.

    Raises
    ------
    InputError
        There is no such preset; a value is not above 0; or neither or both of force and speed are
        given.
    """
    if isinstance(material, str):
        material = preset(material)
    if (force is None) == (speed is None):
        raise InputError("solitary_wave: expected one of force (N) or speed (m/s)")
    for name, value in (("diameter", diameter), ("force", force), ("speed", speed)):
        if value is not None and not 0 < value < math.inf:
            raise InputError(f"{name}: found {value}, expected a finite number above 0")
    plane_modulus = material.youngs_modulus / (1 - material.poisson_ratio**2)
    of_one_newton = discrete_speed() * _NESTERENKO
    of_one_newton *= (2 * plane_modulus / (diameter * material.density**1.5)) ** (1 / 3)
    if force is None:
        assert speed is not None  # the static force is given
        force = (speed / of_one_newton) ** 6
    speed = of_one_newton * force ** (1 / 6)
    overlap = (3 * force / (plane_modulus * math.sqrt(diameter))) ** (2 / 3)
    velocity = speed * overlap / diameter * float(_bead_velocity()[1].max())
    extent = discrete_width() * diameter
    return SolitaryWave(force, speed, overlap, velocity, extent, extent / speed)


def _bead_velocity() -> tuple[Array, Array]:
    """Positions in diameters, and the velocity of a bead in the travelling wave, times the diameter
    divided by speed and largest overlap.
    """
    x, wave, _ = _discrete_wave()
    per_diameter = round(1 / (x[1] - x[0]))
    # rate of the overlap ahead of a bead: the difference of two velocities
    rate = np.gradient(wave, x)
    velocity = np.zeros_like(wave)
    for k in range(2 * _REACH):
        shift = k * per_diameter + per_diameter // 2
        velocity[: len(x) - shift] -= rate[shift:]
    return x, velocity


@cache
def _discrete_wave() -> tuple[Array, Array, float]:
    """Positions in diameters and overlaps, at most 1, of the travelling wave, and the factor that
    fixes its speed.

    The overlap of a wave of speed V obeys ``delta = (k D^2/(m V^2)) L * delta^1.5`` with L the
    triangle of height 1 and base 2 D; its solution, of height 1, is found by iteration (English and
    Pego, Proc. AMS 133, 2005).
    """
    per_diameter = 200
    reach = _REACH
    n = reach * per_diameter
    x = np.arange(-n, n + 1) / per_diameter
    triangle = (
        np.clip(1 - np.abs(x[n - per_diameter : n + per_diameter + 1]), 0, None) / per_diameter
    )
    wave = np.exp(-(x**2))
    factor = 1.0
    for _ in range(60):
        wave = np.convolve(wave**1.5, triangle, mode="same")
        factor = float(wave.max())
        wave /= factor
    return x, wave, factor


def static_overlap(law: ContactLaw, force: Values) -> Values:
    """Hertz's overlap under a force, m."""
    return (force / (4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius))) ** (2 / 3)


@dataclasses.dataclass(frozen=True)
class PrecompressedLine:
    """Line that is equivalent to a chain or a packing, in its static state, for long waves along
    it.

    Attributes
    ----------
    force, overlap
        Force and overlap of each loaded contact, N and m.
    spacing
        Of beads or layers before they were loaded, m: speeds refer to the positions that the
        spheres had then.
    frequency
        omega = sqrt(K/m), rad/s.
    """

    force: float
    overlap: float
    spacing: float
    frequency: float

    @property
    def speed(self) -> float:
        """c0, m/s."""
        return self.spacing * self.frequency

    @property
    def velocity(self) -> float:
        """omega alpha0, m/s; much slower impacts make small waves."""
        return self.frequency * self.overlap


def line_of(case: Case, law: ContactLaw | None = None) -> PrecompressedLine:
    """The line of a precompressed chain, or of the layers of a packing, of identical spheres. With
    periodic sides the load makes the contacts of a packing less steep.

    Parameters
    ----------
    law
        Law between two spheres, by default the law of the case.
    """
    law = sphere_contact(case) if law is None else law
    force = force_of_contact(assemble(case))
    diameter = case.packing.diameter
    mass = case.sphere_mass
    rule = case.packing.rule
    n = len(rule.supports)
    cosine = rule.layer_spacing
    on_layer = n * rule.layer_spacing * force
    for _ in range(_GEOMETRY_ROUNDS if case.boundary.periodic else 1):
        force = on_layer / (n * cosine)
        length = diameter - static_overlap(law, force)
        if case.boundary.periodic:
            cosine = math.sqrt(1 - diameter**2 * (1 - rule.layer_spacing**2) / length**2)
    overlap = static_overlap(law, force)
    length = diameter - overlap
    stiffness = n * (cosine**2 * 1.5 * force / overlap - (1 - cosine**2) * force / length)
    return PrecompressedLine(
        force, overlap, rule.layer_spacing * diameter, math.sqrt(stiffness / mass)
    )


@cache
def _lattice_waves() -> tuple[Array, Array]:
    """Logarithms of F_m/F0 and of the speed divided by c0 of the travelling waves
    of the lattice.
    """
    excess = np.concatenate([[0.0], np.geomspace(3e-4, 6.0, 45)])
    ratio = [1.0, *(_travelling(1 + x) for x in excess[1:])]
    return np.log(ratio), np.log1p(excess)


def lattice_speed(ratio: Array) -> Array:
    """Speed divided by c0 of the travelling wave of the discrete precompressed Hertz lattice, for
    F_m/F0 up to about 1e5; at larger values the exponent is 1/6.
    """
    known, speed = _lattice_waves()
    x = np.log(ratio)
    return np.exp(np.interp(x, known, speed) + np.maximum(x - known[-1], 0) / 6)


def _travelling(speed: float) -> float:
    """F_m/F0 of the wave of the lattice for a speed divided by c0, above 1.

    In units of D, alpha0 and the static stiffness, the overlap 1 + r of a wave obeys V^2 r =
    triangle * g(r) with g = (2/3)((1 + r)^1.5 - 1), the triangle of height 1 and base 2. With g = r
    + N it is solved by Petviashvili's iteration in Fourier space, (V^2 - sinc^2) r = S^2 sinc^2 N.
    """
    decay = min(math.sqrt(12 * (speed**2 - 1)), 10.0)
    reach = max(8.0, 12 / decay)
    n = 1 << math.ceil(math.log2(2 * reach * _PER_BODY))
    x = (np.arange(n) - n // 2) / _PER_BODY
    kernel = np.sinc(np.fft.rfftfreq(n, 1 / _PER_BODY)) ** 2
    operator = speed**2 - kernel
    wave = 3 * (speed**2 - 1) / np.cosh(decay * x / 2) ** 2
    for _ in range(_ROUNDS):
        nonlinear = 2 / 3 * (np.maximum(1 + wave, 0) ** 1.5 - 1) - wave
        ours = np.fft.rfft(wave)
        theirs = kernel * np.fft.rfft(nonlinear)
        factor = np.sum(operator * np.abs(ours) ** 2) / np.sum((theirs * ours.conj()).real)
        new = np.fft.irfft(factor**2 * theirs / operator, n)
        change = float(np.abs(new - wave).max() / new.max())
        wave = new
        if change < _SETTLED:
            break
    return float((1 + wave.max()) ** 1.5)


def crest_times(n: NDArray[np.int64]) -> Array:
    """2 omega t of the first crest of the velocity of body n, from 1, after an impact on the line:
    (n_bodies,).
    """
    return np.array([_crest(2 * int(one) - 1) for one in n])


def crest_speed(line: PrecompressedLine, n: NDArray[np.int64]) -> float:
    """Mean speed of the crest of the forces over contacts n, rising, after an impact on the line,
    m/s.
    """
    times = [_crest(2 * int(one)) for one in n]
    return 2 * line.speed / float(np.polyfit(n, times, 1)[0])


def crest_force(n: NDArray[np.int64]) -> Array:
    """Largest force at contact n, from 1, after an impact on the line, divided by v sqrt(K m):
    (n_contacts,).
    """
    return np.array(
        [4 * one * jv(2 * one, tau) / tau for one, tau in ((int(k), _crest(2 * int(k))) for k in n)]
    )


@cache
def _crest(order: int) -> float:
    """First maximum of J_order(tau)/tau; order from 2."""
    if order < 2:
        return 0.0

    def slope(tau: float) -> float:
        return float(tau * jvp(order, tau) - jv(order, tau))

    return brentq(slope, 0.8 * order, order + 1.5 * order ** (1 / 3), xtol=1e-12)
