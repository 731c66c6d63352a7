"""Command ``granwave infer``: contact forces from measured grains, or from measurements made of a run."""

from __future__ import annotations

import argparse
from pathlib import Path

from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.as_json import print_json
from granwave.workflows.inference import CASE_MISSING, infer_run, infer_table, is_run, results_place, save

_OF_RUNS = ("noise", "frame_rate", "position_noise", "time")


def infer(options: argparse.Namespace) -> int:
    """Infer forces of ``options.measurement`` and write them into ``options.directory``; return the exit status.

    Raises
    ------
    InputError
        An option, the measurement or the case is wrong; nothing was written.
    """
    from granwave.analysis.inference.plan import Camera
    from granwave.analysis.inference.tables import in_words

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
    save(found, directory, figures=options.figures)
    print_json(found.summary) if options.json else print(f"{in_words(found.summary)}\n\nresults in {directory}")
    return 0
