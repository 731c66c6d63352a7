"""Balance of grains at places of their own under a static load, near which the static stage starts.

FIRE, which finds the balance in LAMMPS, takes the more iterations the longer a row of grains is,
and lets a row without a guide buckle on the way. Newton's method on the energy of elastic contacts
takes few. Springs hold the grains in a step (Levenberg, 1944; Marquardt, 1963): they soften after
each step that lowers the energy or the net force, and stiffen where one would not. The stiffness
leaves out the turning of forces, so that it is never negative.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material, Shape
from granwave.lammps_inputs.contact.law import elastic_case, law_between
from granwave.lammps_inputs.contact.static_load import dead_loads, static_stiffness
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.cylinders import nearest_image, nearest_vectors, reaches
from granwave.lammps_inputs.packing.motion import held_ids
from granwave.lammps_inputs.packing.places import Places, near_pairs
from granwave.lammps_inputs.packing.walls import Wall, touched_by, walls

_MARGIN = 0.05  # mean diameters: gaps that may close; no grain moves by more than half of it
_ROUNDS = 400
_BALANCED = 1e-11  # net force over the largest contact force
_ROUNDING = 16.0  # net force by rounding over stiffness times the rounding error of a coordinate
_HOLDING = 1e-3  # stiffness of the springs that hold grains over that of a contact, at first
_SOFTEST = 1e-12
_STIFFEST = 1e9
_STIFFER = 4.0
_SOFTER = 4.0
_MOST_GRAINS = 5000  # whose stiffness is factorised in a second or so
_UNIT = (2.0, 2.0)  # m: radii of two spheres whose effective radius is 1 m

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclasses.dataclass(frozen=True, eq=False)
class LawGroup:
    """Contacts of one law.

    Attributes
    ----------
    law
        The law.
    rows
        The contacts: (n,).
    scale
        Lengths over those of the law: (n,).
    """

    law: ContactLaw
    rows: Ints
    scale: Array


@dataclasses.dataclass(frozen=True, eq=False)
class BalanceState:
    """Grains at some places: energy (J) and gradient (N), its slopes, and the largest force (N)."""

    energy: float
    gradient: Array
    stretch: Any  # derivatives of overlaps by the free displacements, sparse
    slope: Array
    largest: float

    @property
    def net(self) -> float:
        """Largest component of a net force on a grain, N."""
        return float(np.abs(self.gradient).max(initial=0.0))


@kept_by_assembly
def balanced_displacements(assembly: Assembly) -> Array | None:
    """Return the displacements of the grains by which they come near balance: (n, 3), m.

    None for packings whose balance is left to the static stage alone: lattices, many grains, walls
    that move in to a force or give way, and strikers.
    """
    case = assembly.case
    stage = case.precompression
    way = case.packing.contact_way
    if stage is None or way is None or not way.balances or stage.presses or case.settles_damped:
        return None
    yielding = case.boundary.bottom_support is not None or case.load.plate is not None
    if yielding or case.striker or not isinstance(assembly.lattice, Places):
        return None
    if len(assembly.ids) > _MOST_GRAINS or case.has_cohesion:
        return None
    return BalanceSearch(assembly).displacements()


class BalanceSearch:
    """Search for the balance of grains."""

    def __init__(self, assembly: Assembly) -> None:
        lattice = assembly.lattice
        assert isinstance(lattice, Places)
        self.assembly = assembly
        self.start = assembly.positions()
        self.radius = assembly.sphere_diameters() / 2
        self.shapes = assembly.grain_shapes()
        self.period = lattice.period
        self.reach = _MARGIN * 2 * float(self.radius.mean())
        self.free = _free(assembly)
        self.number = np.where(self.free, np.cumsum(self.free).reshape(self.free.shape) - 1, -1)
        self.load = np.zeros_like(self.start)
        ids, forces = dead_loads(assembly)
        self.load[ids - 1] = forces
        self.pairs = near_pairs(self.start, reaches(lattice.grains), self.reach, self.period)
        self.by_shapes = self._by_shapes()
        self.at_walls = list(_at_walls(assembly))
        self.groups = list(_law_groups(assembly, self.pairs))

    def displacements(self) -> Array:
        """Return the displacements of all grains: (n, 3), m."""
        x = np.zeros(int(self.free.sum()))
        if not x.size:
            return np.zeros_like(self.start)
        stiffness = static_stiffness(self.assembly)
        holding = _HOLDING * stiffness
        now = self.at(x)
        rounding = _ROUNDING * stiffness * np.finfo(float).eps * float(np.abs(self.start).max())
        for _ in range(_ROUNDS):
            if now.net <= _BALANCED * now.largest + rounding or holding > _STIFFEST * stiffness:
                break
            move = self._step(now, holding)
            if np.abs(x + move).max() > self.reach / 2:
                break  # other grains than those nearby may touch: that is left to the static stage
            there = self.at(x + move)
            if there.energy < now.energy or there.net < now.net:
                x = x + move
                now = there
                holding = max(holding / _SOFTER, _SOFTEST * stiffness)
            else:
                holding *= _STIFFER
        return self._moved(x) - self.start

    def _moved(self, x: Array) -> Array:
        """Return the centres of all grains: (n, 3), m."""
        position = self.start.copy()
        position[self.free] += x
        return position

    def _step(self, now: BalanceState, holding: float) -> Array:
        """Return a step of Newton's method between springs, at most a quarter of the margin."""
        from scipy import sparse  # takes longer to load than most commands need
        from scipy.sparse.linalg import splu

        stretch = now.stretch
        hessian = stretch.T @ sparse.diags_array(now.slope) @ stretch
        held = (hessian + holding * sparse.eye_array(hessian.shape[0])).tocsc()
        options = {"SymmetricMode": True}
        factors = splu(held, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        move = -factors.solve(now.gradient)
        longest = float(np.abs(move).max())
        return np.asarray(move * min(1.0, self.reach / 4 / longest) if longest else move)

    def at(self, x: Array) -> BalanceState:
        """Return the state of grains with these displacements of free directions."""
        from scipy import sparse  # takes longer to load than most commands need

        position = self._moved(x)
        overlap, normal = self._pairs_at(position)
        parts = [self._rows(self.pairs[:, 1], normal) - self._rows(self.pairs[:, 0], normal)]
        groups = [(group, overlap[group.rows]) for group in self.groups]
        for wall, rows, own in self.at_walls:
            parts.append(self._rows(rows, -_outward(wall, position[rows])))
            gap = wall.gaps(position[rows], self.radius[rows])
            groups += [(group, -gap[group.rows]) for group in own]
        sizes = [len(self.pairs), *(len(rows) for _, rows, _ in self.at_walls)]
        offsets = np.cumsum([0, *sizes])
        force, slope, work = np.zeros((3, offsets[-1]))
        place = [0] * len(self.groups)
        for number, (_, _, own) in enumerate(self.at_walls, start=1):
            place += [number] * len(own)
        for (group, depth), part in zip(groups, place, strict=True):
            rows = offsets[part] + group.rows
            force[rows], slope[rows], work[rows] = _evaluate(group, depth)
        stretch = sparse.vstack(parts).tocsr()
        energy = float(work.sum() - (self.load * (position - self.start)).sum())
        gradient = -(stretch.T @ force) - self.load[self.free]
        return BalanceState(energy, gradient, stretch, slope, float(force.max(initial=0.0)))

    def _pairs_at(self, position: Array) -> tuple[Array, Array]:
        """Return overlaps (n,), m, and directions from the first to the second grain (n, 3)."""
        first, second = self.pairs.T
        between = nearest_image(position[second] - position[first], self.period)
        apart = between.copy()
        beyond = np.full(len(first), -np.inf)
        for (one, other), rows in self.by_shapes.items():
            apart[rows], beyond[rows] = nearest_vectors(between[rows], one, other)
        distance = np.linalg.norm(apart, axis=1)
        overlap = np.where(beyond > 0, -np.inf, self.radius[self.pairs].sum(axis=1) - distance)
        return overlap, apart / distance[:, None]

    def _by_shapes(self) -> dict[tuple[Shape, Shape], Ints]:
        """Rows of the pairs with cylinders, by the shapes of both grains."""
        found: dict[tuple[Shape, Shape], list[int]] = {}
        if not any(self.shapes):
            return {}
        for row, (first, second) in enumerate(self.pairs.tolist()):
            found.setdefault((self.shapes[first], self.shapes[second]), []).append(row)
        return {shapes: np.array(rows) for shapes, rows in found.items()}

    def _rows(self, grains: Ints, direction: Array) -> Any:
        """Return the derivatives of the motion of grains along directions (n, 3): (n, n_free)."""
        from scipy import sparse  # takes longer to load than most commands need

        number = self.number[grains]
        kept = number >= 0
        row = np.repeat(np.arange(len(grains)), 3).reshape(-1, 3)[kept]
        shape = (len(grains), int(self.free.sum()))
        return sparse.coo_array((direction[kept], (row, number[kept])), shape=shape).tocsr()


def _free(assembly: Assembly) -> NDArray[np.bool_]:
    """Return True for the directions along which a grain moves: (n, 3)."""
    case = assembly.case
    free = np.ones((len(assembly.ids), 3), dtype=bool)
    if case.boundary.bottom_rule.holds_layer:
        free[assembly.lattice.last_layer - 1] = False
    for hold in case.holds.values():
        rows = np.asarray(held_ids(case, hold)) - 1
        for axis in hold.axes:
            free[rows, "xyz".index(axis)] = False
    return free


def _outward(wall: Wall, position: Array) -> Array:
    """Return the outward normals of a wall beside grains: (n, 3)."""
    normal = np.zeros_like(position)
    if wall.tube:
        aside = position[:, :2]
        normal[:, :2] = aside / np.maximum(np.linalg.norm(aside, axis=1), 1e-300)[:, None]
    else:
        normal[:, wall.axis] = wall.outward
    return normal


def _evaluate(group: LawGroup, overlap: Array) -> tuple[Array, Array, Array]:
    """Return force (N), slope (N/m) and work (J) of contacts with these overlaps (m)."""
    depth = np.maximum(overlap, 0.0) / group.scale
    force = np.asarray(group.law.force(depth, depth))
    slope = np.where(depth > 0, group.law.tangent_stiffness(depth, depth), 0.0)
    work = np.asarray(group.law.elastic_energy(depth, depth))
    return group.scale**2 * force, group.scale * slope, group.scale**3 * work


def _law_groups(assembly: Assembly, pairs: Ints) -> Iterator[LawGroup]:
    """Give the elastic laws of pairs of rows."""
    case = elastic_case(assembly.case)
    radii = assembly.sphere_diameters()[pairs] / 2
    body = assembly.body[assembly.present][pairs]
    swapped = body[:, 0] > body[:, 1]
    body[swapped] = body[swapped][:, ::-1]
    radii[swapped] = radii[swapped][:, ::-1]
    for kinds in np.unique(body, axis=0):
        rows = np.flatnonzero((body == kinds).all(axis=1))
        first, second = (assembly.species[kind] for kind in kinds)
        bodies = (first.material, second.material)
        yield from _groups_of(case, bodies, (first.shape, second.shape), rows, radii[rows])


def _groups_of(
    case: Case,
    materials: tuple[Material, Material | None],
    shapes: tuple[Shape, Shape],
    rows: Ints,
    radii: Array,
) -> Iterator[LawGroup]:
    """Give the laws of contacts between bodies of these materials and shapes.

    Spheres have one law, at an effective radius of 1 m; others have one for each pair of radii.
    """
    contact = case.contact_between(*materials)
    plane_strain = case.contact.line == "plane-strain"
    if not any(shapes) and not contact.entry.is_power:
        shared = 1 / (1 / radii).sum(axis=1)
        yield LawGroup(law_between(contact, materials, _UNIT), rows, shared)
        return
    sizes, which = np.unique(radii, axis=0, return_inverse=True)
    for number, (first, second) in enumerate(sizes.tolist()):
        law = law_between(
            contact, materials, (first, second), shapes=shapes, plane_strain=plane_strain
        )
        own = rows[which.ravel() == number]
        yield LawGroup(law, own, np.ones(len(own)))


def _at_walls(assembly: Assembly) -> Iterator[tuple[Wall, Ints, list[LawGroup]]]:
    """Give the walls with the rows of the grains that they act on, and the laws of these."""
    case = elastic_case(assembly.case)
    body = assembly.body[assembly.present]
    radius = assembly.sphere_diameters() / 2
    for wall in walls(assembly):
        if wall.held_layer:
            continue
        chosen = touched_by(assembly, wall)
        acts = np.ones(len(body), dtype=bool) if chosen is None else chosen.copy()
        for kind, species in enumerate(assembly.species):
            if species.shape is not None and not wall.tube:
                stands = abs(species.shape.axis[wall.axis]) > 1 / 2  # ends touch nothing
                acts &= ~(stands & (body == kind))
        rows = np.flatnonzero(acts)
        yield wall, rows, list(_groups_at_wall(assembly, case, wall, body[rows], radius[rows]))


def _groups_at_wall(
    assembly: Assembly, case: Case, wall: Wall, body: NDArray[np.int16], radius: Array
) -> Iterator[LawGroup]:
    flat = wall.effective_radii(radius)
    for kind in np.unique(body):
        species = assembly.species[kind]
        rows = np.flatnonzero(body == kind)
        radii = np.stack([flat[rows], np.full(len(rows), np.inf)], axis=1)
        bodies = (species.material, wall.material)
        yield from _groups_of(case, bodies, (species.shape, None), rows, radii)
