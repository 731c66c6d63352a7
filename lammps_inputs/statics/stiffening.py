"""Beds that were settled with soft grains, and receive a hard material.

The overlaps of a settled bed carry its weight. With a modulus that is a thousand times larger the
contact forces would be a thousand times larger, and the bed would burst. The grains move as little
as possible (least squares) until each contact carries its force in the soft bed: the overlap of
Hertz's law shrinks with the power -2/3 of the modulus. Friction and weight then stay in balance, up
to the small turn of the contacts.

The ratio f of the forces follows from moments, sum_c f F_c d_c + sum_i x_i . L_i = 0,
with the normal forces F_c of the overlaps in the material of the case, the distances d_c of the
centres, and the loads L_i and friction of the walls on grains at x_i. Tangential forces of pairs
have no moment of this kind.

A bed without friction has hardly more contacts than it needs. The new directions of its contacts
(turned by up to 3 %) disturb its equilibrium: it rearranges, and Newton's method follows it to a
new equilibrium (`granwave.lammps_inputs.statics.smoothed`).
"""

from __future__ import annotations

import dataclasses
import logging

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.packing.contact_ways import KEY
from granwave.lammps_inputs.case.packing.springs import parse_springs
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.statics.bodies import Array, Bodies, NeighbourPairs
from granwave.lammps_inputs.statics.packing_bodies import loaded_bodies

_LOG = logging.getLogger("granwave")
_SOFT = 1 / 3  # ratio of forces below which a bed was settled with a softer material
_OF_FORCE = 2 / 3  # power of the force with which the overlap grows under Hertz's law
_SETTLED = 0.01  # largest net force of a settled bed / its largest contact force
_MOST_GRAINS = 1000  # largest number of grains of a bed without friction: these take a minute
_MANY_GRAINS = 300  # number of grains above which the search is announced
# what to do with a bed without friction that finds no balance
_SETTLE_AS_RUN = (
    "pour or settle the bed with the Young's modulus of the run, or run it with the modulus with "
    "which it was settled"
)
_ROUNDS = 60  # most iterations of the least squares
_DAMPING = 0.03  # damping of the least squares: bounds motions that hardly change an overlap
_CLOSED = 1e-4  # largest error of an overlap / mean one, at which the iterations end
_PRECISION = 1e-10  # precision of the least squares
_MOST_ITERATIONS = 20_000
_REACH = 4.0  # gap up to which grains may come to touch on the way, largest overlaps


@dataclasses.dataclass(frozen=True, eq=False)
class StiffenedBed:
    """Grains of a soft bed, moved to the overlaps of a hard material.

    Attributes
    ----------
    position
        Centres of all grains: (n, 3), m.
    ratio
        Modulus of the case / modulus of the bed.
    before, after
        Largest overlap in the soft bed and with the material of the case, m.
    moved
        Largest displacement of a grain, m.
    rearranged
        True for a bed without friction, which finds a new balance; False for one whose contacts
        keep their forces.
    """

    position: Array
    ratio: float
    before: float
    after: float
    moved: float
    rearranged: bool = False

    def case_of(self, case: Case) -> Case:
        """Return the case with the grains at these positions."""
        packing = case.packing
        assert packing.grains is not None
        found = packing.grains.found or packing.grains
        grains = dataclasses.replace(packing.grains, position=self.position, found=found)
        return dataclasses.replace(case, packing=dataclasses.replace(packing, grains=grains))

    @property
    def note(self) -> str:
        """Sentence for the user."""
        why = ""
        if self.rearranged:
            why = " (without friction they rearrange until they are in equilibrium)"
        return (
            f"{_pressing(self.ratio)}: the grains move by up to {self.moved:.2g} m{why}, so that "
            f"the largest overlap shrinks from {self.before:.2g} m to {self.after:.2g} m"
        )


