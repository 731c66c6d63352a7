"""Forces, stiffnesses and energies of many contacts at once, by the laws of the plugin.

A law at an effective radius R* follows from that at R* = 1 m: overlaps grow with R*, forces with R*^2, stiffnesses with
R*, energies with R*^3.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.contact.initial_dents import largest_dent
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.walls import wall_friction

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.material import Material
    from granwave.lammps_inputs.packing.walls import Wall

Array = NDArray[np.float64]
_STEP = 1e-6  # of the overlap, for the slope of a loading curve beyond first yield


@dataclasses.dataclass(frozen=True, eq=False)
class Touches:
    """Contacts of one pair of materials with the same law.

    Attributes
    ----------
    law
        The law at an effective radius of 1 m.
    friction
        Coefficient of friction.
    dent
        Largest earlier overlap over R*.
    """

    law: ContactLaw
    friction: float
    dent: float

    def evaluate(self, overlap: Array, radius: Array) -> tuple[Array, Array, Array]:
        """Return force, N, slope of the force, N/m, and work, J, at overlaps (n,), m, as they are first reached."""
        a = np.maximum(overlap, 0.0) / radius
        peak = np.maximum(a, self.dent)
        force = self.law.force(a, peak)
        work = self.law.elastic_energy(a, peak) + self.law.dissipated_energy(peak)
        loading = (a >= self.dent) & (a > self.law.elastic_limit)
        slope = self._unloading(a, peak)
        if loading.any():
            one = a[loading]
            slope[loading] = (self.law.loading_force(one * (1 + _STEP)) - self.law.loading_force(one * (1 - _STEP))) / (
                2 * _STEP * one
            )
        return radius**2 * force, radius * slope, radius**3 * work

    def small(self, overlap: Array, peak: Array, radius: Array) -> tuple[Array, Array, Array]:
        """Return force, N, and normal and tangential stiffness of small motions, N/m, at a state with a past.

        Parameters
        ----------
        overlap, peak
            Overlaps now and the largest so far: (n,), m.
        radius
            Effective radii: (n,), m.
        """
        a = np.maximum(overlap, 0.0) / radius
        most = np.maximum.reduce([a, peak / radius, np.full_like(a, self.dent)])
        tangential = self.law.tangential_stiffness(a, most) if self.friction else np.zeros_like(a)
        return radius**2 * self.law.force(a, most), radius * self._unloading(a, most), radius * tangential

    def _unloading(self, a: Array, peak: Array) -> Array:
        """Slope of the branch that a contact un- and reloads on: n F/(alpha - alpha_R), N/m at R* = 1."""
        above = a - self.law.residual_overlap(peak)
        slope: Array = self.law.unloading_exponent(peak) * self.law.force(a, peak) / np.where(above > 0, above, 1.0)
        return np.where(above > 0, slope, 0.0)


@dataclasses.dataclass(frozen=True, eq=False)
class PairLaws:
    """Laws of all pairs of materials of a case, and of its walls."""

    case: Case
    materials: tuple[Material, ...]

    def __post_init__(self) -> None:
        """Refuse dents that differ from place to place.

        Raises
        ------
        InputError
            The dents come from a file, or belong to regions.
        """
        given = self.case.contact.initial_overlap
        if isinstance(given, str) or (isinstance(given, tuple) and any(one.low or one.high for one in given)):
            raise InputError(
                f"{self.case.name}: contact.initial_overlap: found dents that differ from place to place; "
                "run the case, and give the directory of the run"
            )

    @cached_property
    def _known(self) -> dict[tuple[int, int], Touches]:
        found = {}
        for n, first in enumerate(self.materials):
            for m, second in enumerate(self.materials[n:], start=n):
                contact = self.case.contact_between(first, second)
                law = law_between(contact, (first, second), (2.0, 2.0))
                found[n, m] = Touches(law, contact.friction, self._dent(law))
        return found

    def _dent(self, law: ContactLaw) -> float:
        """Initial dent over R*."""
        given = self.case.contact.initial_overlap
        if not given or not law.entry.yields:
            return 0.0
        if isinstance(given, float | int):
            radius = self.case.packing.diameter / 4
            return float(given) / radius
        radius = self.case.packing.diameter / 4
        own = law_between(self.case.contact, (self.case.material, self.case.material), (2 * radius, 2 * radius))
        return largest_dent(self.case, own) / radius

    def pairs(self, one: NDArray[np.int64], other: NDArray[np.int64]) -> list[tuple[Touches, NDArray[np.int64]]]:
        """Return the laws of pairs of materials (n,), each with the rows that it belongs to."""
        low, high = np.minimum(one, other), np.maximum(one, other)
        found = [(law, np.flatnonzero((low == n) & (high == m))) for (n, m), law in self._known.items()]
        return [(law, rows) for law, rows in found if len(rows)]

    def wall(self, wall: Wall, kind: NDArray[np.int64]) -> list[tuple[Touches, NDArray[np.int64]]]:
        """Return the laws of grains of materials (n,) at a wall, each with the rows that it belongs to."""
        found = []
        for n, material in enumerate(self.materials):
            rows = np.flatnonzero(kind == n)
            if len(rows):
                law = law_between(self.case.contact_between(material, wall.material), (material, wall.material),
                                  (1.0, math.inf))  # fmt: skip
                friction = wall_friction(self.case, wall, material)
                found.append((Touches(law, friction, self._dent(law)), rows))
        return found
