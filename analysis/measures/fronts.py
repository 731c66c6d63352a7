"""Motion of lines of grains against position and time, with the arrivals of the wave and a straight
line through them.

Lines are the beads of a chain, or in a packing the grain of each layer that is nearest to the axis
of the load; and the straight lines of grains ``[[line]]`` of the case. The wave arrives at a bead
of a chain with its first pulse (see `granwave.analysis.measures.first_pulse`), at a grain of a
packing as contacts record it (see `granwave.analysis.measures.waves`), at a grain of a ``[[line]]``
as in `granwave.analysis.measures.lines`.

The line through the arrivals is a least-squares fit of position against time. Along the load it
uses the arrivals of `granwave.analysis.measures.waves.wave_speed`: the deeper half, without the
five uppermost grains; along a ``[[line]]`` it uses all arrivals.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.first_pulse import has_recorded_chain
from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.lines import lines_of
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves import (
    arrivals_of_groups,
    fitted_layers,
    has_parallel_cylinders,
)
from granwave.analysis.result.reader import Result

AXIS = "axis"  # name of the line along the load
_BESIDE = 1.0  # largest distance from the axis of the load, diameters
_VERTICAL = 1 - 1e-9  # z component of a vertical unit vector
_FEWEST = 2  # fewest grains of a line


@dataclasses.dataclass(frozen=True, eq=False)
class Front:
    """Straight line through arrivals.

    Attributes
    ----------
    time, place
        Arrivals of the fit: (n,), s and m.
    """

    time: Array
    place: Array

    @property
    def speed(self) -> float:
        """Slope of position against time, m/s; 0 if the times are equal."""
        late = self.time - self.time.mean()
        if not late.any():
            return 0.0
        return float(late @ (self.place - self.place.mean()) / (late @ late))

    def when(self, place: Array) -> Array:
        """Return the times at which the line reaches positions, s."""
        return self.time.mean() + (place - self.place.mean()) / self.speed


@dataclasses.dataclass(frozen=True, eq=False)
class LineMotion:
    """Motion of the grains of a line.

    Attributes
    ----------
    name
        `AXIS`, or the name of the ``[[line]]``.
    ids
        Ids of the grains: (n_grains,).
    time
        Instants: (n_times,), s.
    place
        Distances along the line, rising: (n_grains,), m.
    velocity
        Velocities along the line: (n_times, n_grains), m/s.
    arrival
        Arrivals of the wave: (n_grains,), s; NaN where there is none.
    front
        Line through arrivals; None for too few.
    """

    name: str
    ids: NDArray[np.int64]
    time: Array
    place: Array
    velocity: Array
    arrival: Array
    front: Front | None


def line_motions(result: Result, place: Array, direction: Array) -> list[LineMotion]:
    """Return the motion along the axis of the load, and along each straight ``[[line]]``.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    place
        Point of the axis: (3,), m.
    direction
        Direction of the load, a unit vector: (3,).
    """
    motions = [_along_axis(result, place, direction), *_along_lines(result)]
    return [
        motion for motion in motions if len(motion.place) >= _FEWEST and len(motion.time) >= _FEWEST
    ]


def _along_axis(result: Result, place: Array, direction: Array) -> LineMotion:
    """Return the motion of the beads of a chain, or of the grains nearest to the axis."""
    if "chain" in result:
        sense = 1.0 if direction[2] >= 0 else -1.0
        ids = result["chain/id"]
        along = sense * (result["chain/position"] - result.origin[2])
        time = result["chain/time"]
        velocity = sense * result["chain/velocity"]
    else:
        rows, along = _nearest_to_axis(result, place, direction)
        ids = result["spheres/id"][rows]
        time = result.frame_times
        frames = [result.frame(number, "velocity")[rows] for number in range(result.n_frames)]
        velocity = np.array(frames).reshape(len(time), len(rows), 3) @ direction
    order = np.argsort(along, kind="stable")
    ids = ids[order]
    along = along[order]
    velocity = velocity[:, order]
    arrival = _arrivals(result, ids)
    front = _front_along_load(result, along, arrival)
    # the wave starts at a loaded grain, whose first contact is also the first of the next grain
    arrival = np.where(np.isin(ids, result.struck), np.nan, arrival)
    return LineMotion(AXIS, ids, time, along, velocity, arrival, front)


def _nearest_to_axis(
    result: Result, place: Array, direction: Array
) -> tuple[NDArray[np.int64], Array]:
    """Return the grain of each layer across an axis that is nearest to it: rows, and distances
    along the axis from the first of them, m.
    """
    diameter = result.case.packing.diameter
    inside = np.flatnonzero(result.in_packing)
    offset = result["spheres/position"][inside] - place
    if abs(direction[2]) > _VERTICAL:
        offset[:, :2] = result.across(offset[:, :2])
    along = offset @ direction
    beside = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    near = beside <= _BESIDE * diameter
    inside = inside[near]
    along = along[near]
    _, layer = layers(along, result["spheres/radius"][inside], diameter)
    order = np.lexsort((beside[near], layer))
    first = np.unique(layer[order], return_index=True)[1]
    chosen = order[first]
    start = along[chosen].min(initial=np.inf)
    return inside[chosen], along[chosen] - start


def _arrivals(result: Result, ids: NDArray[np.int64]) -> Array:
    """Return the arrivals of the wave at grains, s; NaN without an arrival or a record."""
    if result.case.precompression is not None and not has_recorded_chain(result):
        return np.full(len(ids), np.nan)
    group = np.full(result.n_spheres, -1, dtype=np.int64)
    group[result.rows(ids)] = np.arange(len(ids))
    arrival = arrivals_of_groups(result, group, len(ids))
    return np.where(np.isfinite(arrival), arrival, np.nan)


def _front_along_load(result: Result, along: Array, arrival: Array) -> Front | None:
    """Return the line through the arrivals along the load; None for a load that keeps
    oscillating, and for parallel cylinders, whose front spreads without a limit.
    """
    if result.case.load.keeps_oscillating or has_parallel_cylinders(result):
        return None
    arrived = np.where(np.isfinite(arrival), arrival, np.inf)
    place, time = fitted_layers(along, arrived, result.case.packing.diameter)
    return _rising(Front(time, place)) if len(time) else None


def _along_lines(result: Result) -> list[LineMotion]:
    """Return the motion of the straight lines ``[[line]]``."""
    motions = []
    for line in lines_of(result):
        if not line.straight:
            continue
        group = f"lines/{line.name}"
        position = result[f"{group}/position"]
        way = position[-1] - position[0]
        velocity = result[f"{group}/velocity"] @ (way / np.linalg.norm(way))
        reached = np.isfinite(line.arrival)
        front = None
        if np.count_nonzero(reached) >= _FEWEST:
            front = _rising(Front(line.arrival[reached], line.distance[reached]))
        ids = result[f"{group}/id"]
        time = result[f"{group}/time"]
        motions.append(
            LineMotion(line.name, ids, time, line.distance, velocity, line.arrival, front)
        )
    return motions


def _rising(front: Front) -> Front | None:
    return front if front.speed > 0 else None
