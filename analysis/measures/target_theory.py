"""Closed forms for targets: Hertz's impact of a single sphere, and the shock spectrum of plates on
springs.

A sphere of mass m and speed v on a rigid wall, F = K alpha^1.5 with K = 4/3 E* sqrt(R) (Hertz
1882):

    alpha_m = (5 m v^2/(4 K))^(2/5)     F_m = K alpha_m^1.5     t_c = 2.943 alpha_m/v     impulse 2 m v

A mass M on a spring k, omega = sqrt(k/M): a short impulse J moves it by J/(M omega), a slow force
by F/k.

Shock spectrum of a force: displacement of a plate on a spring under it, against the plate's period.
A plate with a period much longer than the force responds to the impulse and moves by J/(M omega); a
plate with a much shorter period follows the force and moves by F/k. In between it is an oscillator
under the force on a fixed wall.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.signal import lsim
from scipy.special import beta

from granwave.analysis.measures.signals import Array, width
from granwave.analysis.measures.target_record import Reached
from granwave.lammps_inputs.case.boundary import Plate
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import flat_contact
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.roots import brentq

_POINTS = 2000  # points of Hertz's force in time

# ratios of the period at which the limits hold, to the width of the peak and to the duration of the
# impulse
_FAST = 0.25
_SLOW = 10.0
_MOST_OF_IT = 0.9  # fraction of the impulse, around its middle, that defines its duration


@dataclasses.dataclass(frozen=True)
class HertzImpact:
    """Elastic impact of a sphere on a rigid wall.

    Attributes
    ----------
    mass, velocity
        kg, m/s.
    stiffness
        K of F = K alpha^1.5, N/m^1.5.
    """

    mass: float
    velocity: float
    stiffness: float

    @classmethod
    def of(cls, case: Case) -> HertzImpact:
        """The impact of a case's first sphere on its bottom, which is fixed."""
        law = flat_contact(assemble(case), 1, case.boundary.bottom_material)
        stiffness = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
        return cls(
            case.sphere_mass,
            case.load.velocity * math.cos(math.radians(case.load.angle)),
            stiffness,
        )

    @property
    def overlap(self) -> float:
        """Largest overlap, m."""
        return (5 * self.mass * self.velocity**2 / (4 * self.stiffness)) ** 0.4

    @property
    def force(self) -> float:
        """Largest force, N."""
        return self.stiffness * self.overlap**1.5

    @property
    def duration(self) -> float:
        """Duration of the contact, s: 2 alpha_m/v times the integral of (1 - s^2.5)^(-1/2) from 0
        to 1.
        """
        return 2 * self.overlap / self.velocity * 0.4 * beta(0.4, 0.5)

    @property
    def impulse(self) -> float:
        """Impulse, N s."""
        return 2 * self.mass * self.velocity

    @property
    def square(self) -> float:
        """Integral of the squared force over time, N^2 s; divided by Z it is the energy absorbed
        by an impedance Z.
        """
        return 2 * self.stiffness**2 * self.overlap**4 / self.velocity * 0.4 * beta(1.6, 0.5)

    def history(self) -> tuple[Array, Array]:
        """Time (s) and force (N), evenly spaced in time: (n,) each."""
        share = (
            np.sin(np.linspace(0, np.pi / 2, _POINTS)) ** 2
        )  # fractions of the largest overlap; dense at both ends
        slowness = 1 / np.sqrt(np.maximum(1 - share**2.5, 1e-300))
        steps = np.diff(share) * (slowness[1:] + slowness[:-1]) / 2
        steps[-1] = np.sqrt(
            np.diff(share)[-1] * 4 / 2.5
        )  # the integral up to the turning point, where the integrand is singular
        time = np.concatenate([[0.0], np.cumsum(steps)]) * self.overlap / self.velocity
        force = self.stiffness * (share * self.overlap) ** 1.5
        even = np.linspace(0, 2 * time[-1], 2 * _POINTS)
        return even, np.interp(
            even,
            np.concatenate([time, 2 * time[-1] - time[-2::-1]]),
            np.append(force, force[-2::-1]),
        )

    def energy_into(self, spring: float, damping: float) -> float:
        """Work on a spring (N/m; 0: none) and damper (N s/m) without mass and with negligible
        motion, J.
        """
        if not spring:
            return self.square / damping
        time, force = self.history()
        speed = np.gradient(response(time, force, 0.0, spring, damping), time)
        return float(np.trapezoid(force * speed, time))

    def on_spring(self, stiffness: float) -> float:
        """Largest force on a wall without mass on a spring (N/m), N: from the balance of energy at
        rest.
        """
        energy = 0.5 * self.mass * self.velocity**2

        def missing(force: float) -> float:
            return (
                0.4 * force ** (5 / 3) / self.stiffness ** (2 / 3)
                + force**2 / (2 * stiffness)
                - energy
            )

        return brentq(missing, 0, self.force, xtol=2e-12)