def stiffened_bed(assembly: Assembly) -> StiffenedBed | None:
    """Return the grains of a soft bed at the overlaps of the material of the case; None for a bed
    that already has these overlaps, or that no damped stage brings to equilibrium.
    """
    if not _may_be_soft(assembly):
        return None
    bodies = loaded_bodies(assembly).elastic()
    contacts = bodies.near(bodies.position, bodies.periods, 0.0)
    ratio = _ratio_of_forces(bodies, contacts, _friction_of_walls(assembly))
    if not 0 < ratio < _SOFT:
        return None
    largest = float(contacts.overlap.max())
    shrink = ratio**_OF_FORCE
    targets = dict(zip(_keys(contacts), (shrink * contacts.overlap).tolist(), strict=True))
    position = _moved_to(bodies, targets, largest)
    moved = np.linalg.norm(position - bodies.position, axis=1)
    return StiffenedBed(position, 1 / ratio, largest, shrink * largest, float(moved.max()))


@kept_by_assembly
def hardened_without_friction(assembly: Assembly) -> float:
    """Return the modulus of the case divided by the modulus with which a bed without friction was
    settled; 1 for all other packings.

    The forces of such a bed, divided by the ratio of moduli, are in equilibrium with its weight;
    forces of overlaps by rounding are not.
    """
    if not _may_be_soft_without_friction(assembly):
        return 1.0
    bodies = loaded_bodies(assembly).elastic()
    contacts = bodies.near(bodies.position, bodies.periods, 0.0)
    ratio = _ratio_of_forces(bodies, contacts, np.zeros_like(bodies.position))
    if not 0 < ratio < _SOFT:
        return 1.0
    # it loads scipy.sparse, which takes longer than most commands need
    from granwave.lammps_inputs.statics.energy import EnergyProblem

    as_settled = dataclasses.replace(bodies, dead_load=bodies.dead_load / ratio)
    problem = EnergyProblem(as_settled)
    state = problem.at(np.zeros(problem.n))
    net = float(np.abs(state.gradient[: problem.n_motions]).max(initial=0.0))
    return 1 / ratio if net < _SETTLED * state.largest else 1.0


def rearranged_bed(assembly: Assembly) -> StiffenedBed | None:
    """Return the grains of a soft bed without friction in equilibrium with the material of the
    case; None for all other packings.

    Raises
    ------
    InputError
        The bed is too large, or finds no balance.
    """
    ratio = hardened_without_friction(assembly)
    if ratio == 1:
        return None
    n_grains = assembly.lattice.n_spheres
    if n_grains > _MOST_GRAINS:
        found = f"found more than {_MOST_GRAINS} grains without friction"
        raise InputError(f"{assembly.case.name}: {_pressing(ratio)}; {found}; {_SETTLE_AS_RUN}")
    # they load scipy.sparse, which takes longer than most commands need
    from granwave.lammps_inputs.statics.energy import EnergyProblem
    from granwave.lammps_inputs.statics.smoothed import (
        follow_smoothing,
        is_balanced,
        largest_net_force,
    )

    if n_grains > _MANY_GRAINS:
        _LOG.warning(
            "%s: searching for an equilibrium of the bed without friction (1000 grains: about a "
            "minute)",
            assembly.case.name,
        )
    bodies = loaded_bodies(assembly).elastic()
    before = bodies.near(bodies.position, bodies.periods, 0.0).overlap
    problem = EnergyProblem(bodies, with_turning=True)
    typical = float(np.median(before)) * ratio**-_OF_FORCE
    unknowns, state = follow_smoothing(problem, np.zeros(problem.n), typical)
    if not is_balanced(state):
        part = largest_net_force(state) / state.largest if state.largest else np.inf
        raise InputError(
            f"{assembly.case.name}: {_pressing(ratio)}; without friction the grains rearrange, "
            f"and a net force of {part:.1g} of the largest contact force remains; {_SETTLE_AS_RUN}"
        )
    position, _ = problem.state(unknowns)
    moved = float(np.linalg.norm(position - bodies.position, axis=1).max())
    after = float(state.contacts.overlap.max())
    return StiffenedBed(position, ratio, float(before.max()), after, moved, rearranged=True)


def _pressing(ratio: float) -> str:
    """Return the text for overlaps whose forces exceed the load by a ratio."""
    return (
        f"{KEY}: the forces of the overlaps are {ratio:.0f} times as large as the load, as in a "
        f"bed that was settled with a Young's modulus {ratio:.0f} times smaller"
    )


