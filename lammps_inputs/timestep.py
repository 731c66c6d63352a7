"""The timestep, from the stiffest contact that the impact can make.

The hardest encounter bounds every overlap of the run. Candidates, each a collision of effective mass m_eff at
the normal velocity v_n, so that the contact takes up at most W = m_eff v_n^2 / 2 on loading:

* the struck sphere against one resting sphere, head on: m_eff = m/2, v_n = v;
* the struck sphere against the spheres it rests on, symmetrically (n of them at the angle theta to the
  impact): m_eff = m / (1 + n cos^2 theta), v_n = v cos theta (for fcc and hcp n = 3, cos^2 theta = 2/3);
* a sphere against a rigid wall: m_eff = m, v_n = v if a line of contacts carries the pulse there undivided
  (chain, simple cubic), else v halved with each layer on the way.

The timestep dt is chosen for the energy balance; stability (dt < 2/omega) would allow some fifty times more. The
error of velocity Verlet is proportional to dt^2 and largest in the first collisions, where few contacts hold all the
energy. There the work W is done on the slope of loading, and the recoverable part E of it is given back on the
steeper slope of unloading, so that the stiffness that counts is

    k = (E/W) k_unloading + (1 - E/W) k_loading        at the largest overlap

With it the largest error, over the input, is c k dt^2 / m with one c: 0.105 to 0.135 over 24 impacts on fcc packings
(brass, steel, aluminium; 0.5 to 40 m/s), less on the other lattices, 0.15 for Hertz and Thornton contacts, 0.2 for
bilinear ones. dt is set so that `_ERROR` k dt^2 / m is `_TOLERANCE`: 29 ns for brass spheres of 10 mm struck at 5 m/s
in fcc.

It is rounded down to two significant digits. At one velocity it is proportional to the diameter, as every
time is.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from granwave.lammps_inputs.laws import sphere_contact, wall_contact

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case import Case

_TOLERANCE = 1e-6  # of the input: error of the energy balance at any instant
_ERROR = 0.135
_SUPPORTS = {"fcc": (3, 2 / 3), "hcp": (3, 2 / 3), "bcc": (4, 1 / 3), "sc": (1, 1.0), "chain": (1, 1.0)}
_SLOPE_SPAN = 1e-6  # of the overlap, over which a slope is taken
_UNDIVIDED = ("chain", "sc", "square")  # the pulse reaches the wall along a line of contacts, or at once
_LARGEST_OVERLAP = 2.0  # in effective radii; brackets the search, far beyond every law


@dataclasses.dataclass(frozen=True)
class Encounter:
    """A collision that bounds the overlaps of the run.

    Attributes
    ----------
    law
        Of the contact.
    energy
        That the contact takes up on loading, J.
    bonds
        Spheres that the contact moves: 2, or 1 against a wall.
    """

    law: ContactLaw
    energy: float
    bonds: int

    @property
    def overlap(self) -> float:
        """At which the work of loading reaches the energy, m."""
        limit = _LARGEST_OVERLAP * self.law.effective_radius
        if _work(self.law, limit) <= self.energy:
            return limit

        def excess(logarithm: float) -> float:
            return math.log(_work(self.law, math.exp(logarithm)) / self.energy)

        low = math.log(limit)
        while excess(low) > 0:
            low -= 5.0
        return math.exp(brentq(excess, low, math.log(limit), xtol=1e-10))

    @property
    def stiffness(self) -> float:
        """Slope of the force at that overlap, N/m: of unloading for what is given back, of loading for the rest."""
        peak = np.array([self.overlap])
        below = peak * (1 - _SLOPE_SPAN)
        loading = (self.law.loading_force(peak) - self.law.loading_force(below)) / (peak - below)
        unloading = self.law.unloading_stiffness(peak)
        returned = 1 - self.law.dissipated_energy(peak) / self.law.loading_work(peak)
        return float((returned * unloading + (1 - returned) * loading)[0])


def expected_peak_overlap(case: Case) -> float:
    """A bound on the largest overlap of two spheres in the run, m."""
    return max(encounter.overlap for encounter in _encounters(case) if encounter.bonds == 2)


def auto_timestep(case: Case) -> float:
    """The timestep for ``run.timestep = "auto"``, s."""
    stiffness = max(encounter.stiffness * encounter.bonds / 2 for encounter in _encounters(case))
    return _round_down(math.sqrt(_TOLERANCE * case.sphere_mass / (_ERROR * stiffness)))


def _encounters(case: Case) -> list[Encounter]:
    kind, mass, velocity = case.packing.kind, case.sphere_mass, case.load.velocity
    law = sphere_contact(case)
    found = [Encounter(law, mass * velocity**2 / 4, 2)]
    if kind in _SUPPORTS:
        n, cosine_squared = _SUPPORTS[kind]
        found.append(Encounter(law, mass * velocity**2 * cosine_squared / (1 + n * cosine_squared) / 2, 2))
    if case.boundary.bottom == "wall":
        halvings = 0 if kind in _UNDIVIDED else case.lattice.shape[2] - 1
        found.append(Encounter(wall_contact(case), mass * (velocity * 0.5**halvings) ** 2 / 2, 1))
    return [encounter for encounter in found if encounter.energy > 0]


def _work(law: ContactLaw, overlap: float) -> float:
    return float(law.loading_work(np.array([overlap]))[0])


def _round_down(value: float, digits: int = 2) -> float:
    scale = digits - 1 - math.floor(math.log10(value))
    return float(f"{math.floor(value * 10.0**scale * (1 + 1e-12))}e{-scale}")
