"""Force that a sensor reads: the mean of the forces of its bead's two contacts in a chain, its acceleration elsewhere.

A transducer glued between the halves of a bead feels the force between them, which for slow pulses is about that mean.
At an end of the chain, where there is one contact, half of its force.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.reader import Result

Arrays = dict[str, NDArray[np.float64]]


def sensor_forces(result: Result) -> Arrays:
    """Force of every sensor of a run at the instants of ``/chain/time``, by its name: (n_times,), N."""
    ends = result["chain/contact_i"], result["chain/contact_j"]
    force = result["chain/contact_force"]
    return {
        sensor.name: 0.5 * force[:, (ends[0] == sensor.id) | (ends[1] == sensor.id)].sum(axis=1)
        for sensor in result.case.sensor
    }


def sensor_accelerations(result: Result) -> Arrays:
    """Acceleration of every sensor of a packing, by its name: (n_times, 3), m/s^2.

    Parameters
    ----------
    result
        Of a run, ``run.result``, whose ``["probes/time"]`` are the instants.
    """
    found = {}
    for name, sphere, force in _probed(result, "f"):
        row = int(result.rows(sphere))
        found[name] = force / result.rows_read("spheres/mass", slice(row, row + 1))[0]
    return found


def sensor_velocities(result: Result) -> Arrays:
    """Velocity of every sensor of a packing, by its name: (n_times, 3), m/s.

    Parameters
    ----------
    result
        Of a run, ``run.result``, whose ``["probes/time"]`` are the instants.
    """
    return {name: velocity for name, _, velocity in _probed(result, "v")}


def _probed(result: Result, quantity: str) -> Iterator[tuple[str, int, NDArray[np.float64]]]:
    for sensor in result.case.sensor:
        if f"probes/sphere_{sensor.id}_{quantity}x" in result:
            parts = [result[f"probes/sphere_{sensor.id}_{quantity}{axis}"] for axis in "xyz"]
            yield sensor.name, sensor.id, np.stack(parts, axis=1)
