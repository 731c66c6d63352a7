"""One run of a finite-element problem, from case to figures."""

from __future__ import annotations

import abc
import json
import logging
import math
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from granwave.analysis.progress_bar import progress_bar
from granwave.lammps_inputs.directories import decide, results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import plain, replace_text
from granwave.lammps_inputs.ownership import claim, clear, figure_files, refuse_foreign
from granwave.lammps_inputs.run_directory import CASE_FILE, CONTINUUM, FIGURES_DIRECTORY, RESULT_FILE, SUMMARY_FILE
from granwave.lammps_inputs.run_state import note_files, read_summary, restore_case, result_fault
from granwave.workflows.finite_elements.frame import ElementCase, check_memory

logger = logging.getLogger("granwave")


class ElementRun(abc.ABC):
    """The solver of a case and its history, and what to make of them.

    Attributes
    ----------
    RESULTS
        Names of the files that a run leaves.
    FINISHED
        Values of ``end_reason`` of a run that is finished.
    UNIT
        Of progress.
    total
        Progress at the end, in the unit; None where it is not known before.
    """

    RESULTS: ClassVar[Sequence[str]]
    FINISHED: ClassVar[Sequence[str]]
    UNIT: ClassVar[str]

    total: float | None

    @abc.abstractmethod
    def __init__(self, case: Any) -> None:
        """Make the solver."""

    @staticmethod
    @abc.abstractmethod
    def figures() -> ModuleType:
        """Module with ``FIGURES``, names, and ``draw_figures``; the drawing library takes a second to load."""

    @abc.abstractmethod
    def integrate(self, report: Callable[[], None]) -> None:
        """Run the solver to the end of the case; ``report`` is called after each entry of the history."""

    @abc.abstractmethod
    def progress(self) -> tuple[float, str]:
        """Progress so far, in the unit, and a note beside it."""

    @abc.abstractmethod
    def summarise(self, wall_time: float) -> dict[str, Any] | None:
        """Summary of what was computed in a time, s; None where there is nothing yet."""

    @abc.abstractmethod
    def write(self, directory: Path, summary: dict[str, Any]) -> None:
        """Write the results but for the summary."""

    @abc.abstractmethod
    def conclude(self, directory: Path, summary: Mapping[str, Any], draw: Callable[[], None]) -> None:
        """Warn of what is doubtful, draw the figures, and refuse a run whose energy balance is off.

        Raises
        ------
        RunError
            The energy balance was refused; what was computed is kept.
        """


def run_elements(
    kind: type[ElementRun],
    case: ElementCase,
    directory: str | Path,
    *,
    progress: bool,
    force: bool,
    resume: bool,
    figures: bool,
) -> dict[str, Any]:
    """Run a case; leaves case.toml, result.h5, summary.json and figures in ``directory``.

    Parameters
    ----------
    kind
        Of the run.
    progress
        Show a bar on a terminal.
    force
        Replace the results that are there.
    resume
        Accept the finished results of the same case that are there; an unfinished run begins anew.
    figures
        Draw them.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    InputError
        The directory holds results, or another case, or the mesh does not fit into memory; nothing was changed.
    RunError
        The energy balance was refused; what was computed is kept.
    """
    directory, drawings = results_directory(directory), kind.figures
    names = (lambda: drawings().FIGURES) if figures else None
    there = _begin(case, directory, kind.RESULTS, kind.FINISHED, resume=resume, force=force, figures=names)
    if there is not None:
        return there
    run, started = kind(case), time.perf_counter()
    try:
        digits = digits_of(run.total)
        total = None if run.total is None else round(run.total, digits)
        with progress_bar(progress, total=total, desc=case.name, unit=kind.UNIT) as bar:

            def show() -> None:
                place, note = run.progress()
                bar.set_postfix_str(note, refresh=False)
                bar.update(advance(bar.n, place, total, digits))

            run.integrate(show)
    finally:
        summary = run.summarise(time.perf_counter() - started)
        if summary is not None:
            summary = plain(summary)
            run.write(directory, summary)
            replace_text(directory / SUMMARY_FILE, json.dumps(summary, indent=2, allow_nan=False) + "\n")
            note_files(directory, [RESULT_FILE, SUMMARY_FILE])
    assert summary is not None  # what is done has a history
    run.conclude(directory, summary, lambda: drawings().draw_figures(directory) if figures else None)
    return summary


def digits_of(total: float | None) -> int:
    """Return how many decimals of a progress to show: two, or as many as give hundredths of a small total."""
    return 2 if not total else max(2, 2 - math.floor(math.log10(total)))


def advance(shown: float, place: float, total: float | None, digits: int) -> float:
    """Return by how much a bar goes on to a place, never back and never beyond its total."""
    reached = place if total is None else min(place, total)
    return max(0.0, round(reached - shown, digits))


def _begin(
    case: ElementCase,
    directory: Path,
    results: Sequence[str],
    finished: Sequence[str],
    *,
    resume: bool,
    force: bool,
    figures: Callable[[], Iterable[str]] | None,
) -> dict[str, Any] | None:
    """Make a directory ready for a run, or find what a finished run of the same case left.

    Parameters
    ----------
    results
        Names of the files that a run leaves.
    finished
        Values of ``end_reason`` of a run that is finished.
    figures
        Gives their names; called where others of these names may be there. None: none are drawn.

    Returns
    -------
    dict or None
        What summary.json of the finished run holds; None if there is a run to do, and case.toml has been written.

    Raises
    ------
    InputError
        The directory holds results, or another case, or files that granwave did not write and would overwrite, or the
        mesh does not fit into memory; nothing was changed.
    """

    def there(tables: Mapping[str, Any]) -> Mapping[str, Any]:
        try:
            return type(case).from_dict(tables, directory / CASE_FILE).to_dict()
        except InputError:
            return {}  # of another kind: another case in any event

    names = list(results)
    if figures and os.path.lexists(directory / FIGURES_DIRECTORY):
        names += [file for name in figures() for file in figure_files(name)]
    if decide(directory, CONTINUUM, names, resume=resume, force=force, case=case.to_dict(), read=there):
        summary, fault = read_summary(directory), result_fault(directory)
        if summary.get("end_reason") in finished and not fault:
            restore_case(directory)
            return summary
        if summary.get("end_reason") in finished:
            logger.warning("%s; the case is run again", fault)
        refuse_foreign(directory, names)
    check_memory(case)
    clear(directory)
    directory.mkdir(parents=True, exist_ok=True)
    text = case.to_toml()
    claim(directory, results, kind=CONTINUUM, case=text)
    replace_text(directory / CASE_FILE, text)
    return None
