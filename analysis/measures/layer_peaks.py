"""Peak force of each layer of a packing, or of each bead of a chain, in the first wave.

Forces are those of the first wave, before the reflection from the end of a chain or from the base
of a packing. The record of a packing has the largest force of each contact in the run, and its
time. The largest force of a layer belongs to the first wave if it occurred before a reflection from
the base can have arrived, see `reflection_arrivals`. Reflections from the sides are included. Under
a load that keeps oscillating the forces are the largest of the run. In a chain to which grains were
added next to its axis, the layers are its beads, and the forces are those between two beads.

With a base at twice the depth, or without one, the forces of the first wave change by less than
2e-5 in fcc, hcp, bcc and sc lattices and in layers in a plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.beads import beads_on_axis
from granwave.analysis.measures.dynamic_force import (
    BEFORE_END,
    dynamic_contact_peaks,
    dynamic_peak_forces,
    has_static_forces,
)
from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.leading_wave import (
    SAME_PEAK,
    has_first_wave,
    leading_peaks_of_spheres,
    spheres_hidden_by_reflection,
)
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import reached
from granwave.analysis.measures.waves import arrivals_of_groups
from granwave.analysis.result.reader import Result

_LEAST_SHARE = 1e-4  # fraction of the largest force: layers that the wave reached
_IN_FLIGHT = 0.5  # fraction of the largest force of a layer: a pulse is in it
_LATEST_PULSE = 2.0  # time of a later, larger pulse over the arrival of the front, at most
_ALONG = 0.999  # cosine of the angle of a contact along the load
_AT_TOP = 1e-9  # fraction of the way down that layers above the impact have


@dataclass(frozen=True, eq=False)
class LayerPeaks:
    """Peak forces of layers, above their static forces; arrays (n_layers,).

    Attributes
    ----------
    depth
        Below the impacted sphere, m.
    largest, median
        Of the peak forces of their spheres, N. The median of a layer of several spheres is of the
        largest forces of the run.
    is_known
        False where the force still rises at the end of the run, where the wave has not arrived, or
        where the reflection came before the force had passed its peak.
    is_reached
        True where the largest force of the run is above 1e-4 of the largest of all.
    is_later
        True for layers of a packing whose largest force occurred when the reflection from the base
        may have arrived.
    reflection
        Time at which the reflection from the base can be at the layers of a packing, s, see
        `reflection_arrivals`; inf where no such time is known.
    n_left_out
        Number of other layers with a force that is not known.
    of_first_wave
        True if the known forces are those of the first wave. Otherwise they are the largest of the
        run.
    n_hidden
        Number of layers among `n_left_out` of a chain whose force rose until the reflection came.
    """

    depth: Array
    largest: Array
    median: Array
    is_known: NDArray[np.bool_]
    is_reached: NDArray[np.bool_]
    is_later: NDArray[np.bool_]
    reflection: Array
    n_left_out: int
    of_first_wave: bool
    n_hidden: int = 0


def layer_peaks(result: Result, grains: NDArray[np.bool_] | None = None) -> LayerPeaks:
    """Return the peak forces of the layers of a packing, or of the beads of a chain.

    Parameters
    ----------
    grains
        True for the grains that make up the layers: (n_spheres,). By default all grains, and only
        the beads of a chain to which grains were added.
    """
    if grains is None:
        grains = beads_on_axis(result)
    mean, layer = layers_of(result, grains)
    is_chain = has_first_wave(result)
    of_run = _peaks_of_run(result, grains)
    force = leading_peaks_of_spheres(result) if is_chain else of_run
    unknown = layer[~np.isfinite(force) & (layer >= 0)]
    force = np.nan_to_num(force)
    largest = _largest(force, layer, len(mean))
    median = np.array([np.median(force[layer == n]) for n in range(len(mean))])
    least = _LEAST_SHARE * float(largest.max(initial=0.0))
    is_known = largest > least
    is_known[unknown] = False
    is_reached = _largest(of_run, layer, len(mean)) > _LEAST_SHARE * of_run.max(initial=0.0)
    is_later = np.zeros(len(mean), dtype=bool)
    reflection = None
    if not is_chain:
        is_known &= ~still_rising(result, layer, largest)
        reflection = reflection_arrivals(result, mean, layer, least)
        is_known &= ~_awaits_larger_pulse(result, layer, largest, reflection)
    if reflection is not None:
        is_later = is_known & _peaks_since(result, layer, largest, reflection)
        is_known &= ~is_later
    is_left_out = is_reached & ~is_known & ~is_later
    is_hidden = np.zeros(len(mean), dtype=bool)
    if is_chain:
        is_hidden[layer[spheres_hidden_by_reflection(result) & (layer >= 0)]] = True
    return LayerPeaks(
        depth=mean,
        largest=largest,
        median=median,
        is_known=is_known,
        is_reached=is_reached,
        is_later=is_later,
        reflection=np.full(len(mean), np.inf) if reflection is None else reflection,
        n_left_out=int(np.count_nonzero(is_left_out)),
        n_hidden=int(np.count_nonzero(is_left_out & is_hidden)),
        of_first_wave=is_chain or (reflection is not None and bool(np.any(is_known))),
    )


def spheres_of_later_waves(
    result: Result, peaks: LayerPeaks, layer: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Return True for spheres whose largest force may be of a later wave than the first, or still
    rises at the end of the run: (n_spheres,).

    Parameters
    ----------
    peaks
        Of the layers.
    layer
        Layer of each sphere: (n_spheres,).
    """
    last = BEFORE_END * float(result["energy/time"][-1])
    since = np.minimum(peaks.reflection, last)[layer]
    each = np.arange(result.n_spheres)
    return ~peaks.is_known[layer] | _peaks_since(result, each, dynamic_peak_forces(result), since)


