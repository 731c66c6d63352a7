"""First wave along the beads of a chain to which grains were added next to its axis.

Contacts have only their largest force in the run, and its time. This force belongs to the first
wave if

* it has fallen again at the end of the run,
* it occurred before the reflection from the end of the chain can have arrived, where the arrival is
  known (see `granwave.analysis.measures.layer_peaks.reflection_arrivals`); elsewhere the last
  contact is left out, and
* no contact farther down had its largest force before: the wave passes the contacts in order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.beads import bead_pairs, bead_peaks, beads_on_axis
from granwave.analysis.measures.layer_peaks import layers_of, reflection_arrivals
from granwave.analysis.measures.leading_wave import REACHED
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves import wave_speed
from granwave.analysis.result.reader import Result


def beads_after_reflection(result: Result) -> NDArray[np.bool_]:
    """Return True for contacts of two beads whose largest force is not of the first wave, in the
    order of `granwave.analysis.measures.beads.bead_peaks`: (n_beads - 1,). Empty without added
    grains.
    """
    is_bead = beads_on_axis(result)
    if is_bead is None:
        return np.empty(0, dtype=bool)
    peaks = np.nan_to_num(bead_peaks(result), nan=np.inf)
    largest = float(peaks.max(initial=0.0, where=np.isfinite(peaks)))
    is_reached = peaks > REACHED * largest
    above, below, _ = bead_pairs(result, is_bead)
    when = np.where(is_reached, result.of_pairs("time_peak", above, below), np.inf)
    earliest = np.minimum.accumulate(when[::-1])[::-1]  # of a contact and of all below
    is_late = is_reached & (when > earliest)
    reflection = _reflection_at(result, is_bead, below, REACHED * largest)
    if reflection is None:
        is_late[-1] = True
    else:
        is_late |= is_reached & (when >= reflection)
    return np.logical_or.accumulate(is_late) & is_reached


def crest_speed(result: Result) -> float | None:
    """Return the speed of the crest of the wave along the beads of a chain with added grains, m/s:
    the slope of the depth of their contacts against the time of the peak force, over the contacts
    of `waves.wave_speed` whose peak force is of the first wave. None without such a chain, and for
    too few contacts.
    """
    is_bead = beads_on_axis(result)
    if is_bead is None or result.case.load.keeps_oscillating:
        return None
    peaks = np.nan_to_num(bead_peaks(result))
    above, below, depth = bead_pairs(result, is_bead)
    is_reached = peaks > REACHED * peaks.max(initial=0.0)
    is_reached &= ~beads_after_reflection(result)
    when = np.where(is_reached, result.of_pairs("time_peak", above, below), np.inf)
    return wave_speed(depth, when, result.case.packing.diameter)


def _reflection_at(
    result: Result, is_bead: NDArray[np.bool_], ids: NDArray[np.int64], least: float
) -> Array | None:
    """Return the time at which the reflection can be at beads, s: (n,); None where it is not known.

    Parameters
    ----------
    ids
        Of the beads: (n,).
    least
        Force on the base from which on the wave has arrived there, N.
    """
    depth, layer = layers_of(result, is_bead)
    reflection = reflection_arrivals(result, depth, layer, least)
    return None if reflection is None else reflection[layer[result.rows(ids)]]
