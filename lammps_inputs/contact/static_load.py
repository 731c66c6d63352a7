"""Dead loads of ``[precompression]``, and spheres that absorb waves, ``[[absorb]]``.

Dead loads are constant forces on spheres during the static stage and the run:

uniaxial   the same force along +z on each sphere of the top layer (grains of a file: on the
           uppermost ones); for a pressure, pressure times area of a cell; the opposite force on
           the last sphere of a chain without a bottom
uniform    the forces of the missing neighbours outside of the packing, if every contact of the
           lattice carried the same force f. The mean stress (virial) of spheres with z contacts
           each in a cell of volume V is p = z f D/(2 d V) in d dimensions; hence
           f = p D^2/(2 sqrt 2) for fcc and hcp. A lattice of equal spheres is then in equilibrium
           at its sites under the pressure p, and its faces carry p times their area. Vacant sites
           that are connected to the outside count as outside.
gravity    m g along +z on each sphere of the packing; with ``strikers`` also on strikers, which
           are held until the static stage is over
walls      none, or as uniaxial: walls are moved in, and held in place
overlaps   none, or as uniaxial: the grains overlap at the start

Fixed spheres carry no dead load, and strikers only their weight.
"""

from __future__ import annotations

import abc
import math

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.bodies import MATCHED, Absorb
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import Contact
from granwave.lammps_inputs.case.precompression import (
    Gravity,
    MovedWalls,
    Overlaps,
    Precompression,
    Uniaxial,
    Uniform,
)
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import Wall, pressed_walls, touched_by
from granwave.lammps_inputs.packing_kind import TOUCHING

_OF_MEAN = 4.0  # largest force of a contact / mean at the bottom of a bed
FORCE_TOLERANCE = 1e-4  # relative tolerance of the force of walls that are moved to a force
_SHELL = (
    3,
    2,
    1,
)  # rows of sites around the packing, along x, y, z, that contain all missing neighbours


