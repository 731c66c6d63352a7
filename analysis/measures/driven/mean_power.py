"""Mean power that a harmonic load puts into a packing, and that leaves it at its absorbing ends.

Both are slopes of energies of the ledger against time, by least squares over the last half of the run, so that what
goes to and fro within a period does not count.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.checks.loads import LEAST_PERIODS

_LEAST = 8  # instants that a slope is fitted to
_ENDS = ("energy/absorbed", "energy/support_lost")


@dataclasses.dataclass(frozen=True)
class MeanPower:
    """Mean power in the last half of a run.

    Attributes
    ----------
    given
        Work of the load over time, W.
    absorbed
        Taken by the spheres of ``[[absorb]]`` and by the damper below, W; None where there is neither.
    """

    given: float
    absorbed: float | None


def mean_power_of(result: Result) -> MeanPower | None:
    """Return the mean power of a harmonic load; None for other loads, and for runs of fewer than some periods."""
    load, time = result.case.load, result["energy/time"]
    if not load.driven or load.shape != "harmonic":
        return None
    later = time >= time[-1] / 2
    if np.count_nonzero(later) < _LEAST or time[-1] / 2 * load.frequencies[1] < LEAST_PERIODS:
        return None
    since = time[later] - time[later].mean()

    def slope(name: str) -> float:
        energy = result[name][later]
        return float(since @ (energy - energy.mean()) / (since @ since))

    ends = [slope(name) for name in _ENDS if name in result]
    return MeanPower(slope("energy/input"), sum(ends) if ends else None)
