"""Equilibrium of grains at user-defined positions under a static load, near which the static stage
starts.

FIRE, which finds the equilibrium in LAMMPS, needs more iterations for longer chains of grains, and
a chain without a guide can buckle on the way. Newton's method on the energy of elastic contacts
needs few iterations, see `granwave.lammps_inputs.statics.relax`. The stiffness leaves out the
turning of forces, so that it is never negative.

A lattice with scattered diameters under a light load has hardly more contacts than degrees of
freedom, and its contacts close one after another; it requires a path from smoothed contacts, see
`granwave.lammps_inputs.statics.smoothed`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.contact.static_load import force_of_contact, static_stiffness
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.statics.packing_bodies import loaded_bodies

_FARTHEST = 0.025  # mean diameters: where grains move farther, the static stage finds the balance
_LOOSE = 10.0  # diameter scatter of a loose lattice, divided by the overlap under its load
_MOST_GRAINS = 5000  # largest number of grains whose stiffness is factorised in about a second


@kept_by_assembly
def balanced_displacements(assembly: Assembly) -> NDArray[np.float64] | None:
    """Return the displacements of the grains to approximate equilibrium: (n, 3), m.

    None for packings whose equilibrium is found only by the static stage: lattices that are not
    loose, many grains, walls that move to a force or are movable, and strikers.
    """
    in_file = _is_file_in_balance(assembly)
    if not _is_searched(assembly) or not (in_file or _is_loose_lattice(assembly)):
        return None
    # they load scipy.sparse, which takes longer than most commands need
    from granwave.lammps_inputs.statics.energy import EnergyProblem
    from granwave.lammps_inputs.statics.relax import fall
    from granwave.lammps_inputs.statics.smoothed import follow_smoothing

    bodies = loaded_bodies(assembly).elastic()
    problem = EnergyProblem(bodies)
    start = np.zeros(problem.n)
    if in_file:
        unknowns, _ = fall(problem, start, _FARTHEST * bodies.spacing)
    else:
        unknowns, _ = follow_smoothing(problem, start, _overlap(assembly))
    position, _ = problem.state(unknowns)
    return np.asarray(position - bodies.position)


def _is_searched(assembly: Assembly) -> bool:
    """Return True for few grains under static loads, without movable walls and strikers."""
    case = assembly.case
    stage = case.precompression
    if stage is None or stage.presses or case.settles_damped or case.striker or case.has_cohesion:
        return False
    if case.boundary.bottom_support is not None or case.load.plate is not None:
        return False
    return len(assembly.ids) <= _MOST_GRAINS


def _is_file_in_balance(assembly: Assembly) -> bool:
    """Return True for grains of a file that are brought to equilibrium."""
    way = assembly.case.packing.contact_way
    return way is not None and way.balances and isinstance(assembly.lattice, Places)


def _is_loose_lattice(assembly: Assembly) -> bool:
    """Return True for a lattice whose gaps are much larger than the overlaps under its load, so
    that it has hardly more contacts than degrees of freedom.
    """
    case = assembly.case
    stage = case.precompression
    if stage is None or isinstance(assembly.lattice, Places) or stage.rule.on_all_faces:
        return False
    if stage.moves_walls or stage.is_overlaps_alone:
        return False
    return case.packing.diameter_scatter > _LOOSE * _overlap(assembly)


def _overlap(assembly: Assembly) -> float:
    """Return the overlap of a contact under the load, m."""
    return 1.5 * force_of_contact(assembly) / static_stiffness(assembly)
