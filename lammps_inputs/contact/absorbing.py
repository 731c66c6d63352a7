"""Spheres that absorb waves, ``[[absorb]]``: which they are, where their damping rises, and the matched impedance."""

from __future__ import annotations

import math

import numpy as np

from granwave.lammps_inputs.case.absorb import MATCHED, Absorb
from granwave.lammps_inputs.contact.static_load import static_stiffness
from granwave.lammps_inputs.packing.assembly import Assembly


def absorbing_ids(assembly: Assembly, entry: Absorb) -> tuple[int, ...]:
    """Return the ids of the spheres that an entry damps, in rising order."""
    lattice = assembly.lattice
    if entry.index is not None:
        return tuple(sorted(set(entry.index)))
    there = assembly.ids[assembly.ids <= lattice.n_spheres]
    layer = np.array([lattice.layer_of(int(one)) for one in there])
    return tuple(there[layer >= lattice.n_layers - (entry.layers or 0)].tolist())


def rise_of(assembly: Assembly, entry: Absorb) -> tuple[float, float] | None:
    """Return the places along the axis where the rate is zero and where it is whole, m; None where it does not rise.

    The rate is zero one diameter before the first of the spheres, so that all of them are damped.
    """
    if entry.rate is None or entry.towards == "none":
        return None
    axis, sign = "xyz".index(entry.towards[1]), 1.0 if entry.towards[0] == "+" else -1.0
    places = sign * np.array([assembly.centre_of(one)[axis] for one in absorbing_ids(assembly, entry)])
    return sign * (float(places.min()) - assembly.case.packing.diameter), sign * float(places.max())


def impedance_of(assembly: Assembly, entry: Absorb) -> float:
    """Return the impedance of each sphere, N s/m.

    That of long waves along z under the static load is sqrt(k m), with the stiffness k between a sphere and the next
    layer: the sum over its contacts there of k_n cos^2 + k_t sin^2, where k_t = 2 (1 - nu)/(2 - nu) k_n with friction
    and 0 without.
    """
    if entry.impedance != MATCHED:
        return float(entry.impedance or 0.0)
    case = assembly.case
    cosines = assembly.lattice.rule.supports[:, 2]
    across = 2 * (1 - case.material.poisson_ratio) / (2 - case.material.poisson_ratio) if case.has_friction else 0.0
    stiffness = static_stiffness(assembly) * float(np.sum(cosines**2 + across * (1 - cosines**2)))
    return math.sqrt(stiffness * case.sphere_mass)
