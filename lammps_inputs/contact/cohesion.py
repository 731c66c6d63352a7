"""Cohesion of a packing at its start: stored energy, and the stiffness of its contacts."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.lattices import TOUCHING, Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls


def energy_at_start(assembly: Assembly) -> float:
    """Energy of contacts that cohere at the start, below 0 that of surfaces apart, J; 0 without cohesion.

    The energy is stationary there, so that rounding of positions does not count.
    """
    case, lattice = assembly.case, assembly.lattice
    if not case.has_cohesion or not isinstance(lattice, Lattice):
        return 0.0
    found = 0.0
    if lattice.overlap:
        found += assembly.sites.n_contacts * _energy(_law(assembly, case.material), lattice.overlap)
    n = assembly.sites.count
    for wall in walls(assembly):
        if wall.overlap:
            gaps = wall.gaps(assembly.positions()[:n], assembly.sphere_diameters()[:n] / 2)
            touching = np.count_nonzero(np.abs(gaps + wall.overlap) <= TOUCHING * lattice.diameter)
            found += touching * _energy(_law(assembly, wall.material, flat=True), wall.overlap)
    return found


def cohesive_laws(assembly: Assembly) -> Iterator[tuple[ContactLaw, float]]:
    """Iterate over the laws of spheres of the packing that cohere, each with twice the effective mass, kg."""
    case = assembly.case
    if case.contact_between(case.material, case.material).coheres:
        yield _law(assembly, case.material), case.sphere_mass
    for wall in walls(assembly):
        if not wall.held_layer and case.contact_between(case.material, wall.material).coheres:
            yield _law(assembly, wall.material, flat=True), 2 * case.sphere_mass


def _law(assembly: Assembly, partner: Material | None, *, flat: bool = False) -> ContactLaw:
    case, radius = assembly.case, assembly.case.packing.diameter / 2
    contact = case.contact_between(case.material, partner)
    return contact.between((case.material, partner), (radius, math.inf if flat else radius))


def _energy(law: ContactLaw, overlap: float) -> float:
    return float(law.elastic_energy(overlap, overlap))
