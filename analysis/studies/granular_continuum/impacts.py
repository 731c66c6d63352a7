"""The runs of a comparison: granular and continuum impacts on normalised axes, and groups of them."""

from __future__ import annotations

import dataclasses
import math
from collections import defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from granwave._contact_laws import ContactLaw
from granwave.analysis.studies.granular_continuum.punch_case import PunchCase, read_punch_case
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.run_directory import CASE_FILE

SAME = 1e-4  # relative difference of normalised velocities and energies that are meant to be equal


class Granular(FinishedRun):
    """An impact on a packing of elasto-plastic spheres."""

    @cached_property
    def law(self) -> ContactLaw:
        """Contact law of two spheres."""
        return sphere_contact(self.case)

    @property
    def energy(self) -> float:
        """Input, J."""
        return float(self.summary["energy_input_J"])

    @property
    def energy_normalised(self) -> float:
        """Input over F_y alpha_y."""
        return self.energy / (self.law.yield_force * self.law.yield_overlap)

    @property
    def velocity_normalised(self) -> float:
        """Thesis 5.11."""
        return float(self.summary["velocity_normalised"])

    @property
    def fraction(self) -> float:
        """Fraction of the input that was dissipated."""
        return float(self.summary["dissipated_fraction"])

    @property
    def beyond(self) -> bool:
        """A contact was pressed beyond the law."""
        return bool(self.summary.get("contacts_beyond_law"))


@dataclasses.dataclass(frozen=True, eq=False)
class Continuum:
    """An impact of a rigid punch on a block."""

    label: str
    directory: Path
    case: PunchCase
    summary: Mapping[str, Any]

    @property
    def energy(self) -> float:
        """Input, J."""
        return float(self.summary["energy_input_J"])

    @property
    def energy_normalised(self) -> float:
        """Input over sigma_y^2 D^3/E."""
        return float(self.summary["energy_input_normalised"])

    @property
    def fraction(self) -> float:
        """Fraction of the input that was dissipated plastically."""
        return float(self.summary["dissipated_fraction"])

    def volume(self, *, ever: bool = False) -> float:
        """Plastic zone over pi D^3/6 with the diameter of the punch: largest at one instant, or that ever yielded."""
        name = "plastic_zone_volume_ever_m3" if ever else "plastic_zone_volume_m3"
        return float(self.summary[name]) / (math.pi * self.case.punch.diameter**3 / 6)


@dataclasses.dataclass(frozen=True)
class Impacts:
    """All runs that can be compared."""

    granular: tuple[Granular, ...]
    continuum: tuple[Continuum, ...]

    @cached_property
    def reference(self) -> tuple[Granular, ...]:
        """The largest group of granular runs that differ in velocity alone, one sphere struck; by velocity."""
        groups = grouped(
            [run for run in self.granular if run.case.load.spheres == 1], lambda run: (packing(run), substance(run))
        )
        largest = max(groups.values(), key=len, default=())
        return distinct(largest, lambda run: run.velocity_normalised)

    @cached_property
    def like_reference(self) -> tuple[Granular, ...]:
        """Granular runs on the packing of the reference, of whatever material, diameter and loading area."""
        return tuple(run for run in self.granular if self.reference and packing(run) == packing(self.reference[0]))

    @cached_property
    def continuum_reference(self) -> tuple[Continuum, ...]:
        """The largest group of continuum runs that differ in the energy of the punch alone; by energy."""
        groups = grouped(self.continuum, lambda run: (punch(run), substance(run)))
        largest = max(groups.values(), key=len, default=())
        return distinct(largest, lambda run: run.energy_normalised)


def collect(runs: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> Impacts:
    """The runs that can be compared, from labels, directories and summaries; others are left out.

    What is compared: impacts on ideal packings (like spheres, no friction) whose contacts yield by the elasto-plastic
    law, and of punches on blocks.
    """
    granular, continuum = [], []
    for label, directory, summary in runs:
        try:
            if summary.get("kind") == "continuum":
                continuum.append(Continuum(label, directory, read_punch_case(directory / CASE_FILE), summary))
            elif "n_spheres" in summary:
                case = load_case(directory / CASE_FILE)
                struck = case.load.kind == "impact" and case.packing.kind != "chain"
                ideal = assemble(case).plain and not case.has_friction
                if struck and ideal and case.contact.law == "elastoplastic" and summary.get("energy_input_J"):
                    granular.append(Granular(label, directory, case, summary))
        except (GranwaveError, OSError):
            continue  # a summary without a case of ours: the report says so elsewhere
    return Impacts(tuple(granular), tuple(continuum))


def grouped(runs: Iterable[Any], key: Any) -> dict[Hashable, tuple[Any, ...]]:
    """Runs by a key, in their order."""
    groups: dict[Hashable, list[Any]] = defaultdict(list)
    for run in runs:
        groups[key(run)].append(run)
    return {name: tuple(members) for name, members in groups.items()}


def distinct(runs: Sequence[Any], key: Any) -> tuple[Any, ...]:
    """Runs in rising order of a number, of those that are equal in it the first."""
    kept: list[Any] = []
    for run in sorted(runs, key=key):
        if not kept or key(run) > key(kept[-1]) * (1 + SAME):
            kept.append(run)
    return tuple(kept)


def packing(run: Granular) -> Hashable:
    """Shape of the packing and what holds it; the size of the spheres does not matter."""
    boundary = run.case.boundary
    return run.case.packing.kind, run.case.packing.size, boundary.bottom, boundary.sides


def substance(run: Granular | Continuum) -> Hashable:
    """Material, and for spheres their size and law."""
    if isinstance(run, Granular):
        return constants(run), run.case.packing.diameter, run.case.contact
    return constants(run)


def constants(run: Granular | Continuum) -> Hashable:
    """Constants of the material, whatever it is called."""
    material = run.case.material
    return material.youngs_modulus, material.poisson_ratio, material.density, material.yield_strength


def punch(run: Continuum) -> Hashable:
    """The punch but for its velocity, the block and the mesh."""
    part = run.case.punch
    return part.diameter, part.mass, part.taper, run.case.block, run.case.run.elements, run.case.run.edge_size


def energy_unit(material: Material, diameter: float) -> float:
    """sigma_y^2 D^3/E, J (thesis 5.30)."""
    assert material.yield_strength is not None  # of a case that yields
    return material.yield_strength**2 * diameter**3 / material.youngs_modulus


def differences(first: Granular | Continuum, other: Granular | Continuum) -> str:
    """How another substance differs, for a legend: such as "modulus 230 GPa"."""
    here, there = first.case.material, other.case.material
    pairs = [
        ("modulus", here.youngs_modulus, there.youngs_modulus, 1e9, "GPa"),
        ("Poisson's ratio", here.poisson_ratio, there.poisson_ratio, 1.0, ""),
        ("density", here.density, there.density, 1.0, "kg/m³"),
        ("yield strength", here.yield_strength or 0.0, there.yield_strength or 0.0, 1e6, "MPa"),
    ]
    if isinstance(first, Granular) and isinstance(other, Granular):
        pairs.insert(0, ("diameter", first.case.packing.diameter, other.case.packing.diameter, 1e-3, "mm"))
    texts = [f"{name} {b / unit:.4g} {word}".rstrip() for name, a, b, unit, word in pairs if a != b]
    return ", ".join(texts) or (there.name or "other")
