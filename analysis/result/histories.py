"""Histories of a chain with its bars, and of lines of grains, as groups of ``result.h5``.

    /chain/{time, id, position, displacement, velocity}
    /chain/{contact_i, contact_j, contact_position, contact_force}
    /bars/NAME/{position, displacement, velocity, force}

Beads and nodes are in the order of z; rows are the instants of ``/chain/time``. Forces in bars are
forces of the elements, positive in compression.

Lines of grains, ``[[line]]``:

    /lines/NAME/{time, id, position, distance, displacement, velocity, force_sums}
        motion, in the order of the line; angular_velocity if grains turn
    /lines/NAME/{arrival, peak_speed, peak_time, width, lateral_force, largest_speed}
        of each grain

``distance`` counts along the line from its first grain to each. ``force_sums`` are the sums of the
magnitudes of the contact forces along x, y and z; the lateral force is half of the sum across the
line, at the instant of the peak. In a packing in a vertical plane it is half of the horizontal sum
for lines in any direction.

The pulse arrives when the speed first exceeds 5 % of a reference speed. Its peak is the first
maximum above that after which the speed falls by 10 %; smaller ripples during the rise do not count
as peaks. Its width is the time between the half heights.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dumps import read_instants, refuse_ids
from granwave.analysis.lammps_output.frame import AGAIN, CUT, Frame
from granwave.lammps_inputs.deck.columns import HISTORY, LINES, names
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import all_line_ids, line_ids, velocities_of
from granwave.lammps_inputs.run_directory import DUMPS, FORCES_FILE, HISTORY_FILE, LINES_FILE

Groups = dict[str, dict[str, NDArray]]
#: Columns of the motion of lines, without the axis.
_MOTION = {"displacement": "u", "velocity": "v", "force_sums": "sum_f", "angular_velocity": "omega"}


def read_chain(
    directory: Path, assembly: Assembly, start: Frame, timestep: float, last: int
) -> Groups:
    """Read the recorded history of a chain as groups by name.

    Parameters
    ----------
    start
        All particles, from `granwave.analysis.lammps_output.dumps.read_data`.
    timestep
        Timestep, s.
    last
        Step of the last instant.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing or damaged.
    """
    steps, frames = _instants(
        directory, HISTORY_FILE, names(HISTORY), start["id"], last,
        lambda number, frame: f"snapshot {number} (step {frame.step}) holds {len(frame)} particles that are not the "
        f"{len(start)} of data.granwave",
    )  # fmt: skip
    displacement, velocity = (np.stack([frame[name] for frame in frames]) for name in ("uz", "vz"))
    z = start["z"]
    beads = np.argsort(z[: assembly.n_spheres], kind="stable")
    order = (beads + 1).tolist()  # ids along the chain, with the faces of bars
    for bar in assembly.bars:
        order.insert(0 if bar.face == bar.last else len(order), bar.face)
    first = np.array(order[:-1], dtype=np.int64)
    second = np.array(order[1:], dtype=np.int64)
    radius = start["diameter"] / 2
    groups: Groups = {
        "chain": {
            "time": steps * timestep,
            "id": beads + 1,
            "position": z[beads],
            "displacement": displacement[:, beads],
            "velocity": velocity[:, beads],
            "contact_i": first,
            "contact_j": second,
            "contact_position": z[first - 1] + radius[first - 1],
            "contact_force": _forces(directory, steps, first, second, start),
        }
    }
    for bar in assembly.bars:
        nodes = slice(bar.first - 1, bar.last)
        groups[f"bars/{bar.name}"] = {
            "position": z[nodes],
            "displacement": displacement[:, nodes],
            "velocity": velocity[:, nodes],
            "force": -bar.stiffness * np.diff(displacement[:, nodes], axis=1),
        }
    return groups


def _instants(
    directory: Path,
    name: str,
    columns: tuple[str, ...],
    ids: ArrayLike,
    last: int,
    strange: Callable[[int, Frame], str],
) -> tuple[NDArray[np.int64], list[Frame]]:
    """Read a history of particles of these ids up to the step ``last``: steps (n_times,), and the
    instants.

    ``strange`` describes an instant with other particles, by its number.
    """
    path = directory / DUMPS / name
    frames = list(read_instants(directory, name, columns, "id"))
    for number, frame in enumerate(frames):
        if not np.array_equal(frame["id"], ids):
            raise OutputFormatError(
                f"{path}: {strange(number, frame)}: the files belong to different runs, or one of "
                f"them is damaged; {AGAIN}"
            )
    steps = np.array([frame.step for frame in frames])
    if steps[-1] < last:
        raise OutputFormatError(
            f"{path} ends with the snapshot of step {steps[-1]}, the run at step {last}: {CUT}"
        )
    return steps, frames


def _forces(
    directory: Path,
    steps: NDArray[np.int64],
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    start: Frame,
) -> NDArray[np.float64]:
    """Return the force of each contact of the chain: (n_times, n_contacts), N."""
    column = {
        pair: n
        for n, pair in enumerate(zip(*np.sort([first, second], axis=0).tolist(), strict=True))
    }
    row = {int(step): n for n, step in enumerate(steps)}
    forces = np.zeros((len(steps), len(first)))
    path = directory / DUMPS / FORCES_FILE
    for frame in read_instants(directory, FORCES_FILE, ("i", "j", "force")):
        refuse_ids(path, np.setdiff1d(frame.vector("i", "j"), start["id"]))
        n = row.pop(frame.step, None)
        if n is None:
            continue
        for (i, j), force in zip(frame.pairs.tolist(), frame["force"].tolist(), strict=True):
            if force > 0 and (i, j) in column:
                forces[n, column[i, j]] = force
    if row:
        raise OutputFormatError(
            f"{path} lacks the snapshot of step {min(row)}, which history.dump has: {CUT}"
        )
    return forces


_FLAT = 1e-6  # diameters; a packing that extends by less along an axis lies in a plane


def line_groups(
    directory: Path, assembly: Assembly, timestep: float, last: int
) -> dict[str, dict[str, NDArray[np.generic]]]:
    """Read the lines of a case as groups by name; raise as `read_chain`.

    Parameters
    ----------
    timestep
        Time of a count of the step counter, s.
    last
        Count of the last instant.
    """
    rows = all_line_ids(assembly)

    def fault(_: Any, frame: Frame) -> str:
        return (
            f"the snapshot of step {frame.step} holds {len(frame)} grains that are not the "
            f"{len(rows)} of the lines of the case"
        )

    steps, frames = _instants(directory, LINES_FILE, names(LINES), rows, last, fault)
    motion = _motion_in(frames)
    positions = assembly.positions()
    centre = dict(zip(assembly.ids.tolist(), positions, strict=True))
    time = np.asarray(steps * timestep, dtype=np.float64)
    extended = np.ptp(positions[:, :2], axis=0) > _FLAT * assembly.case.packing.diameter
    reference = _reference_speed(assembly)
    groups: dict[str, dict[str, NDArray[np.generic]]] = {}
    for line in assembly.case.line:
        ids = np.array(line_ids(assembly, line))
        chosen = np.searchsorted(rows, ids)
        position = np.array([centre[sphere] for sphere in ids.tolist()])
        own = {name: values[:, chosen] for name, values in motion.items()}
        speed = np.asarray(np.linalg.norm(own["velocity"], axis=2), dtype=np.float64)
        pulses, row = first_pulses(time, speed, reference or float(speed.max(initial=0.0)))
        lateral = _lateral_axis(position, extended)
        apart = np.linalg.norm(np.diff(position, axis=0), axis=1)
        groups[f"lines/{line.name}"] = {
            "time": time,
            "id": ids,
            "position": position,
            "distance": np.concatenate([[0.0], np.cumsum(apart)]),
            **own,
            **pulses,
            # half the sum of the contact forces along the axis at the peaks, N; NaN without a peak
            "lateral_force": np.where(
                row >= 0,
                own["force_sums"][np.maximum(row, 0), np.arange(len(row)), lateral] / 2,
                np.nan,
            ),
            "largest_speed": speed.max(axis=0),
        }
    return groups


def _motion_in(frames: Sequence[Frame]) -> dict[str, NDArray[np.float64]]:
    """Return the recorded vectors of the grains of lines by name: (n_times, n, 3)."""
    motion = {}
    for name, column in _MOTION.items():
        axes = [f"{column}{axis}" for axis in "xyz"]
        if axes[0] in frames[0].columns:
            motion[name] = np.stack([frame.vector(*axes) for frame in frames])
    return motion


def _reference_speed(assembly: Assembly) -> float:
    """Return the speed that arrivals refer to: the largest initial speed given by the load, m/s;
    0 if the load gives none, such as a force.
    """
    speeds = [math.hypot(*velocity) for velocity in velocities_of(assembly).values()]
    plate = assembly.case.load.plate
    if plate is not None:
        speeds.append(plate.velocity)
    return max(speeds, default=0.0)


def _lateral_axis(position: NDArray[np.float64], extended: NDArray[np.bool_]) -> int:
    """Return the horizontal axis, 0 or 1, of the lateral force on a line: that of a packing in a
    vertical plane, or else the axis most nearly normal to the line.

    Parameters
    ----------
    position
        Centres along the line: (n, 3), m.
    extended
        True for the horizontal axes along which the packing extends: (2,).
    """
    if np.count_nonzero(extended) == 1:
        return int(np.argmax(extended))
    way = np.abs(position[-1] - position[0])[:2]
    return int(np.argmin(way))


ARRIVAL = 0.05  # fraction of the reference speed
FALL = 0.10  # fraction of the peak


def first_pulses(
    time: NDArray[np.float64], speed: NDArray[np.float64], reference: float
) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.int64]]:
    """Find the first pulse at each of several points.

    Parameters
    ----------
    time
        (n_times,), s.
    speed
        Magnitudes: (n_times, n), m/s.
    reference
        Speed that the threshold of arrival refers to, m/s.

    Returns
    -------
    columns
        ``arrival``, ``peak_time`` and ``width`` between the half heights about the peak, s, and
        ``peak_speed``, m/s: (n,) each, NaN where there is no pulse, of the width also if the record
        ends before.
    row
        Row of the peak in the record; -1: none.
    """
    found = [_pulse(time, one, ARRIVAL * reference) for one in speed.T]
    table = np.array([values for values, _ in found]).reshape(-1, 4).T
    columns = dict(zip(("arrival", "peak_speed", "peak_time", "width"), table, strict=True))
    return columns, np.array([row for _, row in found], dtype=np.int64)


def _pulse(
    time: NDArray[np.float64], speed: NDArray[np.float64], least: float
) -> tuple[tuple[float, ...], int]:
    above = np.flatnonzero(speed > least)
    if not above.size:
        return (np.nan,) * 4, -1
    first = int(above[0])
    arrival = float(time[0]) if first == 0 else _crossing(time, speed, first, least)
    highest = np.maximum.accumulate(speed[first:])
    fallen = np.flatnonzero(speed[first:] <= (1 - FALL) * highest)
    if not fallen.size:
        return (arrival, np.nan, np.nan, np.nan), -1
    row = first + int(np.argmax(speed[first : first + int(fallen[0]) + 1]))
    half = float(speed[row]) / 2
    before = np.flatnonzero(speed[:row] <= half)
    after = np.flatnonzero(speed[row:] <= half)
    width = np.nan
    if after.size:
        start = _crossing(time, speed, int(before[-1]) + 1, half) if before.size else float(time[0])
        width = _crossing(time, speed, row + int(after[0]), half) - start
    return (arrival, float(speed[row]), float(time[row]), width), row


def _crossing(
    time: NDArray[np.float64], speed: NDArray[np.float64], row: int, level: float
) -> float:
    """Return the time between two rows of the record at which a speed passes a level, by a straight
    line.
    """
    low = float(speed[row - 1])
    high = float(speed[row])
    return float(time[row - 1] + (level - low) / (high - low) * (time[row] - time[row - 1]))
