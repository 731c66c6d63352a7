"""Velocities along a line of grains of a run: beads of a chain, layers of a packing, or grains that the user names.

Snapshots are taken at whole timesteps, so that their times are not quite even; velocities are interpolated between them
at even times (cubic splines).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from granwave.analysis.errors import MissingDataError
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

Ints = NDArray[np.int64]


def velocities_of_chain(result: Result) -> tuple[Array, Array, Array]:
    """Return times (n_times,), s, places before the load (n_beads,), m, and velocities (n_times, n_beads), m/s.

    Raises
    ------
    MissingDataError
        The run has no history of a chain.
    """
    if "chain" not in result:
        raise MissingDataError(f"{result.path}: has no history of a chain; run one with output.history")
    return _evenly(result["chain/time"], result["chain/position"], result["chain/velocity"])


def velocities_of_layers(result: Result, axis: int = 2) -> tuple[Array, Array, Array]:
    """Return times, depths of the layers and their mean velocities along an axis, as `velocities_of_chain`."""
    nx, ny, _ = result.assembly.lattice.shape
    return _of_groups(result, (result["spheres/id"] - 1) // (nx * ny), 2, axis)


def velocities_of_columns(result: Result, axis: int = 0) -> tuple[Array, Array, Array]:
    """Return times, places along x of the columns across it and their mean velocities, as `velocities_of_chain`."""
    nx, _, _ = result.assembly.lattice.shape
    return _of_groups(result, (result["spheres/id"] - 1) % nx, 0, axis)


def _of_groups(result: Result, group: Ints, along: int, axis: int) -> tuple[Array, Array, Array]:
    """Means over groups of the spheres of the lattice (n_spheres,), strikers left out."""
    own = result["spheres/id"] <= result.assembly.lattice.n_spheres
    group = group[own]
    count = np.bincount(group)
    place = np.bincount(group, result["spheres/position"][own, along]) / count
    frames = (result.frame(frame, "velocity")[own, axis] for frame in range(result.n_frames))
    return _evenly(result.frame_times, place, np.stack([np.bincount(group, frame) / count for frame in frames]))


def velocities_along(result: Result, ids: Sequence[int], axis: int = 2) -> tuple[Array, Array, Array]:
    """Return times, places along the line and velocities of grains, as `velocities_of_chain`.

    Parameters
    ----------
    ids
        Grains in the order of the line, evenly spaced.
    axis
        Component of the velocities: 0, 1 or 2 for x, y or z.
    """
    rows = result.rows(np.asarray(ids))
    places = result["spheres/position"][rows]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    frames = (result.frame(frame, "velocity")[rows, axis] for frame in range(result.n_frames))
    return _evenly(result.frame_times, along, np.stack(list(frames)))


def _evenly(time: Array, place: Array, velocity: Array) -> tuple[Array, Array, Array]:
    """Interpolate velocities at as many even times."""
    even = np.linspace(time[0], time[-1], len(time))
    return even, place, np.asarray(CubicSpline(time, velocity)(even))
