"""Balance of grains at user-defined positions under a static load, near which the static stage
starts.

FIRE, which finds the balance in LAMMPS, takes the more iterations the longer a row of grains is,
and lets a row without a guide buckle on the way. Newton's method on the energy of elastic contacts
takes few, see `granwave.lammps_inputs.statics.relax`. The stiffness leaves out the turning of
forces, so that it is never negative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.statics.packing_bodies import loaded_bodies

_FARTHEST = 0.025  # mean diameters: where grains move farther, the static stage finds the balance
_MOST_GRAINS = 5000  # whose stiffness is factorised in a second or so


@kept_by_assembly
def balanced_displacements(assembly: Assembly) -> NDArray[np.float64] | None:
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
    # they load scipy.sparse, which takes longer than most commands need
    from granwave.lammps_inputs.statics.energy import EnergyProblem
    from granwave.lammps_inputs.statics.relax import fall

    bodies = loaded_bodies(assembly).elastic()
    problem = EnergyProblem(bodies)
    farthest = _FARTHEST * bodies.spacing
    unknowns, _ = fall(problem, np.zeros(problem.n), farthest)
    position, _ = problem.state(unknowns)
    return np.asarray(position - bodies.position)