class DeadLoad(abc.ABC):
    """Dead loads of a kind of static load, by its name in `DEAD_LOADS`."""

    @abc.abstractmethod
    def forces(self, assembly: Assembly, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces on spheres of the packing: (n, 3), N.

        Parameters
        ----------
        ids
            Their ids: (n,).
        """

    @abc.abstractmethod
    def force_of_contact(self, assembly: Assembly) -> float:
        """Estimate the largest force on a contact that carries the load, N."""

    def force_in_bed(self, assembly: Assembly) -> float:
        """Estimate the largest force on a contact of a disordered bed that carries the load, N."""
        return self.force_of_contact(assembly)

    def axes(self, assembly: Assembly) -> str:
        """Return the axes along which there are forces, as letters of "xyz"."""
        return "z"


class LoadOnTop(DeadLoad):
    """A force along z on each sphere of the top layer, and the opposite force on the last sphere of
    a free chain.
    """

    def forces(self, assembly: Assembly, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        lattice = assembly.lattice
        force = np.zeros((len(ids), 3))
        force[np.isin(ids, lattice.top_layer), 2] = force_on_top(assembly)
        if not assembly.case.boundary.bottom_rule.bears and lattice.rule.is_chain:
            force[np.isin(ids, lattice.last_layer), 2] = -force_on_top(assembly)
        return force

    def force_of_contact(self, assembly: Assembly) -> float:
        return _share_of(force_on_top(assembly), assembly)


class LoadOnAllFaces(DeadLoad):
    """The forces of the missing outside neighbours, if every contact carries the same force."""

    def axes(self, assembly: Assembly) -> str:
        return "xyz"[: assembly.lattice.rule.dimension]

    def forces(self, assembly: Assembly, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        return self.force_of_contact(assembly) * _missing_neighbours(assembly)[ids - 1]

    def force_of_contact(self, assembly: Assembly) -> float:
        lattice = assembly.lattice
        rule = lattice.rule
        layer = rule.pitch[0] * rule.pitch[1] * lattice.diameter**2
        depth = rule.layer_spacing
        stress = 2 * rule.dimension * (_stage_of(assembly).pressure or 0.0)
        return stress * layer * depth * lattice.diameter / (rule.coordination * lattice.diameter)


class Weight(DeadLoad):
    """m g along z on each sphere of the packing."""

    def forces(self, assembly: Assembly, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        force = np.zeros((len(ids), 3))
        masses = assembly.sphere_masses()[: len(ids)]
        force[:, 2] = masses * _stage_of(assembly).acceleration
        return force

    def force_of_contact(self, assembly: Assembly) -> float:
        lattice = assembly.lattice
        n_layers = lattice.n_layers
        bottom = assembly.case.boundary.bottom_rule
        held = bottom.holds_layer and not isinstance(lattice, Places)
        mass = float(assembly.sphere_masses().sum())
        weight = mass * _stage_of(assembly).acceleration / len(lattice.last_layer)
        return _share_of(weight * (n_layers - held) / n_layers, assembly)

    def force_in_bed(self, assembly: Assembly) -> float:
        """Return a multiple of the mean at the bottom: the weight times the area of a grain divided
        by the area of the bed.
        """
        low, high = assembly.bounds()
        diameter = assembly.case.packing.diameter
        area = float(np.prod(np.maximum(high - low, diameter)[:2]))
        weight = float(assembly.sphere_masses().sum()) * _stage_of(assembly).acceleration
        return min(_OF_MEAN * weight * diameter**2 / area, self.force_of_contact(assembly))


class PressOfWalls(LoadOnTop):
    """No dead load, except for a force on the top: walls or overlaps press."""

    def axes(self, assembly: Assembly) -> str:
        return "" if _stage_of(assembly).force is None else "z"

    def force_of_contact(self, assembly: Assembly) -> float:
        stage = _stage_of(assembly)
        lattice = assembly.lattice
        overlaps = np.zeros(0)
        if stage.takes_overlaps and isinstance(lattice, Places):
            overlaps = lattice.overlapping()[1]
        deepest = max([*stage.moves.values(), *overlaps.tolist()], default=0.0)
        hertz = float(sphere_hertz(assembly.case).loading_force(deepest))
        pressed = pressed_walls(assembly) if stage.presses else {}
        shares = [
            stage.presses[name] / len(grains_at_wall(assembly, faces[0]))
            for name, faces in pressed.items()
        ]
        return max([hertz, force_on_top(assembly), *shares])


DEAD_LOADS: dict[str, DeadLoad] = {
    Uniaxial.name: LoadOnTop(),
    Uniform.name: LoadOnAllFaces(),
    Gravity.name: Weight(),
    MovedWalls.name: PressOfWalls(),
    Overlaps.name: PressOfWalls(),
}


def _stage_of(assembly: Assembly) -> Precompression:
    """Return the precompression of a case that has one."""
    stage = assembly.case.precompression
    assert stage is not None
    return stage


def _dead_load(assembly: Assembly) -> DeadLoad:
    return DEAD_LOADS[_stage_of(assembly).kind]


def _share_of(force: float, assembly: Assembly) -> float:
    """Return the force on a contact if a sphere of a layer transmits this force along z, N."""
    lattice = assembly.lattice
    return force if isinstance(lattice, Places) else force / lattice.rule.carried


def dead_loads(assembly: Assembly) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the ids of the spheres with a dead load, rising, and the forces: (n,) and (n, 3),
    N.
    """
    lattice = assembly.lattice
    ids = assembly.ids[assembly.ids <= lattice.n_spheres]
    force = _dead_load(assembly).forces(assembly, ids)
    if assembly.case.boundary.bottom_rule.holds_layer:
        force[np.isin(ids, lattice.last_layer)] = 0.0
    loaded = force.any(axis=1)
    return ids[loaded], force[loaded]


def striker_loads(assembly: Assembly) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the ids of the strikers on which gravity acts, and their weights: (n,) and
    (n, 3), N.
    """
    stage = _stage_of(assembly)
    falls = (assembly.ids > assembly.lattice.n_spheres) & assembly.case.strikers_fall
    weight = np.zeros((int(falls.sum()), 3))
    weight[:, 2] = stage.acceleration * assembly.sphere_masses()[falls]
    return assembly.ids[falls], weight


def directions(assembly: Assembly) -> str:
    """Return the axes along which there are dead loads, as letters of "xyz"."""
    return _dead_load(assembly).axes(assembly)


def force_on_top(assembly: Assembly) -> float:
    """Return the force on each sphere of the top layer under a uniaxial load, N."""
    stage = _stage_of(assembly)
    if stage.force is not None or stage.moves_walls:
        return stage.force or 0.0
    nx, ny, _ = assembly.lattice.shape
    return (stage.pressure or 0.0) * math.prod(assembly.lattice.lengths) / (nx * ny)


def force_of_contact(assembly: Assembly) -> float:
    """Estimate the force on each loaded contact, under gravity on contacts at the bottom, N."""
    return _dead_load(assembly).force_of_contact(assembly)


def force_in_bed(assembly: Assembly) -> float:
    """Estimate the largest force on a loaded contact, N; in a wide bed it is the force
    in a column.
    """
    return _dead_load(assembly).force_in_bed(assembly)


def grains_at_wall(assembly: Assembly, wall: Wall) -> NDArray[np.int64]:
    """Return the ids of the grains that touch a wall before it moves, or of the nearest grain."""
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
    """Estimate the stiffness of a contact under the static load, N/m: the stiffness of Hertz's law
    at `force_of_contact`.
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


def stiffness_in_bed(assembly: Assembly) -> float:
    """Estimate the stiffness of the contacts of a disordered bed that carry the largest forces,
    N/m.
    """
    share = force_in_bed(assembly) / force_of_contact(assembly)
    return static_stiffness(assembly) * share ** (1 / 3)


def _missing_neighbours(assembly: Assembly) -> NDArray[np.float64]:
    """Sum the directions from the missing outside neighbours to each site of the lattice: (n_sites,
    3).

    Below the last layer none is missing unless the bottom is free.
    """
    case = assembly.case
    lattice = assembly.lattice
    sites = assembly.sites
    ranges = [np.arange(-reach, n + reach) for reach, n in zip(_SHELL, lattice.shape, strict=True)]
    if case.boundary.bottom_rule.bears:
        ranges[2] = ranges[2][: -_SHELL[2]]
    if lattice.rule.dimension == 2:
        ranges[2] = np.zeros(1, dtype=np.int64)
    index = np.stack([axis.ravel() for axis in np.meshgrid(*ranges, indexing="ij")], axis=1)
    outside = index[((index < 0) | (index >= np.array(lattice.shape))).any(axis=1)]
    missing = np.stack(lattice.rule.site(*outside.T), axis=1)
    own = lattice.positions(1, lattice.n_spheres) / lattice.diameter
    from scipy.spatial import KDTree  # imported on demand: slow to load

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
    """Return the positions along the axis where the rate is zero and where it is largest, m; None
    for a uniform rate.

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

    The impedance of long waves along z under the static load is sqrt(k m), with the stiffness k
    between a sphere and the next layer: the sum over its contacts there of k_n cos^2 + k_t sin^2,
    where k_t = 2 (1 - nu)/(2 - nu) k_n with friction and 0 without.
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
