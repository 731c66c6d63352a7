"""One run of a finite-element problem, from case to figures, and its ``result.h5``, written whole or not at all."""

from __future__ import annotations

import abc
import json
import logging
import math
import os
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.progress_bar import progress_bar
from granwave.analysis.result.hdf5_file import new_hdf5
from granwave.analysis.result.trajectory import COMPRESSION
from granwave.lammps_inputs.directories import (
    changed_result,
    decide,
    note_files,
    read_summary,
    restore_case,
    result_fault,
    results_directory,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import plain, replace_text
from granwave.lammps_inputs.ownership import claim, clear, figure_files, refuse_foreign
from granwave.lammps_inputs.run_directory import CASE_FILE, CONTINUUM, FIGURES_DIRECTORY, RESULT_FILE, SUMMARY_FILE
from granwave.workflows.finite_elements.frame import ElementCase, check_memory

Tables = Mapping[str, tuple[ArrayLike, str]]  # values and unit by the name of a data set

logger = logging.getLogger("granwave")
_COMPRESSED_FROM = 4096  # values; smaller data sets are kept plain


def write_result(
    directory: Path,
    kind: str,
    case: ElementCase,
    summary: Mapping[str, Any],
    tables: Tables,
    overlaps: Mapping[str, float] | None = None,
) -> None:
    """Write ``result.h5`` into a directory.

    Parameters
    ----------
    kind
        Of the result, as its root says.
    tables
        Data sets.
    overlaps
        Overlaps, m, at which the data of some groups are, by the name of the group.
    """
    with new_hdf5(directory / RESULT_FILE, libver="v110") as file:
        for name, (values, unit) in tables.items():
            array = np.asarray(values)
            options: dict[str, Any] = dict(COMPRESSION) if array.size >= _COMPRESSED_FROM else {}
            file.create_dataset(name, data=array, **options).attrs["unit"] = unit
        for group, overlap in (overlaps or {}).items():
            file[group].attrs["overlap"] = overlap
        file.attrs.update(kind=kind, name=case.name, case=case.to_toml(), summary=json.dumps(summary))
        file.attrs["versions"] = json.dumps(summary["versions"])


class ElementResult:
    """The ``result.h5`` of a finite-element run: all its data sets, its case and its summary.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    OutputFormatError
        It is damaged.
    """

    def __init__(self, directory: str | Path) -> None:
        path = Path(directory) / RESULT_FILE
        if not path.exists():
            raise MissingOutputError(f"{path} is missing: make it with  granwave continuum CASE -o {directory}")
        if changed := changed_result(path.parent):
            raise OutputFormatError(changed)
        try:
            with h5py.File(path, "r") as file:
                self._read(file)
        except (OSError, KeyError, ValueError) as error:
            raise OutputFormatError(
                f"{path}: is damaged ({' '.join(str(error).split())}); run the case again"
            ) from None

    def _read(self, file: h5py.File) -> None:
        names: list[str] = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        self._values: dict[str, NDArray] = {name: file[name][()] for name in names}
        self.tables: dict[str, Any] = tomllib.loads(str(file.attrs["case"]))
        self.summary: dict[str, Any] = json.loads(str(file.attrs["summary"]))
        self._read_more(file)

    def _read_more(self, file: h5py.File) -> None:
        """Further values that a kind of result reads."""

    def __getitem__(self, name: str) -> NDArray:
        """A data set by its name."""
        return self._values[name]

    def __contains__(self, name: str) -> bool:
        return name in self._values


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

    RESULTS: ClassVar[Sequence[str]] = (CASE_FILE, RESULT_FILE, SUMMARY_FILE)
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
    progress: bool = False,
    force: bool = False,
    resume: bool = False,
    figures: bool = True,
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
    directory = results_directory(directory)
    there = _begin(kind, case, directory, resume=resume, force=force, figures=figures)
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
    run.conclude(directory, summary, lambda: kind.figures().draw_figures(directory) if figures else None)
    return summary


def digits_of(total: float | None) -> int:
    """Return how many decimals of a progress to show: two, or as many as give hundredths of a small total."""
    return 2 if not total else max(2, 2 - math.floor(math.log10(total)))


def advance(shown: float, place: float, total: float | None, digits: int) -> float:
    """Return by how much a bar goes on to a place, never back and never beyond its total."""
    reached = place if total is None else min(place, total)
    return max(0.0, round(reached - shown, digits))


def _begin(
    kind: type[ElementRun], case: ElementCase, directory: Path, *, resume: bool, force: bool, figures: bool
) -> dict[str, Any] | None:
    """Make a directory ready for a run and write case.toml, or return what a finished run of the same case left."""

    def there(tables: Mapping[str, Any]) -> Mapping[str, Any]:
        try:
            return type(case).from_dict(tables, directory / CASE_FILE).to_dict()
        except InputError:
            return {}  # of another kind: another case in any event

    names = list(kind.RESULTS)
    if figures and os.path.lexists(directory / FIGURES_DIRECTORY):
        names += [file for name in kind.figures().FIGURES for file in figure_files(name)]
    if decide(directory, CONTINUUM, names, resume=resume, force=force, case=case.to_dict(), read=there):
        summary, fault = read_summary(directory), result_fault(directory)
        if summary.get("end_reason") in kind.FINISHED:
            if not fault:
                restore_case(directory)
                return summary
            logger.warning("%s; the case is run again", fault)
        refuse_foreign(directory, names)
    check_memory(case)
    clear(directory)
    directory.mkdir(parents=True, exist_ok=True)
    text = case.to_toml()
    claim(directory, kind.RESULTS, kind=CONTINUUM, case=text)
    replace_text(directory / CASE_FILE, text)
    return None
