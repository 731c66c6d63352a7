"""Reader of the ``result.h5`` of a sphere contact."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.workflows.finite_elements.runner import ElementResult
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.study import yield_unit

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

Array = NDArray[np.float64]

_CURVE = 500  # points of a curve of a law


class SphereContactResult(ElementResult):
    """The ``result.h5`` of a sphere contact, with quantities for its figures; raise as `ElementResult`."""

    def _read_more(self, file: h5py.File) -> None:
        self.case = SphereContactCase.from_dict(self.tables)
        profiles = sorted(file.get("pressure", {}), key=int)
        self.profiles = [(float(file[f"pressure/{n}"].attrs["overlap"]), f"pressure/{n}") for n in profiles]

    @cached_property
    def law(self) -> ContactLaw:
        """Contact law of the pair."""
        return self.case.law

    @property
    def units(self) -> tuple[float, float]:
        """Overlap (m) and force (N) for normalisation: those at first yield, or at the overlap in its place."""
        unit = yield_unit(self.case)
        return unit, float(self.hertz(np.array([unit]))[0])

    @property
    def plastic(self) -> bool:
        """True if first yield is reached."""
        return self.law.yield_overlap < self.case.max_overlap

    @property
    def overlap_label(self) -> str:
        """Axis label of normalised overlaps."""
        return r"Overlap $\alpha/\alpha_\mathrm{y}$" if self.plastic else r"Overlap, 400 $\alpha/\alpha_\mathrm{max}$"

    @property
    def strength(self) -> float:
        """Yield strength of the softer sphere, Pa; without yielding, the Hertzian mean pressure at the unit overlap."""
        strength = self.law.yield_strength
        unit, force = self.units
        return strength if math.isfinite(strength) else force / (math.pi * self.law.effective_radius * unit)

    def hertz(self, overlap: Array) -> Array:
        """Return the force of Hertz's law at overlaps (m), N."""
        return 4 / 3 * self.law.effective_modulus * math.sqrt(self.law.effective_radius) * overlap**1.5

    def thornton(self) -> ContactLaw | None:
        """Return Thornton's law of the same pair; None if no sphere can yield."""
        return self.case.contact_law("thornton") if self.case.yields else None

    def branch(self, branch: int, cycle: int = 0) -> NDArray[np.int64]:
        """Return the indices of the entries of one branch."""
        return np.flatnonzero((self["history/branch"] == branch) & (self["history/cycle"] == cycle))

    @property
    def cycles(self) -> list[int]:
        """Numbers of the cycles."""
        return [int(number) for number in self["cycles/number"]]

    @property
    def overlaps(self) -> Array:
        """Overlaps from 0 to the largest, for curves of laws, m."""
        return np.linspace(0, self["loading/overlap"].max(), _CURVE)
