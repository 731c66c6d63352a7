"""Analysis of a run: result.h5, summary.json and the figures, from the output of LAMMPS."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator
from pathlib import Path

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.figures.side_by_side import helpers, number_expected
from granwave.analysis.lammps_output.dumps import read_data
from granwave.analysis.lammps_output.frame import AGAIN
from granwave.analysis.lammps_output.time_series import check_complete, check_unchanged
from granwave.analysis.products import Product
from granwave.analysis.progress_bar import progress_bar
from granwave.analysis.result.hdf5_file import AT_ONCE
from granwave.analysis.result.not_a_run import way_on, where_stopped, why_no_run
from granwave.analysis.result.reader import Result
from granwave.analysis.result.writer import write_result
from granwave.analysis.summary import Summary, summarise
from granwave.lammps_inputs.case.figures import Figures, usual_figure_names
from granwave.lammps_inputs.deck.deck import read_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added_by_key, missing_package
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.planning.cost import MOST_DRAWN
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    RESULT_FILE,
    SUMMARY_FILE,
)

logger = logging.getLogger(__name__)

#: Figures that need no values of spheres and contacts.
_IN_TIME = (
    "energies",
    "timestep",
    "bottom_force",
    "target",
    "impactor_velocity",
    "probes",
    "accelerations",
)


def analyse(
    directory: AnyPath,
    progress: bool | Callable[[str], None] = False,
    *,
    figures: bool = True,
    at_once: int | None = None,
    processes: Processes = ALONE,
    assembly: Assembly | None = None,
) -> Summary:
    """Analyse a run; results of an earlier analysis are replaced.

    Parameters
    ----------
    directory
        Of the run.
    progress
        True for a bar on a terminal or in a notebook; or a function, called with the name of each
        part before it is made.
    figures
        Draw the figures requested in the case, and make its other files, such as an animation. Of
        packings with more spheres than `MOST_DRAWN` only figures of the run in time are drawn.
    at_once
        Largest number of spheres in memory; larger packings are analysed in parts. None: as
        `spheres_of_part` says. The values do not depend on it.
    processes
        Processes that share the work. Nor do the values depend on them.
    assembly
        All bodies of the case that was run, if it was read before.

    Returns
    -------
    dict
        Content of summary.json.

    Raises
    ------
    MissingOutputError
        It is not the directory of a run, or the run did not leave a file that is needed.
    OutputFormatError
        A file is damaged, or differs from the file that the run wrote.
    InputError
        case.toml or data.granwave was changed after the run, or there are files of such names that
        granwave did not write.
    """
    if callable(progress):
        results = ResultDirectory.at(directory)
        with _advice_to_resume(results):
            return _analyse(results, progress, figures, at_once, processes, assembly)
    parts = 2 + (len(usual_figure_names()) if figures else 0)
    with progress_bar(progress, total=parts, desc="analysis", leave=False) as bar:

        def report(part: str) -> None:
            logger.debug("%s: %s", directory, part)
            bar.set_postfix_str(part)
            bar.update()

        results = ResultDirectory.at(directory)
        with _advice_to_resume(results):
            return _analyse(results, report, figures, at_once, processes, assembly)


@contextlib.contextmanager
def _advice_to_resume(results: ResultDirectory) -> Iterator[None]:
    """Give the error of an unfinished run, whose output is not complete, the advice to resume it,
    as reports and figures do.
    """
    try:
        yield
    except (MissingOutputError, OutputFormatError) as error:
        directory = results.path
        stop = where_stopped(directory)
        if not stop or not (directory / CASE_FILE).exists() or results.kind.why_no_run:
            raise
        fault = str(error).partition(AGAIN)[0].rstrip(" ;,")
        raise type(error)(f"{fault}: {stop}; {way_on(directory)}") from None


def _drawn(directory: Path, n_spheres: int, options: Figures) -> tuple[str, ...] | None:
    """Return the names of the figures to draw; None: the figures selected by the options."""
    if n_spheres <= MOST_DRAWN:
        return None
    text = (
        "%s: figures of the packing are omitted, since each drawing process would hold %d "
        "spheres, more than %d; "
    )
    logger.warning(
        text + "granwave figures %s  draws them nevertheless",
        directory,
        n_spheres,
        MOST_DRAWN,
        directory,
    )
    return tuple(name for name in options.chosen if name in _IN_TIME)


def _analyse(
    results: ResultDirectory,
    report: Callable[[str], None],
    figures: bool,
    at_once: int | None,
    processes: Processes,
    assembly: Assembly | None,
) -> Summary:
    directory = results.path
    if not (directory / CASE_FILE).exists() or results.kind.why_no_run:
        raise MissingOutputError(why_no_run(directory))
    results.check_case()
    deck = read_deck(directory, None if assembly is None else assembly.case)
    assembly = assembly or assemble(deck.case)
    check_complete(directory, assembly, deck.schedule)
    try:
        results.check_deck()
    except InputError:
        list(read_data(directory))  # a damaged file has a message of its own, with the line
        raise
    check_unchanged(results, processes)
    with helpers(number_expected(deck.case.figures) if figures else 0) as others:
        report("result.h5")
        write_result(results, at_once=at_once, assembly=assembly, processes=processes)
        report("summary.json")
        rows = at_once or AT_ONCE
        summary = summarise(results, at_once=rows, assembly=assembly, processes=processes)
        results.note_files([RESULT_FILE, SUMMARY_FILE])
        if figures:
            # loading matplotlib takes longer than computing many a small run
            from granwave.analysis.figures.run_figures import draw_figures

            with Result(results, assembly=assembly) as result:
                options = result.figure_options
            drawn = _drawn(directory, summary["n_spheres"], options)
            draw_figures(results, report, drawn, helpers=others, options=options, assembly=assembly)
    if figures:
        _make_products(results, report)
    return summary


def _make_products(results: ResultDirectory, report: Callable[[str], None]) -> None:
    """Make the further files requested by ``[figures]`` of the case; log the reason if a file
    cannot be made.
    """
    with Result(results) as result:
        files = result.figure_options.products
    if not files:
        return
    products: dict[str, Product] = added_by_key("products", "figures")
    for key, file in files.items():
        if key not in products:
            logger.warning("%s: not made: the extension that makes it is not installed", file)
            continue
        report(file)
        try:
            products[key].make(results, file)
        except InputError as error:
            logger.warning("%s: not made: %s", file, error)
        except ModuleNotFoundError as error:
            logger.warning("%s: not made: %s", file, missing_package(error) or error)
