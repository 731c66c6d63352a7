"""Searches for a design in Python: ``gw.design("plate.toml")``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.extensions.design.notebook import Designs
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.python.inputs import home, plain, words_of_python


def design(
    source: str | Path | Mapping[str, Any],
    /,
    *,
    directory: str | Path | None = None,
    jobs: int | None = None,
    ranks: int = 1,
    budget: int | None = None,
    force: bool = False,
    resume: bool = False,
    progress: bool = True,
) -> Designs:
    """Search for the best design, and load the result.

    Parameters
    ----------
    source
        Path of a design file, or its tables as nested mappings.
    directory
        Directory of the results; by default the name of the search, in the working directory.
    jobs
        Number of simultaneous runs, by default the cores of this machine divided by the ranks.
    ranks
        MPI ranks of each run.
    budget
        Number of designs to run; overrides the file.
    force
        Move existing results into NAME.old.
    resume
        Resume an earlier start of the same search.
    progress
        Show a bar on a terminal or in a notebook.

    Returns
    -------
    Designs
        The result.

    Raises
    ------
    InputError
        The file is invalid, no design meets the limits known before a run, the directory holds
        results or another search, or scikit-learn is missing. Nothing was run.
    KeyboardInterrupt
        The search was interrupted; ``resume=True`` continues it.
    """
    from granwave.extensions.design.search.design_file import load_problem
    from granwave.extensions.design.search.driver import run_design

    with words_of_python():
        for name, value in (("jobs", jobs), ("budget", budget), ("ranks", ranks)):
            if value is not None and (
                not isinstance(value, int) or isinstance(value, bool) or value < 1
            ):
                raise InputError(f"{name}: found {show(value)}, expected a whole number from 1 up")
        problem = load_problem(
            plain(source) if isinstance(source, Mapping) else home(source), budget
        )
        place = results_directory(problem.name if directory is None else home(directory))
        _, stopped = run_design(
            problem, place, jobs=jobs, ranks=ranks, force=force, resume=resume, progress=progress
        )
        if stopped:
            raise KeyboardInterrupt(f"{place}: interrupted; pass resume=True to continue")
    return Designs(place)