def _may_be_soft_without_friction(assembly: Assembly) -> bool:
    """Return True for spheres without friction under gravity, which a search
    brings to equilibrium.
    """
    case = assembly.case
    stage = case.precompression
    way = case.packing.contact_way
    if case.settles_damped or case.contact.friction or way is None or not way.balances:
        return False
    return stage is not None and stage.rule.grows_with_depth and _are_loaded_spheres(case)


def _may_be_soft(assembly: Assembly) -> bool:
    """Return True for spheres under dead loads that a damped stage brings to equilibrium."""
    return assembly.case.settles_damped and _are_loaded_spheres(assembly.case)


def _are_loaded_spheres(case: Case) -> bool:
    """Return True for single spheres of a file, under dead loads, without cohesion."""
    packing = case.packing
    stage = case.precompression
    if packing.grains is None or stage is None or stage.presses:
        return False
    if packing.restart is not None or packing.has_clumps or case.has_cohesion:
        return False
    return not any(packing.grains.shape)


def _friction_of_walls(assembly: Assembly) -> Array:
    """Return the forces of the tangential springs between grains and walls: (n, 3), N."""
    force = np.zeros((len(assembly.ids), 3))
    text = assembly.case.packing.springs
    for spring in parse_springs(text) if text else ():
        if isinstance(spring.first, str) and spring.second <= len(force):
            force[spring.second - 1] += spring.force
    return force


def _ratio_of_forces(bodies: Bodies, contacts: NeighbourPairs, friction: Array) -> float:
    """Return the ratio of the forces in the bed to the forces of the overlaps; 0 without forces.

    Parameters
    ----------
    friction
        Forces of the walls along their surfaces, as far as they are known: (n, 3), N.
    """
    force = np.zeros(len(contacts))
    for law, rows, scale in bodies.laws_of(contacts):
        force[rows], _, _ = law.evaluate(contacts.overlap[rows], scale)
    height = bodies.position - _origin(bodies)
    pairs = contacts.second >= 0
    along = (height[contacts.first] * contacts.normal).sum(axis=1)
    arm = np.where(pairs, contacts.distance, -along)
    virial = float((force * arm).sum())
    n = len(height)
    load = float((height * (bodies.dead_load + friction[:n])).sum())
    return -load / virial if virial else 0.0


def _origin(bodies: Bodies) -> Array:
    """Return the middle of the bottom of the grains: (3,), m."""
    low = bodies.position.min(axis=0)
    high = bodies.position.max(axis=0)
    middle = (low + high) / 2
    return np.array([middle[0], middle[1], high[2]])


def _keys(contacts: NeighbourPairs) -> list[tuple[object, ...]]:
    """Return the identifiers of each contact: its grains, their cells and the wall."""
    columns = (contacts.first, contacts.second, contacts.wall)
    images = map(tuple, contacts.image.tolist())
    return list(zip(*(column.tolist() for column in columns), images, strict=True))


def _moved_to(bodies: Bodies, targets: dict[tuple[object, ...], float], largest: float) -> Array:
    """Return the centres, moved as little as possible, at which contacts have their overlaps.

    Parameters
    ----------
    targets
        Overlaps of the contacts by their keys, m; others may only touch.
    largest
        Largest overlap at the start, m.
    """
    # imported on demand: scipy is slow to load
    from scipy.sparse.linalg import lsqr

    from granwave.lammps_inputs.statics.energy import EnergyProblem

    problem = EnergyProblem(bodies)
    closed = _CLOSED * float(np.mean(list(targets.values())))
    position = bodies.position.copy()
    for _ in range(_ROUNDS):
        contacts = bodies.near(position, bodies.periods, _REACH * largest)
        target = np.array([targets.get(key, 0.0) for key in _keys(contacts)])
        error = contacts.overlap - target
        rows = (target > 0) | (error > 0)
        most = float(np.abs(error[rows]).max())
        if most <= closed:
            break
        matrix = problem.stretch(contacts, contacts.normal)[rows]
        step = lsqr(
            matrix,
            error[rows] / most,
            damp=_DAMPING,
            atol=_PRECISION,
            btol=_PRECISION,
            conlim=0,
            iter_lim=_MOST_ITERATIONS,
        )[0]
        longest = most * float(np.abs(step).max())
        position[problem.free] += min(1.0, largest / longest) * most * step
    return position
