"""Viscous losses of contacts, ``contact.loss``, of small motions.

A contact of the slope k = dF/d(overlap) resists the rate of its overlap by c = A k with the loss time A, or by
c = alpha sqrt(2/3 m* k) with the factor alpha of a dashpot and the effective mass m*, as in the runs. A network whose
springs have c for k, no static force and no friction has the matrix of these dampers for its stiffness.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from granwave.analysis.spectra.network import Array, Network
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import Viscous, viscous_loss
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls


def losses_of(assembly: Assembly, network: Network) -> Network | None:
    """Return the network with the damping constants of contacts (N s/m) for stiffnesses; None if they lose nothing."""
    if not assembly.case.has_loss:
        return None
    springs, supports = network.springs, network.supports
    pairs = list(zip(network.ids[springs.first].tolist(), network.ids[springs.second].tolist(), strict=True))
    one, other = network.mass[springs.first], network.mass[springs.second]
    between = _constants(springs.stiffness, one * other / (one + other), _of_pairs(assembly, pairs))
    touching = list(zip(network.ids[supports.grain].tolist(), supports.wall.tolist(), strict=True))
    at_walls = _constants(supports.stiffness, network.mass[supports.grain], _of_walls(assembly, touching))
    none, unmoved = np.zeros(len(springs)), np.zeros(len(supports))
    return dataclasses.replace(
        network,
        springs=dataclasses.replace(springs, stiffness=between, tangential=none, force=none),
        supports=dataclasses.replace(supports, stiffness=at_walls, tangential=unmoved, turning=unmoved),
    )


def _constants(stiffness: Array, mass: Array, losses: list[Viscous | None]) -> Array:
    """Damping constants of contacts, from their stiffnesses, N/m, and effective masses, kg: (n,), N s/m."""
    found = np.zeros(len(stiffness))
    for row, loss in enumerate(losses):
        if loss is not None:
            kind, size = loss
            k = float(stiffness[row])
            found[row] = size * (k if kind == "time" else math.sqrt(2 / 3 * float(mass[row]) * k))
    return found


def _of_pairs(assembly: Assembly, pairs: list[tuple[int, int]]) -> list[Viscous | None]:
    known: dict[tuple, Viscous | None] = {}
    found = []
    for one, other in pairs:
        materials = assembly.material_of(one), assembly.material_of(other)
        shapes = assembly.shape_of(one), assembly.shape_of(other)
        if (materials, shapes) not in known:
            contact = assembly.case.contact_between(*materials)
            known[materials, shapes] = viscous_loss(assembly, contact, *materials, shapes=shapes)
        found.append(known[materials, shapes])
    return found


def _of_walls(assembly: Assembly, touching: list[tuple[int, str]]) -> list[Viscous | None]:
    partner = {wall.name: wall.material for wall in walls(assembly)}
    known: dict[tuple[Material, str], Viscous | None] = {}
    found = []
    for grain, wall in touching:
        material = assembly.material_of(grain)
        if (material, wall) not in known:
            contact = assembly.case.contact_between(material, partner[wall])
            known[material, wall] = viscous_loss(assembly, contact, material, partner[wall], flat=True)
        found.append(known[material, wall])
    return found
