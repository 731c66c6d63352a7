"""The functions of ``import granwave as gw``: run a case or a scan, and load results.

run = gw.run("fcc-small", load__velocity=10)
run["peak_force_N"], run.contacts, run.fields, run.figure("energies")
"""

from __future__ import annotations

import contextlib
import logging
import os
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.measures.target_record import rising_force_warning
from granwave.analysis.measures.zone_size import zone_warning
from granwave.analysis.notebook.load import ScanRuns, load
from granwave.analysis.notebook.run import Run
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
from granwave.lammps_inputs.extensions import added_by_name
from granwave.lammps_inputs.extensions import load as load_reference
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows.python.contacts import (
    contact_energy,
    contact_force,
    contact_overlap,
    contact_stiffness,
    contact_yield,
)
from granwave.workflows.python.inputs import (
    CaseLike,
    given_changes,
    home,
    read_case,
    read_scan,
    words_of_python,
)
from granwave.workflows.run import mpi, record
from granwave.workflows.run.directory import RunDirectory, decide, held
from granwave.workflows.run.leftovers import scratch_directory
from granwave.workflows.run.turns import turn
from granwave.workflows.solvers import GRANULAR

if TYPE_CHECKING:
    from granwave.analysis.reports.comparison.comparison import Comparison

__all__ = [
    "Case",
    "Comparison",
    "GranwaveError",
    "InputError",
    "MissingOutputError",
    "OutputFormatError",
    "Picture",
    "Row",
    "Run",
    "RunError",
    "ScanRuns",
    "case",
    "compare",
    "contact_energy",
    "contact_force",
    "contact_overlap",
    "contact_stiffness",
    "contact_yield",
    "export",
    "load",
    "run",
    "scan",
    "style",
]

logger = logging.getLogger(__name__)

#: Classes that are loaded on demand, with matplotlib.
_ON_DEMAND = {"Comparison": "granwave.analysis.reports.comparison.comparison:Comparison"}
_STOPPED = "{}: interrupted; pass resume=True to continue"


def public_names() -> list[str]:
    """Return the names of ``import granwave`` other than modules, including names of extensions."""
    return sorted({*__all__, *added_by_name("python")})


def object_of(name: str) -> Any:
    """Return the function or the class of a name of ``import granwave``.

    Raises
    ------
    AttributeError
        There is no such name.
    InputError
        A package that the extension of this name needs is not installed.
    """
    if name in _ON_DEMAND:
        return load_reference(_ON_DEMAND[name])
    if name in __all__:
        return globals()[name]
    references = added_by_name("python")
    if name not in references:
        raise AttributeError(f"module 'granwave' has no attribute '{name}'")
    with words_of_python():
        return load_reference(references[name])


def case(source: CaseLike, changes: Mapping[str, Any] | None = None, /, **keys: Any) -> Case:
    """Make a case, with the checks of a case file.

    Parameters
    ----------
    source
        Name of a built-in case, path of a case file, tables of a case file as nested mappings, a
        case, or a run, whose case is used.
    changes
        Values by dotted key: ``{"load.velocity": 10}``. The name of a table replaces the complete
        table.
    keys
        Changes as keywords, with two underscores for each dot: ``load__velocity=10``.

    Returns
    -------
    Case
        The case; other kinds of cases have classes of their own.

    Raises
    ------
    InputError
        There is no such case, or it is invalid; the message has a line for each fault.
    """
    with words_of_python():
        found: Case = read_case(source, changes, keys)[0]
        return found


def run(
    source: CaseLike,
    changes: Mapping[str, Any] | None = None,
    /,
    *,
    directory: str | Path | None = None,
    ranks: int = 1,
    figures: bool = False,
    force: bool = False,
    resume: bool = False,
    progress: bool = True,
    checkpoint: float = 60.0,
    **keys: Any,
) -> Run:
    """Run a case and load its results.

    Parameters
    ----------
    source, changes, keys
        The case, as in `case`.
    directory
        Directory of the results; by default the name of the case, in the working directory.
    ranks
        Number of MPI ranks. Several ranks are started by mpiexec, as by ``granwave run --np``.
    figures
        Draw the default figures into the directory. `Run.figure` draws one at any time.
    force
        Move existing results into NAME.old.
    resume
        Continue existing results of the same case; a finished run is loaded, and without results
        the run begins.
    progress
        Show a bar on a terminal or in a notebook.
    checkpoint
        Wall time between checkpoints, s.

    Returns
    -------
    Run
        The results.

    Raises
    ------
    InputError
        The case is invalid, or the directory holds results or another case, or memory or disk space
        is insufficient. Nothing was run.
    RunError
        LAMMPS failed, or the energy balance was rejected; the results are kept.
    KeyboardInterrupt
        The run was interrupted; it wrote a checkpoint, and ``resume=True`` continues it.
    """
    with words_of_python():
        found, kind = read_case(source, changes, keys)
        place = results_directory(found.name if directory is None else home(directory))
        if not isinstance(ranks, int) or isinstance(ranks, bool) or ranks < 1:
            raise InputError(f"ranks: found {show(ranks)}, expected a whole number from 1 up")
        if isinstance(checkpoint, str) or not 0 < checkpoint < float("inf"):
            raise InputError(f"checkpoint: found {show(checkpoint)}, expected a number above 0 (s)")
        how: dict[str, Any] = {
            "figures": figures,
            "force": force,
            "resume": resume,
            "progress": progress,
        }
        if kind.run is not None:
            if ranks > 1:
                raise InputError(
                    f"ranks: found {ranks}, expected 1: {found.name} is {kind.noun}, which has one"
                )
            if not resume:
                kind.afford(found, kind.cost(found, 1, figures), place)
            with held(ResultDirectory(place)), turn(place):
                kind.run(found, place, **how)
        elif ranks > 1 and not mpi.launched():
            _run_on_ranks(found, place, ranks, checkpoint, **how)
        else:
            from granwave.workflows.run.driver import run_case

            run_case(found, place, checkpoint_interval=checkpoint, **how)
        state = getattr(RunDirectory(place).read_record(), "state", "") if kind is GRANULAR else ""
        if state == record.INTERRUPTED:
            raise KeyboardInterrupt(_STOPPED.format(place))
        if state == record.REFUSED:
            raise RunError(
                f"{place}: energy balance error too large; the results are kept, load them with "
                "granwave.load"
            )
        loaded = Run(place)
    if mpi.is_first():
        _warn_of_limits(loaded, place)
    return loaded


