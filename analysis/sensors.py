"""What a sensor in a bead of a chain reads: the mean of the forces of the bead's two contacts.

A transducer glued between the halves of a bead feels the force between them, which for slow pulses is about that mean.
At an end of the chain, where there is one contact, half of its force.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result import Result


def sensor_forces(result: Result) -> dict[str, NDArray[np.float64]]:
    """Force of every sensor of a run at the instants of ``/chain/time``, by its name: (n_times,), N."""
    ends = result["chain/contact_i"], result["chain/contact_j"]
    force = result["chain/contact_force"]
    return {
        sensor.name: 0.5 * force[:, (ends[0] == sensor.id) | (ends[1] == sensor.id)].sum(axis=1)
        for sensor in result.case.sensor
    }
