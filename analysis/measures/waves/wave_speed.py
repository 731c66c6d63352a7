"""Speed of the wave down into a packing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.geometry.planes import layers
from granwave.analysis.result.reader import Result

_LEAD = 5  # layers, the struck one among them, that the first disturbance passes before any contact is at its peak
_FEWEST_LAYERS = 4  # that a wave speed is taken from
_STRUCK_LAYER = 0.1  # diameters that the mean of the struck layer may be above the struck sphere
_ARRIVED = 0.1  # of the largest rise of a contact's force: the wave is there, in a chain that was loaded before
_RISEN = 0.01  # of the largest rise anywhere: a contact that rose by less was not reached


def wave_speed(
    depth: NDArray[np.float64], arrival: NDArray[np.float64], diameter: float, radii: NDArray[np.float64] | None = None
) -> float | None:
    """Speed of the wave into the depth: slope of depth over arrival, by layers of spheres.

    The arrival at a layer is the earliest at any of its spheres. The slope is a least-squares fit to the deeper half
    of the layers that were reached, without the five uppermost ones. An arrival is the first contact force at all,
    which runs about four layers ahead of the peak force: the speed is that of the peak some four layers above. It
    needs no threshold, and neither later pulses nor the echo of the bottom disturb it, as they do the times of peak
    forces. On a chain of Hertz contacts it is within 2 % of the solitary wave's
    0.6802 (2E / (D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6). Where the wave gets weaker and slower it is above
    that of the peak: in FCC brass struck at 5 m/s by 10 %, and by 15 to 25 % if compared in the same layers.

    Parameters
    ----------
    depth
        Below the struck sphere, of each sphere's centre at the start: (n_spheres,), m.
    arrival
        When any contact of the sphere was first loaded: (n_spheres,), s; NaN: never.
    diameter
        Of the spheres, nominal, m.
    radii
        Of each sphere: (n_spheres,), m; half the diameter if not given.

    Returns
    -------
    float or None
        m/s; None when fewer than four layers below the five uppermost were reached, or when contacts are loaded from
        the start, as under precompression.
    """
    radii = np.full(len(depth), diameter / 2) if radii is None else radii
    mean, layer = layers(depth, radii, diameter)
    first = np.full(len(mean), np.inf)
    np.fmin.at(first, layer, arrival)
    return _slope(mean, first, diameter)


def _slope(mean: NDArray[np.float64], first: NDArray[np.float64], diameter: float) -> float | None:
    """Return the `wave_speed` of layers, from the depth of each and when it was reached first (inf: never)."""
    reached = np.isfinite(first) & (mean > -_STRUCK_LAYER * diameter)
    z, time = mean[reached], first[reached]
    used = slice(max(_LEAD, len(z) // 2), None)
    z, time = z[used], time[used]
    if len(z) < _FEWEST_LAYERS:
        return None
    late, deep = time - time.mean(), z - z.mean()
    slope = float(late @ deep / (late @ late)) if late.any() else 0.0
    return slope if slope > 0 else None


def wave_speed_of(result: Result) -> float | None:
    """The `wave_speed` of a run; of one that was precompressed only in a chain whose forces were recorded.

    There the wave is at a contact once its force has risen by a tenth of its largest rise, if that was over before the
    end of the run. Of weak waves in a chain of Hertz contacts that is 3 % above the speed of sound, D sqrt(k/m) with
    the contact stiffness k under the static force.

    None of loads that go on oscillating: a bead's largest force may come at any time, and later where beads absorb; a
    burst passes once.

    None of cylinders beside each other: the stiffness of their contacts hardly grows with the force, so that the first
    force at all runs ahead of the wave without a limit. Lines of grains have a front speed.
    """
    diameter = result.case.packing.diameter
    load = result.case.load
    if _beside_each_other(result) or (load.driven and load.oscillates and load.shape != "burst"):
        return None
    if result.case.precompression is None:
        return _slope(*_arrivals(result, diameter), diameter)
    if "chain" not in result:
        return None
    rise = result["chain/contact_force"] - result["chain/contact_force"][0]
    if not rise.size:  # a single bead
        return None
    largest = rise.max(axis=0)
    passed = (largest >= _RISEN * largest.max()) & (rise.argmax(axis=0) < len(rise) - 1)
    arrival = np.where(passed, result["chain/time"][(rise > _ARRIVED * largest).argmax(axis=0)], np.nan)
    return wave_speed(result["chain/contact_position"] - result.origin[2], arrival, diameter)


def _beside_each_other(result: Result) -> bool:
    """Return True if all grains are cylinders with parallel axes."""
    if not result.assembly.has_cylinders:
        return False
    axes = [one.axis if one else None for one in result.assembly.shapes]
    return None not in axes and len(set(axes)) == 1


def _arrivals(result: Result, diameter: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the depth of each layer, m, and when a contact of its spheres was first loaded, s; inf: never.

    Spheres of a layer have few different depths, which are sorted into layers first.
    """
    top, depths, smallest = result.origin[2], np.empty(0), np.inf
    for positions, radii in result.blocks("spheres/position", "spheres/radius"):
        depths = np.union1d(depths, positions[:, 2] - top)
        smallest = min(smallest, radii.min(initial=np.inf))
    mean, layer_of = layers(depths, np.array([smallest]), diameter)
    n_spheres, first = np.zeros(len(mean), dtype=np.int64), np.full(len(mean), np.inf)
    total: NDArray[np.float64] = np.zeros(len(mean))
    every = np.arange(len(mean))
    for positions, arrival in result.blocks("spheres/position", "spheres/time_first"):
        depth = positions[:, 2] - top
        layer = layer_of[np.searchsorted(depths, depth)]
        total = np.bincount(np.append(every, layer), np.append(total, depth)).astype(np.float64)  # in one order for all
        n_spheres += np.bincount(layer, minlength=len(mean))
        np.fmin.at(first, layer, arrival)
    return total / n_spheres, first
