"""Size of the plastic zone: depth, radius and volume with 50, 90 and 99 % of the plastic
dissipation; boundaries, waves from them, marks.

One definition for packings and the continuum. A part is a sphere of the packing, with the energy
that it dissipated by yielding as weight, or an element, with its plastic work as weight:

    depth     smallest d such that the parts whose centres lie at most d below the impacted
              sphere's centre (packing) or the block's face (continuum) contain the fraction; a
              centre above counts as depth 0
    radius    the same for the distance of the centres from the impact axis
    volume    smallest volume that contains the fraction: parts are added in descending
              order of energy per volume; in a packing without voids. Of equal parts these
              are the fewest

None of these is interpolated: a size is the distance of a part, or a sum over parts. In a lattice
the depth is the depth of a layer, and does not change with the load until the next layer is needed.
The interpolated depth and radius lie between layers: E(d) is the energy of all parts at most d
away, and straight lines connect its values at the distances of the parts. The interpolated size is
where these lines reach the fraction: between the size above and the next smaller distance of a
part. Both agree if the parts are small.

The outermost yielded part (``plastic_zone_depth_m``) may be many times farther away. A zone
is marked if it reaches a boundary, or if a reflected wave returned to it: it differs from the zone
in an infinite packing.

The impact axis is parallel to z through the centroid of the impacted spheres.

The plastic dissipation of a sphere is half the dissipation of each of its contacts, all of it if
the partner has the higher yield strength, none if the partner has the lower one. Contacts with
walls of a material follow the same rule; at a rigid wall all dissipation belongs to the sphere.
Friction, dampers and strikers do not count: strikers are not part of the packing, and their
dissipation is excluded.

A contact has yielded when its largest overlap passed alpha_y (elastoplastic, thornton) or when it
was loaded (bilinear); with hertz no contact yields. A dent from before the run must have grown in
it. A contact just beyond first yield keeps a dent and may dissipate nothing: the default
elasto-plastic law, continuous, unloads up to 1.083 alpha_y without dissipation. More spheres
therefore yield than dissipate.

The elasto-plastic law was fitted up to an overlap of about 0.2 R*; above 0.1 R* the plastic zones
of a sphere's contacts may begin to touch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntFlag
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import reached
from granwave.analysis.quantities import SHARES
from granwave.lammps_inputs.packing.places import Places

if TYPE_CHECKING:
    from granwave.analysis.result.reader import Result

Zone = dict[str, NDArray]  # columns of spheres, see `packing_zone`

LAW_LIMIT = 0.2  # largest overlap / R* in the fit of the elasto-plastic law
HALF_LAW_LIMIT = 0.1  # half of this limit
# boundaries that a zone, or a wave, may reach
BOTTOM = "bottom"
SIDES = "sides"
_WAYS = {BOTTOM: "depth", SIDES: "radius"}  # columns of the distance from each boundary
_DISTANCES = ("depth", "radius", BOTTOM, SIDES)
IMAGES = "periodic images"  # beyond periodic sides, in texts
PERIODIC_SIDES = "sides_periodic"  # key of the summary
COLLISION = (1, 2)  # numbers of spheres of a single collision
WAVE_KEYS = ("wave_returned", "wave_return_s", "wave_return_share")  # results of `wave_returns`
_ROUNDING = 1e-12  # tolerance of sums of energy against a fraction, relative
# fraction of the energy dissipated after the first wave returned, above which the run is marked
NOTED_SHARE = 0.01
_SAME = 1e-9  # relative tolerance of equal lengths
_LATE = 0.1  # fraction of a run: if the extent grew so near the end, the zone may still grow
# fraction of the largest force among some contacts: the wave came through contacts that carry more
_BEARS = 0.01
_NOTHING = 1e-12  # fraction of the input that counts as zero: the yield energy is a difference
# fraction of the largest force of the run: smaller forces are rounding or precursors
_NO_WAVE = 1e-6


def extent_holding(distance: Array, energy: Array, share: float) -> float:
    """Return the smallest distance of a part within which a fraction of the energy lies, m; 0
    without any energy.

    Parameters
    ----------
    distance, energy
        Distances, m, and energies, J, of the parts: (n,); no energy is negative.
    share
        Fraction of the total energy, above 0.
    """
    order = np.lexsort(
        (energy, distance)
    )  # equal parts are alike, so that their order in the file does not matter
    n = _parts_holding(energy[order], share)
    return float(distance[order][n - 1]) if n else 0.0


def interpolated_extent(distance: Array, energy: Array, share: float) -> float:
    """Return the distance within which the energy reaches a fraction, interpolated linearly between
    the distances of parts with energy, m; parameters as in `extent_holding`.
    """
    active = np.flatnonzero(energy > 0)
    if not len(active):
        return 0.0
    order = active[np.lexsort((energy[active], distance[active]))]
    place = distance[order]
    held = np.cumsum(energy[order])
    last_of_layer = np.append(np.diff(place) > _SAME * place[-1], True)
    place = place[last_of_layer]
    held = held[last_of_layer]
    return float(np.interp(share * held[-1], held, place))


def volume_holding(volume: Array, energy: Array, share: float) -> float:
    """Return the volume (m^3) of the parts of highest energy per volume that contain a fraction;
    parameters as in `extent_holding`.
    """
    order = np.lexsort((volume, -energy / volume))
    return float(np.sum(volume[order][: _parts_holding(energy[order], share)]))


def _parts_holding(energy: Array, share: float) -> int:
    """Number of parts, from the first, that contain a fraction of the energy; 0 if it is zero."""
    held = np.cumsum(energy)
    holds = len(held) and held[-1] > 0
    return int(np.searchsorted(held, (1 - _ROUNDING) * share * held[-1])) + 1 if holds else 0


def zone_sizes(
    energy: Array | None,
    volume: Array | None = None,
    depth: Array | None = None,
    radius: Array | None = None,
) -> dict[str, float | None]:
    """Sizes of a plastic zone, by their names in ``summary.json``.

    Parameters
    ----------
    energy
        Dissipated by yielding, of the parts: (n,), J; None where nothing can yield.
    volume
        Of the parts: (n,), m^3.
    depth, radius
        Depths and radii of the parts: (n,), m; None in directions without extent.

    Returns
    -------
    dict
        ``zone_depth_50_m``, ``zone_radius_50_m``, ``zone_volume_50_m3``,
        ``zone_depth_50_interpolated_m``, ``zone_radius_50_interpolated_m``, ... 90, 99; None where
        a size does not apply.
    """
    measures = (
        ("depth", "_m", depth, extent_holding),
        ("radius", "_m", radius, extent_holding),
        ("volume", "_m3", volume, volume_holding),
        ("depth", "_interpolated_m", depth, interpolated_extent),
        ("radius", "_interpolated_m", radius, interpolated_extent),
    )
    sizes = dict[str, float | None]()
    for (name, unit, parts, size), percent in product(measures, SHARES):
        key = f"zone_{name}_{percent}{unit}"
        sizes[key] = None
        if energy is not None and parts is not None:
            sizes[key] = size(parts, energy, percent / 100)
    return sizes


def wave_returns(times: dict[str, float] | None, ledger: Array, lost: Array) -> dict[str, Any]:
    """Return the part of the summary on waves that return from the boundaries.

    Parameters
    ----------
    times
        Times of return to the zone, by boundary, s; None where they are not known.
    ledger
        Times of the energy record: (n,), s.
    lost
        Energy dissipated by yielding so far: (n,), J.

    Returns
    -------
    dict
        ``wave_returned``, the boundaries that a wave returned from within the run;
        ``wave_return_s``, the earliest return; ``wave_return_share``, the fraction of the energy
        that was dissipated after it.
    """
    if times is None:
        return dict.fromkeys(WAVE_KEYS)
    first = min(times.values(), default=None)
    share = 0.0
    if first is not None and lost[-1] > 0:
        share = float(1 - np.interp(first, ledger, lost) / lost[-1])
    within = [name for name, time in times.items() if time < ledger[-1]]
    return dict(zip(WAVE_KEYS, (within, first, max(share, 0.0)), strict=True))


def packing_zone(result: Result) -> Zone:
    """Return the columns for the plastic zone of a run, for the spheres of the packing, without
    strikers.

    The last layer is at the ``bottom``, the first and last sphere of a row and the first and last
    row at the ``sides``. With periodic sides the spheres half a period from the axis are at the
    sides, where a zone meets its image. A packing of one layer has no bottom, a chain has no sides;
    grains of a file have no defined boundaries.

    Returns
    -------
    dict
        Arrays (n_spheres,): ``energy`` dissipated by yielding, J; ``volume``, m^3; ``yielded``,
        True with a contact that yielded, or that dissipated energy at a wall; ``yield_time`` of the
        first such contact, s (NaN: never); and as far as the packing extends that way ``depth`` of
        the centres below that of the impacted sphere, m, ``radius``, their distance from the impact
        axis, m, and ``bottom`` and ``sides``, True where they touch these bounds.
    """
    own = result.in_packing
    lattice = result.assembly.lattice
    nx, ny, nz = lattice.shape
    position = result["spheres/position"][own]
    periodic = result.case.boundary.periodic
    energy = np.maximum(result.yield_energy[own], 0.0)
    zone: Zone = {
        "energy": energy,
        "volume": 4 / 3 * np.pi * result["spheres/radius"][own] ** 3,
        "yielded": (result["spheres/contacts_yielded"][own] > 0) | (energy > 0),
        "yield_time": result["spheres/time_yield"][own],
    }
    free = isinstance(lattice, Places)
    if nz > 1 or free:
        zone["depth"] = np.maximum(position[:, 2] - result.origin[2], 0.0)
    if nx * ny > 1 or free:
        zone["radius"] = result.distance_from_axis(position)
    if not isinstance(lattice, Places):
        ids = result["spheres/id"][own]
        if nz > 1:
            zone[BOTTOM] = ids >= lattice.last_layer[0]
        if periodic:
            pitch = np.array(lattice.rule.pitch) * lattice.diameter
            offset = result.across(position[:, :2] - result.impact_axis)
            near_image = np.abs(offset) >= np.array(lattice.lengths) / 2 - pitch
            zone[SIDES] = np.any(near_image, axis=1)
        elif nx * ny > 1:
            zone[SIDES] = lattice.at_sides(ids)
    return zone


def cut_of(zone: Zone) -> list[str]:
    """Return the boundaries that a yielded sphere touches."""
    return [name for name in _WAYS if name in zone and np.any(zone["yielded"] & zone[name])]


def zone_summary(result: Result) -> dict[str, Any]:
    """Return the values of the summary on the size of the plastic zone, and whether the sides are
    periodic; sizes are None without yielding.

    In a collision of two spheres, the values on boundaries are None.
    """
    sides = {PERIODIC_SIDES: result.case.boundary.periodic}
    if not result.yields:
        keys = ("zone_cut", "zone_growing", PERIODIC_SIDES, *WAVE_KEYS)
        return zone_sizes(None) | dict.fromkeys(keys) | sides
    active, distances = _active_and_distances(result)
    sizes = zone_sizes(*map(active.get, ("energy", "volume", "depth", "radius")))
    border = {BOTTOM: sizes["zone_depth_99_m"], SIDES: sizes["zone_radius_99_m"]}
    times = _return_times(result, distances, border)
    lost = result.yield_ledger
    time = result["energy/time"]
    if lost[-1] <= _NOTHING * result.energy_input:
        lost = np.zeros_like(lost)
    growing = []
    when = active["yield_time"]
    has_yielded = np.isfinite(when)
    measured = [name for name in _WAYS.values() if name in active]
    for name in measured if has_yielded.any() else []:
        outermost = active[name] >= (1 - _SAME) * active[name][has_yielded].max()
        if np.nanmin(when[outermost]) > (1 - _LATE) * time[-1]:
            growing.append(name)
    cut: list[str] | None = cut_of(active)
    returns = wave_returns(times, time, lost)
    if result.n_spheres in COLLISION:
        cut = None
        returns = dict.fromkeys(WAVE_KEYS)
    return sizes | {"zone_cut": cut, "zone_growing": growing} | sides | returns


def _active_and_distances(result: Result) -> tuple[Zone, Zone]:
    """Return the columns of the spheres that yielded or dissipated energy, and the distances and
    bounds of all spheres, from one pass through the parts of the packing.
    """
    parts = [result] if result.n_spheres <= result.at_once else result.parts()
    active = []
    distances = []
    for zone in map(packing_zone, parts):
        chosen = zone["yielded"] | (zone["energy"] > 0) | np.isfinite(zone["yield_time"])
        active.append({name: column[chosen] for name, column in zone.items()})
        distances.append({name: zone[name] for name in _DISTANCES if name in zone})
    return _joined(active), _joined(distances)


def _joined(parts: Sequence[Zone]) -> Zone:
    """Return the columns of all parts, concatenated."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _return_times(
    result: Result, distances: Zone, border: dict[str, float | None]
) -> dict[str, float] | None:
    """Return the time at which a wave reflected by a boundary can return to the border of the zone,
    by boundary, s.

    The peak of the first wave is at the bound at t_b and was at the border of the zone, at
    ``border`` (m), at t_z on its way: the way back takes the same time, so that it returns at 2 t_b
    - t_z. Waves get weaker and slower on their way, so this is about the earliest time. No wave
    returns from a boundary that no wave reached within the run. If contacts are loaded from the
    start, arrivals cannot be observed: the wave is assumed to travel in all directions at the speed
    with which it reached the bottom. None if this speed is also unknown.
    """
    inner = {name: border[name] or 0.0 for name in _WAYS if name in distances}
    if result.case.precompression is None:
        sets = []
        for name, within in inner.items():
            beyond = distances[_WAYS[name]] >= (1 - _SAME) * within
            sets += [distances[name], beyond]
        arrivals = wave_arrivals(result, sets)
        found = zip(inner, arrivals[::2], arrivals[1::2], strict=True)
        return {name: far + max(far - near, 0.0) for name, far, near in found if np.isfinite(far)}
    target = reached(result)
    if target is None or "depth" not in distances:
        return None
    if not target.arrival:
        return {}
    speed = float(distances["depth"].max(initial=0.0)) / target.arrival
    times = {}
    for name, within in inner.items():
        at_bound = distances[_WAYS[name]][distances[name]]
        nearest = float(at_bound.min(initial=np.inf))
        times[name] = (nearest + max(nearest - within, 0.0)) / speed
    return {name: time for name, time in times.items() if np.isfinite(time)}


