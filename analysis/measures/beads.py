"""Beads of a chain to which grains were added next to its axis: rings in a tube, rods between
walls.

The beads carry the wave: the peak forces of their contacts and their times are those between two
beads. The added grains have smaller forces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.dynamic_force import BEFORE_END
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.added_grains import has_added_to_chain

_ON_AXIS = 1e-6  # distance over the nominal diameter, of grains on the axis
_FEWEST = 2  # fewest beads with a contact


def beads_on_axis(result: Result) -> NDArray[np.bool_] | None:
    """Return True for the beads of a chain with added grains next to its axis, False for these
    grains: (n_spheres,). None for other packings.
    """
    packing = result.case.packing
    if not has_added_to_chain(packing.source or ""):
        return None
    offset = result["spheres/position"][:, :2] - result.impact_axis
    is_bead: NDArray[np.bool_] = np.hypot(*offset.T) < _ON_AXIS * packing.diameter
    is_bead &= result.in_packing
    if np.count_nonzero(is_bead) < _FEWEST or np.array_equal(is_bead, result.in_packing):
        return None
    return is_bead


def bead_peaks(result: Result) -> Array:
    """Return the largest rise of the force between each two neighbouring beads, in the order of the
    depth, above its static value: (n_beads - 1,), N. It is NaN where the force still rises at the
    end of the run, and 0 above the impacted bead, where the wave does not go down. Empty without
    added grains.
    """
    is_bead = beads_on_axis(result)
    if is_bead is None:
        return np.empty(0)
    above, below, depth = bead_pairs(result, is_bead)
    peak = result.of_pairs("peak_force", above, below)
    if result.case.precompression is not None:
        peak = peak - result.of_pairs("initial_force", above, below)
    when = result.of_pairs("time_peak", above, below)
    is_complete = when < BEFORE_END * float(result["energy/time"][-1])
    return np.where(depth > 0, np.where(is_complete, peak, np.nan), 0.0)


def bead_contact_depths(result: Result) -> Array:
    """Return the depths of the contacts of `bead_peaks` below the impacted bead: (n_beads - 1,),
    m.
    """
    is_bead = beads_on_axis(result)
    return np.empty(0) if is_bead is None else bead_pairs(result, is_bead)[2]


def bead_pairs(
    result: Result, is_bead: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Return the ids of the upper and of the lower bead of each contact of two beads, and the depth
    of its middle below the impacted bead, m: (n_beads - 1,) each.
    """
    depth = result["spheres/position"][is_bead, 2] - result.origin[2]
    order = np.argsort(depth)
    ids = result["spheres/id"][is_bead][order]
    depth = depth[order]
    return ids[:-1], ids[1:], 0.5 * (depth[1:] + depth[:-1])
