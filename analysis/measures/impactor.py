"""Velocity of the impacted spheres, or of the moving strikers, at the end of a run."""

from __future__ import annotations

import numpy as np

from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.motion import velocities_of

_AT_END = 1e-9  # relative tolerance of the time of a snapshot at the end


def impactor_velocity(result: Result) -> float | None:
    """Return the velocity of the loaded spheres at the end along the load, m/s; negative after a
    rebound.

    The energy record has the component along the load, which is along z for strikers. The velocity
    of strikers that move in a plane across z is that of the last snapshot, along their own
    direction at the start; None without a snapshot at the end.
    """
    way = _way_across(result)
    if way is None:
        return float(result["energy/struck_velocity"][-1])
    end = float(result["energy/time"][-1])
    if not result.n_frames or result.frame_times[-1] < (1 - _AT_END) * end:
        return None
    rows = result.rows(np.array(result.struck))
    mass = result["spheres/mass"][rows]
    velocity = result.frame(result.n_frames - 1, "velocity")[rows]
    return float(mass @ (velocity @ way) / mass.sum())


def _way_across(result: Result) -> Array | None:
    """Return the direction of strikers that move across z, a unit vector: (3,); None for other
    loads.
    """
    if not result.case.striker:
        return None
    velocities = velocities_of(result.assembly)
    rows = result.rows(np.array(result.struck))
    moving = np.array([velocities.get(sphere, (0.0, 0.0, 0.0)) for sphere in result.struck])
    momentum = result["spheres/mass"][rows] @ moving.reshape(-1, 3)
    size = float(np.linalg.norm(momentum))
    if np.any(moving[:, 2:]) or not size > 0:
        return None
    return momentum / size