def wave_arrivals(result: Result, sets: Sequence[NDArray[np.bool_]]) -> list[float]:
    """Return the time of the peak of the first force at contacts of each set of spheres, s; inf:
    never.

    The first non-zero force does not mark a wave: rounding errors propagate by one sphere per step.
    Contacts of a set with less than a hundredth of its largest force do not count.

    Parameters
    ----------
    sets
        Members of each set, True for spheres of the packing in the set, without strikers:
        (n_spheres,).
    """
    last = result.assembly.lattice.n_spheres
    of_all = 0.0
    fronts = [np.empty((2, 0)) for _ in sets]  # force and time of each set
    for i, j, force, time in result.blocks(
        "contacts/i", "contacts/j", "contacts/peak_force", "contacts/time_peak"
    ):
        ends = np.stack([i, j])
        own = ends <= last
        at_rows = np.where(own, result.rows(ends), 0)
        of_all = max(of_all, float(force.max(initial=0.0)))
        for n, of_set in enumerate(sets):
            here = (own & of_set[at_rows]).any(axis=0) & (force > 0)
            fronts[n] = _front(np.concatenate([fronts[n], [force[here], time[here]]], axis=1))
    arrivals = []
    for force, time in fronts:
        largest = float(force.max(initial=0.0))
        first = float(np.nanmin(time[force >= _BEARS * largest], initial=np.inf))
        arrivals.append(first if largest > _NO_WAVE * of_all else np.inf)
    return arrivals


