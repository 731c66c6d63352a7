"""Waves in packings: their directions, and their speed into the depth.

Directionality: fractions of energy and dissipation by direction from the impact point, for any
packing.

The direction of a sphere is its direction from the nearest impacted sphere. In a layer it is an
angle; in a packing of several layers a point of the half sphere below, cut into cells of equal
solid angle.
"""

from __future__ import annotations

import dataclasses
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.measures.first_pulse import bead_arrivals, has_recorded_chain
from granwave.analysis.measures.geometry import layers, nearest, preferred_directions
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import reached
from granwave.analysis.result.contacts import ARRIVED
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.motion import velocities_of

AXIS_ANGLE = 15.0  # degrees around the direction of a contact that belong to it
LAYER_BINS = 72  # bins of 5 degrees
# cells of the half sphere: in the angle to the impact axis, and around it
RINGS = 8
PER_RING = 24
_ONE_LAYER = 0.1  # largest vertical distance of spheres of a layer, diameters
# fraction of the energy at the outermost spheres above which the wave has reached them
_REACHED = 0.02

# layers, including the impacted one, in which the wave takes its shape
_LEAD = 5
_FEWEST_LAYERS = 4  # fewest layers for a wave speed
# largest height of the mean of the impacted layer above the impacted sphere, diameters
_STRUCK_LAYER = 0.1
# fraction of the largest force of all: the wave did not reach contacts that carry less
_REACHES = 1e-4
_SAME_TIME = 1e-9  # relative
_RISEN = 0.01  # fraction of the largest rise anywhere: the wave did not reach contacts with less


@dataclasses.dataclass(frozen=True, eq=False)
class Spread:
    """Distribution of a quantity of the spheres over the directions from the impact point.

    Attributes
    ----------
    cells
        Fraction of the total in each cell: (LAYER_BINS,) from -180 degrees on, or (RINGS,
        PER_RING).
    along
        Fraction within `AXIS_ANGLE` of the directions of contacts; an isotropic distribution has
        ``even``.
    even
        Part of all directions within that angle.
    """

    cells: Array
    along: float
    even: float

    @property
    def relative(self) -> Array:
        """Values of the cells divided by their mean: 1 everywhere if nothing is directional."""
        return self.cells / (self.cells.mean() or 1.0)


def struck_rows(result: Result) -> NDArray[np.int64]:
    """Rows of the spheres of the packing that strikers or the load hit."""
    case = result.case
    n = result.assembly.lattice.n_spheres
    if case.striker:
        touched = set(chain.from_iterable(striker.touches for striker in case.striker))
        return result.rows(np.array(sorted(number for number in touched if number <= n)))
    return result.rows(np.array(result.struck))


def directions(result: Result) -> Array:
    """Unit vectors from the nearest impacted sphere to each sphere: (n_spheres, 3); NaN for
    impacted spheres and strikers.

    Parameters
    ----------
    result
        Of a run, ``run.result``.
    """
    struck = struck_rows(result)
    positions = result["spheres/position"]
    _, row = nearest(positions, positions[struck])
    offset = positions - positions[struck][row]
    offset[struck] = np.nan
    offset[~result.in_packing] = np.nan
    return offset / np.linalg.norm(offset, axis=1, keepdims=True)


