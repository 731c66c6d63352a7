"""Command ``granwave infer``: contact forces from measured grains, or from measurements made of a run."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.as_json import print_json
from granwave.workflows.inference import CASE_MISSING, infer_run, infer_table, is_run, results_place

_OF_RUNS = ("noise", "frame_rate", "position_noise", "time")


def infer(options: argparse.Namespace) -> int:
    """Infer forces of ``options.measurement`` and write them into ``options.directory``; return the exit status.

    Raises
    ------
    InputError
        An option, the measurement or the case is wrong; nothing was written.
    """
    from granwave.analysis.inference.plan import Camera

    source: Path = options.measurement
    directory = results_place(options.directory or "infer", force=options.force)
    if is_run(source):
        camera = Camera(
            noise=tuple(options.noise or (0.0,)),
            frame_rate=options.frame_rate,
            position_noise=options.position_noise or 0.0,
            time=options.time,
            repetitions=10 if options.repeat is None else max(options.repeat, 1),
        )
        found = infer_run(source, options.case, camera, progress=True)
    else:
        for name in _OF_RUNS:
            if getattr(options, name) is not None:
                raise InputError(
                    f"--{name.replace('_', '-')}: found it with a table, expected it with the directory of a run; what "
                    "holds for a table stands in [infer] of --case"
                )
        if options.case is None:
            raise InputError(CASE_MISSING)
        found = infer_table(source, options.case, options.repeat, progress=True)
    found.save(directory, figures=options.figures)
    print_json(found.summary) if options.json else print(f"{report(found.summary)}\n\nresults in {directory}")
    return 0


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