def _front(peaks: NDArray[np.float64]) -> NDArray[np.float64]:
    """Select the peaks that can be the first of a wave: forces, N, and times, s, (2, n).

    Only a contact with a larger force than all contacts with an earlier peak can be the first.
    """
    force, time = peaks
    bears = np.flatnonzero(force >= _BEARS * force.max(initial=0.0))
    by_time = bears[np.argsort(time[bears], kind="stable")]
    rises = np.diff(np.maximum.accumulate(force[by_time]), prepend=0.0) > 0
    return peaks[:, by_time[rises]]


class Mark(IntFlag):
    """Influence of the finite packing or block on its plastic zone, or of the end of the run or of
    contacts beyond the range of the law on any value. A value may have several marks.
    """

    NONE = 0
    WAVE = 1  # a reflected wave contributed to more than `NOTED_SHARE` of the dissipation
    CUT = 2  # the zone reaches a boundary
    LAW = 4  # contacts beyond the range of the law determine the value
    END = 8  # the end of the run limits the value


#: Text of a mark, next to a marker in a figure or a table.
LABELS = {
    Mark.CUT: "zone reaches a boundary",
    Mark.WAVE: "reflected wave came back",
    Mark.LAW: "contacts beyond the law",
    Mark.END: "not final at the end of the run",
}