def spread(result: Result, values: ArrayLike) -> Spread | None:
    """Distribution of a quantity of spheres over the directions from the nearest impacted sphere,
    without strikers.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    values
        Not negative: (n_spheres,).

    Returns
    -------
    Spread or None
        Fraction ``along`` the directions of contacts, within 15 degrees; ``even``, the fraction in
        an isotropic distribution; ``cells`` by direction. None if impacted spheres hold all.
    """
    values = np.asarray(values, dtype=np.float64)
    vectors = directions(result)
    known = np.isfinite(vectors[:, 0])
    vectors = vectors[known]
    weights = values[known]
    total = float(weights.sum())
    if not total > 0:
        return None
    axes = preferred_directions(result.case.packing.kind)
    cosine = (vectors @ axes.T).max(axis=1)
    along = float(weights[cosine >= np.cos(np.deg2rad(AXIS_ANGLE)) - 1e-9].sum()) / total
    flat = is_layer(result)
    cap = np.deg2rad(AXIS_ANGLE)
    rings, per_ring = (1, LAYER_BINS) if flat else (RINGS, PER_RING)
    ring = np.minimum(((1 - np.clip(vectors[:, 2], 0, 1)) * rings).astype(int), rings - 1)
    angle = np.rad2deg(np.arctan2(vectors[:, 1], vectors[:, 0]))
    around = np.floor((angle + 180) / 360 * per_ring + 0.5 + 1e-9).astype(
        int
    )  # a bin is centred on each multiple of this angle
    cells = (
        np.bincount(ring * per_ring + around % per_ring, weights, minlength=rings * per_ring)
        / total
    )
    even = (
        cap / np.pi if flat else 1 - np.cos(cap)
    )  # solid angle of a direction: separate caps of a half sphere
    return Spread(cells if flat else cells.reshape(rings, per_ring), along, float(len(axes) * even))


def is_layer(result: Result) -> bool:
    """Return True if the packing has one layer."""
    return bool(
        np.ptp(result["spheres/position"][result.in_packing, 2])
        < _ONE_LAYER * result.case.packing.diameter
    )


def stays_in_layer(result: Result) -> bool:
    """Return True for a packing of one layer whose load acts in its plane: nothing moves towards
    the bottom.
    """
    along_z = [velocity[2] for velocity in velocities_of(result.assembly).values()]
    load = result.case.load
    if load.driven or not along_z:
        along_z.append(load.way[2])
    return is_layer(result) and not np.any(along_z)


def energy_of_spheres(result: Result, frame: int) -> Array:
    """Kinetic energy of each sphere and half the elastic energy of its contacts: (n_spheres,), J.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    frame
        Number of the snapshot, from 0.
    """
    energy = 0.5 * result["spheres/mass"] * np.sum(result.frame(frame, "velocity") ** 2, axis=1)
    if "elastic_energy" in result.quantities:
        stored = result.frame(frame, "elastic_energy")
        energy = energy + np.where(np.isfinite(stored), stored, 0.0)
    return energy


def travelling_frame(result: Result) -> int:
    """Number of the last snapshot before the wave reaches sides or bottom; otherwise of the first
    snapshot after the start.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    """
    outer = _outermost(result)
    struck = struck_rows(result)
    inner = result.in_packing
    inner[struck] = False
    chosen = min(1, result.n_frames - 1)
    for frame in range(chosen, result.n_frames):
        energy = energy_of_spheres(result, frame)
        moving = float(energy[inner].sum())
        if moving > 0 and float(energy[outer & inner].sum()) > _REACHED * moving:
            break
        chosen = frame
    return chosen


def _outermost(result: Result) -> NDArray[np.bool_]:
    """Spheres at the sides and the bottom, without sides on which an impact acts."""
    inside = result.in_packing
    positions = result["spheres/position"]
    packing = positions[inside]
    struck = positions[struck_rows(result)]
    edge = 0.6 * result.case.packing.diameter
    found = np.zeros(len(positions), dtype=bool)
    for axis in (0, 1) if is_layer(result) else (0, 1, 2):
        for sign in (-1, 1):
            limit = (sign * packing[:, axis]).max()
            if (
                sign * struck[:, axis]
            ).max() < limit - edge:  # the impacted side is not an end of the wave's way
                found |= inside & (sign * positions[:, axis] > limit - edge)
    return found


