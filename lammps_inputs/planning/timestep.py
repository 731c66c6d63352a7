"""Timestep from the stiffest contact that the load can cause; see
`granwave.lammps_inputs.planning.encounters`.

The timestep dt is chosen for the energy balance; stability (dt < 2/omega) would allow a timestep
about fifty times longer. The error of velocity Verlet is proportional to dt^2 and largest in the
first collisions, where few contacts store all the energy. In these collisions the work W is done
with the loading stiffness, and its recoverable part E is returned with the higher unloading
stiffness. The effective stiffness is

    k = (E/W) k_unloading + (1 - E/W) k_loading        at the largest overlap

or, with an initial dent larger than this overlap, k_unloading at the overlap at which the contact
stores all of W.

The largest error divided by the energy input is then c k dt^2 / m, with m twice the effective mass
of the pair and c nearly constant: 0.105 to 0.135 in 24 impacts on fcc packings (brass, steel,
aluminium; 0.5 to 40 m/s), less in other lattices, 0.15 for Hertz and Thornton contacts, 0.2 for
bilinear contacts. dt is set so that `_ERROR` k dt^2 / m is `_TOLERANCE`: 29 ns for an impact at 5
m/s on 10 mm brass spheres in fcc. A bar limits dt to half the transit time of a wave through an
element.

dt is rounded down to two significant digits. At given velocity it is proportional to the diameter,
like all times.

No wave propagates above the cut-off. At higher frequencies the motion of the grains falls with the
square of the frequency, and the timestep follows the load: far above the cut-off a run takes long,
and shows only rounding errors.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Sequence

from granwave.lammps_inputs.case.boundary import BAR_COURANT_NUMBER, PLATE_OSCILLATION
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import Resistance
from granwave.lammps_inputs.case.loads.driven import DrivenLoad
from granwave.lammps_inputs.case.run import ENERGY_TOLERANCE
from granwave.lammps_inputs.contact.law import cohesive_laws
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import support_of, support_timestep
from granwave.lammps_inputs.planning.encounters import (
    BOTTOM,
    Encounter,
    encounters,
    some_encounters,
)

_TOLERANCE = 1e-6  # error of the energy balance at any instant / energy input
_ERROR = 0.135  # c above, upper end of its range in fcc packings
_OF_ROLLING = 0.2  # timestep over 1/angular frequency of a given stiffness; stable below 2
_OF_COHESION = 0.5  # surfaces that jump together move fast at first
# timestep over effective mass/viscous coefficient; unstable from 0.25 on in fcc packings
_OF_VISCOUS_DECAY = 0.1
# mass that moves along the surface over the effective mass: spheres of 2/5 m R^2 turn as well
_OF_MASS_ALONG = 2 / 7

# bounds of bodies behind walls, by their keys
_REMEDIES = {
    BOTTOM: "a heavier or softer support",
    "bar.length": "a longer bar",
    "incident_bar.length": "a longer bar",
}
_OF_LOAD = 0.01  # timestep / duration or period of a load
# same for a load on a bar, whose energy balance has an error of some (pi dt/T)^2
_OF_LOAD_ON_BAR = 5e-4


def expected_peak_overlap(assembly: Assembly) -> float:
    """Return an upper bound on the largest overlap of two spheres in the run, m."""
    between = [
        encounter.overlap for encounter in encounters(assembly) if not encounter.against_wall
    ]
    return max(between, default=0.0)


def auto_timestep(assembly: Assembly, *, tolerance: float = ENERGY_TOLERANCE) -> float:
    """The timestep for the stiffest contact expected, with which a run of an automatic timestep
    begins, s.

    Parameters
    ----------
    tolerance
        ``run.energy_tolerance``.

    Raises
    ------
    ValueError
        No contact absorbs energy, or a contact has no stiffness at its overlap.
    """
    step = timestep_limits(assembly, tolerance)[0].step
    scale = 1 - math.floor(math.log10(step))
    return float(f"{math.floor(step * 10.0**scale * (1 + 1e-12))}e{-scale}")


@dataclasses.dataclass(frozen=True)
class TimestepLimit:
    """Bound on the timestep.

    Attributes
    ----------
    step
        Largest timestep that it leaves, s.
    cause
        What sets it: a key of the case and its value, or the contacts.
    remedy
        What would leave a longer timestep.
    of_contact
        True for the bound by a kind of collision.
    against_wall
        True for a collision with a wall.
    """

    step: float
    cause: str
    remedy: str
    of_contact: bool = False
    against_wall: bool = False


def timestep_limits(assembly: Assembly, tolerance: float = ENERGY_TOLERANCE) -> list[TimestepLimit]:
    """Return the bounds on the timestep, the smallest first; contacts have a bound for each kind of
    collision.

    Raises
    ------
    ValueError
        No contact absorbs energy, or a contact has no stiffness at its overlap.
    """
    factor = math.sqrt(_TOLERANCE * tolerance / ENERGY_TOLERANCE / _ERROR)
    load = assembly.case.load
    found = _limits_at_any_time(assembly)
    for one in some_encounters(assembly):
        cause = (
            f"a contact of R* = {one.law.effective_radius:.3g} m and a mass of {one.mass:.3g} kg"
        )
        step = factor * math.sqrt(one.mass / one.stiffness)
        remedy = _REMEDIES.get(one.body, "a heavier plate") if one.body else "larger grains there"
        step_of_contact = TimestepLimit(
            step, one.body or cause, remedy, of_contact=True, against_wall=one.against_wall
        )
        found.append(step_of_contact)
    for law, mass in cohesive_laws(
        assembly
    ):  # stiffness 2 E* a of the circle of contact without force
        overlap = law.balanced_overlap
        stiffness = 2 * law.effective_modulus * float(law.contact_radius(overlap, overlap))
        step = _OF_COHESION * factor * math.sqrt(mass / stiffness)
        found.append(TimestepLimit(step, "contact.cohesion", "a smaller work of adhesion"))
    share = _OF_LOAD_ON_BAR if assembly.case.incident_bar else _OF_LOAD
    if (limit := load.timestep_limit(share)) is not None:
        found.append(TimestepLimit(*limit))
    return sorted(found, key=lambda limit: limit.step)


def largest_timestep(assembly: Assembly) -> float:
    """Bound on the timestep by viscous losses, support and bars at any time, s; infinite without
    any of these.
    """
    return min((limit.step for limit in _limits_at_any_time(assembly)), default=math.inf)


def _limits_at_any_time(assembly: Assembly) -> list[TimestepLimit]:
    """Return the bounds by losses, bars and other moving bodies.

    For given stiffnesses K and dampings gamma of resistance to rolling: with the smallest effective
    mass m* and radius R* of any contact, the square of the angular frequency of spheres of 2/5 m
    R^2 is at most 2.5 K/m*, their rate of decay 2.5 gamma/m*; twisting has K/R*^2 and gamma/R*^2
    instead.
    """
    case = assembly.case
    found = some_encounters(assembly)
    stiffness = max(one.stiffness for one in found)
    mass = min(one.mass for one in found)
    radius = min(one.law.effective_radius for one in found)
    lossy = [one for one in found if one.loss is not None]
    limits = [
        TimestepLimit(_OF_VISCOUS_DECAY * one.decay_time, "contact.loss", "a smaller loss")
        for one in lossy
    ]
    limits += _limits_along_surfaces(case, lossy)
    for contact in (case.contact, *(pair.contact for pair in case.pair)):
        for key, arm in (("rolling", 1.0), ("twisting", radius)):
            one = getattr(contact, key)
            if not isinstance(one, Resistance) or not one.coefficient:
                continue
            if one.stiffness:
                step = _OF_ROLLING * math.sqrt(mass * arm**2 / (2.5 * one.stiffness))
                limits.append(TimestepLimit(step, f"contact.{key}", "a smaller stiffness"))
            if one.damping:
                step = _OF_VISCOUS_DECAY * mass * arm**2 / (2.5 * one.damping)
                limits.append(TimestepLimit(step, f"contact.{key}", "a smaller damping"))
    for bar in assembly.bars:
        step = BAR_COURANT_NUMBER * bar.pitch / bar.wave_speed
        limits.append(TimestepLimit(step, f"{bar.name}.elements", "fewer elements"))
    if (support := support_of(assembly)) is not None:
        step = support_timestep(assembly, stiffness)
        limits.append(TimestepLimit(step, BOTTOM, support.remedy))
    if (plate := case.load.plate) is not None:
        on_plate = len(assembly.lattice.top_layer) * stiffness
        step = PLATE_OSCILLATION * math.sqrt(plate.mass / on_plate)
        limits.append(TimestepLimit(step, plate.key, "a heavier plate"))
    return limits


def _limits_along_surfaces(case: Case, lossy: Sequence[Encounter]) -> list[TimestepLimit]:
    """Return the bounds from the damping along the surfaces of contacts with a loss."""
    ratios = [one.loss.tangential or 0.0 for one in case.contact_laws if one.loss is not None]
    largest = max(ratios, default=0.0)
    if not largest or not case.has_friction:
        return []
    part = _OF_VISCOUS_DECAY * _OF_MASS_ALONG / largest
    return [
        TimestepLimit(part * one.decay_time, "contact.loss.tangential", "less damping")
        for one in lossy
    ]


_LOG = logging.getLogger("granwave")
# cut-off of a row over 1/(2 pi shortest time): 2/sqrt(1.2) for Hertz's law by its mean stiffness
_OF_CUTOFF = 2.0
# times the cut-off: a warning, and an error
_FAR = 5.0
_TOO_FAR = 100.0


def check_load_frequency(assembly: Assembly) -> None:
    """Warn about a load that oscillates far above the cut-off; reject frequencies more than a
    hundred times higher.

    Raises
    ------
    InputError
        The frequency is more than a hundred times the cut-off of the contacts under the static
        load.
    """
    case = assembly.case
    load = assembly.case.load
    if not isinstance(load, DrivenLoad) or not load.oscillates:
        return
    if assembly.bars or case.precompression is None:
        return
    try:
        shortest = math.sqrt(min(one.mass / one.stiffness for one in some_encounters(assembly)))
    except (ArithmeticError, ValueError):  # no contact takes up energy
        return
    cutoff = _OF_CUTOFF / (2 * math.pi * shortest)
    highest = load.highest_frequency
    if highest <= _FAR * cutoff:
        return
    found = (
        f"{case.name}: {load.highest_key}: found {highest:g} Hz, {highest / cutoff:.3g} times the "
        f"highest frequency that the stiffest contact transmits, about {cutoff:.3g} Hz"
    )
    if highest > _TOO_FAR * cutoff:
        raise InputError(f"{found}; expected at most {_TOO_FAR:g} times this frequency")
    _LOG.warning(
        "%s: the packing hardly moves, the load sets the timestep, and the energy balance may be "
        "inaccurate",
        found,
    )
