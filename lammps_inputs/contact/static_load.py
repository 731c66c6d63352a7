"""Dead loads of ``[precompression]``: constant forces on spheres, from the static stage before the run to its end.

uniaxial   the same force along +z on each sphere of the top layer; from a pressure, that on the area of its cell
uniform    what missing neighbours outside of the packing would press with, if every contact of the lattice bore the
           same force f. The mean stress of spheres that each have z contacts in the volume V of a cell (virial) is
           p = z f D/(2 d V) in d dimensions: f = p D^2/(2 sqrt 2) in fcc and hcp. A lattice of like spheres is then in
           balance as it stands, the whole of it under the pressure p, and its faces carry p times their area. Vacant
           sites that are open to the outside count as outside.
gravity    m g along +z on each sphere of the packing

Spheres held in place bear no load, nor do strikers.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from granwave.lammps_inputs.case.sections import Contact
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import Assembly

_SHELL = (3, 2, 1)  # rows of sites around the packing, along x, y, z, in which its missing neighbours are


def dead_loads(assembly: Assembly) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Ids of the spheres that bear a dead load, rising, and the forces on them: (n,) and (n, 3), N."""
    case = assembly.case
    stage, lattice = case.precompression, assembly.lattice
    assert stage is not None
    nx, ny, nz = lattice.shape
    ids = assembly.ids[assembly.ids <= lattice.n_spheres]
    force = np.zeros((len(ids), 3))
    if stage.kind == "gravity":
        force[:, 2] = assembly.sphere_masses()[: len(ids)] * stage.acceleration
    elif stage.kind == "uniaxial":
        force[ids <= nx * ny, 2] = force_on_top(assembly)
    else:
        force = force_of_contact(assembly) * _missing_neighbours(assembly)[ids - 1]
    if case.boundary.bottom == "fixed":
        force[ids > nx * ny * (nz - 1)] = 0.0
    loaded = force.any(axis=1)
    return ids[loaded], force[loaded]


def directions(assembly: Assembly) -> str:
    """The axes along which there are dead loads, of "xyz"."""
    case = assembly.case
    stage = case.precompression
    if stage is None or stage.kind != "uniform":
        return "z"
    return "xyz"[: assembly.lattice.rule.dimension]


def force_on_top(assembly: Assembly) -> float:
    """On each sphere of the top layer under a uniaxial load, N."""
    case = assembly.case
    stage = case.precompression
    assert stage is not None
    if stage.force is not None:
        return stage.force
    nx, ny, _ = assembly.lattice.shape
    return (stage.pressure or 0.0) * math.prod(assembly.lattice.lengths) / (nx * ny)


def force_of_contact(assembly: Assembly) -> float:
    """About what each contact that carries the load bears, under gravity the ones at the bottom, N."""
    case = assembly.case
    stage, lattice = case.precompression, assembly.lattice
    assert stage is not None
    if stage.kind == "uniform":
        rule = lattice.rule
        layer = rule.pitch[0] * rule.pitch[1] * lattice.diameter**2
        return 2 * rule.dimension * (stage.pressure or 0.0) * layer * lattice.rule.layer_spacing * lattice.diameter / (
            rule.coordination * lattice.diameter
        )  # fmt: skip
    top = force_on_top(assembly) if stage.kind == "uniaxial" else 0.0
    if stage.kind == "gravity":
        nx, ny, nz = lattice.shape
        held = case.boundary.bottom == "fixed"
        top = float(assembly.sphere_masses().sum()) * stage.acceleration / (nx * ny) * (nz - held) / nz
    return top / lattice.rule.carried


def static_stiffness(assembly: Assembly) -> float:
    """Static stiffness of a contact under the static load, about, N/m: that of Hertz's law at `force_of_contact`."""
    case = assembly.case
    radius = case.packing.diameter / 2
    law = law_between(Contact(law="hertz"), (case.material, case.material), (radius, radius))
    hertz = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
    return 1.5 * hertz ** (2 / 3) * force_of_contact(assembly) ** (1 / 3)


def _missing_neighbours(assembly: Assembly) -> NDArray[np.float64]:
    """Sum of the directions from the neighbours that each site of the lattice lacks outside: (n_sites, 3).

    Below the last layer none is missing where something else is there.
    """
    case = assembly.case
    lattice, sites = assembly.lattice, assembly.sites
    ranges = [np.arange(-reach, n + reach) for reach, n in zip(_SHELL, lattice.shape, strict=True)]
    if case.boundary.bottom != "free":
        ranges[2] = ranges[2][: -_SHELL[2]]
    if lattice.rule.dimension == 2:
        ranges[2] = np.zeros(1, dtype=np.int64)
    index = np.stack([axis.ravel() for axis in np.meshgrid(*ranges, indexing="ij")], axis=1)
    outside = index[((index < 0) | (index >= np.array(lattice.shape))).any(axis=1)]
    missing = np.stack(lattice.rule.site(*outside.T), axis=1)
    own = lattice.positions(1, lattice.n_spheres) / lattice.diameter
    if sites is not None and not sites.present.all():
        missing = np.concatenate([missing, _open_to(missing, own[~sites.present])])
    near = KDTree(missing).query_ball_point(own, 1 + TOUCHING)
    result = np.zeros_like(own)
    for site, found in enumerate(near):
        if found:
            result[site] = (own[site] - missing[found]).sum(axis=0)
    return np.where(np.abs(result) < TOUCHING, 0.0, result)


def _open_to(outside: NDArray[np.float64], vacant: NDArray[np.float64]) -> NDArray[np.float64]:
    """Select the vacant places that touch the outside, or each other on to it: (n, 3)."""
    found, border = np.zeros(len(vacant), dtype=bool), outside
    while len(border):
        distance, _ = KDTree(border).query(vacant)
        reached = (distance <= 1 + TOUCHING) & ~found
        found |= reached
        border = vacant[reached]
    return vacant[found]
