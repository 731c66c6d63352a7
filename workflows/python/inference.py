"""Contact forces from measured grains in Python."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.notebook.load import InferredForces
from granwave.analysis.notebook.run import Run
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import inference
from granwave.workflows.python.inputs import home
from granwave.workflows.python.words import words_of_python


def infer(
    measurement: str | Path | Run,
    case: str | Path | None = None,
    *,
    noise: float | Sequence[float] | None = None,
    frame_rate: float | None = None,
    position_noise: float | None = None,
    time: float | None = None,
    repeat: int | None = None,
    directory: str | Path | None = None,
    figures: bool = False,
    force: bool = False,
) -> InferredForces:
    """Infer contact forces from a table of measured grains, or from measurements made of a run.

    Parameters
    ----------
    measurement
        Path of a table of grains; or a run, or its directory, to plan an experiment.
    case
        File with ``[material]`` and ``[infer]``; a run can do without.
    noise
        Errors of strains and accelerations of a run, over their root mean squares; several for a curve.
    frame_rate
        Frames per second from which accelerations of a run are differentiated.
    position_noise
        Errors of the places in these frames, m.
    time
        Instant of a run, s; by default that with the largest forces.
    repeat
        Repetitions with noise; by default ``infer.repetitions``, of a run 10.
    directory
        Directory of the results, as of ``granwave infer``; by default nothing is written.
    figures
        Draw the figures into the directory.
    force
        Replace existing results.

    Returns
    -------
    InferredForces
        The forces.

    Raises
    ------
    InputError
        The measurement, the case or an argument is wrong, or the equations do not determine the forces.
    """
    from granwave.analysis.inference.plan import Camera

    with words_of_python():
        if not isinstance(measurement, str | Path | Run):
            raise InputError(f"measurement: found {show(measurement)}, expected the path of a table, or a run")
        if case is not None and not isinstance(case, str | Path):
            raise InputError(f"case: found {show(case)}, expected the path of a file with [material] and [infer]")
        source = measurement.directory if isinstance(measurement, Run) else Path(home(measurement))
        file = None if case is None else Path(home(case))
        place = None if directory is None else inference.results_place(home(directory), force=force)
        repetitions = None if repeat is None else _number("repeat", repeat, whole=True)
        of_runs = {"noise": noise, "frame_rate": frame_rate, "position_noise": position_noise, "time": time}
        if inference.is_run(source):
            levels = (0.0,) if noise is None else tuple(_number("noise", one) for one in np.atleast_1d(noise).tolist())
            rate = None if frame_rate is None else _number("frame_rate", frame_rate, above=True)
            camera = Camera(
                noise=levels or (0.0,),
                frame_rate=rate,
                position_noise=0.0 if position_noise is None else _number("position_noise", position_noise),
                time=None if time is None else _number("time", time),
                repetitions=10 if repetitions is None else max(int(repetitions), 1),
            )
            found = inference.infer_run(source, file, camera)
        else:
            if given := [name for name, value in of_runs.items() if value is not None]:
                raise InputError(f"{given[0]}: found it with a table, expected it with a run")
            if file is None:
                raise InputError("case: missing; expected a file with [material] and [infer]")
            found = inference.infer_table(source, file, None if repetitions is None else int(repetitions))
        if place is not None:
            inference.save(found, place, figures=figures)
    return InferredForces(found.summary, found.forces, found.grains, found.measurement)


def _number(name: str, value: Any, *, above: bool = False, whole: bool = False) -> float:
    kind = "a whole number from 0 up" if whole else f"a number {'above' if above else 'from'} 0{'' if above else ' up'}"
    good = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not good or value < 0 or (above and not value) or (whole and value != int(value)):
        raise InputError(f"{name}: found {show(value)}, expected {kind}")
    return float(value)
