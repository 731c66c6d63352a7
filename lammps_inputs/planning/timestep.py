"""Timestep from the stiffest contact that the load can cause; see `granwave.lammps_inputs.planning.encounters`.

The timestep dt is chosen for the energy balance; stability (dt < 2/omega) would allow some fifty times more. The error
of velocity Verlet is proportional to dt^2 and largest in the first collisions, where few contacts store all the energy.
There the work W is done with the loading stiffness, and its recoverable part E is returned with the higher unloading
stiffness. The effective stiffness is

    k = (E/W) k_unloading + (1 - E/W) k_loading        at the largest overlap

or, with an initial dent larger than this overlap, k_unloading at the overlap at which the contact stores all of W.

The largest error over the energy input is then c k dt^2 / m, with m twice the effective mass of the pair and c nearly
constant: 0.105 to 0.135 in 24 impacts on fcc packings (brass, steel, aluminium; 0.5 to 40 m/s), less on other lattices,
0.15 for Hertz and Thornton contacts, 0.2 for bilinear ones. dt is set so that `_ERROR` k dt^2 / m is `_TOLERANCE`:
29 ns for 10 mm brass spheres struck at 5 m/s in fcc. A bar limits dt to half the transit time of a wave through an
element.

dt is rounded down to two significant digits. At given velocity it is proportional to the diameter, like all times.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from granwave.lammps_inputs.case.run import ENERGY_TOLERANCE
from granwave.lammps_inputs.case.supports import BAR_COURANT_NUMBER
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.walls import support_timestep
from granwave.lammps_inputs.planning.encounters import encounters, some_encounters

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.load import Load


_TOLERANCE = 1e-6  # error of the energy balance at any instant over the energy input
_ERROR = 0.135  # c above, upper end of its range in fcc packings
_OF_VISCOUS_DECAY = 0.1  # timestep over effective mass/viscous coefficient; unstable from 0.25 on in fcc packings

_OF_LOAD = 0.01  # timestep over the duration or period of a load
_OF_LOAD_ON_BAR = 5e-4  # same for a load on a bar, whose energy balance has an error of some (pi dt/T)^2


def expected_peak_overlap(case: Case | Assembly) -> float:
    """Return an upper bound on the largest overlap of two spheres in the run, m."""
    assembly = assemble(case)
    between = [encounter.overlap for encounter in encounters(assembly) if not encounter.against_wall]
    return max(between, default=0.0)


def auto_timestep(case: Case | Assembly, *, tolerance: float = ENERGY_TOLERANCE) -> float:
    """The timestep for the stiffest contact expected, with which a run of an automatic timestep begins, s.

    Parameters
    ----------
    tolerance
        ``run.energy_tolerance``.

    Raises
    ------
    ValueError
        No contact absorbs energy, or one has no stiffness at its overlap.
    """
    assembly = assemble(case)
    for_contacts = math.sqrt(_TOLERANCE * tolerance / ENERGY_TOLERANCE / _ERROR) * shortest_time(assembly)
    share = _OF_LOAD_ON_BAR if assembly.case.incident_bar else _OF_LOAD
    of_load = [share * time for time in _times_of_load(assembly.case.load)]
    return _round_down(min(for_contacts, largest_timestep(assembly), *of_load))


def shortest_time(assembly: Assembly) -> float:
    """Return the smallest sqrt(mass/stiffness) of the contacts expected, s."""
    return math.sqrt(min(encounter.mass / encounter.stiffness for encounter in some_encounters(assembly)))


def largest_timestep(assembly: Assembly) -> float:
    """Bound on the timestep by viscous losses, support and bars at any time, s; infinite without these."""
    stiffness = max(encounter.stiffness for encounter in some_encounters(assembly))
    of_losses = [_OF_VISCOUS_DECAY * encounter.decay_time for encounter in some_encounters(assembly)]
    of_bars = [BAR_COURANT_NUMBER * bar.pitch / bar.wave_speed for bar in assembly.bars]
    return min(support_timestep(assembly, stiffness), *of_bars, *of_losses, math.inf)


def _times_of_load(load: Load) -> list[float]:
    """Return the duration or the period of the load, s; empty if it has none."""
    if load.oscillates:
        return [1 / load.frequencies[1]]
    return [load.duration] if load.duration else []


def _round_down(value: float, digits: int = 2) -> float:
    scale = digits - 1 - math.floor(math.log10(value))
    return float(f"{math.floor(value * 10.0**scale * (1 + 1e-12))}e{-scale}")
