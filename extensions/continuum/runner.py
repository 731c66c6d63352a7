"""One run of a finite-element problem, from case to figures, and its ``result.h5``, written
completely or not at all.
"""

from __future__ import annotations

import abc
import importlib
import json
import logging
import math
import os
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
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
from granwave.analysis.versions import versions_of
from granwave.extensions.continuum.files import CONTINUUM
from granwave.extensions.continuum.frame import ElementCase, check_memory
from granwave.lammps_inputs.directories import label_of, results_directory
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.files import plain, regular, replace_text
from granwave.lammps_inputs.own_files import AnyPath, figure_files
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    FIGURES_DIRECTORY,
    RESULT_FILE,
    SUMMARY_FILE,
)

Tables = Mapping[str, tuple[ArrayLike, str]]  # values and unit by the name of a data set

#: Names of energies in summary.json where they differ from those of the solvers.
SUMMARY_NAMES = {"plastic": "dissipated", "work": "input", "penalty": "contact"}

logger = logging.getLogger("granwave")
_COMPRESSED_FROM = 4096  # values; smaller data sets are not compressed


class ElementResult:
    """The ``result.h5`` of a finite-element run: all its data sets, its case and its summary.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    OutputFormatError
        It is damaged.
    """

    def __init__(self, directory: AnyPath) -> None:
        path = Path(directory) / RESULT_FILE
        if not path.exists():
            raise MissingOutputError(
                f"{path} is missing: make it with  granwave continuum CASE -o {directory}"
            )
        if changed := ResultDirectory.at(directory).changed_result():
            raise OutputFormatError(changed)
        try:
            with h5py.File(regular(path), "r") as file:
                self._read(file)
        except (OSError, KeyError, ValueError) as error:
            raise OutputFormatError(
                f"{path}: is damaged ({' '.join(str(error).split())}); run the case again"
            ) from None

    def _read(self, file: h5py.File) -> None:
        self.values: dict[str, NDArray] = {}
        file.visititems(
            lambda name, item: (
                self.values.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None
            )
        )
        self.tables: dict[str, Any] = tomllib.loads(str(file.attrs["case"]))
        self.summary: dict[str, Any] = json.loads(str(file.attrs["summary"]))

    def __getitem__(self, name: str) -> NDArray:
        """Return a data set by its name."""
        return self.values[name]


