"""Force that grains transmit into the depth, against time.

A plane across the axis of depth divides the grains by the positions of their centres at the start.
The force through the plane is the sum of the forces along z that grains above it exert on grains
below it. It changes the momentum of the grains below, and is balanced by the force on the bottom.
In a chain it is the force of one contact, recorded at the instants of the history; in other
packings it requires the forces of all contacts at the snapshots, recorded with
``output.contact_forces``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.lammps_output.dumps import Frame, read_frame_forces
from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs.run_directory import DUMPS, FRAME_FORCES_FILE

_MOST = 5  # depths that are chosen
_FEWEST_TIMES = 3


@dataclasses.dataclass(frozen=True, eq=False)
class ForceAtDepth:
    """Force through a plane at a depth, against time.

    Attributes
    ----------
    depth
        Depth below the centre of the impacted grain, m; in a chain the depth of the contact.
    time
        Instants: (n_times,), s.
    force
        Force along z on the grains below the plane from those above it: (n_times,), N.
    """

    depth: float
    time: Array
    force: Array


def forces_at_depths(result: Result, depths: Sequence[float] | None = None) -> list[ForceAtDepth]:
    """Return the force through planes at depths; empty if it was not recorded.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    depths
        Depths below the centre of the impacted grain, m; by default up to five between layers.
        Depths with grains on one side only are omitted.
    """
    if "chain" in result:
        return _of_chain(result, depths)
    if not (result.path.parent / DUMPS / FRAME_FORCES_FILE).exists():
        return []
    if result.n_frames < _FEWEST_TIMES:
        return []
    return _of_snapshots(result, depths)


def depth_range(result: Result) -> tuple[float, float]:
    """Return the depths of the uppermost and the deepest centre of the packing, m."""
    depth = _depths(result)
    return float(depth.min()), float(depth.max())


def _depths(result: Result) -> Array:
    """Return the depths of the grains of the packing, without strikers, m."""
    depth: Array = result["spheres/position"][result.in_packing, 2] - result.origin[2]
    return depth


def _inside(result: Result, depths: Sequence[float]) -> list[float]:
    """Return the depths that have grains on both sides."""
    top, bottom = depth_range(result)
    return [float(depth) for depth in depths if top < depth <= bottom]


def _even(values: NDArray[Any]) -> NDArray[Any]:
    """Return up to five of the values, evenly spread."""
    number = min(_MOST, len(values))
    return values[np.unique(np.linspace(0, len(values) - 1, number).round().astype(int))]


def _of_chain(result: Result, depths: Sequence[float] | None) -> list[ForceAtDepth]:
    """Return the forces of the contacts of a chain that are nearest to the depths."""
    place = result["chain/contact_position"] - result.origin[2]
    force = result["chain/contact_force"]
    if not len(place) or not force.any():
        return []
    time = result["chain/time"]
    if depths is None:
        loaded = np.flatnonzero(force.max(axis=0) > 0)
        chosen = _even(loaded)
    else:
        nearest = [int(np.abs(place - depth).argmin()) for depth in _inside(result, depths)]
        chosen = np.unique(np.array(nearest, dtype=np.int64))
    return [ForceAtDepth(float(place[n]), time, force[:, n]) for n in chosen.tolist()]


def _of_snapshots(result: Result, depths: Sequence[float] | None) -> list[ForceAtDepth]:
    """Return the forces through planes at the snapshots."""
    planes = _between_layers(result) if depths is None else np.array(_inside(result, depths))
    if not len(planes):
        return []
    number = {step: n for n, step in enumerate(result[f"{GROUP}/position/step"].tolist())}
    force = np.zeros((result.n_frames, len(planes)))
    for frame in read_frame_forces(result.path.parent):
        row = number.get(frame.step)
        if row is not None:
            force[row] = _through(result, row, frame, planes)
    time = result.frame_times
    return [
        ForceAtDepth(float(depth), time, through)
        for depth, through in zip(planes, force.T, strict=True)
    ]


def _between_layers(result: Result) -> Array:
    """Return depths in the middle between layers."""
    inside = result.in_packing
    radius = result["spheres/radius"][inside]
    mean, _ = layers(_depths(result), radius, result.case.packing.diameter)
    return _even(0.5 * (mean[1:] + mean[:-1]))


def _through(result: Result, number: int, frame: Frame, planes: Array) -> Array:
    """Return the force through planes at a snapshot: (n_planes,), N."""
    start = result["spheres/position"]
    first = result.rows(frame["i"].astype(np.int64))
    second = result.rows(frame["j"].astype(np.int64))
    place = start + result.frame(number, "displacement")
    step = place[first] - place[second]
    step[:, :2] = result.across(step[:, :2])
    along = step[:, 2] / np.linalg.norm(step, axis=1)
    on_first = frame["force"] * along + frame["tz"]
    depth = start[:, 2] - result.origin[2]
    through = [_crossing(depth[first], depth[second], float(plane)) @ on_first for plane in planes]
    return np.array(through)


def _crossing(first: Array, second: Array, plane: float) -> NDArray[np.int64]:
    """Return 1 for contacts whose first grain is below a plane and whose second is above it, -1 for
    the opposite, 0 for others.
    """
    return (first >= plane).astype(np.int64) - (second >= plane)
