"""Lines of grains, ``[[line]]``, as groups of ``result.h5``.

    /lines/NAME/{time, id, position, distance, displacement, velocity, force_sums}    motion, in the order of the line;
                                                                                     angular_velocity if grains turn
    /lines/NAME/{arrival, peak_speed, peak_time, width, lateral_force, largest_speed}     of each grain

``distance`` counts along the line from its first grain to each. ``force_sums`` are the sums of the magnitudes of the
contact forces along x, y and z; the lateral force is half of that across the line, at the instant of the peak. In a
packing in a vertical plane it is half of the horizontal sum for lines in any direction.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.lammps_output.time_series import read_lines
from granwave.analysis.result.first_pulse import first_pulses
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import all_line_ids, line_ids, velocities_of

_FLAT = 1e-6  # diameters; a packing that extends by less along an axis lies in a plane


def line_groups(
    directory: str | Path, assembly: Assembly, timestep: float, last: int
) -> dict[str, dict[str, NDArray[np.generic]]]:
    """Read the lines of a case as groups by name; raise as `read_lines`.

    Parameters
    ----------
    timestep
        Time of a count of the step counter, s.
    last
        Count of the last instant.
    """
    history = read_lines(directory, all_line_ids(assembly), last)
    centre, row = dict(zip(assembly.ids.tolist(), assembly.positions(), strict=True)), history.ids
    time, across = np.asarray(history.steps * timestep, dtype=np.float64), _across(assembly)
    groups: dict[str, dict[str, NDArray[np.generic]]] = {}
    for line in assembly.case.line:
        ids = np.array(line_ids(assembly, line))
        chosen, position = np.searchsorted(row, ids), np.array([centre[one] for one in ids.tolist()])
        velocity, sums = history.velocity[:, chosen], history.sums[:, chosen]
        speed = np.asarray(np.linalg.norm(velocity, axis=2), dtype=np.float64)
        pulses = first_pulses(time, speed, reference_speed(assembly) or float(speed.max(initial=0.0)))
        steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
        groups[f"lines/{line.name}"] = {
            "time": time,
            "id": ids,
            "position": position,
            "distance": np.concatenate([[0.0], np.cumsum(steps)]),
            "displacement": history.displacement[:, chosen],
            "velocity": velocity,
            "force_sums": sums,
            "arrival": pulses.arrival,
            "peak_speed": pulses.peak,
            "peak_time": pulses.time,
            "width": pulses.width,
            "lateral_force": _lateral(sums, pulses.row, position, across),
            "largest_speed": speed.max(axis=0),
        }
        if history.angular_velocity is not None:
            groups[f"lines/{line.name}"]["angular_velocity"] = history.angular_velocity[:, chosen]
    return groups


def reference_speed(assembly: Assembly) -> float:
    """Return the speed that arrivals refer to: the largest that the load gives at the start, m/s; 0 of a force."""
    speeds = [math.hypot(*velocity) for velocity in velocities_of(assembly).values()]
    if assembly.case.load.plate is not None:
        speeds.append(assembly.case.load.velocity)
    return max(speeds, default=0.0)


def _lateral(
    sums: NDArray[np.float64], row: NDArray[np.int64], position: NDArray[np.float64], across: int | None
) -> NDArray[np.float64]:
    """Return half the sum of the horizontal contact forces at the peaks: (n,), N; NaN without a peak.

    In a packing in a vertical plane they are along ``across``, the horizontal axis of the plane, whatever the line;
    elsewhere (None) along the horizontal axis that is most nearly normal to the line.
    """
    way = np.abs(position[-1] - position[0])
    axis = int(np.argmin(way[:2])) if across is None else across
    found = 0.5 * sums[np.maximum(row, 0), np.arange(len(row)), axis]
    return np.where(row >= 0, found, np.nan)


def _across(assembly: Assembly) -> int | None:
    """Return the horizontal axis of a packing in a vertical plane, 0 or 1; None for other packings."""
    extent = np.ptp(assembly.positions()[:, :2], axis=0) > _FLAT * assembly.case.packing.diameter
    return int(np.argmax(extent)) if np.count_nonzero(extent) == 1 else None
