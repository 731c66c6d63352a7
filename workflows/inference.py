"""Forces inferred from a table of grains or from measurements made of a run, for the command line
and for Python.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.ownership import refuse_foreign, refuse_other_kind, results_in
from granwave.lammps_inputs.run_directory import INFERENCE, RESULT_FILE

if TYPE_CHECKING:
    from granwave.analysis.inference.output import Inferred


def save(inferred: Inferred, directory: Path, *, figures: bool) -> None:
    """Write the files of an inference into a directory, which is locked meanwhile."""
    from granwave.workflows.run.directory import held

    with held(directory):
        inferred.write(directory, figures=figures)


def results_place(wanted: str | Path, *, force: bool) -> Path:
    """Return the directory of the results.

    Raises
    ------
    InputError
        It holds other things, or results that are not to be replaced, or cannot be made.
    """
    from granwave.analysis.inference.output import WRITTEN

    directory = results_directory(wanted, force=force)
    if not directory.parent.is_dir():
        raise InputError(f"{directory}: there is no directory {directory.parent}")
    refuse_other_kind(directory, INFERENCE)
    if not force and set(WRITTEN) & set(results_in(directory)):
        raise InputError(
            f"{directory}: already holds results; "
            "force=True replaces them, or choose another with directory=..."
        )
    refuse_foreign(directory, WRITTEN)
    return directory


def infer(
    source: Path,
    case_file: Path | None,
    *,
    noise: Sequence[float] | None = None,
    frame_rate: float | None = None,
    position_noise: float | None = None,
    time: float | None = None,
    repeat: int | None = None,
    progress: bool = False,
) -> Inferred:
    """Infer the forces of a table of grains, or of measurements made of a run.

    Parameters
    ----------
    source
        Table, or directory of the run.
    case_file
        File with [material] and [infer]; a run can do without.
    noise, frame_rate, position_noise, time
        Measurements made of a run, as of `granwave.analysis.inference.plan.plan_experiment`.
    repeat
        Repetitions with noise; None: those of the case, of a run 10.
    progress
        Show a bar on a terminal.

    Raises
    ------
    InputError
        There is no such table or run, it or the case is wrong, or the equations do not determine
        the forces.
    """
    from granwave.analysis.inference.case import read_infer_case
    from granwave.analysis.inference.plan import plan_experiment

    if not source.exists():
        raise InputError(
            f"{source}: no such file; expected a table of grains (CSV), or the directory of a run"
        )
    of_runs = {
        "noise": noise,
        "frame-rate": frame_rate,
        "position-noise": position_noise,
        "time": time,
    }
    if not (source.is_dir() or source.name == RESULT_FILE):
        if given := [name for name, value in of_runs.items() if value is not None]:
            raise InputError(
                f"--{given[0]}: found it with a table, expected it with the directory of a run; what "
                "holds for a table stands in [infer] of --case"
            )
        if case_file is None:
            raise InputError(
                "--case: missing; expected a file with [material] and [infer] (granwave keys infer)"
            )
        return _infer_table(source, case_file, repeat, progress=progress)
    return plan_experiment(
        source,
        None if case_file is None else read_infer_case(case_file, of_run=True),
        noise=tuple(noise or (0.0,)),
        frame_rate=frame_rate,
        position_noise=position_noise or 0.0,
        time=time,
        repetitions=10 if repeat is None else max(repeat, 1),
        progress=progress,
    )


def _infer_table(
    source: Path, case_file: Path, repetitions: int | None, *, progress: bool
) -> Inferred:
    from granwave.analysis.inference.case import read_infer_case
    from granwave.analysis.inference.equations import Noise
    from granwave.analysis.inference.infer import infer as infer_forces
    from granwave.analysis.inference.measurement import read_measurement
    from granwave.analysis.inference.output import Inferred
    from granwave.analysis.inference.tables import summary_of

    case = read_infer_case(case_file)
    times, measured, notes = read_measurement(source, case)
    settings = case.infer
    if repetitions is not None:
        settings = dataclasses.replace(settings, repetitions=repetitions)
    found = []
    for time, grains in zip(times, measured, strict=True):
        try:
            found.append(infer_forces(grains, case.walls, settings, progress=progress))
        except InputError as error:
            at = "" if math.isnan(time) else f" at {time:g} s"
            raise InputError(item.inside(f"{source}{at}") for item in error.items) from None
    lacking = settings.deviations.missing(measured[0])
    if lacking and settings.deviations != Noise():
        notes.append(f"infer.noise lacks {' and '.join(lacking)}: it is not used")
    summary = summary_of(source.stem, str(source), case.infer.state, found, times, notes)
    return Inferred(found, times, summary)
