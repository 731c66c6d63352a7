"""The first wave along a chain, before the reflection from the end: peak forces of contacts, and
speeds in stretches of one material and diameter.

The reflection starts when the wave arrives at the end of the chain: once the force on the bottom,
or on the last contact without one, has risen by 1 % of its largest rise. Contacts whose force has
fallen again by then carried the first wave only.
"""

from __future__ import annotations

import numpy as np

from granwave.analysis.measures.fronts import line_motions
from granwave.analysis.measures.regions import stretches
from granwave.analysis.measures.signals import Array, arrival
from granwave.analysis.measures.target_record import ARRIVED, reached
from granwave.analysis.result.reader import Result

_LEAD = 5  # beads, including the impacted one, in which the wave takes its shape
_FEWEST_BEADS = 4  # fewest beads of a speed
_REACHED = 1e-3  # fraction of the largest rise of all: the wave has reached the contact


def leading_peaks(result: Result) -> Array:
    """Return the largest rise of the force of each contact of a chain in the first wave, above the
    static force: (n_contacts,), N; 0 where the wave has not passed before the end of the run, NaN
    where the reflection came before the force had passed its peak.
    """
    time = result["chain/time"]
    force = result["chain/contact_force"]
    if not force.shape[1]:
        return np.empty(0)
    static = force[0] if result.case.precompression is not None else np.zeros(force.shape[1])
    rise = np.maximum(force - static, 0.0)
    start = _reflection_start(result, time, rise)
    n_rows = len(time) if start is None else int(np.searchsorted(time, start, side="right"))
    first = rise[:n_rows]
    if not first.size:
        return np.full(force.shape[1], np.nan)
    peaks = first.max(axis=0)
    is_complete = first.argmax(axis=0) < n_rows - 1
    exact = np.maximum(result.along_chain("peak_force") - static, 0.0)
    is_of_first = result.along_chain("time_peak") <= time[n_rows - 1]
    peaks = np.where(is_of_first, exact, peaks)
    return np.where(is_complete, peaks, 0.0 if start is None else np.nan)


def _reflection_start(result: Result, time: Array, rise: Array) -> float | None:
    """Return the time at which the wave arrives at the end of the chain, s; None: never."""
    least = _REACHED * float(rise.max(initial=0.0))
    target = reached(result)
    if target is not None:
        return target.arrival if target.dynamic_peak_force > least else None
    last = rise[:, -1]
    largest = float(last.max(initial=0.0))
    if largest <= least:
        return None
    return arrival(time, last, ARRIVED * largest)


def has_first_wave(result: Result) -> bool:
    """Return True for a chain of beads with recorded forces, under a load that does not keep
    oscillating: its first wave has a peak at each contact.
    """
    return (
        "chain" in result
        and len(result["chain/id"]) == result.n_spheres
        and len(result["chain/contact_i"]) > 0
        and not result.case.load.keeps_oscillating
    )


def leading_peaks_of_spheres(result: Result) -> Array:
    """Return the largest of `leading_peaks` at the contacts of each bead of a chain, with bars:
    (n_spheres,), N; NaN where the force of a contact of the bead is not known.
    """
    peaks = leading_peaks(result)
    largest = np.zeros(result.n_spheres)
    is_known = np.ones(result.n_spheres, dtype=bool)
    for name in ("chain/contact_i", "chain/contact_j"):
        ids = result[name]
        is_bead = ids <= result.n_spheres
        rows = result.rows(ids[is_bead])
        np.fmax.at(largest, rows, peaks[is_bead])
        is_known[rows[~(peaks[is_bead] > 0)]] = False
    return np.where(is_known, largest, np.nan)


def stretch_speeds(result: Result) -> dict[str, float]:
    """Return the speed of the wave front in each stretch of a chain of one material and diameter,
    m/s, by its name; empty for a uniform chain. Stretches with fewer than four beads below the five
    uppermost, or with no arrival there, are omitted.
    """
    parts = stretches(result)
    motions = line_motions(result, result.origin, np.array([0.0, 0.0, 1.0])) if parts else []
    if not motions:
        return {}
    motion = motions[0]
    is_known = np.isfinite(motion.arrival)
    is_known[:_LEAD] = False
    speeds = {}
    for name, ids in parts.items():
        inside = is_known & np.isin(motion.ids, ids)
        if np.count_nonzero(inside) >= _FEWEST_BEADS and np.ptp(motion.arrival[inside]) > 0:
            slope = np.polyfit(motion.arrival[inside], motion.place[inside], 1)[0]
            speeds[name] = float(slope)
    return {name: speed for name, speed in speeds.items() if speed > 0}