def wave_speed(mean: Array, first: Array, diameter: float) -> float | None:
    """Speed of the front of the wave into the depth: slope of depth against arrival, by layers.

    The front is at a layer as `front_arrivals` defines it. The slope is a least-squares fit to the
    deeper half of the layers that were reached, without the five uppermost layers, where the wave
    develops its shape. The reflection from the bottom does not affect it, unlike the times of peak
    forces. The first nonzero force is not a suitable measure: ahead of a wave in Hertzian contacts
    the overlap falls faster than exponentially, so that the rounding of the coordinates decides
    when it is first above zero. On a chain of Hertz contacts the speed is within 2 % of the
    solitary wave's 0.6802 (2E / (D rho^1.5 (1 - nu^2)))^(1/3) F^(1/6). As the wave becomes weaker
    it also becomes slower and longer, and its front is faster than its peak.

    Parameters
    ----------
    mean
        Depth of the layers below the impacted sphere: (n_layers,), m.
    first
        Arrival at each: (n_layers,), s; inf: never.
    diameter
        Of the spheres, nominal, m.

    Returns
    -------
    float or None
        m/s; None when fewer than four layers below the five uppermost were reached, or when
        contacts are loaded from the start, as under precompression.
    """
    z, time = fitted_layers(mean, first, diameter)
    if not len(z):
        return None
    late = time - time.mean()
    deep = z - z.mean()
    slope = float(late @ deep / (late @ late)) if late.any() else 0.0
    return slope if slope > 0 else None