def _awaits_larger_pulse(
    result: Result, layer: NDArray[np.int64], largest: Array, reflection: Array | None
) -> NDArray[np.bool_]:
    """Return True for layers that a pulse larger than all so far may still reach: (n_layers,).

    Either the run ends before the reflection can be at the layer, and contacts of a layer above
    carry at the end more than half the largest force of their layer, and more than that of the
    layer. Or grains that yield are in lines along the load, and the run ends before twice the
    arrival at the layer.
    """
    end = float(result["energy/time"][-1])
    at_end = _largest(_dynamic_forces_at_end(result), layer, len(largest))
    in_flight = np.where(at_end > _IN_FLIGHT * largest, at_end, 0.0)
    above = np.maximum.accumulate(np.append(0.0, in_flight[:-1]))
    is_awaited = above > (1 + SAME_PEAK) * largest
    if reflection is not None:
        is_awaited &= reflection > end
    if result.yields and _has_lines_along_load(result):
        is_awaited |= _LATEST_PULSE * arrivals_of_groups(result, layer, len(largest)) > end
    return is_awaited


def _has_lines_along_load(result: Result) -> bool:
    """Return True if contacts along z carried forces, as in a simple cubic packing: their lines are
    chains, in which a larger pulse can follow far behind the front.
    """
    position = result["spheres/position"]
    for i, j, peak in result.blocks("contacts/i", "contacts/j", "contacts/peak_force"):
        step = position[result.rows(j)] - position[result.rows(i)]
        step[:, :2] = result.across(step[:, :2])
        is_along = np.abs(step[:, 2]) > _ALONG * np.linalg.norm(step, axis=1)
        if np.any(is_along & (peak > 0)):
            return True
    return False


def _dynamic_forces_at_end(result: Result) -> Array:
    """Return the largest contact force of each sphere at the end, above its static value:
    (n_spheres,), N.
    """
    largest = np.zeros(result.n_spheres)
    names = ["contacts/i", "contacts/j", "contacts/force"]
    static = ["contacts/initial_force"] if has_static_forces(result) else []
    for i, j, force, *initial in result.blocks(*names, *static):
        rise = force - initial[0] if initial else force
        for ends in (i, j):
            np.maximum.at(largest, result.rows(ends), rise)
    return largest


