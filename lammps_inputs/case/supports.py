"""Supports of a moving bottom plane: ``boundary.bottom = {plate = {...}}``, ``damper``, ``half_space`` or ``bar``.

plate        a rigid plate on a spring and an optional damper
damper       a massless plate on a damper, which bears the static force: an end that absorbs waves
half_space   the surface of an elastic half-space under the packing's footprint: Lysmer's analogue, a spring
             4 G r/(1 - nu) parallel to a damper 3.4 r^2 sqrt(rho G)/(1 - nu) (Lysmer and Richart, 1966)
bar          an elastic bar along z, of linear elements with lumped mass; its far end free, fixed or non-reflecting
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, Literal

from granwave.lammps_inputs.case.material import Material, read_material
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    choice,
    count,
    number,
    read_table,
    refuse_unknown,
    show,
)
from granwave.lammps_inputs.case.si_values import AREA, LENGTH, MASS

_SPRING = 4.0  # K (1 - nu) / (G r) of a rigid disc on a half-space, exact in statics
_DAMPER = 3.4  # C (1 - nu) / (r^2 sqrt(rho G)) (Lysmer and Richart, 1966)
BAR_COURANT_NUMBER = 0.5  # timestep over the time that a wave takes through one element of a bar
PLATE_OSCILLATION = 0.05  # timestep over sqrt(mass/stiffness), of a plate or the first element of a bar
_OF_DECAY = 0.05  # timestep over damping/stiffness of a massless surface


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plate:
    """Rigid plate on a spring and a damper."""

    mass: float = number("mass of the plate", unit="kg", above=0, usual=MASS)
    stiffness: float = number("stiffness of the spring between plate and ground", unit="N/m", above=0)
    damping: float = number("constant of the damper beside the spring", unit="N s/m", at_least=0, default=0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Damper:
    """Plate without mass on a damper; the ground bears the force that is on it when the run begins."""

    damping: float = number(
        "force on the ground, beyond the static one, over the velocity of the plate", unit="N s/m", above=0
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class HalfSpace:
    """Surface of an elastic half-space under the packing, moving as a rigid disc."""

    radius: float | None = number(
        "radius of the disc that moves; that of the packing's footprint by default",
        unit="m",
        above=0,
        default=None,
        usual=LENGTH,
    )

    def stiffness(self, material: Material, radius: float) -> float:
        """Return the stiffness of a rigid disc of this radius (m) on the half-space, N/m."""
        return _SPRING * _shear_modulus(material) * radius / (1 - material.poisson_ratio)

    def damping(self, material: Material, radius: float) -> float:
        """Return the radiation damping, N s/m."""
        return (
            _DAMPER * radius**2 * math.sqrt(material.density * _shear_modulus(material)) / (1 - material.poisson_ratio)
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SupportBar:
    """Elastic bar under the whole packing."""

    length: float = number("length of the bar", unit="m", above=0, usual=LENGTH)
    area: float = number("area of its cross-section", unit="m^2", above=0, usual=AREA)
    elements: int = count("number of elements of equal length", at_most=10_000_000, default=200)
    end: Literal["free", "fixed", "infinite"] = choice(
        "far end: free, fixed, or going on without an echo", ("free", "fixed", "infinite"), default="infinite"
    )

    def mass(self, material: Material) -> float:
        """Return the mass of the whole bar, kg."""
        return material.density * self.area * self.length

    def stiffness(self, material: Material) -> float:
        """Return the stiffness of an element, N/m."""
        return material.youngs_modulus * self.area * self.elements / self.length


@dataclasses.dataclass(frozen=True)
class NodeConstants:
    """Constants of a node on a spring and a damper, along the normal of the plane.

    Attributes
    ----------
    mass
        Mass of the node, kg; 0 for a surface without inertia.
    stiffness
        Stiffness of the spring, N/m.
    damping
        Damping constant, N s/m.
    """

    mass: float
    stiffness: float
    damping: float


@dataclasses.dataclass(frozen=True)
class BarConstants:
    """Constants of an elastic bar of lumped masses, along the normal of the plane.

    Attributes
    ----------
    elements
        Number of elements.
    mass
        Mass of the whole bar, kg.
    stiffness
        Stiffness of an element, N/m.
    end
        Far end: ``free``, ``fixed``, or the impedance of a non-reflecting end, N s/m.
    """

    elements: int
    mass: float
    stiffness: float
    end: float | Literal["free", "fixed"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Support:
    """Support of the bottom plane: exactly one of plate, damper, half-space and bar."""

    plate: Plate | None = None
    damper: Damper | None = None
    half_space: HalfSpace | None = None
    bar: SupportBar | None = None

    @property
    def kind(self) -> str:
        """Name of the support, as in the case file."""
        return next(name for name in SUPPORTS if getattr(self, name))

    @property
    def bears(self) -> bool:
        """True if the support can bear a static load, by a spring to the ground or as a damper."""
        return self.bar is None or self.bar.end == "fixed"

    def constants(self, material: Material | None, footprint: float) -> NodeConstants | BarConstants:
        """Return the mass, stiffness and damping behind the plane.

        Parameters
        ----------
        material
            Material of the surface; a plate and a damper need none.
        footprint
            Radius of the packing's footprint, m.
        """
        if self.plate:
            return NodeConstants(self.plate.mass, self.plate.stiffness, self.plate.damping)
        if self.damper:
            return NodeConstants(0.0, 0.0, self.damper.damping)
        assert material is not None
        if self.half_space:
            radius = self.half_space.radius or footprint
            stiffness, damping = self.half_space.stiffness(material, radius), self.half_space.damping(material, radius)
            return NodeConstants(0.0, stiffness, damping)
        assert self.bar is not None
        impedance = self.bar.area * math.sqrt(material.youngs_modulus * material.density)
        end = impedance if self.bar.end == "infinite" else self.bar.end
        return BarConstants(self.bar.elements, self.bar.mass(material), self.bar.stiffness(material), end)

    def longest_timestep(self, material: Material | None, footprint: float, contacts: float) -> float:
        """Return the longest timestep that resolves the motion of the support, s.

        Parameters
        ----------
        material, footprint
            As in `constants`.
        contacts
            Sum of the stiffnesses of all contacts with the plane, N/m.
        """
        if self.plate:
            return PLATE_OSCILLATION * math.sqrt(self.plate.mass / (self.plate.stiffness + contacts))
        if self.damper:
            return _OF_DECAY * self.damper.damping / contacts
        assert material is not None
        if self.half_space:
            return _OF_DECAY * self.half_space.damping(material, self.half_space.radius or footprint) / contacts
        assert self.bar is not None
        element = self.bar.length / self.bar.elements
        front = self.bar.mass(material) / self.bar.elements / 2
        return min(
            BAR_COURANT_NUMBER * element * math.sqrt(material.density / material.youngs_modulus),
            PLATE_OSCILLATION * math.sqrt(front / (self.bar.stiffness(material) + contacts)),
        )


SUPPORTS: dict[str, type] = {"plate": Plate, "damper": Damper, "half_space": HalfSpace, "bar": SupportBar}


def read_bottom(table: Mapping[str, Any], key: str, errors: ErrorList) -> tuple[Material | None, Support | None]:
    """Read material and support from ``bottom = {...}``; faults are added to ``errors``."""
    refuse_unknown(table, ("material", *SUPPORTS), key, errors)
    chosen = [name for name in SUPPORTS if name in table]
    if not table:
        errors.add(key, f'found {show(table)}, expected a word, {{material = "..."}}, or one of {", ".join(SUPPORTS)}')
    if len(chosen) > 1:
        errors.add(key, f"found {' and '.join(chosen)}, expected one of them")
        return None, None
    material = read_material(table["material"], errors, f"{key}.material") if "material" in table else None
    if not chosen:
        return material, None
    if "material" not in table and chosen[0] not in ("plate", "damper"):
        errors.add(f"{key}.material", f"missing; a {chosen[0]} needs it")
    section = read_table(SUPPORTS[chosen[0]], table[chosen[0]], f"{key}.{chosen[0]}", errors)
    return material, None if section is None else Support(**{chosen[0]: section})


def _shear_modulus(material: Material) -> float:
    return material.youngs_modulus / (2 * (1 + material.poisson_ratio))