def is_collision(summary: Mapping[str, Any]) -> bool:
    """Return True for a collision of two spheres, or of a sphere and a wall: no boundary limits its
    zone.
    """
    return summary.get("n_spheres") in COLLISION


def zone_marks(summary: Mapping[str, Any]) -> Mark:
    """Return all marks of the plastic zone of a run; `Mark.NONE` if its summary has no plastic
    zone, or for a collision of two spheres.
    """
    marks = Mark.NONE
    if is_collision(summary):
        return marks
    if summary.get("zone_cut"):
        marks |= Mark.CUT
    share = summary.get("wave_return_share")
    if isinstance(share, int | float) and share > NOTED_SHARE:
        marks |= Mark.WAVE
    return marks


def mark_of(summary: Mapping[str, Any]) -> Mark:
    """Return the most severe mark of the plastic zone of a run: `Mark.CUT` before `Mark.WAVE`."""
    marks = zone_marks(summary)
    return Mark.CUT if Mark.CUT in marks else marks


def bounds_in_words(bounds: object, *, periodic: object = False) -> str:
    """Return a list of bounds, or of other names, as words: ``bottom, sides``, or ``none`` if it is
    empty.

    Parameters
    ----------
    periodic
        True if the sides are periodic, so that there are images in place of sides.
    """
    if not isinstance(bounds, list | tuple):
        return ""
    return ", ".join(_names(bounds, periodic)) or "none"