def reflection_arrivals(
    result: Result, depth: Array, layer: NDArray[np.int64], least: float = 0.0
) -> Array | None:
    """Return the time at which the reflection from the base of a packing can be at each layer, s:
    (n_layers,); inf if the wave does not arrive at the base. None under a load that keeps
    oscillating, and where the arrival at the base is not known.

    The front is at the base at t_b, and was at the layer at t on its way. Waves get weaker and
    slower on their way, so that the reflection returns at 2 t_b - t at the earliest. If contacts
    are loaded from the start, arrivals at layers cannot be observed; t is then that of a wave with
    a constant speed down to the base.

    Parameters
    ----------
    depth
        Of the layers, rising: (n_layers,), m.
    layer
        Layer of each sphere: (n_spheres,).
    least
        Force on the base from which on the wave has arrived there, N.
    """
    if result.case.load.keeps_oscillating:
        return None
    base = reached(result)
    if result.case.precompression is None:
        front = arrivals_of_groups(result, layer, len(depth))
        if not np.isfinite(front[-1]) and base is not None and base.dynamic_peak_force > least:
            front[-1] = base.arrival or np.inf  # the force of the last layer still rises
    else:
        if base is None or not depth[-1] > 0:
            return None
        is_there = base.dynamic_peak_force > least
        at_base = base.arrival if is_there else None
        front = np.clip(depth / depth[-1], _AT_TOP, 1.0) * (at_base or np.inf)
    if not np.isfinite(front[-1]):
        return np.full(len(depth), np.inf)
    return np.asarray(2 * front[-1] - np.minimum(front, front[-1]))


def layers_of(result: Result, grains: NDArray[np.bool_] | None) -> tuple[Array, NDArray[np.int64]]:
    """Return the depth of each layer, m, and the layer of each sphere, -1 for spheres that do not
    belong to ``grains``, if these are given.
    """
    depth = result["spheres/position"][:, 2] - result.origin[2]
    radius = result["spheres/radius"]
    diameter = result.case.packing.diameter
    if grains is None:
        return layers(depth, radius, diameter)
    mean, own = layers(depth[grains], radius[grains], diameter)
    layer = np.full(len(depth), -1, dtype=np.int64)
    layer[grains] = own
    return mean, layer


def _peaks_of_run(result: Result, grains: NDArray[np.bool_] | None) -> Array:
    """Return the largest rise of a contact force of each sphere in the run, N: (n_spheres,); 0 for
    other spheres than ``grains``, if these are given. For the beads of a chain to which grains were
    added it is the largest force of their contacts with each other.
    """
    force = dynamic_peak_forces(result)
    if grains is None:
        return force
    beads = beads_on_axis(result)
    if beads is None or not np.array_equal(beads, grains):
        return np.where(grains, force, 0.0)
    largest = np.zeros(result.n_spheres)
    for i, j, rise, _ in dynamic_contact_peaks(result):
        between = beads[result.rows(i)] & beads[result.rows(j)]
        for ends in (i, j):
            np.maximum.at(largest, result.rows(ends[between]), rise[between])
    return largest


def _largest(force: Array, layer: NDArray[np.int64], n_layers: int) -> Array:
    """Return the largest of the forces of the spheres of each layer: (n_layers,), N."""
    largest = np.zeros(n_layers)
    np.maximum.at(largest, layer[layer >= 0], force[layer >= 0])
    return largest


def still_rising(result: Result, layer: NDArray[np.int64], force: Array) -> NDArray[np.bool_]:
    """Return True for layers whose largest force was reached at the end of the run: (n_layers,).

    Parameters
    ----------
    layer
        Layer of each sphere: (n_spheres,).
    force
        Largest force of each layer, dynamic under a static load: (n_layers,), N.
    """
    last = BEFORE_END * float(result["energy/time"][-1])
    return _peaks_since(result, layer, force, np.full(len(force), last))


def _peaks_since(
    result: Result, layer: NDArray[np.int64], force: Array, since: Array
) -> NDArray[np.bool_]:
    """Return True for layers whose largest force, (n_layers,), N, was reached at a time of their
    own, (n_layers,), s, or later: (n_layers,).
    """
    is_since = np.zeros(len(force), dtype=bool)
    for i, j, peak, when in dynamic_contact_peaks(result):
        for ends in (i, j):
            there = layer[result.rows(ends)]
            is_largest = (there >= 0) & (peak >= force[there]) & (when >= since[there])
            is_since[there[is_largest]] = True
    return is_since