def _warn_of_limits(run: Run, place: Path) -> None:
    """Warn if the packing limits the plastic zone of a run, or its end the force on the bottom."""
    kind = ResultDirectory(place).kind
    if warning := zone_warning(run.summary, kind.body):
        logger.warning("%s: %s", run.name, warning)
    if kind.of_spheres and (warning := rising_force_warning(place)):
        logger.warning("%s: %s", run.name, warning)


@contextlib.contextmanager
def style() -> Iterator[None]:
    """Give figures of matplotlib the style of granwave within a ``with`` block: the width of one
    column, fonts and colours.

    Settings are restored at its end. ``figsize`` of ``pyplot.subplots`` changes the size, inches.
    """
    from granwave.analysis.figures.series import own_style

    with own_style():
        yield


def scan(
    source: str | Path | Mapping[str, Any],
    changes: Mapping[str, Any] | None = None,
    /,
    *,
    directory: str | Path | None = None,
    jobs: int | None = None,
    force: bool = False,
    resume: bool = False,
    progress: bool = True,
    executor: str = "local",
    profile: str | Path | None = None,
    **keys: Any,
) -> ScanRuns:
    """Run a scan and load its results; failed points are reported, and the other points are loaded.

    Parameters
    ----------
    source
        Name of a built-in scan, path of a scan file, or the tables of a scan file as nested
        mappings, where ``case`` may also be a case or its tables.
    changes, keys
        Keys of the case for all points, as in `case`.
    directory
        Directory of the results; by default the name of the scan, in the working directory.
    jobs
        Number of cores of this machine to use, by default all; or of simultaneous jobs on a
        cluster.
    force
        Move existing results into NAME.old.
    resume
        Run missing points only; points that failed are tried again.
    progress
        Show a bar on a terminal or in a notebook.
    executor
        ``local``, or the scheduler of a cluster: ``slurm``, ``pbs``, ``torque``, ``lsf``, ``sge``,
        ``moab`` or ``flux``.
    profile
        Profile file of the cluster.

    Returns
    -------
    ScanRuns
        The results.

    Raises
    ------
    InputError
        The scan or one of its points is invalid, the directory holds results or another scan, or
        there is no such scheduler. Nothing was run.
    RunError
        No job could start a point, or the disk is full.
    KeyboardInterrupt
        The scan was interrupted; ``resume=True`` continues it.
    """
    from granwave.workflows.cluster.profile import check_executor, load_profile
    from granwave.workflows.scanning.driver import STOPPED, run_scan
    from granwave.workflows.scanning.engine import EXECUTORS, LOCAL

    with words_of_python():
        if executor not in EXECUTORS:
            expected = ", ".join(EXECUTORS)
            raise InputError(f"executor: found {show(executor)}, expected one of {expected}")
        found = read_scan(source, given_changes(changes, keys), here=executor == LOCAL)
        place = results_directory(found.name if directory is None else home(directory))
        if jobs is not None and (not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1):
            raise InputError(f"jobs: found {show(jobs)}, expected a whole number from 1 up")
        cluster = None
        if profile is not None and executor != LOCAL:
            cluster = load_profile(profile)
            check_executor(cluster, executor, profile)
        how = {"resume": resume, "force": force, "progress": progress}
        outcome = run_scan(found, place, executor=executor, profile=cluster, jobs=jobs, **how)
        if outcome.stopped == STOPPED:
            raise KeyboardInterrupt(_STOPPED.format(place))
        if outcome.stopped:
            raise RunError(
                f"{place}: {outcome.stopped}; free disk space, then pass resume=True to continue"
            )
        for count, what in ((outcome.failed, "failed"), (outcome.missing, "missing")):
            if count:
                text = (
                    "%s: of %d points %d %s; table.reason gives the reason, resume=True runs "
                    "them again"
                )
                logger.warning(text, place, len(found.distinct), count, what)
        return ScanRuns(place)


