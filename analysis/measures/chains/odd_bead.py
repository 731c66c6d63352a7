"""A chain with at most one bead of another kind, under a force, that ends on an elastic bar (thesis 3.2.3, 3.2.4).

Transmitted energy is what the bar holds at the end of the run, strain and kinetic; transmitted force is the largest
contact force on the bar, which is that of a section of a bar in which nothing comes back.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable

import numpy as np

from granwave.analysis.measures.chains.bar_pulse import impedance
from granwave.analysis.measures.chains.record import ChainRecord
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.bars import BAR

_LAST, _SETTLED = 0.05, 1e-3  # of the run, in which the energy in the bar changes by less than this share of it


@dataclasses.dataclass(frozen=True, eq=False)
class OddBead:
    """A chain on a bar with at most one odd bead.

    Attributes
    ----------
    place
        Of the odd bead, from the struck end; None in a chain of like beads.
    material, diameter
        Of the odd bead, or of all.
    """

    run: ChainRecord
    place: int | None
    material: Material
    diameter: float

    @property
    def energy(self) -> float:
        """Transmitted, J."""
        return self.run.value(f"energy_{BAR}_J")

    @property
    def peak(self) -> float:
        """Largest force on the bar over that of the load."""
        return self.run.value("wall_peak_force_N") / self.run.load.largest

    @property
    def base(self) -> Material:
        """Material of the other beads."""
        return self.run.case.material

    @property
    def properties(self) -> dict[str, float]:
        """Properties of the odd bead, SI."""
        own = self.material
        return {
            "yield strength": own.yield_strength or math.inf,
            "density": own.density,
            "radius": self.diameter / 2,
            "modulus": own.youngs_modulus,
            "Poisson's ratio": own.poisson_ratio,
        }

    @property
    def substance(self) -> Hashable:
        """Constants and size of the odd bead."""
        return constants(self.material), self.diameter

    @property
    def line(self) -> Hashable:
        """Properties that the chains of a study share, whatever their beads are of."""
        case, (bar,) = self.run.case, self.run.assembly.bars
        return case.packing, case.load, case.contact, bar.section.area, impedance(bar)

    @property
    def unfinished(self) -> bool:
        """The energy in the bar still changed at the end of the run."""
        energy = self.run.array("energy/bar")
        last = energy[-max(2, int(_LAST * len(energy))) :]
        return bool(np.ptp(last) > _SETTLED * energy[-1])


def odd_bead_of(run: ChainRecord) -> OddBead | None:
    """A run as a chain on a bar, under a force, with at most one odd bead; None if it is something else."""
    case, assembly = run.case, run.assembly
    odd = {*assembly.diameters, *assembly.materials}
    if case.bar is None or case.incident_bar is not None or assembly.strikers or case.load.kind != "force":
        return None
    if len(odd) > 1 or case.load.oscillates:
        return None
    place = next(iter(odd), None)
    return OddBead(run, place, assembly.material_of(place or 1), assembly.diameter_of(place or 1))


def constants(material: Material) -> Hashable:
    """By which materials are told apart."""
    return material.youngs_modulus, material.poisson_ratio, material.density, material.yield_strength
