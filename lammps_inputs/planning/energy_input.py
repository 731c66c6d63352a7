"""Energy that a load puts into a packing, and the speeds that it can cause."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bars import INCIDENT_BAR
from granwave.lammps_inputs.packing.motion import struck_of, velocities_of

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.load import Load


def expected_energy(assembly: Assembly) -> float:
    """Return the energy input of the load, J; for a force an upper bound."""
    case = assembly.case
    energy = sum(0.5 * assembly.mass_of(k) * math.hypot(*v) ** 2 for k, v in velocities_of(assembly).items())
    energy += energy_of_plate(case.load)
    return energy + (_energy_of_force(assembly) if case.load.kind == "force" else 0.0)


def fastest(assembly: Assembly) -> float:
    """Return an upper bound on the speed of any sphere, m/s."""
    case = assembly.case
    given = max((math.hypot(*velocity) for velocity in velocities_of(assembly).values()), default=0.0)
    if case.load.kind == "force":
        given = max(given, math.sqrt(2 * _energy_of_force(assembly) / _least_mass(assembly)))
    elif case.load.kind == "displacement":
        given = max(given, case.load.fastest)
    elif case.load.plate is not None:
        given = max(given, 2 * case.load.velocity)  # of a sphere that a heavy plate hits
    return given


def _energy_of_force(assembly: Assembly) -> float:
    """Return the energy input of the force, J: that of its impulse on the loaded spheres, or of the wave in the bar."""
    case = assembly.case
    load = case.load
    for bar in assembly.bars:
        if bar.name == INCIDENT_BAR:
            impedance = bar.section.area * math.sqrt(bar.material.youngs_modulus * bar.material.density)
            return load.largest * load.impulse / impedance
    masses = [assembly.mass_of(sphere) for sphere in struck_of(assembly)]
    return load.impulse**2 / (2 * sum(masses))


def energy_of_plate(load: Load) -> float:
    """Return the energy of a plate, J; 0 for other loads."""
    mass, velocity = load.plate or (0.0, 0.0)
    return mass * velocity**2 / 2


def _least_mass(assembly: Assembly) -> float:
    case = assembly.case
    return float(assembly.sphere_masses().min()) if not assembly.plain else case.sphere_mass
