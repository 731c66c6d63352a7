"""Arrival of the wave at the beads of a chain with recorded forces.

The wave arrives at a contact when its force has risen by 10 % of the peak of the first pulse there.
The first pulse has passed once the force has fallen by 1 % of its largest rise so far. Later
pulses, which may be larger, the reflection and the end of the run do not change the arrival.

Contacts record the time at which they carried 10 % of their largest force of the run. This time is
used where the largest force is of the first pulse, and where the records are too far apart to show
the pulse. Elsewhere the arrival is interpolated in the fourth root of the recorded force, which
rises about evenly in a solitary wave.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Array, arrivals
from granwave.analysis.result.contacts import ARRIVED
from granwave.analysis.result.reader import Result

_FALLEN = 0.01  # fraction of the peak by which the force has fallen after the first pulse
_LEAST = 1e-4  # fraction of the largest rise of all: the wave did not reach contacts with less
_LEAST_STATIC = 1e-2  # the same under a static load
_ROOT = 0.25  # power of a force that rises about evenly in a solitary wave
_RECORDED = 0.9  # fraction of the largest force that records of a resolved pulse show
_RIPPLE = 0.1  # fraction of that least rise: smaller maxima are no pulses


def has_recorded_chain(result: Result) -> bool:
    """Return True for a chain of beads with recorded forces of all contacts."""
    return (
        "chain" in result
        and "chain/contact_force" in result
        and len(result["chain/id"]) == result.n_spheres
        and len(result["chain/contact_i"]) > 0
    )


def contact_arrivals(result: Result) -> Array:
    """Return the arrival of the wave at the contacts of a recorded chain: (n_contacts,), s; NaN
    where the first pulse has not passed before the end.
    """
    time = result["chain/time"]
    force = result["chain/contact_force"]
    is_static = result.case.precompression is not None
    rise = np.maximum(force - force[0], 0.0) if is_static else force
    least = (_LEAST_STATIC if is_static else _LEAST) * float(rise.max(initial=0.0))
    end = first_pulse_ends(rise, _RIPPLE * least)
    until = np.arange(len(time))[:, None] < end
    peak = rise.max(axis=0, initial=0.0, where=until)
    has_passed = (end < len(time)) & (peak >= least) & (peak > 0)
    level = np.where(has_passed, ARRIVED * peak, np.inf)
    arrival = arrivals(time, rise**_ROOT, level**_ROOT)
    if is_static:
        return arrival
    exact = result.along_chain("time_first")
    when = result.along_chain("time_peak")
    largest = result.along_chain("peak_force")
    is_coarse = rise.max(axis=0, initial=0.0) < _RECORDED * largest
    is_exact = is_coarse & (when < time[-1]) & (largest >= _LEAST * largest.max(initial=0.0))
    if "contacts/viscous_energy" not in result:  # otherwise their times are without losses
        is_exact |= has_passed & (when <= time[np.minimum(end, len(time) - 1)])
    return np.where(is_exact & np.isfinite(exact), exact, arrival)


def first_pulse_ends(rise: Array, least: float) -> NDArray[np.int64]:
    """Return the row in which each force has fallen by 1 % from the peak of its first pulse, the
    number of rows where it has not: (n_contacts,).

    Parameters
    ----------
    rise
        Of the forces: (n_times, n_contacts), N.
    least
        Peak of the smallest pulse, N.
    """
    largest = np.maximum.accumulate(rise, axis=0)
    has_fallen = (largest > least) & (rise <= (1 - _FALLEN) * largest)
    return np.where(has_fallen.any(axis=0), has_fallen.argmax(axis=0), len(rise))


def bead_arrivals(result: Result) -> Array:
    """Return the arrival of the wave at the beads of a recorded chain: (n_spheres,), s; NaN where
    it has not arrived. It is the arrival at the contact of the bead on the side of the load, and at
    a loaded bead that at its first contact.
    """
    arrival = contact_arrivals(result)
    above = np.full(result.n_spheres, np.nan)
    below = np.full(result.n_spheres, np.nan)
    for name, times in (("chain/contact_j", above), ("chain/contact_i", below)):
        ids = result[name]
        is_bead = ids <= result.n_spheres
        times[result.rows(ids[is_bead])] = arrival[is_bead]
    height = result["spheres/position"][:, 2]
    loaded = result.rows(np.array(result.struck, dtype=np.int64))
    heights = height[loaded] if len(loaded) else np.array([height.min()])
    offset = height[:, None] - heights
    nearest = np.abs(offset).argmin(axis=1)
    is_below = offset[np.arange(len(height)), nearest] > 0
    times = np.where(is_below, above, below)
    times[loaded] = np.fmin(above, below)[loaded]
    return times
