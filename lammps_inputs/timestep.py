"""The timestep, from the stiffest contact that the impact can make.

The hardest encounter bounds every overlap of the run. Candidates, each a collision of effective mass m_eff at
the normal velocity v_n, so that the contact takes up at most W = m_eff v_n^2 / 2 on loading:

* the struck sphere against one resting sphere, head on: m_eff = m/2, v_n = v;
* the struck sphere against the spheres it rests on, symmetrically (n of them at the angle theta to the
  impact): m_eff = m / (1 + n cos^2 theta), v_n = v cos theta (for fcc and hcp n = 3, cos^2 theta = 2/3);
* a sphere against a rigid wall: m_eff = m, v_n = v if a line of contacts carries the pulse there undivided
  (chain, simple cubic), else v halved with each layer on the way.

The stiffness k there is the slope of unloading from that overlap, the steepest of the law. With every contact
of the lattice at k, its highest frequency is omega = sqrt(2 k N / m) with N = Z/d (Z contacts a sphere in d
dimensions: 4 for fcc and hcp, 8/3 for bcc, 2 for sc, square and chain). Velocity Verlet is stable up to dt =
2/omega; what matters here is the energy balance. Its error is that of the method, proportional to dt^2, and
largest in the first collisions, where few stiff contacts hold all the energy. The timestep is the `_FRACTION`
of 1/omega, which makes it 32 ns for brass spheres of 10 mm struck at 5 m/s in fcc: the balance then stays
within about 1e-6 of the input at every instant (1.1e-5 at 100 ns, where it closes to 5e-7 at the end).

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

_FRACTION = 0.012
_SUPPORTS = {"fcc": (3, 2 / 3), "hcp": (3, 2 / 3), "bcc": (4, 1 / 3), "sc": (1, 1.0), "chain": (1, 1.0)}
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
        """Steepest slope of the force at that overlap, N/m."""
        return float(self.law.unloading_stiffness(np.array([self.overlap]))[0])


def expected_peak_overlap(case: Case) -> float:
    """A bound on the largest overlap of two spheres in the run, m."""
    return max(encounter.overlap for encounter in _encounters(case) if encounter.bonds == 2)


def auto_timestep(case: Case) -> float:
    """The timestep for ``run.timestep = "auto"``, s."""
    rule = case.lattice.rule
    stiffness = max(encounter.stiffness * encounter.bonds / 2 for encounter in _encounters(case))
    omega = math.sqrt(2 * stiffness * rule.coordination / rule.dimension / case.sphere_mass)
    return _round_down(_FRACTION / omega)


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
