"""The compiled contact law of a case: between two of its spheres, and between a sphere and a rigid wall."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.errors import InputError

if TYPE_CHECKING:
    from granwave.lammps_inputs.case import Case
    from granwave.lammps_inputs.materials import Material


def sphere_contact(case: Case) -> ContactLaw:
    """The law between two spheres of the case."""
    radius = case.packing.diameter / 2
    material = case.material
    return _law(case, material.youngs_modulus, material.poisson_ratio, _strength(case), radius)


def wall_contact(case: Case) -> ContactLaw:
    """The law between a sphere of the case and a rigid flat wall."""
    return _law(case, math.inf, case.material.poisson_ratio, math.inf, math.inf)


def contact_of(
    materials: Sequence[Material],
    radii: Sequence[float],
    law: str = "elastoplastic",
    variant: str = "continuous",
) -> ContactLaw:
    """The law between two spheres of one or two materials and one or two radii (m).

    Raises
    ------
    InputError
        A material lacks the yield strength that the law needs.
    """
    pair, radius = (materials[0], materials[-1]), (radii[0], radii[-1])
    if law != "hertz":
        faults = [
            f"material {m.name}: yield_strength: missing; law {law} needs it"
            for m in pair
            if m.yield_strength is None
        ]
        if faults:
            raise InputError(dict.fromkeys(faults))
    return ContactLaw(
        youngs_modulus=(pair[0].youngs_modulus, pair[1].youngs_modulus),
        poisson_ratio=(pair[0].poisson_ratio, pair[1].poisson_ratio),
        yield_strength=(pair[0].yield_strength or math.inf, pair[1].yield_strength or math.inf),
        radius=radius,
        law=law,
        variant=variant,
    )


def _law(case: Case, modulus: float, ratio: float, strength: float, radius: float) -> ContactLaw:
    material, contact = case.material, case.contact
    return ContactLaw(
        youngs_modulus=(material.youngs_modulus, modulus),
        poisson_ratio=(material.poisson_ratio, ratio),
        yield_strength=(_strength(case), strength),
        radius=(case.packing.diameter / 2, radius),
        law=contact.law,
        variant=contact.variant,
        yield_factor=contact.yield_factor,
        beta=contact.beta,
    )


def _strength(case: Case) -> float:
    strength = case.material.yield_strength
    return math.inf if strength is None else strength