def response(
    time: Array, force: Array, mass: float, stiffness: float, damping: float = 0.0
) -> Array:
    """Displacement of a mass on a spring and a damper under a force, at rest at the start:
    (n_times,), m.

    Parameters
    ----------
    time, force
        (n_times,), s and N.
    mass, stiffness, damping
        kg, N/m, N s/m; the mass may be 0 next to a damper.
    """
    even = np.linspace(time[0], time[-1], len(time))
    order = [mass, damping, stiffness] if mass else [damping, stiffness]
    moved = lsim(([1.0], order), np.interp(even, time, force), even)[1]
    return np.interp(time, even, moved)


def after_impulse(impulse: float, mass: float, stiffness: float) -> float:
    """Largest displacement of a mass on a spring after a short impulse, m."""
    return impulse / math.sqrt(mass * stiffness)


@dataclasses.dataclass(frozen=True, eq=False)
class Curves:
    """Largest displacement of plates of one mass: by the oscillator and in its limits, m; all
    (n_periods,).
    """

    period: Array
    oscillator: Array
    slow_force: Array
    short_impulse: Array


def oscillator(held: Reached, plate: Plate, end: float) -> float:
    """Largest displacement of a plate under the force on a wall, and after it up to a time (s): m."""
    time = held.time
    force = held.force
    if end > time[-1]:
        step = time[1] - time[0]
        time = np.append(time, np.arange(time[-1] + step, end, step))
        force = np.append(force, np.zeros(len(time) - len(force)))
    return float(response(time, force, plate.mass, plate.stiffness, plate.damping).max())


def expected_displacement(held: Reached, plate: Plate, end: float) -> tuple[float, str]:
    """Largest displacement of a plate under the force on a fixed wall, m, and the name of the
    theory.

    ``held`` is the record of the same packing on a wall, ``end`` the last time of the record of the
    plate, s.
    """
    period = plate.period
    if period < _FAST * width(held.time, held.force):
        return held.peak_force / plate.stiffness, "slow force, F/k"
    part = np.array([1 - _MOST_OF_IT, 1 + _MOST_OF_IT]) / 2 * held.impulse[-1]
    lasts = float(np.diff(np.interp(part, held.impulse, held.time))[0])
    if period > _SLOW * lasts and not plate.damping:
        return after_impulse(
            float(held.impulse[-1]), plate.mass, plate.stiffness
        ), "short impulse, J/(M omega)"
    return oscillator(held, plate, max(end, held.time[-1])), "oscillator"


def spectrum_curves(held: Reached, plate: Plate, period: Array) -> Curves:
    """Curves of plates with other springs, at the periods (n_periods,), s."""
    springs = plate.mass * (2 * math.pi / period) ** 2
    plates = (dataclasses.replace(plate, stiffness=spring) for spring in springs)
    ends = held.time[-1] + period
    moved = np.array(
        [oscillator(held, other, end) for other, end in zip(plates, ends, strict=True)]
    )
    short = after_impulse(float(held.impulse[-1]), plate.mass, 1.0) / np.sqrt(springs)
    return Curves(period, moved, held.peak_force / springs, short)
