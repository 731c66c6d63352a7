"""Cohesive packings of equal spheres at rest: overlaps at which contacts bear no force."""

from __future__ import annotations

import dataclasses
import math

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.places import Layout


def balanced_overlap(case: Case, partner: Material | None, *, flat: bool = False) -> float:
    """Return the overlap without force of spheres of the packing with each other, or a flat, m; 0 without cohesion.

    Parameters
    ----------
    partner
        Material of the other body; None if it is rigid.
    """
    contact, radius = case.contact_between(case.material, partner), case.packing.diameter / 2
    if not contact.coheres:
        return 0.0
    law = contact.between((case.material, partner), (radius, math.inf if flat else radius))
    return float(law.balanced_overlap)


def in_balance(case: Case, lattice: Layout) -> Layout:
    """Return the lattice with the spacing at which contacts bear no force; places of grains as they are."""
    if not isinstance(lattice, Lattice) or not case.has_cohesion:
        return lattice
    return dataclasses.replace(lattice, overlap=balanced_overlap(case, case.material))
