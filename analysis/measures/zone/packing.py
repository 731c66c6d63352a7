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
from granwave.lammps_inputs.packing.places import Places

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


def packing_zone(result: Result) -> PackingZone:
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
        arrival=None if result.case.precompression is not None else result["spheres/time_first"][own],
        yield_time=result["spheres/time_yield"][own],
    )


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
    if isinstance(lattice, Places):
        return {}  # such grains may leave off anywhere
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

    The first wave reaches the bound at t_b and passed the border of the zone, at ``border`` (m), at t_z on its way: it
    takes as long back, and returns at 2 t_b - t_z. Waves get weaker and slower on their way, so this is about the
    earliest time. A bound that no wave reached within the run sends none back. Where contacts are loaded from the start
    arrivals cannot be seen; then the wave goes all ways at the speed with which it reached the bottom. None where
    that is not known either.
    """
    distances = {BOTTOM: zone.depth, SIDES: zone.radius}
    times = {}
    if zone.arrival is None:
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
    arrival = np.where(np.isnan(zone.arrival), np.inf, zone.arrival)
    for name, touching in zone.bounds.items():
        distance, inner = distances[name], border[name]
        assert distance is not None and inner is not None
        at_bound = float(arrival[touching].min(initial=np.inf))
        outside = distance >= (1 - _SAME) * inner
        at_border = float(arrival[outside].min(initial=np.inf))
        if np.isfinite(at_bound):
            times[name] = at_bound + max(at_bound - at_border, 0.0)
    return times
