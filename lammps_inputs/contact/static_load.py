"""Dead loads of ``[precompression]``, and spheres that absorb waves, ``[[absorb]]``.

Dead loads are constant forces on spheres during the static stage and the run:

uniaxial   the same force along +z on each sphere of the top layer (grains of a file: on the uppermost ones); for a
           pressure, pressure times area of a cell; the opposite force on the last sphere of a chain
           without a bottom
uniform    the forces of the missing neighbours outside of the packing, if every contact of the lattice carried the
           same force f. The mean stress (virial) of spheres with z contacts each in a cell of
           volume V is p = z f D/(2 d V) in d dimensions; hence f = p D^2/(2 sqrt 2) for fcc and
           hcp. A lattice of equal spheres is then in equilibrium in place under the pressure p, and
           its faces carry p times their area. Vacant sites that are connected to the outside count
           as outside.
gravity    m g along +z on each sphere of the packing
walls      none, or as uniaxial: walls are moved in, and held
overlaps   the same: the grains overlap at the start

Fixed spheres and strikers carry no dead load.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.bodies import MATCHED, Absorb
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact import Contact
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import Wall, touched_by, walls

_SHELL = (
    3,
    2,
    1,
)  # rows of sites around the packing, along x, y, z, that contain all missing neighbours


def dead_loads(assembly: Assembly) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the ids of the spheres with a dead load, rising, and the forces: (n,) and (n, 3), N."""
    case = assembly.case
    stage = case.precompression
    lattice = assembly.lattice
    assert stage is not None
    ids = assembly.ids[assembly.ids <= lattice.n_spheres]
    force = np.zeros((len(ids), 3))
    if stage.kind == "gravity":
        force[:, 2] = assembly.sphere_masses()[: len(ids)] * stage.acceleration
    elif stage.kind == "uniaxial" or stage.moves_walls:
        force[np.isin(ids, lattice.top_layer), 2] = force_on_top(assembly)
        if case.boundary.bottom == "free" and case.packing.rule.is_chain:
            force[np.isin(ids, lattice.last_layer), 2] = -force_on_top(assembly)
    else:
        force = force_of_contact(assembly) * _missing_neighbours(assembly)[ids - 1]
    if case.boundary.bottom == "fixed":
        force[np.isin(ids, lattice.last_layer)] = 0.0
    loaded = force.any(axis=1)
    return ids[loaded], force[loaded]


def directions(assembly: Assembly) -> str:
    """Return the axes along which there are dead loads, as letters of "xyz"."""
    stage = assembly.case.precompression
    if stage is not None and stage.moves_walls:
        return "z" if stage.force is not None else ""
    return (
        "xyz"[: assembly.lattice.rule.dimension]
        if stage is not None and stage.kind == "uniform"
        else "z"
    )


def force_on_top(assembly: Assembly) -> float:
    """Return the force on each sphere of the top layer under a uniaxial load, N."""
    stage = assembly.case.precompression
    assert stage is not None
    if stage.force is not None or stage.moves_walls:
        return stage.force or 0.0
    nx, ny, _ = assembly.lattice.shape
    return (stage.pressure or 0.0) * math.prod(assembly.lattice.lengths) / (nx * ny)


def force_of_contact(assembly: Assembly) -> float:
    """Estimate the force on each contact that carries the load, under gravity on those at the
    bottom, N.
    """
    case = assembly.case
    stage = case.precompression
    lattice = assembly.lattice
    assert stage is not None
    if stage.moves_walls:
        overlaps = (
            lattice.overlapping()[1]
            if stage.takes_overlaps and isinstance(lattice, Places)
            else np.zeros(0)
        )
        deepest = max([*stage.moves.values(), *overlaps.tolist()], default=0.0)
        hertz = float(sphere_hertz(case).loading_force(deepest))
        there = walls(assembly) if stage.presses else ()
        first = {
            name: next(wall for wall in there if wall.name.startswith(name))
            for name in stage.presses
        }
        pressed = (
            force / len(grains_at_wall(assembly, first[name]))
            for name, force in stage.presses.items()
        )
        return max([hertz, force_on_top(assembly), *pressed])
    if stage.kind == "uniform":
        rule = lattice.rule
        layer = rule.pitch[0] * rule.pitch[1] * lattice.diameter**2
        depth = rule.layer_spacing
        stress = 2 * rule.dimension * (stage.pressure or 0.0)
        return stress * layer * depth * lattice.diameter / (rule.coordination * lattice.diameter)
    top = force_on_top(assembly) if stage.kind == "uniaxial" else 0.0
    if stage.kind == "gravity":
        nz = lattice.n_layers
        held = case.boundary.bottom == "fixed" and not isinstance(lattice, Places)
        top = (
            float(assembly.sphere_masses().sum())
            * stage.acceleration
            / len(lattice.last_layer)
            * (nz - held)
            / nz
        )
    return top if isinstance(lattice, Places) else top / lattice.rule.carried