def _names(bounds: Sequence[object], periodic: object) -> list[str]:
    """Return the names of bounds in texts."""
    return [IMAGES if periodic and bound == SIDES else str(bound) for bound in bounds]


def zone_warning(summary: Mapping[str, Any], body: str = "packing") -> str:
    """Return the caveats on the sizes of a plastic zone in a line; empty if there are none.

    Parameters
    ----------
    body
        Noun for the body that contains the zone.
    """
    is_chain = (
        summary.get("zone_radius_99_m", 0.0) is None and summary.get("zone_depth_99_m") is not None
    )
    if (
        summary.get("n_spheres") in (1, 2) or is_chain
    ):  # a collision, or a pulse that goes from end to end
        return ""
    found = []
    periodic = summary.get(PERIODIC_SIDES)
    if summary.get("zone_cut"):
        reached_bounds = " and the ".join(_names(summary["zone_cut"], periodic))
        found.append(f"the plastic zone reaches the {reached_bounds} of the {body}")
    share = summary.get("wave_return_share")
    if isinstance(share, int | float) and share > NOTED_SHARE:
        names = _names(summary.get("wave_returned") or (), periodic)
        wave = "wave" if IMAGES in names else "reflection"
        microseconds = 1e6 * summary["wave_return_s"]
        arrival = f"a {wave} from the {' and the '.join(names)} arrived ({microseconds:.3g} µs)"
        found.append(
            f"up to {100 * share:.3g} % of the plastic dissipation occurred after {arrival}"
        )
    return f"{'; '.join(found)}. Use a larger {body} to avoid this." if found else ""
