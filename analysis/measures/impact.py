"""Impacts: dissipation by mechanism, energy by region, the quadratic law, and the normalised
velocity.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.measures.dynamic_force import dynamic_peak_forces
from granwave.analysis.measures.geometry import layers, nearest, preferred_directions
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves import energy_of_spheres
from granwave.analysis.result.reader import Result

_ON_RAY = 0.25  # largest distance of a sphere from its position on a ray, diameters


def ranked(dissipated: Array) -> NDArray[np.int64]:
    """Rows of the spheres that dissipated energy, in descending order of their dissipation."""
    order = np.argsort(-dissipated, kind="stable")
    return order[: np.count_nonzero(dissipated > 0)]


def cumulated(
    dissipated: Array, energy_input: float, volume: Array | None = None
) -> tuple[Array, NDArray]:
    """Cumulative dissipated fraction of the input against the volume of the dissipating spheres, in
    descending order of their dissipation.

    Parameters
    ----------
    dissipated
        By sphere: (n_spheres,), J.
    energy_input
        J.
    volume
        Volume of each sphere, in units of pi D^3/6: (n_spheres,); 1 by default, so that the volume
        of identical spheres is their number.

    Returns
    -------
    tuple
        Fraction of the input, and volume, so far: (n,) each.
    """
    rows = ranked(dissipated)
    share = np.cumsum(dissipated[rows]) / energy_input
    return share, np.arange(1, len(rows) + 1) if volume is None else np.cumsum(volume[rows])


@dataclass(frozen=True, eq=False)
class ZoneGrowth:
    """The plastic zone in time; every array (n_times,)."""

    time: Array  # time of the growth of the zone, s
    contacts: NDArray[np.int64]  # yielded so far
    spheres: NDArray[np.int64]
    depth: Array  # depth of the deepest plastic centre below the impacted sphere, m
    radius: Array  # largest distance of a plastic centre from the impact axis, m


def zone_growth(result: Result) -> ZoneGrowth:
    """Growth of the plastic zone, from the times at which contacts yielded."""
    yielded = result["contacts/yielded"].astype(bool)
    when = result["contacts/time_yield"][yielded]
    ends = result.ends[yielded]
    order = np.argsort(when, kind="stable")
    when = when[order]
    ends = ends[order]
    _, first = np.unique(ends.ravel(), return_index=True)
    new = np.zeros(ends.size, dtype=np.int64)
    new[first] = 1
    position = result["spheres/position"]
    below = position[:, 2] - result.origin[2]
    from_axis = result.distance_from_axis(position)
    depth = np.maximum.accumulate(below[ends].max(axis=1, initial=0.0))
    radius = np.maximum.accumulate(from_axis[ends].max(axis=1, initial=0.0))
    time, last = np.unique(when[::-1], return_index=True)
    last = len(when) - 1 - last
    spheres = np.cumsum(new.reshape(-1, 2).sum(axis=1))
    return ZoneGrowth(time, last + 1, spheres[last], depth[last], radius[last])


@dataclass(frozen=True, eq=False)
class Rays:
    """Peak forces of the contacts along the preferred directions.

    Attributes
    ----------
    directions
        Unit vectors: (n_directions, 3).
    peak_force
        Of the n-th contact from the impacted sphere: (n_contacts, n_directions), N; NaN beyond the
        packing, and where a sphere is missing.
    time_peak
        Time of this force: (n_contacts, n_directions), s; NaN without contact.
    """

    directions: Array
    peak_force: Array
    time_peak: Array

    @property
    def difference(self) -> Array:
        """Largest minus smallest peak force divided by the largest, for contacts that all rays
        have: (n,).

        By symmetry it is 0 if one sphere is impacted.
        """
        complete = self.peak_force[~np.isnan(self.peak_force).any(axis=1)]
        largest = complete.max(axis=1, initial=0.0)
        return (largest - complete.min(axis=1, initial=np.inf)) / np.where(
            largest > 0, largest, 1.0
        )


def rays(result: Result) -> Rays:
    """Peak force of every contact along each preferred direction, starting at the impacted sphere.

    Each sphere of a ray is the sphere nearest to the position in a perfect packing, within a
    quarter of a diameter. Grains of a file have no such directions: there is no ray.
    """
    directions = preferred_directions(result.case.packing.kind)
    if not len(directions):
        return Rays(directions, np.empty((0, 0)), np.empty((0, 0)))
    diameter = result.case.packing.diameter
    positions = result["spheres/position"]
    ids = result["spheres/id"]
    reach = int(np.linalg.norm(np.ptp(positions, axis=0)) / diameter) + 2
    forces = []
    times = []
    for direction in directions:
        points = result.origin + np.arange(reach)[:, None] * diameter * direction
        distance, row = nearest(points, positions)
        found = np.where(distance <= _ON_RAY * diameter, ids[row], 0)
        forces.append(result.of_pairs("peak_force", found[:-1], found[1:], np.nan))
        times.append(result.of_pairs("time_peak", found[:-1], found[1:], np.nan))
    table = np.stack(forces, axis=1)
    there = np.flatnonzero(np.isfinite(table).any(axis=1))
    n_contacts = there[-1] + 1 if there.size else 0
    return Rays(directions, table[:n_contacts], np.stack(times, axis=1)[:n_contacts])


def peak_force_by_depth(result: Result, *, dynamic: bool = False) -> tuple[Array, Array]:
    """Depth below the impacted sphere, m, and largest peak force of a contact, N, of each layer:
    (n_layers,) each.

    Parameters
    ----------
    dynamic
        True for the largest rise above the static force of each contact.
    """
    depth = result["spheres/position"][:, 2] - result.origin[2]
    mean, layer = layers(depth, result["spheres/radius"], result.case.packing.diameter)
    force = np.zeros(len(mean))
    peaks = dynamic_peak_forces(result) if dynamic else result["spheres/peak_force"]
    np.maximum.at(force, layer, peaks)
    return mean, force


@dataclass(frozen=True, eq=False)
class Involved:
    """Material in descending order of its dissipation, cumulated; arrays (n,).

    Attributes
    ----------
    fraction
        Of the input, dissipated in the material so far.
    volume
        Of the solid, m^3.
    """

    fraction: Array
    volume: Array

    def part(self, share: float) -> tuple[float, float]:
        """Fraction of the input, and volume, of the least material that contains a fraction of the
        dissipation.
        """
        enough = self.enough(share)
        return float(self.fraction[enough]), float(self.volume[enough])

    def enough(self, share: float) -> int:
        """Index of the last element of the least material that contains a fraction of the
        dissipation.
        """
        return int(np.searchsorted(self.fraction, share * self.fraction[-1]))


def spheres_involved(result: Result, energy_input: float) -> Involved:
    """Return the spheres that dissipated; the input is in J."""
    fraction, count = cumulated(result["spheres/dissipated_energy"], energy_input)
    return Involved(fraction, math.pi * result.case.packing.diameter**3 / 6 * count)


def energy_by_region(result: Result, regions: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Fraction of the input in each region of a packing: kinetic energy, and half the elastic
    energy of contacts.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    regions
        Ids of the spheres of each region, by name; strikers are spheres too.

    Returns
    -------
    dict
        Fractions at each snapshot, (n_frames,), by the name of the region. Further entries are
        ``other spheres``, outside all regions; ``walls``, the elastic energy of contacts with
        walls; and ``dissipated``. In an impact, the sum of all entries is the input if the regions
        do not overlap.
    """
    energy = (
        np.stack([energy_of_spheres(result, frame) for frame in range(result.n_frames)])
        / result.energy_input
    )
    rows = {name: result.rows(np.asarray(ids)) for name, ids in regions.items()}
    rest = np.setdiff1d(np.arange(energy.shape[1]), np.concatenate([*rows.values()]))
    found = {
        name: energy[:, chosen].sum(axis=1)
        for name, chosen in (rows | {"other spheres": rest}).items()
    }
    time = result["energy/time"]
    given = result["energy/input"][-1]
    for name, term in (("walls", "elastic_wall"), ("dissipated", "dissipated")):
        found[name] = np.interp(result.frame_times, time, result[f"energy/{term}"] / given)
    return found


