"""Viscous losses of contacts as the plugin takes them: a loss time, or the factor of a dashpot.

The loss time of a restitution at a speed is found from the head-on collision of two bodies with their own law
(`ContactLaw.collide`). Grains have the median diameter of those of their material, all of which have one time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.loss import DashpotRestitution, Loss
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.roots import brentq

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.contact import Contact
    from granwave.lammps_inputs.case.material import Material
    from granwave.lammps_inputs.case.shape import Shape
    from granwave.lammps_inputs.packing.assembly import Assembly

_STEPS = 2000  # of a collision
_ROUNDING = 1e-6  # of a restitution, in which collisions without loss differ from 1
_MOST_TIME = 20.0  # loss time over the duration of the collision without loss: restitution is below 0.01
_MOST_FACTOR = 50.0  # of a dashpot: restitution is below 0.01
_ACCURACY = 1e-9  # of the time or factor found, relative to these

Viscous = tuple[Literal["time", "dashpot"], float]  # kind, and loss time (s) or factor


def viscous_loss(
    assembly: Assembly,
    contact: Contact,
    first: Material,
    second: Material | None,
    *,
    flat: bool = False,
    shapes: tuple[Shape, Shape] | None = None,
) -> Viscous | None:
    """Return the loss of contacts between grains of a material and their partners; None if they lose nothing.

    Parameters
    ----------
    second
        Material of the partners; None for a rigid one.
    flat
        True for partners that are planes: walls and faces of bars.
    shapes
        Shapes of the grains; by default whatever there are of these materials.

    Raises
    ------
    ValueError
        No loss time gives the restitution.
    """
    loss = contact.loss
    if loss is None:
        return None
    if loss.restitution is None or loss.velocity is None:
        return _given(loss)
    own = nominal_grain(assembly, first, None if shapes is None else shapes[:1])
    bodies, inverse_mass = [(assembly.diameter_of(own) / 2, assembly.shape_of(own))], 1 / assembly.mass_of(own)
    if flat or second is None:
        bodies.append((math.inf, None))
    else:
        other = nominal_grain(assembly, second, None if shapes is None else shapes[1:])
        bodies.append((assembly.diameter_of(other) / 2, assembly.shape_of(other)))
        inverse_mass += 1 / assembly.mass_of(other)
    (radius, shape), (partner_radius, partner_shape) = bodies
    time = loss_time(
        contact, (first, second), (radius, partner_radius), (shape, partner_shape), assembly.plane_strain,
        1 / inverse_mass, loss.restitution, loss.velocity,
    )  # fmt: skip
    return ("time", time) if time else None


def _given(loss: Loss) -> Viscous | None:
    if loss.time is not None:
        return ("time", loss.time) if loss.time else None
    factor = loss.dashpot
    if isinstance(factor, DashpotRestitution):
        factor = dashpot_factor(factor.restitution)
    return ("dashpot", factor) if factor else None


@lru_cache(maxsize=256)
def loss_time(
    contact: Contact,
    materials: tuple[Material, Material | None],
    radii: tuple[float, float],
    shapes: tuple[Shape, Shape],
    plane_strain: bool,
    mass: float,
    restitution: float,
    velocity: float,
) -> float:
    """Return the loss time with which two bodies have a restitution at a speed, s.

    Parameters
    ----------
    radii
        m; infinite for a plane.
    shapes
        Shapes of grains; None for spheres and planes.
    plane_strain
        True if a cylinder on a plane is in plane strain.
    mass
        Effective mass, kg.
    velocity
        Speed of approach, m/s.

    Raises
    ------
    ValueError
        The law alone, by yielding, leaves less than this restitution, or no loss time as little.
    """
    law = law_between(contact, materials, radii, shapes=shapes, plane_strain=plane_strain)
    alone = law.collide(mass, velocity, steps=_STEPS)
    if math.isnan(alone["restitution"]):  # nothing stops them
        return 0.0
    longest = _MOST_TIME * alone["duration"]

    def excess(time: float) -> float:
        return float(law.collide(mass, velocity, loss_time=time, steps=_STEPS)["restitution"]) - restitution

    if alone["restitution"] < restitution - _ROUNDING:
        raise ValueError(
            f"at most {alone['restitution']:.4g}, which law {contact.law} alone leaves at {velocity:g} m/s by yielding"
        )
    if alone["restitution"] <= restitution + _ROUNDING:
        return 0.0
    if excess(longest) > 0:
        raise ValueError(f"at least {excess(longest) + restitution:.4g}, which a loss time of {longest:.3g} s leaves")
    return brentq(excess, 0.0, longest, xtol=_ACCURACY * alone["duration"])


@lru_cache(maxsize=64)
def dashpot_factor(restitution: float) -> float:
    """Return the factor of the dashpot that gives a Hertzian contact this restitution, at any speed and size."""
    one = (1.0, 1.0)
    law = ContactLaw("hertz", youngs_modulus=one, poisson_ratio=(0.0, 0.0), yield_strength=one, radius=one)

    def excess(factor: float) -> float:
        return float(law.collide(1.0, 1e-3, loss_dashpot=factor, steps=_STEPS)["restitution"]) - restitution

    if excess(0.0) <= _ROUNDING:
        return 0.0
    if excess(_MOST_FACTOR) > 0:
        raise ValueError(
            f"at least {excess(_MOST_FACTOR) + restitution:.4g}, which a factor of {_MOST_FACTOR:g} leaves"
        )
    return brentq(excess, 0.0, _MOST_FACTOR, xtol=_ACCURACY)


def nominal_grain(assembly: Assembly, material: Material, shapes: Sequence[Shape] | None = None) -> int:
    """Return the id of the grain of a material, and one of these shapes if they are given, with the median diameter."""
    sites, first_striker = assembly.sites, assembly.lattice.n_spheres + 1
    if sites is None:
        ids = np.array([1] if material == assembly.material else [], dtype=int)
    else:
        kinds = [kind for kind, one in enumerate(sites.materials) if one == material]
        ids = np.flatnonzero(sites.present & np.isin(sites.kind, kinds)) + 1
    strikers = range(first_striker, assembly.last_sphere + 1)
    found = [ids, np.array([one for one in strikers if assembly.material_of(one) == material], dtype=int)]
    if shapes is not None and len(assembly.shapes) > 1:
        found = [np.array([one for one in group.tolist() if assembly.shape_of(one) in shapes], dtype=int)
                 for group in found]  # fmt: skip
    group = next((group for group in found if len(group)), np.array([1]))
    if sites is not None and group[-1] < first_striker:
        diameters = sites.diameter[group - 1]
    else:
        diameters = np.array([assembly.diameter_of(one) for one in group.tolist()])
    return int(group[np.argsort(diameters, kind="stable")[(len(group) - 1) // 2]])
