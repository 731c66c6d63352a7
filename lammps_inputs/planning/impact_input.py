"""Normalised inputs of impacts.

Packing and continuum are compared at equal energy in units of sigma_y^2 D^3/E, with the diameter D
of the spheres or of the punch.
"""

from __future__ import annotations

import dataclasses

from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import sphere_contact, velocity_normalised
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import start_speed
from granwave.lammps_inputs.planning.encounters import expected_energy


@dataclasses.dataclass(frozen=True)
class ImpactInput:
    """Energy and velocity of an impact; None where they do not apply.

    Attributes
    ----------
    energy
        J; of a load by force an upper bound.
    energy_normalised
        Over F_y alpha_y of two spheres, as in a packing's summary.json.
    energy_continuum
        Over sigma_y^2 D^3/E, as in the summary.json of a continuum run.
    velocity_normalised
        Velocity in units in which all materials fall on one curve.
    """

    energy: float
    energy_normalised: float | None
    energy_continuum: float | None
    velocity_normalised: float | None


def energy_unit(material: Material, diameter: float) -> float | None:
    """Return sigma_y^2 D^3/E, J; None without a yield strength."""
    if material.yield_strength is None:
        return None
    return material.yield_strength**2 * diameter**3 / material.youngs_modulus


def inputs_of_packing(assembly: Assembly) -> ImpactInput:
    """Return the inputs of the impact on a packing."""
    case = assembly.case
    law = sphere_contact(case)
    energy = expected_energy(assembly)
    unit = energy_unit(case.material, case.packing.diameter)
    if not case.contact.yields or unit is None:
        return ImpactInput(energy, None, None, None)
    velocity = None
    if case.load.gives_velocity:
        strength = law.yield_strength
        density = case.material.density
        speed = start_speed(assembly)
        velocity = velocity_normalised(speed, law.effective_modulus, density, strength)
    return ImpactInput(
        energy, energy / (law.yield_force * law.yield_overlap), energy / unit, velocity
    )