def fitted_layers(mean: Array, first: Array, diameter: float) -> tuple[Array, Array]:
    """Return depth, m, and arrival, s, of the layers in the fit of `wave_speed`: the deeper half of
    the layers that were reached, without the five uppermost; empty for fewer than four layers.

    Parameters
    ----------
    mean, first, diameter
        As of `wave_speed`.
    """
    reached = np.isfinite(first) & (mean > -_STRUCK_LAYER * diameter)
    z = mean[reached]
    used = slice(max(_LEAD, len(z) // 2), None)
    if len(z[used]) < _FEWEST_LAYERS:
        used = slice(0, 0)
    return z[used], first[reached][used]


def wave_speed_of(result: Result) -> float | None:
    """Speed of the wave into the depth of a run, m/s; None if it is not known, see `wave_speed`.

    After precompression it is known only in a chain with recorded forces. For weak waves in a chain
    of Hertz contacts this speed is 3 % above the speed of sound, D sqrt(k/m) with the contact
    stiffness k under the static force.

    None for loads that keep oscillating: they have no front of one height. A burst passes once.

    None for a load that does not push down: its wave does not start at the top.

    None for parallel cylinders: the stiffness of their contacts is almost independent of the force,
    so that the front of the wave spreads without a limit. Lines of grains have a front speed.
    """
    diameter = result.case.packing.diameter
    load = result.case.load
    if has_parallel_cylinders(result) or load.way[2] <= 0 or load.keeps_oscillating:
        return None
    if result.case.precompression is not None and not has_recorded_chain(result):
        return None
    return wave_speed(*front_arrivals(result), diameter)


def has_parallel_cylinders(result: Result) -> bool:
    """Return True for a packing of parallel cylinders: its front spreads without a limit."""
    axes = [shape.axis if shape else None for shape in result.assembly.shapes]
    return result.assembly.has_cylinders and None not in axes and len(set(axes)) == 1


def front_arrivals(result: Result) -> tuple[Array, Array]:
    """Return the depth of each layer, m, and the arrival time of the wave front, s; inf if it never
    arrived.

    At a bead of a chain with recorded forces it arrives with the first pulse, see
    `granwave.analysis.measures.first_pulse`. In other packings it arrives with the earliest arrival
    at a contact that carries at least 10 % of the largest force of the layer. Layers whose arrival
    is later than at all contacts that have passed their largest force do not count: the wave may
    still rise there. Contacts do not count if they carry less than 1e-4 of the largest force of
    all: grains that touch overlap by the rounding of their coordinates.
    """
    mean, layer = _layers_of(result, result.case.packing.diameter)
    return mean, arrivals_of_groups(result, layer, len(mean))


def arrivals_of_groups(result: Result, group: NDArray[np.integer], n_groups: int) -> Array:
    """Return the arrival of the wave front at groups of spheres, defined as in `front_arrivals`:
    (n_groups,), s; inf if it never arrived.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    group
        Group of each sphere, from 0; below 0: none. (n_spheres,).
    """
    if has_recorded_chain(result):
        return _earliest_of_beads(result, group, n_groups)
    largest = np.zeros(n_groups)
    for i, j, force in result.blocks("contacts/i", "contacts/j", "contacts/peak_force"):
        for ends in (i, j):
            there = group[result.rows(ends)]
            inside = there >= 0
            np.maximum.at(largest, there[inside], force[inside])
    least = np.maximum(ARRIVED * largest, _REACHES * largest.max(initial=0.0))
    last = (1 - _SAME_TIME) * float(result["energy/time"][-1])
    first = np.full(n_groups, np.inf)
    of_fallen = np.full(n_groups, np.inf)  # at contacts whose force is not largest at the end
    names = ("i", "j", "peak_force", "time_first", "time_peak")
    for i, j, force, arrival, peak in result.blocks(*(f"contacts/{name}" for name in names)):
        for ends in (i, j):
            there = group[result.rows(ends)]
            counts = (there >= 0) & (force > 0) & (force >= least[there])
            np.fmin.at(first, there[counts], arrival[counts])
            counts &= peak < last
            np.fmin.at(of_fallen, there[counts], arrival[counts])
    latest = of_fallen.max(initial=0.0, where=np.isfinite(of_fallen))
    return np.where(first <= latest, first, np.inf)


def _earliest_of_beads(result: Result, group: NDArray[np.integer], n_groups: int) -> Array:
    """Return the earliest arrival at the beads of each group: (n_groups,), s; inf: never."""
    first = np.full(n_groups, np.inf)
    inside = group >= 0
    np.fmin.at(first, group[inside], bead_arrivals(result)[inside])
    return first


def passage(result: Result) -> float:
    """Return the time at which the front of the wave has passed the packing, s; the end of a run in
    which it has not. The front has then arrived at the deepest layer; in a packing of one layer, at
    the last of the spheres that carry at least 1 % of the largest force. If contacts are loaded
    from the start, it is the arrival at the bottom.
    """
    end = float(result["energy/time"][-1])
    if result.case.precompression is not None:
        at_bottom = reached(result)
        return (at_bottom.arrival if at_bottom else None) or end
    if is_layer(result):
        force = result["spheres/peak_force"]
        arrival = result["spheres/time_first"][force >= _RISEN * force.max(initial=0.0)]
        return float(np.nanmax(arrival, initial=0.0)) or end
    last = float(front_arrivals(result)[1][-1])
    return last if np.isfinite(last) and last > 0 else end


def _layers_of(result: Result, diameter: float) -> tuple[Array, NDArray[np.int32]]:
    """Return the depth of each layer below the impacted sphere, m, and the layer of each sphere.

    Spheres of a layer have few different depths, which are sorted into layers first.
    """
    top = result.origin[2]
    depths = np.empty(0)
    smallest = np.inf
    for positions, radii in result.blocks("spheres/position", "spheres/radius"):
        depths = np.union1d(depths, positions[:, 2] - top)
        smallest = min(smallest, radii.min(initial=np.inf))
    mean, layer_of = layers(depths, np.array([smallest]), diameter)
    n_spheres = np.zeros(len(mean), dtype=np.int64)
    total: Array = np.zeros(len(mean))
    every = np.arange(len(mean))
    parts = []
    for (positions,) in result.blocks("spheres/position"):
        depth = positions[:, 2] - top
        layer = layer_of[np.searchsorted(depths, depth)]
        # in a common order
        total = np.bincount(np.append(every, layer), np.append(total, depth)).astype(np.float64)
        n_spheres += np.bincount(layer, minlength=len(mean))
        parts.append(layer.astype(np.int32))
    return total / n_spheres, np.concatenate(parts)
