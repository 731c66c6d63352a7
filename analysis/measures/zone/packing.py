"""Plastic zone of a packing: its size, the bounds that it reaches, and the waves that come back from them.

The energy that a sphere dissipated by yielding is half of that of each of its contacts, all of it where the partner is
harder, and what it left at walls, which stays with the sphere that touches the wall. Friction and dampers do not count,
nor do strikers: they are no part of the packing.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.target.record import reached
from granwave.analysis.measures.zone.size import BOTTOM, SIDES, WAVE_KEYS, Array, wave_returns, zone_sizes
from granwave.analysis.result.reader import Result

_SAME = 1e-9  # relative, of lengths that are equal but for rounding
_LATE = 0.1  # of a run: where the outermost yield came within so much of its end it may go on
_BEARS = 0.01  # of the largest force among some contacts: those that bear less are not what the wave came through
_NO_WAVE = 1e-6  # of the largest force of the run: what stays below is rounding, or runs ahead of the wave


@dataclasses.dataclass(frozen=True, eq=False)
class Waves:
    """Peaks of the forces between spheres, which tell when the wave was where.

    The first force at all tells nothing of a wave: rounding passes one on by a sphere a step.

    Attributes
    ----------
    ends
        Rows of the two spheres of each contact among those of the packing, -1 for a striker: (n_contacts, 2).
    force
        Peak force of each contact: (n_contacts,), N.
    time
        When it was reached: (n_contacts,), s.
    """

    ends: NDArray[np.int64]
    force: Array
    time: Array

    def arrival(self, spheres: NDArray[np.bool_]) -> float:
        """Return when the first force at contacts of some spheres, (n_spheres,), was at its peak, s; inf: never.

        Contacts that bear less than a hundredth of the largest force among these contacts do not count.
        """
        of_them = np.append(spheres, False)[self.ends].any(axis=1)
        largest = float(self.force[of_them].max(initial=0.0))
        if not largest > _NO_WAVE * float(self.force.max(initial=0.0)):
            return np.inf
        return float(np.nanmin(self.time[of_them & (self.force >= _BEARS * largest)], initial=np.inf))


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
    waves
        Contacts that the wave came through, with the times of their peaks. None where contacts are loaded from the
        start.
    yield_time
        When a contact of the sphere first yielded, s; NaN: never.
    """

    energy: Array
    volume: Array
    depth: Array | None
    radius: Array | None
    yielded: NDArray[np.bool_]
    bounds: dict[str, NDArray[np.bool_]]
    waves: Waves | None
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


def packing_zone(result: Result) -> PackingZone:
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
        waves=None if result.case.precompression is not None else _waves(result, own),
        yield_time=result["spheres/time_yield"][own],
    )


def _waves(result: Result, own: NDArray[np.bool_]) -> Waves:
    """Return the peaks at all contacts with a sphere of the packing, ``own``."""
    row = np.where(own, np.cumsum(own) - 1, -1)
    return Waves(row[result.ends], result["contacts/peak_force"], result["contacts/time_peak"])


def zone_summary(result: Result) -> dict[str, Any]:
    """Return the part of the summary that is about the size of the plastic zone; null where nothing can yield."""
    if not result.yields:
        return zone_sizes(None) | dict.fromkeys(("zone_cut", "zone_growing", *WAVE_KEYS))
    zone = packing_zone(result)
    sizes = zone_sizes(zone.energy, zone.volume, zone.depth, zone.radius)
    times = _return_times(result, zone, {BOTTOM: sizes["zone_depth_99_m"], SIDES: sizes["zone_radius_99_m"]})
    waves = wave_returns(times, result["energy/time"], result.yield_ledger)
    reached = {"zone_cut": zone.cut, "zone_growing": zone.growing(float(result["energy/time"][-1]))}
    return sizes | reached | waves


def _bounds(result: Result, own: NDArray[np.bool_], offset: Array, periods: Array | None) -> dict[str, NDArray]:
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


def _return_times(result: Result, zone: PackingZone, border: dict[str, float | None]) -> dict[str, float] | None:
    """Return when a wave that a bound reflects can be back at the border of the zone, by bound, s.

    The peak of the first wave is at the bound at t_b and was at the border of the zone, at ``border`` (m), at t_z on
    its way: it takes as long back, and returns at 2 t_b - t_z. Waves get weaker and slower on their way, so this is
    about the earliest time. A bound that no wave reached within the run sends none back. Where contacts are loaded
    from the start arrivals cannot be seen; then the wave goes all ways at the speed with which it reached the bottom.
    None where that is not known either.
    """
    distances = {BOTTOM: zone.depth, SIDES: zone.radius}
    times = {}
    if zone.waves is None:
        found, depth = reached(result), zone.depth
        if found is None or found.arrival is None or depth is None or not found.arrival > 0:
            return None if found is None or depth is None else {}
        speed = float(depth.max()) / found.arrival
        for name, touching in zone.bounds.items():
            distance, inner = distances[name], border[name]
            assert distance is not None and inner is not None  # of a bound that there is
            nearest = float(distance[touching].min(initial=np.inf))
            times[name] = (nearest + max(nearest - inner, 0.0)) / speed
        return {name: time for name, time in times.items() if np.isfinite(time)}
    for name, touching in zone.bounds.items():
        distance, inner = distances[name], border[name]
        assert distance is not None and inner is not None
        at_bound = zone.waves.arrival(touching)
        at_border = zone.waves.arrival(distance >= (1 - _SAME) * inner)
        if np.isfinite(at_bound):
            times[name] = at_bound + max(at_bound - at_border, 0.0)
    return times