_CONSTANTS = 3  # number of constants of the quadratic law


@dataclass(frozen=True, eq=False)
class QuadraticLaw:
    """Dissipation as ``D0 + D1 v + D2 v^2``.

    Attributes
    ----------
    constants, deviations
        D0, D1, D2 and their standard deviations: (3,); the deviations are NaN if three points were
        fitted, which the law then meets exactly.
    misfit
        Largest |law / dissipation - 1| of the fitted points.
    lowest
        Smallest velocity that was fitted.
    """

    constants: Array
    deviations: Array
    misfit: float
    lowest: float

    def __call__(self, velocity: Array) -> Array:
        """Dissipation at velocities."""
        return np.asarray(
            np.polynomial.polynomial.polyval(velocity, self.constants), dtype=np.float64
        )


def quadratic_law(velocity: ArrayLike, dissipation: ArrayLike) -> QuadraticLaw:
    """Fit the law, every point with the same relative weight.

    Parameters
    ----------
    velocity, dissipation
        At least three points: (n,) each.

    Raises
    ------
    ValueError
        There are fewer than three points.
    """
    velocity = np.asarray(velocity, dtype=np.float64)
    dissipation = np.asarray(dissipation, dtype=np.float64)
    n_points = len(velocity)
    if n_points < _CONSTANTS:
        raise ValueError(
            f"the quadratic law has {_CONSTANTS} constants: found {n_points} points, expected at"
            f" least {_CONSTANTS}"
        )
    matrix = (
        np.stack([np.ones_like(velocity), velocity, velocity**2], axis=1) / dissipation[:, None]
    )
    constants = np.asarray(np.linalg.lstsq(matrix, np.ones_like(velocity))[0], dtype=np.float64)
    residual = matrix @ constants - 1
    deviations = np.full(_CONSTANTS, np.nan)
    if n_points > _CONSTANTS:
        scatter = residual @ residual / (n_points - _CONSTANTS)
        deviations = np.sqrt(scatter * np.diag(np.linalg.inv(matrix.T @ matrix)))
    return QuadraticLaw(constants, deviations, float(np.abs(residual).max()), float(velocity.min()))