def grains_at_wall(assembly: Assembly, wall: Wall) -> NDArray[np.int64]:
    """Return the ids of the grains that touch a wall before it moves, or are nearest to it; at
    least one.
    """
    sites = assembly.sites
    chosen = touched_by(assembly, wall)
    ids = 1 + np.flatnonzero(sites.present if chosen is None else chosen)
    gaps = wall.gaps(sites.positions(1, len(sites.present))[ids - 1], sites.diameter[ids - 1] / 2)
    return ids[gaps <= gaps.min() + TOUCHING * assembly.lattice.diameter]


def sphere_hertz(case: Case) -> ContactLaw:
    """Return the elastic law between two grains of the packing."""
    radius = case.packing.diameter / 2
    shape = case.packing.of_grain
    return law_between(
        Contact(law="hertz"),
        (case.material, case.material),
        (radius, radius),
        shapes=(shape, shape),
    )


def static_stiffness(assembly: Assembly) -> float:
    """Estimate the stiffness of a contact under the static load, N/m: that of Hertz's law at
    `force_of_contact`.
    """
    case = assembly.case
    law = sphere_hertz(case)
    if case.packing.of_grain is not None:
        force = force_of_contact(assembly)
        largest = case.packing.diameter / 2
        return float(
            law.unloading_stiffness(largest * min(1.0, force / law.loading_force(largest)))
        )  # nearly linear
    hertz = 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)
    return 1.5 * hertz ** (2 / 3) * force_of_contact(assembly) ** (1 / 3)


def _missing_neighbours(assembly: Assembly) -> NDArray[np.float64]:
    """Sum the directions from the missing outside neighbours to each site of the lattice: (n_sites,
    3).

    Below the last layer none is missing unless the bottom is free.
    """
    case = assembly.case
    lattice = assembly.lattice
    sites = assembly.sites
    ranges = [np.arange(-reach, n + reach) for reach, n in zip(_SHELL, lattice.shape, strict=True)]
    if case.boundary.bottom != "free":
        ranges[2] = ranges[2][: -_SHELL[2]]
    if lattice.rule.dimension == 2:
        ranges[2] = np.zeros(1, dtype=np.int64)
    index = np.stack([axis.ravel() for axis in np.meshgrid(*ranges, indexing="ij")], axis=1)
    outside = index[((index < 0) | (index >= np.array(lattice.shape))).any(axis=1)]
    missing = np.stack(lattice.rule.site(*outside.T), axis=1)
    own = lattice.positions(1, lattice.n_spheres) / lattice.diameter
    from scipy.spatial import KDTree  # takes longer to load than most commands need

    border = missing
    vacant = own[~sites.present]
    while len(border) and len(
        vacant
    ):  # vacant sites that are connected to the outside, directly or through others
        reached = KDTree(border).query(vacant)[0] <= 1 + TOUCHING
        border = vacant[reached]
        vacant = vacant[~reached]
        missing = np.concatenate([missing, border])
    near = KDTree(missing).query_ball_point(own, 1 + TOUCHING)
    result = np.zeros_like(own)
    for site, found in enumerate(near):
        if found:
            result[site] = (own[site] - missing[found]).sum(axis=0)
    return np.where(np.abs(result) < TOUCHING, 0.0, result)


def absorbing_ids(assembly: Assembly, entry: Absorb) -> tuple[int, ...]:
    """Return the ids of the spheres that an entry damps, in rising order."""
    lattice = assembly.lattice
    if entry.index is not None:
        return tuple(sorted(set(entry.index)))
    there = assembly.ids[assembly.ids <= lattice.n_spheres]
    layer = np.array([lattice.layer_of(int(one)) for one in there])
    return tuple(there[layer >= lattice.n_layers - (entry.layers or 0)].tolist())


def rise_of(assembly: Assembly, entry: Absorb) -> tuple[float, float] | None:
    """Return the places along the axis where the rate is zero and where it is whole, m; None where
    it does not rise.

    The rate is zero one diameter before the first of the spheres, so that all of them are damped.
    """
    if entry.rate is None or entry.towards == "none":
        return None
    axis = "xyz".index(entry.towards[1])
    sign = 1.0 if entry.towards[0] == "+" else -1.0
    places = sign * np.array(
        [assembly.centre_of(one)[axis] for one in absorbing_ids(assembly, entry)]
    )
    return sign * (float(places.min()) - assembly.case.packing.diameter), sign * float(places.max())


def impedance_of(assembly: Assembly, entry: Absorb) -> float:
    """Return the impedance of each sphere, N s/m.

    That of long waves along z under the static load is sqrt(k m), with the stiffness k between a
    sphere and the next layer: the sum over its contacts there of k_n cos^2 + k_t sin^2, where k_t =
    2 (1 - nu)/(2 - nu) k_n with friction and 0 without.
    """
    if entry.impedance != MATCHED:
        return float(entry.impedance or 0.0)
    case = assembly.case
    cosines = assembly.lattice.rule.supports[:, 2]
    across = (
        2 * (1 - case.material.poisson_ratio) / (2 - case.material.poisson_ratio)
        if case.has_friction
        else 0.0
    )
    stiffness = static_stiffness(assembly) * float(np.sum(cosines**2 + across * (1 - cosines**2)))
    return math.sqrt(stiffness * case.sphere_mass)
