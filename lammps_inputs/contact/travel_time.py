"""Chain along which the transmission of an oscillating load is measured, and the travel time of
waves along it.

Beads of masses m and contacts of stiffnesses k transmit displacement u and force s from one bead to
the next by

    s' = s - m omega^2 u,   u' = u + s'/k

The product of these matrices over one period of the chain has the trace 2 cos q, with the
phase q from one repetition to the next; the group delay is dq/domega for each. Where |cos q| > 1
there is no wave. A chain without a repeated sequence is treated bead by bead, each as part of an
infinite, periodic chain (long chains that change slowly).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.contact.law import pair_contact, sphere_contact
from granwave.lammps_inputs.contact.static_load import absorbing_ids, force_on_top, static_stiffness
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import held_ids, line_ids, struck_of
from granwave.lammps_inputs.roots import brentq

Array = NDArray[np.float64]

_STEP = 1e-5  # relative step of a frequency, for the slope of the phase


@dataclasses.dataclass(frozen=True, eq=False)
class WaveRow:
    """Chain along which waves travel.

    Attributes
    ----------
    mass
        Of the beads that it repeats: (n,), kg.
    stiffness
        Of the contact behind each: (n,), N/m.
    repeats
        True if the row repeats them exactly, False if it is only much like a row of each.
    """

    mass: Array
    stiffness: Array
    repeats: bool = True

    @property
    def of_long_wave(self) -> float:
        """Mean travel time of a long wave from one bead to the next, s; no wave is faster."""
        if self.repeats:
            return math.sqrt(float(self.mass.mean()) * float((1 / self.stiffness).mean()))
        return float(np.sqrt(self.mass / self.stiffness).mean())

    def per_bead(self, frequency: Array) -> Array:
        """Return the travel time of a wave packet from one bead to the next, s; infinite if there
        is no wave: (n,).
        """
        if self.repeats:
            low, here, high = (
                self._cosine(frequency * factor) for factor in (1 - _STEP, 1.0, 1 + _STEP)
            )
            inside = np.maximum.reduce([np.abs(low), np.abs(here), np.abs(high)]) < 1
            change = np.abs(np.arccos(np.clip(high, -1, 1)) - np.arccos(np.clip(low, -1, 1)))
            return np.where(inside, change / (4 * math.pi * _STEP * frequency), np.inf) / len(
                self.mass
            )
        kinds, counts = np.unique(
            np.stack([self.mass, self.stiffness], axis=1), axis=0, return_counts=True
        )
        each = [WaveRow(one[:1], one[1:]).per_bead(frequency) for one in kinds]
        return np.asarray(np.average(each, axis=0, weights=counts))

    def _cosine(self, frequency: Array) -> Array:
        """Half of the trace: (n,)."""
        square = (2 * math.pi * frequency) ** 2
        product = np.broadcast_to(np.eye(2), (len(frequency), 2, 2))
        for mass, stiffness in zip(self.mass, self.stiffness, strict=True):
            one = np.empty((len(frequency), 2, 2))
            one[:, 1, 0] = -mass * square
            one[:, 1, 1] = 1.0
            one[:, 0, 0] = 1 - mass * square / stiffness
            one[:, 0, 1] = 1 / stiffness
            product = one @ product
        return np.asarray(np.trace(product, axis1=1, axis2=2) / 2)


def row_of(assembly: Assembly) -> WaveRow | None:
    """Return the equivalent chain of plane waves along z; None if the static force is not known
    beforehand.

    A chain is its own equivalent. The layers of a lattice without disorder move as wholes, and the
    rotation of the force with the contacts is neglected.
    """
    case = assembly.case
    lattice = assembly.lattice
    stage = case.precompression
    if stage is None or not stage.rule.is_even or assembly.bars or case.packing.grains is not None:
        return None
    if not case.packing.rule.is_chain:
        cosines = lattice.rule.supports[:, 2]
        if not assembly.sites.uniform or not len(cosines):
            return None
        along = static_stiffness(assembly) * float(np.sum(cosines**2))
        return WaveRow(np.array([case.sphere_mass]), np.array([along]))
    force = force_on_top(assembly)
    n = lattice.n_spheres
    sites = assembly.sites
    if sites.uniform:
        return WaveRow(
            np.array([case.sphere_mass]), np.array([_stiffness(sphere_contact(case), force)])
        )
    if not sites.present.all():
        return None
    period = sites.period_of_chain()
    beads = np.arange(1, (period or n) + 1)
    mass = np.array([assembly.mass_of(one) for one in beads.tolist()])
    kinds = list(zip(sites.diameter.tolist(), sites.body.tolist(), strict=True))
    pairs = [(one, one + 1) if one < n else (one - 1, one) for one in beads.tolist()]
    of_kinds = {(kinds[a - 1], kinds[b - 1]): (a, b) for a, b in pairs}
    known = {
        key: _stiffness(pair_contact(assembly, *pair), force) for key, pair in of_kinds.items()
    }
    return WaveRow(
        mass,
        np.array([known[kinds[a - 1], kinds[b - 1]] for a, b in pairs]),
        repeats=period is not None,
    )


def _stiffness(law: ContactLaw, force: float) -> float:
    """Stiffness of a contact for small motions under a force that has not been exceeded, N/m."""

    def miss(overlap: float) -> float:
        return float(law.loading_force(overlap)) - force

    most = 1e-9
    while miss(most) < 0:
        most *= 2
    return float(law.unloading_stiffness(brentq(miss, 0.0, most, xtol=1e-18, rtol=1e-12)))


@dataclasses.dataclass(frozen=True)
class MeasuredRow:
    """Grains in their order.

    Attributes
    ----------
    group
        Group of ``result.h5`` that has their motion.
    ids
        Their ids.
    first, last
        Positions in ``ids`` of the loaded grain, or of the first if none is loaded, and of the last
        movable grain that does not absorb.
    """

    group: str
    ids: tuple[int, ...]
    first: int
    last: int

    @property
    def ends(self) -> tuple[int, int]:
        """Ids of the first and the last grain."""
        return self.ids[self.first], self.ids[self.last]


def measured_row(assembly: Assembly) -> MeasuredRow | None:
    """Return the grains of a chain, or of the first line that is not of all grains; None without
    any.
    """
    case = assembly.case
    if case.packing.rule.is_chain:
        group = "chain"
        ids = tuple(range(1, assembly.lattice.n_spheres + 1))
    else:
        line = next((one for one in case.line if one.index != "all"), None)
        if line is None:
            return None
        group = f"lines/{line.name}"
        ids = line_ids(assembly, line)
    if not ids:
        return None
    loaded = {axis for axis, part in zip("xyz", case.load.way, strict=True) if part}
    struck = struck_of(assembly)
    first = next((place for place, one in enumerate(ids) if one in struck), 0)
    still: set[int] = set()
    for entry in case.absorb:
        still.update(absorbing_ids(assembly, entry))
    for hold in case.holds.values():
        if loaded & set(hold.axes):
            still.update(held_ids(case, hold))
    if case.boundary.bottom_rule.holds_layer:
        still |= set(assembly.lattice.last_layer.tolist())
    rest = [place for place, one in enumerate(ids) if one not in still and place != first]
    return MeasuredRow(group, ids, first, rest[-1] if rest else len(ids) - 1)
