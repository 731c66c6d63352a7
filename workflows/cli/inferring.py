"""Command ``granwave infer``: contact forces from measured grains, or from measurements made of a run."""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.ownership import refuse_foreign, refuse_other_kind, results_in
from granwave.lammps_inputs.run_directory import INFERENCE, RESULT_FILE
from granwave.workflows.cli.as_json import print_json

if TYPE_CHECKING:
    from granwave.analysis.inference.case import InferCase

_OF_RUNS = ("noise", "frame_rate", "position_noise", "time")


def infer(options: argparse.Namespace) -> int:
    """Infer forces of ``options.measurement`` and write them into ``options.directory``; return the exit status.

    Raises
    ------
    InputError
        An option, the measurement or the case is wrong; nothing was written.
    """
    from granwave.analysis.inference.case import read_infer_case
    from granwave.analysis.inference.output import WRITTEN

    source: Path = options.measurement
    of_run = source.is_dir() or source.name == RESULT_FILE
    directory = results_directory(options.directory or "infer", force=options.force)
    if not directory.parent.is_dir():
        raise InputError(f"-o {directory}: there is no directory {directory.parent}")
    refuse_other_kind(directory, INFERENCE)
    if not options.force and set(WRITTEN) & set(results_in(directory)):
        raise InputError(f"{directory}: already holds results; --force replaces them, or choose another with -o")
    refuse_foreign(directory, WRITTEN)
    if not of_run:
        for name in _OF_RUNS:
            if getattr(options, name) is not None:
                raise InputError(
                    f"--{name.replace('_', '-')}: found it with a table, expected it with the directory of a run; what "
                    "holds for a table stands in [infer] of --case"
                )
        if options.case is None:
            raise InputError("--case: missing; expected a file with [material] and [infer] (granwave keys infer)")
    case = None if options.case is None else read_infer_case(options.case, of_run=of_run)
    summary = _of_run(options, case, directory) if of_run else _of_table(options, case, directory)
    print_json(summary) if options.json else print(f"{report(summary)}\n\nresults in {directory}")
    return 0


def _of_table(options: argparse.Namespace, case: InferCase | None, directory: Path) -> dict[str, Any]:
    """Infer the forces of a table of grains."""
    from granwave.analysis.inference.infer import infer as infer_forces
    from granwave.analysis.inference.measurement import read_measurement
    from granwave.analysis.inference.output import write_inference
    from granwave.analysis.inference.tables import summary_of
    from granwave.workflows.run.directory import held

    assert case is not None
    measured = read_measurement(options.measurement, case)
    settings = case.settings
    if options.repeat is not None:
        settings = dataclasses.replace(settings, repetitions=options.repeat)
    found = []
    for time, grains in zip(measured.times, measured.grains, strict=True):
        try:
            found.append(infer_forces(grains, case.walls, settings))
        except InputError as error:
            at = "" if math.isnan(time) else f" at {time:g} s"
            raise InputError([f"{options.measurement}{at}: {line}" for line in error.errors]) from None
    name = options.measurement.stem
    summary = summary_of(name, str(options.measurement), case.infer.state, found, measured.times, measured.notes)
    with held(directory):
        write_inference(directory, found, measured.times, summary, figures=options.figures)
    return summary


def _of_run(options: argparse.Namespace, case: InferCase | None, directory: Path) -> dict[str, Any]:
    """Infer the forces of measurements made of a run."""
    from granwave.analysis.inference.plan import Camera, plan_experiment
    from granwave.workflows.run.directory import held

    camera = Camera(
        noise=tuple(options.noise or (0.0,)),
        frame_rate=options.frame_rate,
        position_noise=options.position_noise or 0.0,
        time=options.time,
        repetitions=10 if options.repeat is None else max(options.repeat, 1),
    )
    planned = plan_experiment(options.measurement, case, camera)
    with held(directory):
        planned.write(directory, figures=options.figures)
    return planned.summary


def report(summary: Mapping[str, Any]) -> str:
    """Return the main values for the terminal."""
    from granwave.analysis.summary_table import lines

    def shown(key: str, form: str, factor: float = 1.0) -> str:
        values = summary.get(key)
        if not isinstance(values, list):
            values = [values]
        numbers = [value if factor == 1 else factor * value for value in values if isinstance(value, int | float)]
        if not numbers:
            return ""
        low, high = format(min(numbers), form), format(max(numbers), form)
        return low if low == high else f"{low} to {high}"

    rows = [
        ("grains", shown("n_grains", "d")),
        ("contacts", f"{shown('n_contacts', 'd')}, {shown('n_loaded_contacts', 'd')} of them bear a force"),
        (
            "equations",
            f"{shown('n_equations', 'd')} for {shown('n_unknowns', 'd')} unknowns, {summary['weights']} weights",
        ),
        ("largest force", f"{shown('largest_force_N', '.4g')} N"),
        ("residuals", f"{shown('residual_fraction', '.2g', 100)} % of the data"),
    ]
    if instants := summary["n_instants"] - 1:
        rows.insert(0, ("instants", str(instants + 1)))
    if text := shown("chi2_per_equation", ".3g"):
        rows.append(("chi^2", f"{text} for each free equation (1: as the noise)"))
    if text := shown("standard_error_fraction", ".2g", 100):
        rows.append(("standard error", f"{text} % of the forces, from {summary['repetitions']} repetitions"))
    if text := shown("youngs_modulus_error_Pa", ".2g", 1e-6):
        rows.append(("Young's modulus", f"{shown('youngs_modulus_Pa', '.4g', 1e-6)} +- {text} MPa"))
    if text := shown("acceleration_error", ".2g", 100):
        rows.append(("accelerations", f"off by {text} %"))
    if text := shown("true_force_error", ".2g", 100):
        rows.append(("forces", f"off by {text} % of the true ones"))
    return lines([*rows, *(("note", note) for note in summary["notes"])])
