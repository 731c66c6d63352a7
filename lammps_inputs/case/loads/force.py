"""A force on the impacted spheres, or on the free end of the incident bar."""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case import hints
from granwave.lammps_inputs.case.loads.bounds import work_to_force
from granwave.lammps_inputs.case.loads.driven import SHAPES, DrivenLoad
from granwave.lammps_inputs.case.loads.load import LoadedPacking

_LARGEST_OF_CHAIN = 2.5  # upper bound of contact forces / force that drives a chain


@dataclasses.dataclass(frozen=True, kw_only=True)
class ForceLoad(DrivenLoad):
    """Force on the impacted spheres together, or on the free end of the incident bar."""

    kind: ClassVar[str] = "force"
    means: ClassVar[str] = "a force"
    takes_incident_bar: ClassVar[bool] = True
    energy_is_bound: ClassVar[bool] = True
    amplitude_unit: ClassVar[str] = "N"
    usual_amplitude: ClassVar[hints.Usual] = hints.FORCE
    shown_amplitude: ClassVar[tuple[float, str]] = (1.0, "N")
    shapes: ClassVar[tuple[str, ...]] = tuple(SHAPES)
    holds_last: ClassVar[bool] = False

    @property
    def impulse(self) -> float:
        """Largest magnitude of the impulse up to any time, N s; for an oscillating load after
        half a period.
        """
        if self.table:
            time, force = np.array(self.table).T
            parts = np.diff(time) * (force[1:] + force[:-1]) / 2
            return float(np.abs(np.cumsum(parts)).max())
        if self.oscillates:
            return self.largest / (math.pi * self.lowest_frequency)
        mean = 2 / math.pi if self.shape == "half-sine" else 1.0
        return (self.amplitude or 0.0) * (self.duration or 0.0) * mean

    def impulse_on(self, mass: float) -> float:
        return self.impulse

    def energy_in(self, packing: LoadedPacking) -> float:
        """Return the energy of the impulse on the impacted spheres, or of the wave in the bar."""
        if packing.bar_impedance is not None:
            return self.largest * self.impulse / packing.bar_impedance
        return self.impulse**2 / (2 * sum(map(packing.mass_of, self.struck(packing))))

    def speed_bound(self, packing: LoadedPacking) -> float:
        return math.sqrt(2 * self.energy_in(packing) / packing.masses[0])

    def force_on_contact(self, stiffness: float) -> float:
        return self.largest

    def contact_energy(self, energy: float, law: ContactLaw, packing: LoadedPacking) -> float:
        """Limit the energy by the work up to the largest force if no sphere moves at the start."""
        if not packing.is_at_rest:
            return energy
        bound = work_to_force(law, _LARGEST_OF_CHAIN * self.largest)
        return bound if self.oscillates else min(energy, bound)

    def sentence(self, n_strikers: int) -> str:
        direction = f"{list(self.direction or ())}" if self.slants else "+z"
        return f"{self.shape} force, at most {self.largest:g} N, along {direction}."

    @property
    def no_bare_target(self) -> str:
        if self.oscillates:
            return "the load oscillates; see the transmission of the packing"
        if self.way[2] <= 0:
            return "the force does not push towards the target"
        return ""
