"""Case of a contact of two spheres, as read from a TOML file: radii, materials, overlaps."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.continuum.frame import ElementCase
from granwave.lammps_inputs.case.hints import DIAMETER
from granwave.lammps_inputs.case.material import Material, material_field
from granwave.lammps_inputs.case.schema import ErrorList, count, number, read_table

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

_FIRST_PEAK = 4.0  # overlap of the first unloading over alpha_y
_ELASTIC_UNIT = 1 / 400  # unit in place of alpha_y, if that is not reached / largest overlap


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sphere:
    """``[sphere]``: the first sphere, made of the case's material."""

    radius: float = number("radius of the sphere", DIAMETER, above=0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Partner:
    """``[partner]``: the second sphere, if it differs from the first."""

    radius: float = number("radius of the sphere", DIAMETER, above=0)
    material: Material = material_field(
        "material of the second sphere; default: the material of the case"
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SphereContactRunSettings:
    """``[run]``: largest overlap, unloadings, mesh and speed."""

    max_overlap: float = number("largest overlap / R*", at_least=1e-6, at_most=1.0, default=0.2)
    unloadings: int = count(
        "number of unload-reload cycles; the last starts at the largest overlap",
        at_least=0,
        at_most=1000,
        default=10,
    )
    elements: int = count(
        "approximate number of elements of the mesh of both spheres",
        at_least=100,
        at_most=1_000_000_000,
        default=6000,
    )
    speed: float = number(
        "loading speed; 1: default; 0.5: half the speed, twice the steps",
        above=0,
        at_most=10,
        default=1.0,
    )
    velocity: float = number(
        "velocity of approach and of separation, m/s, which defines strain rates for a material "
        "with rate_sensitivity; inertia is neglected; 0: quasi-static",
        at_least=0,
        default=0.0,
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SphereContactCase(ElementCase):
    """Contact of two spheres pressed together."""

    SECTIONS: ClassVar[Mapping[str, type]] = {"sphere": Sphere, "run": SphereContactRunSettings}
    REQUIRED: ClassVar[tuple[str, ...]] = ("material", "sphere")

    material: Material
    sphere: Sphere
    partner: Partner | None = None
    run: SphereContactRunSettings = dataclasses.field(default_factory=SphereContactRunSettings)

    @staticmethod
    def _complete(parts: dict[str, Any], data: Mapping[str, Any], errors: ErrorList) -> None:
        if "partner" in data:
            parts["partner"] = _read_partner(data["partner"], parts, errors)

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of the first and the second sphere, m."""
        return (
            self.sphere.radius,
            self.sphere.radius if self.partner is None else self.partner.radius,
        )

    @property
    def materials(self) -> tuple[Material, Material]:
        """Materials of the first and the second sphere."""
        return self.material, self.material if self.partner is None else self.partner.material

    @property
    def identical(self) -> bool:
        """True if both spheres are equal, so that a single sphere on the plane of symmetry is
        sufficient.
        """
        first, second = (
            (
                material.youngs_modulus,
                material.poisson_ratio,
                material.yield_strength,
                material.hardening or 0.0,
                material.rate,
            )
            for material in self.materials
        )
        return self.radii[0] == self.radii[1] and first == second

    @property
    def yields(self) -> bool:
        """True if at least one sphere can yield."""
        return any(material.yield_strength is not None for material in self.materials)

    @cached_property
    def law(self) -> ContactLaw:
        """Elasto-plastic contact law of this pair; Hertz's law if neither sphere can yield."""
        return self.contact_law("elastoplastic" if self.yields else "hertz")

    def contact_law(self, name: str) -> ContactLaw:
        """Return a contact law of this pair by name; a sphere without a yield strength is elastic."""
        from granwave.lammps_inputs.contact.law import contact_of

        limits = [material.yield_strength or math.inf for material in self.materials]
        materials = [
            dataclasses.replace(material, yield_strength=limit)
            for material, limit in zip(self.materials, limits, strict=True)
        ]
        return contact_of(materials, self.radii, name)

    @property
    def max_overlap(self) -> float:
        """Largest overlap, m."""
        return self.run.max_overlap * self.law.effective_radius

    @property
    def yield_unit(self) -> float:
        """Yield overlap alpha_y, m, or a fraction of the largest overlap if first yield is not
        reached.
        """
        unit = self.law.yield_overlap
        return unit if unit < self.max_overlap else self.max_overlap * _ELASTIC_UNIT

    @property
    def peaks(self) -> NDArray[np.float64]:
        """Overlaps at which to unload, m: evenly spaced in their logarithm up to the largest
        overlap.
        """
        number = self.run.unloadings
        largest = self.max_overlap
        first = min(_FIRST_PEAK * self.yield_unit, 0.5 * largest)
        return np.geomspace(first, largest, number) if number > 1 else np.full(number, largest)


def _read_partner(table: Any, parts: Mapping[str, Any], errors: ErrorList) -> Partner | None:
    """Read the partner; missing values are taken from the first sphere."""
    sphere: Sphere | None = parts.get("sphere")
    if isinstance(table, Mapping) and "radius" not in table and sphere is not None:
        table = {**table, "radius": sphere.radius}
    partner = read_table(Partner, table, "partner", errors)
    if partner is None or "material" in table:
        return partner
    material: Material | None = parts.get("material")
    return None if material is None else dataclasses.replace(partner, material=material)
