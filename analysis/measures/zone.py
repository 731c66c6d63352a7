"""Plastic zone of a packing: its size, the bounds that it reaches, and the waves that come back from them.

The energy that a sphere dissipated by yielding is half of that of each of its contacts, all of it where the partner is
harder, and what it left at walls, which stays with the sphere that touches the wall. Friction and dampers do not count,
nor do strikers: they are no part of the packing.

A contact has yielded when its largest overlap passed alpha_y (elastoplastic, thornton) or when it was loaded
at all (bilinear); with hertz none yields. A dent from before the run must have grown in it. The elasto-plastic law was
fitted up to an overlap of about 0.2 R*; from 0.1 R* on the plastic zones of one sphere's contacts may begin to touch.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target import reached
from granwave.analysis.measures.zone_size import BOTTOM, SIDES, WAVE_KEYS, wave_returns, zone_sizes
from granwave.analysis.result.reader import PartOfResult, Result
from granwave.lammps_inputs.packing.places import Places

_SAME = 1e-9  # relative, of lengths that are equal but for rounding
_LATE = 0.1  # of a run: where the outermost yield came within so much of its end it may go on
_BEARS = 0.01  # of the largest force among some contacts: those that bear less are not what the wave came through
_ROUNDING = 1e-12  # of the input: yielding where nothing yields, left by subtraction
_NO_WAVE = 1e-6  # of the largest force of the run: what stays below is rounding, or runs ahead of the wave


LAW_LIMIT = 0.2  # of R*: the largest overlap that the elasto-plastic law was fitted to
HALF_LAW_LIMIT = 0.1  # of R*


@dataclasses.dataclass(frozen=True, eq=False)
class PackingZone:
    """Spheres of the packing, strikers left out, as the plastic zone needs them; every array (n_spheres,).

    Attributes
    ----------
    energy
        Dissipated by yielding, J.
    volume
        m^3.
    depth
        Of the centres below that of the struck sphere, m; None in a packing of one layer.
    radius
        Distance of the centres from the impact axis, m; None in a chain.
    yielded
        Spheres with a contact that yielded, or that dissipated energy at a wall.
    bounds
        Spheres that touch each bound, by its name: the last layer is at the ``bottom``, the first and last sphere of a
        row and the first and last row at the ``sides``. With periodic sides those half a period from the axis are,
        where a zone meets its image. A packing of one layer has no bottom, a chain no sides.
    yield_time
        When a contact of the sphere first yielded, s; NaN: never.
    """

    energy: Array
    volume: Array
    depth: Array | None
    radius: Array | None
    yielded: NDArray[np.bool_]
    bounds: dict[str, NDArray[np.bool_]]
    yield_time: Array

    @property
    def cut(self) -> list[str]:
        """Bounds that a yielded sphere touches."""
        return [name for name, touching in self.bounds.items() if np.any(self.yielded & touching)]

    def growing(self, end_time: float) -> list[str]:
        """Outermost yields, ``depth`` or ``radius``, that moved out in the last tenth of a run of so many seconds."""
        spheres = np.isfinite(self.yield_time)
        found = []
        for name, distance in (("depth", self.depth), ("radius", self.radius)):
            if distance is None or not spheres.any():
                continue
            outermost = distance[spheres] >= (1 - _SAME) * distance[spheres].max()
            if self.yield_time[spheres][outermost].min() > (1 - _LATE) * end_time:
                found.append(name)
        return found


def packing_zone(result: Result | PartOfResult) -> PackingZone:
    """Return what the plastic zone of a run is made of."""
    own = result.in_packing
    lattice = result.assembly.lattice
    nx, ny, nz = lattice.shape
    free = isinstance(lattice, Places)
    offset = (result["spheres/position"] - result.origin)[own]
    periods = np.array(lattice.lengths) if result.case.boundary.sides == "periodic" else None
    if periods is not None:
        offset[:, :2] -= periods * np.round(offset[:, :2] / periods)
    energy = np.maximum(result.yield_energy[own], 0.0)
    return PackingZone(
        energy=energy,
        volume=4 / 3 * np.pi * result["spheres/radius"][own] ** 3,
        depth=np.maximum(offset[:, 2], 0.0) if nz > 1 or free else None,
        radius=np.hypot(offset[:, 0], offset[:, 1]) if nx * ny > 1 or free else None,
        yielded=(result["spheres/contacts_yielded"][own] > 0) | (energy > 0),
        bounds=_bounds(result, own, offset, periods),
        yield_time=result["spheres/time_yield"][own],
    )


def zone_summary(result: Result) -> dict[str, Any]:
    """Return the part of the summary that is about the size of the plastic zone; null where nothing can yield."""
    if not result.yields:
        return zone_sizes(None) | dict.fromkeys(("zone_cut", "zone_growing", *WAVE_KEYS))
    single = [packing_zone(result)] if result.n_spheres <= result.at_once else None

    def zones() -> Iterable[PackingZone]:
        """Return the zones of all parts of the packing, made anew each time if there are several."""
        return single or map(packing_zone, result.parts())

    zone = _active(zones())
    sizes = zone_sizes(zone.energy, zone.volume, zone.depth, zone.radius)
    times = _return_times(result, zones, {BOTTOM: sizes["zone_depth_99_m"], SIDES: sizes["zone_radius_99_m"]})
    lost = result.yield_ledger
    if lost[-1] <= _ROUNDING * result.energy_input:
        lost = np.zeros_like(lost)
    waves = wave_returns(times, result["energy/time"], lost)
    reached = {"zone_cut": zone.cut, "zone_growing": zone.growing(float(result["energy/time"][-1]))}
    return sizes | reached | waves


def _active(zones: Iterable[PackingZone]) -> PackingZone:
    """Join the spheres of some zones that yielded or dissipated; sizes and bounds of a zone follow from these alone."""
    found = [(zone, zone.yielded | (zone.energy > 0) | np.isfinite(zone.yield_time)) for zone in zones]
    first = found[0][0]

    def column(name: str) -> NDArray | None:
        if getattr(first, name) is None:
            return None
        return np.concatenate([getattr(zone, name)[kept] for zone, kept in found])

    columns = {field.name: column(field.name) for field in dataclasses.fields(PackingZone) if field.name != "bounds"}
    bounds = {name: np.concatenate([zone.bounds[name][kept] for zone, kept in found]) for name in first.bounds}
    return PackingZone(bounds=bounds, **columns)  # type: ignore[arg-type]


def _bounds(
    result: Result | PartOfResult, own: NDArray[np.bool_], offset: Array, periods: Array | None
) -> dict[str, NDArray]:
    """Spheres that touch each bound, by its name; see `PackingZone`."""
    lattice = result.assembly.lattice
    if isinstance(lattice, Places):
        return {}  # such grains may leave off anywhere
    nx, ny, nz = lattice.shape
    ids = result["spheres/id"][own]
    found = {}
    if nz > 1:
        found[BOTTOM] = ids >= lattice.last_layer[0]
    if periods is not None:
        pitch = np.array(lattice.rule.pitch) * lattice.diameter
        found[SIDES] = np.any(np.abs(offset[:, :2]) >= periods / 2 - pitch, axis=1)
    elif nx * ny > 1:
        found[SIDES] = lattice.at_sides(ids)
    return found


def _return_times(
    result: Result, zones: Callable[[], Iterable[PackingZone]], border: dict[str, float | None]
) -> dict[str, float] | None:
    """Return when a wave that a bound reflects can be back at the border of the zone, by bound, s.

    The peak of the first wave is at the bound at t_b and was at the border of the zone, at ``border`` (m), at t_z on
    its way: it takes as long back, and returns at 2 t_b - t_z. Waves get weaker and slower on their way, so this is
    about the earliest time. A bound that no wave reached within the run sends none back. Where contacts are loaded
    from the start arrivals cannot be seen; then the wave goes all ways at the speed with which it reached the bottom.
    None where that is not known either.
    """
    first = next(iter(zones()))
    inner = {name: border[name] for name in first.bounds}
    if result.case.precompression is not None:
        times = _at_one_speed(result, zones, inner)
        return times if times is None else {name: time for name, time in times.items() if np.isfinite(time)}

    def outside(zone: PackingZone, name: str) -> NDArray[np.bool_]:
        return _distance(zone, name) >= (1 - _SAME) * (inner[name] or 0.0)

    sets = [[part for name in inner for part in (zone.bounds[name], outside(zone, name))] for zone in zones()]
    arrivals = wave_arrivals(result, sets)
    found = zip(inner, arrivals[::2], arrivals[1::2], strict=True)
    return {name: far + max(far - near, 0.0) for name, far, near in found if np.isfinite(far)}


def _at_one_speed(
    result: Result, zones: Callable[[], Iterable[PackingZone]], border: dict[str, float | None]
) -> dict[str, float] | None:
    """Return the times of waves that go all ways at the speed with which they reached the bottom, s."""
    found, first = reached(result), next(iter(zones()))
    if found is None or found.arrival is None or first.depth is None or not found.arrival > 0:
        return None if found is None or first.depth is None else {}
    speed = max(float(_distance(zone, BOTTOM).max(initial=0.0)) for zone in zones()) / found.arrival
    times = {}
    for name, inner in border.items():
        assert inner is not None  # of a bound that there is
        nearest = min(float(_distance(zone, name)[zone.bounds[name]].min(initial=np.inf)) for zone in zones())
        times[name] = (nearest + max(nearest - inner, 0.0)) / speed
    return times


def wave_arrivals(result: Result, sets: list[list[NDArray[np.bool_]]]) -> list[float]:
    """Return when the first force at contacts of each set of spheres was at its peak, s; inf: never.

    The first force at all tells nothing of a wave: rounding passes one on by a sphere a step. Contacts of a set that
    bear less than a hundredth of the largest force among them do not count.

    Parameters
    ----------
    sets
        Members of each set, by part of the packing, without strikers: lists of (n_spheres,).
    """
    # a bit for each sphere, so that sets of large packings are small
    members = [np.packbits(np.concatenate(parts)) for parts in zip(*sets, strict=True)]
    last = result.assembly.lattice.n_spheres
    largest, of_all = np.zeros(len(members)), 0.0
    arrival = np.full(len(members), np.inf)

    def contacts() -> Iterator[tuple[Array, Array, list[NDArray[np.bool_]]]]:
        """Iterate over forces, times and membership of contacts, in blocks."""
        for i, j, force, time in result.blocks("contacts/i", "contacts/j", "contacts/peak_force", "contacts/time_peak"):
            ends = np.stack([i, j])
            rows, own = result.rows(ends), ends <= last
            at_rows = np.where(own, rows, 0)
            yield force, time, [np.asarray((own & _has(bits, at_rows)).any(axis=0)) for bits in members]

    for force, _, touching in contacts():
        of_all = max(of_all, float(force.max(initial=0.0)))
        largest = np.maximum(largest, [float(force[here].max(initial=0.0)) for here in touching])
    for force, time, touching in contacts():
        for n, here in enumerate(touching):
            bears = here & (force >= _BEARS * largest[n])
            arrival[n] = min(arrival[n], float(np.nanmin(time[bears], initial=np.inf)))
    return [
        time if force > _NO_WAVE * of_all else np.inf for time, force in zip(arrival.tolist(), largest, strict=True)
    ]


def _has(bits: NDArray[np.uint8], rows: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return True for the rows whose bit is set."""
    return np.asarray((bits[rows >> 3] >> (7 - (rows & 7)).astype(np.uint8)) & 1, dtype=bool)


