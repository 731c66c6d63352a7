"""Reader of ``dumps/lines.dump``: the motion of lines of grains in time."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dumps import instants
from granwave.analysis.lammps_output.number_rows import AGAIN, CUT
from granwave.lammps_inputs.deck.columns import LINES, names
from granwave.lammps_inputs.run_directory import DUMPS, LINES_FILE


@dataclasses.dataclass(frozen=True, eq=False)
class LineHistory:
    """Motion of the grains of all lines.

    Attributes
    ----------
    steps
        Counts of the step counter: (n_times,).
    ids
        Ids of the grains, rising: (n,).
    displacement, velocity
        (n_times, n, 3), m and m/s.
    sums
        Sums of the magnitudes of the contact forces along x, y and z: (n_times, n, 3), N.
    angular_velocity
        (n_times, n, 3), rad/s; None if nothing rotates.
    """

    steps: NDArray[np.int64]
    ids: NDArray[np.int64]
    displacement: NDArray[np.float64]
    velocity: NDArray[np.float64]
    sums: NDArray[np.float64]
    angular_velocity: NDArray[np.float64] | None


def read_lines(directory: str | Path, ids: tuple[int, ...], last: int) -> LineHistory:
    """Read the motion of the grains with these ids, up to the step ``last``.

    Raises
    ------
    MissingOutputError, OutputFormatError
        The file is missing, damaged or ends too soon, or holds other grains.
    """
    path = Path(directory) / DUMPS / LINES_FILE
    frames = list(instants(directory, LINES_FILE, names(LINES)))
    for frame in frames:
        if tuple(frame["id"].astype(int).tolist()) != ids:
            raise OutputFormatError(
                f"{path}: the snapshot of step {frame.step} holds {len(frame)} grains that are not the {len(ids)} of "
                f"the lines of the case: the files belong to different runs, or one is damaged; {AGAIN}"
            )
    if frames[-1].step < last:
        raise OutputFormatError(
            f"{path} ends with the snapshot of step {frames[-1].step}, the run at step {last}: {CUT}"
        )

    def vectors(form: str) -> NDArray[np.float64]:
        return np.stack([frame.vector(*(form.format(axis) for axis in "xyz")) for frame in frames])

    turning = vectors("omega{}") if "omegax" in frames[0].columns else None
    steps = np.array([frame.step for frame in frames])
    return LineHistory(steps, np.array(ids), vectors("u{}"), vectors("v{}"), vectors("sum_f{}"), turning)
