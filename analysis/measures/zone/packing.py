"""Plastic zone of a packing: its size, the bounds that it reaches, and the waves that come back from them.

The energy that a sphere dissipated by yielding is half of that of each of its contacts, all of it where the partner is
harder, and what it left at walls, which stays with the sphere that touches the wall. Friction and dampers do not count,
nor do strikers: they are no part of the packing.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.target.record import reached
from granwave.analysis.measures.zone.size import BOTTOM, SIDES, WAVE_KEYS, Array, wave_returns, zone_sizes
from granwave.analysis.result.reader import PartOfResult, Result

_SAME = 1e-9  # relative, of lengths that are equal but for rounding
_LATE = 0.1  # of a run: where the outermost yield came within so much of its end it may go on


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
    arrival
        When a contact of the sphere was first loaded, s; NaN: never. None where contacts are loaded from the start.
    yield_time
        When a contact of the sphere first yielded, s; NaN: never.
    """

    energy: Array
    volume: Array
    depth: Array | None
    radius: Array | None
    yielded: NDArray[np.bool_]
    bounds: dict[str, NDArray[np.bool_]]
    arrival: Array | None
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
    nx, ny, nz = result.assembly.lattice.shape
    offset = (result["spheres/position"] - result.origin)[own]
    periods = np.array(result.assembly.lattice.lengths) if result.case.boundary.sides == "periodic" else None
    if periods is not None:
        offset[:, :2] -= periods * np.round(offset[:, :2] / periods)
    energy = np.maximum(result.yield_energy[own], 0.0)
    return PackingZone(
        energy=energy,
        volume=4 / 3 * np.pi * result["spheres/radius"][own] ** 3,
        depth=np.maximum(offset[:, 2], 0.0) if nz > 1 else None,
        radius=np.hypot(offset[:, 0], offset[:, 1]) if nx * ny > 1 else None,
        yielded=(result["spheres/contacts_yielded"][own] > 0) | (energy > 0),
        bounds=_bounds(result, own, offset, periods),
        arrival=None if result.case.precompression is not None else result["spheres/time_first"][own],
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
    waves = wave_returns(times, result["energy/time"], result.yield_ledger)
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
    nx, ny, nz = lattice.shape
    site = result["spheres/id"][own] - 1
    found = {}
    if nz > 1:
        found[BOTTOM] = site // (nx * ny) == nz - 1
    if periods is not None:
        pitch = np.array(lattice.rule.pitch) * lattice.diameter
        found[SIDES] = np.any(np.abs(offset[:, :2]) >= periods / 2 - pitch, axis=1)
    elif nx * ny > 1:
        ends = [(place == 0) | (place == n - 1) for place, n in ((site % nx, nx), (site // nx % ny, ny)) if n > 1]
        found[SIDES] = np.any(ends, axis=0)
    return found


def _return_times(
    result: Result, zones: Callable[[], Iterable[PackingZone]], border: dict[str, float | None]
) -> dict[str, float] | None:
    """Return when a wave that a bound reflects can be back at the border of the zone, by bound, s.

    The first wave reaches the bound at t_b and passed the border of the zone, at ``border`` (m), at t_z on its way: it
    takes as long back, and returns at 2 t_b - t_z. Waves get weaker and slower on their way, so this is about the
    earliest time. A bound that no wave reached within the run sends none back. Where contacts are loaded from the start
    arrivals cannot be seen; then the wave goes all ways at the speed with which it reached the bottom. None where
    that is not known either.
    """
    first = next(iter(zones()))
    times = {}
    if first.arrival is None:
        found = reached(result)
        if found is None or found.arrival is None or first.depth is None or not found.arrival > 0:
            return None if found is None or first.depth is None else {}
        speed = max(float(_distance(zone, BOTTOM).max(initial=0.0)) for zone in zones()) / found.arrival
        for name in first.bounds:
            inner = border[name]
            assert inner is not None  # of a bound that there is
            nearest = min(float(_distance(zone, name)[zone.bounds[name]].min(initial=np.inf)) for zone in zones())
            times[name] = (nearest + max(nearest - inner, 0.0)) / speed
        return {name: time for name, time in times.items() if np.isfinite(time)}
    for name in first.bounds:
        inner = border[name]
        assert inner is not None
        at_bound = min(_arrival(zone, zone.bounds[name]) for zone in zones())
        at_border = min(_arrival(zone, _distance(zone, name) >= (1 - _SAME) * inner) for zone in zones())
        if np.isfinite(at_bound):
            times[name] = at_bound + max(at_bound - at_border, 0.0)
    return times


def _arrival(zone: PackingZone, spheres: NDArray[np.bool_]) -> float:
    """Return when the first of some spheres of a zone was reached, s; inf: never."""
    assert zone.arrival is not None
    return float(np.nanmin(zone.arrival[spheres], initial=np.inf))


def _distance(zone: PackingZone, bound: str) -> Array:
    """Return how far the spheres are out towards a bound that there is: (n_spheres,), m."""
    distance = {BOTTOM: zone.depth, SIDES: zone.radius}[bound]
    assert distance is not None
    return distance
