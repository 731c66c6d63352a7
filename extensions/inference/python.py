"""Contact forces from measured grains in Python."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.notebook.run import Run
from granwave.extensions.inference import run as inference
from granwave.extensions.inference.notebook import InferredForces
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.python.inputs import home, words_of_python

_OPTIONS = ("noise", "time", "case", "repeat", "frame-rate", "position-noise")


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
    """Infer contact forces from a table of measured grains, or from synthetic measurements of a
    run.

    Parameters
    ----------
    measurement
        Path of a table of grains; or a run, or its directory, to plan an experiment.
    case
        File with ``[material]`` and ``[infer]``; a run can do without.
    noise
        Errors of strains and accelerations of a run, over their root mean squares; several for a
        curve.
    frame_rate
        Frames per second from which accelerations of a run are differentiated.
    position_noise
        Errors of the positions in these frames, m.
    time
        Instant of a run, s; by default that with the largest forces.
    repeat
        Repetitions with noise; by default ``infer.repetitions``, of a run 10.
    directory
        Directory of the results, as of ``granwave infer``; by default nothing is written.
    figures
        Draw the figures into the directory.
    force
        Move existing results into NAME.old.

    Returns
    -------
    InferredForces
        The forces.

    Raises
    ------
    InputError
        The measurement, the case or an argument is invalid, or the equations do not determine the
        forces.
    """
    with words_of_python(*_OPTIONS):
        if not isinstance(measurement, str | Path | Run):
            raise InputError(
                f"measurement: found {show(measurement)}, expected the path of a table, or a run"
            )
        if case is not None and not isinstance(case, str | Path):
            raise InputError(
                f"case: found {show(case)}, expected the path of a file with [material] and [infer]"
            )
        source = measurement.directory if isinstance(measurement, Run) else Path(home(measurement))
        place = None if directory is None else inference.results_place(home(directory), force=force)
        levels = None
        if noise is not None:
            levels = [_number("noise", one) for one in np.atleast_1d(noise).tolist()]
        found = inference.infer(
            source,
            None if case is None else Path(home(case)),
            noise=levels,
            frame_rate=_number_or_none("frame_rate", frame_rate, above=True),
            position_noise=_number_or_none("position_noise", position_noise),
            time=_number_or_none("time", time),
            repeat=None if repeat is None else int(_number("repeat", repeat, whole=True)),
        )
        if place is not None:
            inference.save(found, place, force=force, figures=figures)
    return InferredForces(found.summary, found.forces, found.grains, found.measurement)


def _number_or_none(name: str, value: Any, *, above: bool = False) -> float | None:
    return None if value is None else _number(name, value, above=above)


def _number(name: str, value: Any, *, above: bool = False, whole: bool = False) -> float:
    kind = "a number from 0 up"
    if whole:
        kind = "a whole number from 0 up"
    elif above:
        kind = "a number above 0"
    good = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not good or value < 0 or (above and not value) or (whole and value != int(value)):
        raise InputError(f"{name}: found {show(value)}, expected {kind}")
    return float(value)