class ElementRun(abc.ABC):
    """The solver of a case, its history, and the evaluation of both.

    Attributes
    ----------
    KIND
        Kind of result, as the root of ``result.h5`` and the summary say.
    RESULTS
        Names of the files that a run leaves.
    FINISHED
        Values of ``end_reason`` of a run that is finished.
    UNIT
        Unit of progress.
    PACKAGES
        Packages whose versions are recorded.
    total
        Progress at the end, in the unit; None where it is not known before.
    end_reason
        Why the run ended: one of ``FINISHED``, ``refused`` (energy balance), or ``interrupted``.
    rows
        History: quantities by name, for each instant.
    overlaps
        Overlaps, m, at which the data of some groups of ``result.h5`` are, by the name of the
        group.
    """

    KIND: ClassVar[str]
    RESULTS: ClassVar[Sequence[str]] = (CASE_FILE, RESULT_FILE, SUMMARY_FILE)
    FINISHED: ClassVar[Sequence[str]]
    UNIT: ClassVar[str]
    PACKAGES: ClassVar[Sequence[str]]

    solver: Any
    total: float | None

    def __init__(self, case: Any) -> None:
        """Make the solver, at its start."""
        self.case = case
        self.end_reason = "interrupted"
        self.rows: list[dict[str, float]] = []
        self.overlaps: dict[str, float] = {}

    @classmethod
    def figures(cls) -> ModuleType:
        """Module ``figures`` of this kind of run, imported on demand.

        The drawing library takes a second to load.
        """
        return importlib.import_module(f"{cls.__module__.rpartition('.')[0]}.figures")

    def column(self, name: str) -> NDArray[np.float64]:
        """Return one quantity of the history, (n_instants,)."""
        return np.array([row[name] for row in self.rows])

    @abc.abstractmethod
    def integrate(self, report: Callable[[], None] = lambda: None) -> None:
        """Run the solver to the end of the case; ``report`` is called after each entry of the
        history.
        """

    @abc.abstractmethod
    def progress(self) -> tuple[float, str]:
        """Progress so far, in the unit of `total`, and a note."""

    @abc.abstractmethod
    def values(self) -> dict[str, Any]:
        """Values of summary.json that belong to this kind of run."""

    @abc.abstractmethod
    def tables(self) -> Tables:
        """Data sets of ``result.h5``."""

    @abc.abstractmethod
    def warnings(self, summary: Mapping[str, Any]) -> list[str]:
        """Warnings of doubtful results."""

    @abc.abstractmethod
    def refusal(self) -> tuple[str, str]:
        """Parts of the message that rejects the energy balance: its error, and the
        remedy.
        """

    def summarise(self, wall_time: float) -> dict[str, Any]:
        """Return the values of summary.json of a run whose integration took a time, s."""
        return {
            "name": self.case.name,
            "kind": self.KIND,
            **self.values(),
            "wall_time_s": wall_time,
            "element_steps_per_s": self.solver.n_elements * self.solver.n_steps / wall_time,
            "n_ranks": 1,
            "versions": versions_of(self.PACKAGES),
        }

    def write(self, directory: Path, summary: Mapping[str, Any]) -> None:
        """Write ``result.h5`` into a directory."""
        with new_hdf5(directory / RESULT_FILE, libver="v110") as file:
            for name, (values, unit) in self.tables().items():
                array = np.asarray(values)
                options: dict[str, Any] = (
                    dict(COMPRESSION) if array.size >= _COMPRESSED_FROM else {}
                )
                file.create_dataset(name, data=array, **options).attrs["unit"] = unit
            for group, overlap in self.overlaps.items():
                file[group].attrs["overlap"] = overlap
            file.attrs.update(kind=self.KIND, name=self.case.name, case=self.case.to_toml())
            file.attrs.update(summary=json.dumps(summary), versions=json.dumps(summary["versions"]))


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
        Move existing results into NAME.old.
    resume
        Accept existing, finished results of the same case; an unfinished run restarts from the
        beginning.
    figures
        Draw them.

    Returns
    -------
    dict
        Content of summary.json.

    Raises
    ------
    InputError
        The directory holds results, or another case, or the mesh does not fit into memory; nothing
        was changed.
    RunError
        The energy balance was rejected; the results are kept.
    """
    results = ResultDirectory(results_directory(directory))
    there = _begin(kind, case, results, resume=resume, force=force, figures=figures)
    if there is not None:
        return there
    run = kind(case)
    label = label_of(case.name, results.path)
    started = time.perf_counter()
    try:
        digits = digits_of(run.total)
        total = None if run.total is None else round(run.total, digits)
        with progress_bar(progress, total=total, desc=label, unit=kind.UNIT) as bar:

            def show() -> None:
                place, note = run.progress()
                bar.set_postfix_str(note, refresh=False)
                bar.update(advance(bar.n, place, total, digits))

            run.integrate(show)
    finally:
        if len(run.rows) > 1:
            summary: dict[str, Any] = plain(run.summarise(time.perf_counter() - started))
            run.write(results.path, summary)
            replace_text(
                results / SUMMARY_FILE, json.dumps(summary, indent=2, allow_nan=False) + "\n"
            )
            results.note_files(name for name in kind.RESULTS if name != CASE_FILE)
    for words in run.warnings(summary):
        logger.warning("%s: %s", label, words)
    if figures:
        draw_figures(kind, results)
    if run.end_reason == "refused":
        off, remedy = run.refusal()
        raise RunError(
            f"{label}: energy balance error too large: {off} is accepted; the results are "
            f"kept in {results}. {remedy}"
        )
    return summary


def draw_figures(kind: type[ElementRun], directory: AnyPath) -> list[Path]:
    """Draw the figures of a run from its ``result.h5``; return the paths of the PNG files.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    """
    from granwave.analysis.figures.style import FigureFolder, style

    module = kind.figures()
    folder = FigureFolder(directory)
    result = module.RESULT(directory)
    with style():
        for name, draw in module.FIGURES.items():
            folder.draw(partial(draw, result), name)
    return folder.written


def digits_of(total: float | None) -> int:
    """Return the decimals to show of a progress: two, or enough for hundredths of a small total."""
    return 2 if not total else max(2, 2 - math.floor(math.log10(total)))


def advance(shown: float, place: float, total: float | None, digits: int) -> float:
    """Return the advance of a progress bar to a position, never back and never beyond its total."""
    reached = place if total is None else min(place, total)
    return max(0.0, round(reached - shown, digits))


def _begin(
    kind: type[ElementRun],
    case: ElementCase,
    results: ResultDirectory,
    *,
    resume: bool,
    force: bool,
    figures: bool,
) -> dict[str, Any] | None:
    """Make a directory ready for a run and write case.toml, or return the results of a finished
    run of the same case.
    """

    def there(tables: Mapping[str, Any]) -> Mapping[str, Any]:
        try:
            return type(case).from_dict(tables, results / CASE_FILE).to_dict()
        except InputError:
            return {}  # results of another kind belong to another case

    names = list(kind.RESULTS)
    if figures and os.path.lexists(results / FIGURES_DIRECTORY):
        for name in kind.figures().FIGURES:
            names.extend(figure_files(name))
    if results.decide(
        CONTINUUM, names, resume=resume, force=force, case=case.to_dict(), read=there
    ):
        summary = results.summary()
        fault = results.fault()
        if summary.get("end_reason") in kind.FINISHED:
            if not fault:
                results.restore_case()
                return summary
            logger.warning("%s; the case is run again", fault)
        results.refuse_foreign(names)
    check_memory(case)
    results.make_room(force=force)
    results.path.mkdir(parents=True, exist_ok=True)
    text = case.to_toml()
    results.claim(kind.RESULTS, kind=CONTINUUM, case=text)
    replace_text(results / CASE_FILE, text)
    return None
