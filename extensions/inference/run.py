"""Forces inferred from a table of grains or from synthetic measurements of a run, for the command
line and for Python.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.extensions.inference.files import INFERENCE
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import RESULT_FILE

if TYPE_CHECKING:
    from granwave.extensions.inference.forces.output import Inferred


def save(inferred: Inferred, results: ResultDirectory, *, force: bool, figures: bool) -> None:
    """Write the files of an inference into a directory, which is locked meanwhile; with ``force``
    earlier files are first moved to NAME.old.
    """
    from granwave.extensions.inference.forces.output import WRITTEN
    from granwave.workflows.run.directory import held

    with held(results):
        results.make_room(force=force, names=WRITTEN)
        inferred.write(results, figures=figures)


def results_place(wanted: str | Path, *, force: bool) -> ResultDirectory:
    """Return the directory of the results.

    Raises
    ------
    InputError
        It holds other things, or results that are not to be replaced, or cannot be made.
    """
    from granwave.extensions.inference.forces.output import WRITTEN

    results = ResultDirectory(results_directory(wanted))
    if not results.path.parent.is_dir():
        raise InputError(f"{results}: no such directory: {results.path.parent}")
    results.refuse_other_kind(INFERENCE)
    if set(WRITTEN) & set(results.result_names()):
        if not force:
            raise InputError(f"{results}: already holds results; {results.by_force}")
        results.refuse_immovable()
    results.refuse_foreign(WRITTEN)
    return results


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
    """Infer the forces of a table of grains, or of synthetic measurements of a run.

    Parameters
    ----------
    source
        Table, or directory of the run.
    case_file
        File with [material] and [infer]; a run can do without.
    noise, frame_rate, position_noise, time
        Settings of synthetic measurements of a run, as in
        `granwave.extensions.inference.forces.plan.plan_experiment`.
    repeat
        Repetitions with noise; None: from the case; for a run 10.
    progress
        Show a bar on a terminal.

    Raises
    ------
    InputError
        There is no such table or run, it or the case is invalid, or the equations do not determine
        the forces.
    """
    from granwave.extensions.inference.forces.case import read_infer_case
    from granwave.extensions.inference.forces.plan import plan_experiment

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
                f"--{given[0]}: this option requires the directory of a run; for a table use "
                "[infer] of --case"
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
    from granwave.extensions.inference.forces.case import read_infer_case
    from granwave.extensions.inference.forces.equations import Noise
    from granwave.extensions.inference.forces.infer import infer as infer_forces
    from granwave.extensions.inference.forces.measurement import read_measurement
    from granwave.extensions.inference.forces.output import Inferred
    from granwave.extensions.inference.forces.tables import summary_of

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
