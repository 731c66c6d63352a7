"""Impacts on packings and on blocks that can be compared, on normalised axes, and groups of them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Hashable, Iterable
from functools import cached_property
from typing import TypeVar

from granwave._contact_laws import ContactLaw
from granwave.analysis.studies.punch_case import PunchCase
from granwave.analysis.studies.runs import AnyCase, AnyRun, ContinuumRun, FinishedRun
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import sphere_contact

SAME = 1e-4  # relative difference of normalised velocities and energies that are meant to be equal

_FAST = 0.1  # of the largest velocity


class Measured(AnyRun[AnyCase]):
    """Energies of an impact, whatever was hit."""

    @property
    def energy(self) -> float:
        """Input, J."""
        return self.value("energy_input_J")

    @property
    def fraction(self) -> float:
        """Fraction of the input that was dissipated."""
        return self.value("dissipated_fraction")


class Granular(Measured[Case], FinishedRun):
    """An impact on a packing of elasto-plastic spheres."""

    what = "granular"

    @cached_property
    def law(self) -> ContactLaw:
        """Contact law of two spheres."""
        return sphere_contact(self.case)

    @property
    def diameter(self) -> float:
        """Diameter of the spheres, m."""
        return self.case.packing.diameter

    @property
    def energy_normalised(self) -> float:
        """Input over F_y alpha_y."""
        return self.energy / (self.law.yield_force * self.law.yield_overlap)

    @property
    def velocity_normalised(self) -> float:
        """Impact velocity in units that make materials collapse on one curve."""
        return self.value("velocity_normalised")

    @property
    def shape(self) -> Hashable:
        """Shape of the packing and what holds it; the size of the spheres does not matter."""
        packing, boundary = self.case.packing, self.case.boundary
        return packing.kind, packing.size, boundary.bottom, boundary.sides

    @property
    def substance(self) -> Hashable:
        """Material, size and law of the spheres."""
        return constants(self.case.material), self.diameter, self.case.contact


class Continuum(Measured[PunchCase], ContinuumRun):
    """An impact of a rigid punch on a block."""

    what = "continuum"

    @property
    def diameter(self) -> float:
        """Diameter of the punch, m."""
        return self.case.punch.diameter

    @property
    def energy_normalised(self) -> float:
        """Input over sigma_y^2 D^3/E."""
        return self.value("energy_input_normalised")

    @property
    def volume(self) -> float:
        """Largest plastic zone at one instant, over pi D^3/6 with the diameter of the punch."""
        return self.value("plastic_zone_volume_m3") / (math.pi * self.diameter**3 / 6)

    @property
    def volume_ever(self) -> float:
        """Volume that ever yielded, in the same unit."""
        return self.value("plastic_zone_volume_ever_m3") / (math.pi * self.diameter**3 / 6)

    @property
    def shape(self) -> Hashable:
        """The punch but for its velocity, the block and the mesh."""
        return dataclasses.replace(self.case.punch, velocity=0.0), self.case.block, self.case.run

    @property
    def substance(self) -> Hashable:
        """Material of the block."""
        return constants(self.case.material)


Impact = TypeVar("Impact", Granular, Continuum)
Curve = tuple[str, tuple[Impact, ...]]


@dataclasses.dataclass(frozen=True)
class Impacts:
    """All runs that can be compared."""

    granular: tuple[Granular, ...]
    continuum: tuple[Continuum, ...]

    @cached_property
    def reference(self) -> tuple[Granular, ...]:
        """The largest group of granular runs that differ in velocity alone, one sphere struck; by velocity."""
        single = [run for run in self.granular if run.case.load.spheres == 1]
        return rising(largest(single, lambda run: (run.shape, run.substance)), lambda run: run.velocity_normalised)

    @property
    def fast(self) -> tuple[Granular, ...]:
        """Runs of the reference from a tenth of its largest velocity on.

        Below, the peak forces of too many contacts are near F_y, where dissipation is not quadratic in force.
        """
        velocity = [run.velocity_normalised for run in self.reference]
        return tuple(run for run in self.reference if run.velocity_normalised >= _FAST * velocity[-1] * (1 - SAME))

    @cached_property
    def like_reference(self) -> tuple[Granular, ...]:
        """Granular runs on the packing of the reference, of whatever material, diameter and loading area."""
        return tuple(run for run in self.granular if self.reference and run.shape == self.reference[0].shape)

    @property
    def other_packings(self) -> tuple[Granular, ...]:
        """Granular runs on packings that no figure or table of the reference shows."""
        if not self.reference:
            return self.granular
        first = self.reference[0].case
        alike = (first.packing.kind, first.boundary)
        others = [run for run in self.granular if run not in self.like_reference]
        return tuple(run for run in others if (run.case.packing.kind, run.case.boundary) != alike)

    @cached_property
    def continuum_reference(self) -> tuple[Continuum, ...]:
        """The largest group of continuum runs that differ in the energy of the punch alone; by energy."""
        same = largest(self.continuum, lambda run: (run.shape, run.substance))
        return rising(same, lambda run: run.energy_normalised)


def collect(runs: Iterable[FinishedRun | ContinuumRun]) -> Impacts:
    """The runs that can be compared; others are left out.

    What is compared: impacts on ideal packings (like spheres, no friction) whose contacts yield by the elasto-plastic
    law, and of punches on blocks.
    """
    granular, continuum = [], []
    for run in runs:
        if isinstance(run, ContinuumRun):
            continuum.append(run.seen_as(Continuum))
        elif not not_ideal(run):
            granular.append(run.seen_as(Granular))
    return Impacts(tuple(granular), tuple(continuum))


def not_ideal(run: FinishedRun) -> str:
    """Return why a run of grains is not compared; empty if it is."""
    case = run.case
    reasons = {
        "a chain": case.packing.kind == "chain",
        "the load is no impact": case.load.kind != "impact",
        "the grains are not all alike": not run.assembly.plain,
        "friction": case.has_friction,
        f"the law is {case.contact.law}": case.contact.law != "elastoplastic",
        "no energy was put in": not run.summary.get("energy_input_J"),
    }
    return ", ".join(reason for reason, applies in reasons.items() if applies)


def grouped(runs: Iterable[Impact], key: Callable[[Impact], Hashable]) -> dict[Hashable, list[Impact]]:
    """Runs by a key, in their order."""
    groups: dict[Hashable, list[Impact]] = {}
    for run in runs:
        groups.setdefault(key(run), []).append(run)
    return groups


def largest(runs: Iterable[Impact], key: Callable[[Impact], Hashable]) -> list[Impact]:
    """The largest group of runs that are equal in a key."""
    return max(grouped(runs, key).values(), key=len, default=[])


def rising(runs: Iterable[Impact], key: Callable[[Impact], float]) -> tuple[Impact, ...]:
    """Runs in rising order of a number; of those that are meant to be equal in it the first."""
    kept: list[Impact] = []
    for run in sorted(runs, key=key):
        if not kept or key(run) > key(kept[-1]) * (1 + SAME):
            kept.append(run)
    return tuple(kept)


def substances(runs: Iterable[Impact], reference: tuple[Impact, ...]) -> list[Curve[Impact]]:
    """The reference, and runs of each other substance by energy; with their names."""
    curves = [("reference", reference)]
    for group in grouped(runs, lambda run: run.substance).values():
        if group[0].substance != reference[0].substance:
            curves.append((differences(reference[0], group[0]), rising(group, lambda run: run.energy)))
    return curves


def constants(material: Material) -> Hashable:
    """Constants of a material, whatever it is called."""
    return material.youngs_modulus, material.poisson_ratio, material.density, material.yield_strength


def energy_unit(material: Material, diameter: float) -> float:
    """sigma_y^2 D^3/E, J."""
    assert material.yield_strength is not None  # of a case that yields
    return material.yield_strength**2 * diameter**3 / material.youngs_modulus


def differences(first: Impact, other: Impact) -> str:
    """Label of another substance by what differs, for a legend: such as "modulus 230 GPa"."""
    here, there = first.case.material, other.case.material
    pairs = [
        ("diameter", first.diameter, other.diameter, 1e-3, "mm"),
        ("modulus", here.youngs_modulus, there.youngs_modulus, 1e9, "GPa"),
        ("Poisson's ratio", here.poisson_ratio, there.poisson_ratio, 1.0, ""),
        ("density", here.density, there.density, 1.0, "kg/m³"),
        ("yield strength", here.yield_strength or 0.0, there.yield_strength or 0.0, 1e6, "MPa"),
    ]
    texts = [f"{name} {b / unit:.4g} {word}".rstrip() for name, a, b, unit, word in pairs if a != b]
    return ", ".join(texts) or (there.name or "other")