def _distance(zone: PackingZone, bound: str) -> Array:
    """Return how far the spheres are out towards a bound that there is: (n_spheres,), m."""
    distance = {BOTTOM: zone.depth, SIDES: zone.radius}[bound]
    assert distance is not None
    return distance


@dataclass(frozen=True)
class PlasticZone:
    """The spheres with at least one contact that yielded.

    Attributes
    ----------
    n_spheres
        How many.
    volume
        Their volume, m^3.
    depth
        From the struck sphere's centre to the deepest of their centres, m.
    radius
        Largest lateral distance of their centres from the impact axis, m.
    """

    n_spheres: int
    volume: float
    depth: float
    radius: float


def plastic_zone(
    positions: NDArray[np.float64],
    radii: NDArray[np.float64],
    plastic: NDArray[np.bool_],
    origin: NDArray[np.float64],
) -> PlasticZone:
    """The plastic zone of a packing.

    Parameters
    ----------
    positions
        At the start: (n_spheres, 3), m.
    radii
        (n_spheres,), m.
    plastic
        Which spheres belong to it: (n_spheres,).
    origin
        Centre of the struck sphere at the start: (3,), m.
    """
    offset = positions[plastic] - origin
    return PlasticZone(
        n_spheres=int(np.count_nonzero(plastic)),
        volume=float(np.sum(4 / 3 * np.pi * radii[plastic] ** 3)),
        depth=float(np.max(offset[:, 2], initial=0.0)),
        radius=float(np.max(np.hypot(offset[:, 0], offset[:, 1]), initial=0.0)),
    )
