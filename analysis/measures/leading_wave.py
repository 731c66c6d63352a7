"""The first wave along a chain, before the reflection from the end: peak forces of contacts, and
speeds in stretches of one material and diameter.

The reflection starts when the wave arrives at the end of the chain: once the force on the bottom,
or on the last contact without one, has risen by 1 % of its largest rise. The first wave is recorded
until then, or until the end of the run.

The first pulse is not always the largest. In a chain that yields, a larger pulse can follow at some
distance, and the record can end between the two. The peak of a contact is known only if

* its force has fallen again at the end of the record, and
* no larger pulse is on its way. The wave arrived at the contact k at the time T_k, and at a contact
  j before it at T_j. The record, which ends at t, shows t - T_k of the wave at k. The part of the
  wave at j that is later than T_j + t - T_k has not passed k. The largest force of this part must
  not be more than 1 % above the peak of k.

Waves behind the front are assumed to travel no faster than the front, and not to grow by more than
that. In 25 chains of 15 to 60 beads (elastic, damped and yielding; brass, steel and aluminium; with
a wall, held or free at the end; preloaded, with a heavy first bead, with two materials, under force
pulses) known peaks are within 1 % of the peaks of chains of 100 to 110 beads. The largest forces
before the reflection, without this condition, were up to 45 % too small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.fronts import line_motions
from granwave.analysis.measures.regions import stretches
from granwave.analysis.measures.signals import Array, arrival, arrivals
from granwave.analysis.measures.target_record import ARRIVED, reached
from granwave.analysis.result.reader import Result

_LEAD = 5  # beads, including the impacted one, in which the wave takes its shape
_FEWEST_BEADS = 4  # fewest beads of a speed
SAME_PEAK = 0.01  # a pulse that is larger by this fraction of the peak is larger
REACHED = 1e-3  # fraction of the largest rise of all: the wave has reached the contact


@dataclass(frozen=True, eq=False)
class FirstWave:
    """Peak forces of the first wave along a chain; arrays (n_contacts,).

    Attributes
    ----------
    peak
        Largest rise of the force above its static value before the reflection, N.
    is_known
        True where the wave has passed: the force has fallen again, and no larger pulse is on its
        way.
    is_passing
        True where the force has fallen again, and a larger pulse may still come.
    reflection
        Time at which the wave arrives at the end of the chain, s; None: not before the end of the
        run.
    """

    peak: Array
    is_known: NDArray[np.bool_]
    is_passing: NDArray[np.bool_]
    reflection: float | None


def first_wave(result: Result) -> FirstWave:
    """Return the peak forces of the first wave along a chain."""
    time = result["chain/time"]
    force = result["chain/contact_force"]
    n_contacts = force.shape[1]
    nowhere = np.zeros(n_contacts, dtype=bool)
    static = force[0] if result.case.precompression is not None else np.zeros(n_contacts)
    rise = np.maximum(force - static, 0.0)
    start = _reflection_start(result, time, rise) if n_contacts else None
    n_rows = len(time) if start is None else int(np.searchsorted(time, start, side="right"))
    record = rise[:n_rows]
    if not record.size:
        return FirstWave(np.full(n_contacts, np.nan), nowhere, nowhere, start)
    has_fallen = record.argmax(axis=0) < n_rows - 1
    exact = np.maximum(result.along_chain("peak_force") - static, 0.0)
    is_of_first = result.along_chain("time_peak") <= time[n_rows - 1]
    peak = np.where(is_of_first, exact, record.max(axis=0))
    is_awaited = _awaits_larger_pulse(time[:n_rows], record)
    return FirstWave(peak, has_fallen & ~is_awaited, has_fallen & is_awaited, start)


def leading_peaks(result: Result) -> Array:
    """Return the largest rise of the force of each contact of a chain in the first wave, above the
    static force: (n_contacts,), N; 0 where the wave has not passed before the end of the run, NaN
    where it has not passed before the reflection.
    """
    return known_peaks(first_wave(result))


def known_peaks(wave: FirstWave) -> Array:
    """Return the peak forces of a wave: (n_contacts,), N; 0 or NaN where not known, as
    `leading_peaks`.
    """
    return np.where(wave.is_known, wave.peak, 0.0 if wave.reflection is None else np.nan)


def _awaits_larger_pulse(time: Array, rise: Array) -> NDArray[np.bool_]:
    """Return True for contacts at which a pulse larger than all so far may still arrive, from
    contacts that the wave reached before: (n_contacts,).

    Parameters
    ----------
    time, rise
        Record of the first wave: (n_times,), s, and (n_times, n_contacts), N.
    """
    peak = rise.max(axis=0)
    arrived = arrivals(time, rise, np.maximum(ARRIVED * peak, np.finfo(float).tiny))
    later = np.maximum.accumulate(rise[::-1], axis=0)[::-1]  # largest from each instant on
    is_awaited = np.zeros(len(peak), dtype=bool)
    for contact in np.flatnonzero(np.isfinite(arrived)).tolist():
        before = np.flatnonzero(arrived <= arrived[contact])
        unseen = arrived[before] + time[-1] - arrived[contact]
        rows = np.minimum(np.searchsorted(time, unseen), len(time) - 1)
        is_awaited[contact] = later[rows, before].max() > (1 + SAME_PEAK) * peak[contact]
    return is_awaited


def _reflection_start(result: Result, time: Array, rise: Array) -> float | None:
    """Return the time at which the wave arrives at the end of the chain, s; None: never."""
    least = REACHED * float(rise.max(initial=0.0))
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


def spheres_hidden_by_reflection(result: Result) -> NDArray[np.bool_]:
    """Return True for beads of a chain with a contact whose force rose until the reflection came,
    and with no contact that a larger pulse may still reach: (n_spheres,).
    """
    wave = first_wave(result)
    is_hidden = np.zeros(result.n_spheres, dtype=bool)
    is_awaiting = np.zeros(result.n_spheres, dtype=bool)
    if wave.reflection is None:
        return is_hidden
    for name in ("chain/contact_i", "chain/contact_j"):
        ids = result[name]
        is_bead = ids <= result.n_spheres
        rows = result.rows(ids[is_bead])
        rising = ~(wave.is_known | wave.is_passing)[is_bead]
        is_hidden[rows[rising]] = True
        is_awaiting[rows[wave.is_passing[is_bead]]] = True
    return is_hidden & ~is_awaiting


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
