"""The contact of two spheres that a run probed: recorded force against overlap beside the law's curve."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import Array
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import pair_contact

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

_LEGIBLE = 1e-2  # of the largest overlap: from where on forces are compared


def probed_name(case: Case) -> str | None:
    """Name of the probe of the contact of the first two spheres; None without one."""
    wanted = (f"contact_{i}_{j}" for i, j in ((1, 2), (2, 1)) if any(p.contact == (i, j) for p in case.output.probes))
    return next(wanted, None)


@dataclasses.dataclass(frozen=True, eq=False)
class Pair:
    """The contact of two spheres in one run."""

    run: ChainRecord

    @property
    def materials(self) -> tuple[Material, Material]:
        """Materials of both spheres."""
        assembly = self.run.assembly
        return assembly.material_of(1), assembly.material_of(2)

    @property
    def strength(self) -> float:
        """Lower yield strength of both, Pa."""
        return min(one.yield_strength or np.inf for one in self.materials)

    @property
    def diameters(self) -> tuple[float, float]:
        """Diameters of both spheres, m."""
        assembly = self.run.assembly
        return assembly.diameter_of(1), assembly.diameter_of(2)

    @property
    def ratio(self) -> float:
        """Ratio of the larger radius to the smaller."""
        return max(self.diameters) / min(self.diameters)

    @property
    def like(self) -> bool:
        """Both are of one material."""
        return self.materials[0] == self.materials[1]

    @cached_property
    def law(self) -> ContactLaw:
        """Between the two."""
        return pair_contact(self.run.case, 1, 2)

    @property
    def overlap(self) -> Array:
        """At all recorded instants: (n_times,), m."""
        return self.run.array(f"probes/{probed_name(self.run.case)}_overlap")

    @property
    def force(self) -> Array:
        """At all recorded instants: (n_times,), N."""
        return self.run.array(f"probes/{probed_name(self.run.case)}_force")

    @property
    def deepest(self) -> float:
        """Largest overlap, m; between records it is known as a peak."""
        return max(float(self.overlap.max()), float(self.run.array("contacts/peak_overlap").max()))

    @property
    def loading(self) -> slice:
        """Records before the largest overlap."""
        return slice(0, int(self.overlap.argmax()) + 1)

    def at(self, overlap: float) -> float:
        """Recorded force of loading at an overlap, by a straight line between records, N; NaN beyond the largest."""
        x, force = self.overlap[self.loading], self.force[self.loading]
        return float(np.interp(overlap, x, force)) if overlap <= x[-1] else np.nan

    def expected(self, overlap: float) -> float:
        """The law's force of loading at an overlap, N."""
        return float(self.law.loading_force(np.array([overlap]))[0])

    @property
    def law_curve(self) -> tuple[Array, Array]:
        """Overlap (m) and the law's force (N): loading to the largest overlap, and unloading from there."""
        peak = self.deepest
        up = np.linspace(0, peak, 200)
        down = np.linspace(peak, float(self.law.residual_overlap(np.array([peak]))[0]), 100)
        force = np.concatenate([self.law.loading_force(up), self.law.force(down, np.full_like(down, peak))])
        return np.concatenate([up, down]), force

    @property
    def deviation(self) -> float:
        """Largest |force - law| while the overlap is above 1 % of the largest, over the largest force."""
        chosen = self.overlap > _LEGIBLE * self.deepest
        overlap, force = self.overlap[chosen], self.force[chosen]
        so_far = np.maximum.accumulate(self.overlap)[chosen]
        turned = np.arange(len(self.overlap))[chosen] > int(self.overlap.argmax())
        largest = np.where(turned, self.deepest, so_far)
        return float(np.abs(self.law.force(overlap, largest) - force).max() / force.max())