def compare(
    runs: Sequence[Run | ScanRuns | str | Path],
    quantities: str | Sequence[str] = (),
    measured: str | Path | None = None,
    measured_as: str = "bottom_force",
    *,
    shift: float = 0.0,
    scale: float = 1.0,
) -> Comparison:
    """Compare runs: largest differences, differences between their cases, and their curves.

    Parameters
    ----------
    runs
        Two or more runs or their directories; a scan stands for all its finished points.
    quantities
        Names of values of summary.json and of figures; by default all.
    measured
        Table of a measured curve with a column of times or lengths and a column of values. Each
        name contains the unit, such as ``time_us`` and ``force_kN``.
    measured_as
        Figure in which the curve is drawn: ``bottom_force``, ``peak_force_depth`` or ``fronts``.
    shift, scale
        Shift of the measured times or lengths, s or m, and factor of the values.

    Returns
    -------
    Comparison
        Its ``sentence``, ``table``, ``differences``, ``figures`` and ``figure(name)``.

    Raises
    ------
    InputError
        A directory has no results, there are fewer than two runs, a name is unknown, or a file
        cannot be read.
    """
    from granwave.analysis.reports.comparison.compare import compare_inputs
    from granwave.analysis.reports.inputs import read_inputs

    with words_of_python():
        places = [run if isinstance(run, str | Path) else run.directory for run in runs]
        names = [quantities] if isinstance(quantities, str) else list(quantities)
        inputs = read_inputs(places, Path.cwd(), repeated=True, skip_unfinished=True)
        return compare_inputs(inputs, names, measured, measured_as, shift=shift, scale=scale)


def export(
    run: Run | ScanRuns | str | Path,
    to: str,
    directory: str | Path | None = None,
    *,
    only: str | Sequence[str] = (),
    spheres: int | Iterable[int] | None = None,
    layers: int | Iterable[int] | None = None,
    depth: Sequence[float] | None = None,
    region: str | None = None,
    time: Sequence[float] | None = None,
) -> list[Path]:
    """Export a run or a scan to other programs; files of an earlier export to the same format are
    replaced.

    Parameters
    ----------
    run
        Run or scan, or its directory.
    to
        Format, such as ``csv``, ``netcdf``, ``vtp`` or ``ovito``.
    directory
        Directory to write to; by default ``export`` in the directory of the run.
    only
        Names of the tables to export to csv.
    spheres, layers, depth, region, time
        Rows to export to csv, netcdf and vtp, as in `Run.select`. With a selection csv has by
        default only the tables to which it applies.

    Returns
    -------
    list of Path
        Paths of the files.

    Raises
    ------
    InputError
        A value is invalid, the directory holds no results, or a library is missing; nothing was
        written.
    """
    from granwave.analysis.exports.export import export as export_directory
    from granwave.analysis.exports.selection import selection

    with words_of_python():
        place = Path(home(run)) if isinstance(run, str | Path) else run.directory
        tables = [only] if isinstance(only, str) else list(only)
        selected = selection(spheres, layers, depth, region, time)
        output = None if directory is None else home(directory)
        return export_directory(place, to, output, tables, selected)


def _run_on_ranks(
    found: Case, place: Path, ranks: int, checkpoint: float, *, progress: bool, **how: Any
) -> None:
    """Run a case on MPI ranks in separate processes; arguments as in
    `granwave.workflows.run.driver.run_case`.

    Raises
    ------
    InputError
        The directory holds results or another case, or there is no mpiexec. Nothing was run.
    RunError
        The ranks failed; results so far are kept.
    KeyboardInterrupt
        The run was interrupted; it wrote a checkpoint.
    """
    mpi.check_cores(ranks)
    results = RunDirectory(place)
    decide(assemble(found), results, n_ranks=ranks, **how)
    options = {
        "--force": how["force"],
        "--resume": how["resume"],
        "--no-figures": not how["figures"],
    }
    with scratch_directory() as scratch:
        file = scratch / "case.toml"
        file.write_text(found.to_toml(), encoding="utf-8")
        words = ["run", str(file), "-o", str(place), "--checkpoint", str(checkpoint)]
        words += [option for option, wanted in options.items() if wanted]
        lines: list[str] = []
        if progress and os.isatty(2):  # the progress bar of the first rank
            status = mpi.launch(ranks, words, stdout=subprocess.DEVNULL)
        else:
            status, lines = mpi.launch_unseen(ranks, words)
    if status == 130:
        raise KeyboardInterrupt(_STOPPED.format(place))
    errors = mpi.errors_in(lines)
    if status == 2:
        raise InputError(errors or f"{place}: the ranks rejected their input")
    state = results.read_record()
    if status and (state is None or state.state not in (record.REFUSED, record.INTERRUPTED)):
        reason = errors[-1] if errors else f"the ranks ended with status {status}"
        raise RunError((state.reason if state else None) or reason)
