"""History of a chain: motion of all beads, forces of all contacts, and bars, as groups of ``result.h5``.

    /chain/{time, id, position, displacement, velocity, contact_i, contact_j, contact_position, contact_force}
    /bars/NAME/{position, displacement, velocity, force}

Beads and nodes are in the order of z; rows are the instants of ``/chain/time``. Forces in bars are those of the
elements, positive in compression.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dumps import read_forces, read_history, refuse_ids
from granwave.analysis.lammps_output.frame import AGAIN, CUT, Frame
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.assembly import assemble

if TYPE_CHECKING:
    from granwave.analysis.result.reader import Result

Groups = dict[str, dict[str, NDArray]]


def read_chain(directory: str | Path, case: Case, start: Frame, timestep: float, last: int) -> Groups:
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
    frames, path = list(read_history(directory)), Path(directory) / "dumps" / "history.dump"
    steps = np.array([frame.step for frame in frames])
    for number, frame in enumerate(frames):
        if not np.array_equal(frame["id"], start["id"]):
            raise OutputFormatError(
                f"{path}: snapshot {number} (step {frame.step}) holds {len(frame)} particles that are not the "
                f"{len(start)} of data.granwave: the files belong to different runs, or one is damaged; {AGAIN}"
            )
    if steps[-1] < last:
        raise OutputFormatError(f"{path} ends with the snapshot of step {steps[-1]}, the run at step {last}: {CUT}")
    displacement, velocity = (np.stack([frame[name] for frame in frames]) for name in ("uz", "vz"))
    assembly, z = assemble(case), start["z"]
    beads = np.argsort(z[: assembly.n_spheres], kind="stable")
    first, second = _contacts(case, beads)
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
            "contact_force": _forces(Path(directory), steps, first, second, start),
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


def along(result: Result, column: str) -> NDArray[np.float64]:
    """Return a column of ``/contacts``, and of ``/wall_contacts`` of bars, in the order of the chain: (n_contacts,)."""
    value = {
        (int(i), int(j)): float(number)
        for i, j, number in zip(*(result[f"contacts/{name}"] for name in ("i", "j", column)), strict=True)
    }
    faces = {bar.name: bar.face for bar in result.assembly.bars}
    for wall, bead, number in zip(*(result[f"wall_contacts/{name}"] for name in ("wall", "id", column)), strict=True):
        if wall in faces:
            value[int(bead), faces[wall]] = float(number)
    pairs = zip(result["chain/contact_i"].tolist(), result["chain/contact_j"].tolist(), strict=True)
    return np.array([value.get((min(pair), max(pair)), 0.0) for pair in pairs])


def _contacts(case: Case, beads: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the ids of the upper and lower partner of every contact along the chain, including faces of bars."""
    order = [int(bead) + 1 for bead in beads]
    for bar in assemble(case).bars:
        order.insert(0 if bar.face == bar.last else len(order), bar.face)
    return np.array(order[:-1], dtype=np.int64), np.array(order[1:], dtype=np.int64)


def _forces(
    directory: Path, steps: NDArray[np.int64], first: NDArray[np.int64], second: NDArray[np.int64], start: Frame
) -> NDArray[np.float64]:
    stride = 1 + max(first.max(initial=0), second.max(initial=0))
    column = {int(code): n for n, code in enumerate(np.minimum(first, second) * stride + np.maximum(first, second))}
    row = {int(step): n for n, step in enumerate(steps)}
    forces = np.zeros((len(steps), len(first)))
    path = directory / "dumps" / "forces.dump"
    for frame in read_forces(directory):
        refuse_ids(path, np.setdiff1d(frame.vector("i", "j"), start["id"]))
        n = row.pop(frame.step, None)
        if n is None:
            continue
        i, j = np.sort(frame.vector("i", "j").astype(np.int64), axis=1).T
        for code, force in zip((i * stride + j).tolist(), frame["force"].tolist(), strict=True):
            if force > 0 and code in column:
                forces[n, column[code]] = force
    if row:
        raise OutputFormatError(f"{path} lacks the snapshot of step {min(row)}, which history.dump has: {CUT}")
    return forces
