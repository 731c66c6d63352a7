"""The functions of ``import granwave as gw``: run a case or a scan, and load results.

run = gw.run("fcc-small", load__velocity=10)
run["peak_force_N"], run.contacts, run.fields, run.figure("energies")
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import tomli_w

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.measures.zone.marks import zone_warnings
from granwave.analysis.notebook.load import load
from granwave.analysis.notebook.run import Run
from granwave.analysis.notebook.scan import ScanRuns
from granwave.lammps_inputs.case.case import Case, case_keys
from granwave.lammps_inputs.case.overrides import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
from granwave.lammps_inputs.named_files import with_absolute_paths
from granwave.lammps_inputs.toml_files import read_toml
from granwave.workflows import library
from granwave.workflows.run import mpi, record
from granwave.workflows.solvers import CONTINUUM, GRANULAR, SPHERE_CONTACT, AnyCase, Kind, solver_of

__all__ = [
    "Case",
    "GranwaveError",
    "InputError",
    "MissingOutputError",
    "OutputFormatError",
    "Run",
    "RunError",
    "ScanRuns",
    "case",
    "load",
    "run",
    "scan",
]

CaseLike = str | Path | Mapping[str, Any] | AnyCase

logger = logging.getLogger(__name__)

_OWN_NAMES = {"case": Path("case"), "scan": Path("scan")}  # in place of files, in messages and as default names
_COMMAND = re.compile(r"\bgranwave (run|scan|continuum|analyse)\b")
# options of the command line in messages, and what they are called here
_WORDS = (
    (re.compile(r"^--set: "), ""),
    (re.compile(r"--(force|resume)\b"), r"\1=True"),
    (re.compile(r"--np (\d+)"), r"ranks=\1"),
    (re.compile(r" with -o\b"), " with directory=..."),
)


def case(source: CaseLike, changes: Mapping[str, Any] | None = None, /, **keys: Any) -> Case:
    """Make a case, checked as a case file is.

    Parameters
    ----------
    source
        Name of a built-in case, path of a case file, tables of a case file as nested mappings, or a case.
    changes
        Values by dotted key: ``{"load.velocity": 10}``. The name of a table replaces the whole table.
    keys
        The same as keywords, with two underscores for each dot: ``load__velocity=10``.

    Returns
    -------
    Case
        The case; of a continuum case an object of its own kind.

    Raises
    ------
    InputError
        There is no such case, or it is wrong; the message has a line for each fault.
    """
    with _words_of_python():
        found: Case = _read_case(source, changes, keys)[0]
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
        Number of MPI ranks. More than one are started by mpiexec, as ``granwave run --np`` does.
    figures
        Draw all figures into the directory. `Run.figure` draws one at any time.
    force
        Replace existing results.
    resume
        Continue existing results of the same case; a finished run is loaded, and without results the run begins.
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
        The case is wrong, or the directory holds results or another case, or memory or disk space is insufficient.
        Nothing was run.
    RunError
        LAMMPS failed, or the energy balance was refused; what was computed is kept.
    KeyboardInterrupt
        The run was interrupted; it wrote a checkpoint, and ``resume=True`` continues it.
    """
    with _words_of_python():
        found, kind = _read_case(source, changes, keys)
        place = results_directory(found.name if directory is None else _home(directory))
        if not isinstance(ranks, int) or isinstance(ranks, bool) or ranks < 1:
            raise InputError(f"ranks: found {show(ranks)}, expected a whole number from 1 up")
        if isinstance(checkpoint, str) or not 0 < checkpoint < float("inf"):
            raise InputError(f"checkpoint: found {show(checkpoint)}, expected a number above 0 (s)")
        how = {"figures": figures, "force": force, "resume": resume, "progress": progress}
        if not kind.parallel:
            if ranks > 1:
                raise InputError(f"ranks: found {ranks}, expected 1: {found.name} is a continuum case, which has one")
            _run_elements(found, kind, place, **how)
        elif ranks > 1 and not mpi.launched():
            _run_on_ranks(found, place, ranks, checkpoint=checkpoint, **how)
        else:
            from granwave.workflows.run.driver import run_case

            run_case(found, place, checkpoint_interval=checkpoint, **how)
        if kind is GRANULAR:
            _raise_unfinished(place)
        loaded = Run(place)
    for warning in zone_warnings(loaded.summary) if mpi.is_first() else ():
        logger.warning("%s: %s", loaded.name, warning)
    return loaded


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
    """Run a scan and load its results; points that fail are reported, and the others loaded.

    Parameters
    ----------
    source
        Name of a built-in scan, path of a scan file, or the tables of one as nested mappings, in which ``case`` may
        also be the tables of a case, or a case.
    changes, keys
        Keys of the case for all points, as in `case`.
    directory
        Directory of the results; by default the name of the scan, in the working directory.
    jobs
        Number of cores of this machine to use, by default all; or of simultaneous jobs on a cluster.
    force
        Replace existing results.
    resume
        Run missing points only; points that failed are tried again.
    progress
        Show a bar on a terminal or in a notebook.
    executor
        ``local`` or ``slurm``.
    profile
        File that tells how to use the cluster, for ``slurm``.

    Returns
    -------
    ScanRuns
        The results.

    Raises
    ------
    InputError
        The scan or one of its points is wrong, the directory holds results or another scan, or Snakemake is missing.
        Nothing was run.
    RunError
        Snakemake failed, or the disk is full.
    KeyboardInterrupt
        The scan was interrupted; ``resume=True`` continues it.
    """
    from granwave.workflows.scanning.driver import STOPPED, run_scan
    from granwave.workflows.scanning.engine import EXECUTORS, LOCAL
    from granwave.workflows.scanning.profile import load_profile

    with _words_of_python():
        if executor not in EXECUTORS:
            raise InputError(f"executor: found {show(executor)}, expected {' or '.join(EXECUTORS)}")
        found = _read_scan(source, _changes(changes, keys), here=executor == LOCAL)
        place = results_directory(found.name if directory is None else _home(directory))
        if jobs is not None and (not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1):
            raise InputError(f"jobs: found {show(jobs)}, expected a whole number from 1 up")
        outcome = run_scan(
            found,
            place,
            executor=executor,
            profile=load_profile(profile) if profile is not None else None,
            jobs=jobs,
            resume=resume,
            force=force,
            progress=progress,
        )
        if outcome.stopped == STOPPED:
            raise KeyboardInterrupt(f"{place}: stopped before its end; resume=True goes on")
        if outcome.stopped:
            raise RunError(f"{place}: {outcome.stopped}; make room, then resume=True goes on")
        for count, what in ((outcome.failed, "failed"), (outcome.missing, "are missing")):
            if count:
                logger.warning("%s: %d points %s; table.reason tells why, resume=True tries again", place, count, what)
        return ScanRuns(place)


# ---------------------------------------------------------------------- input


def _read_case(source: CaseLike, changes: Mapping[str, Any] | None, keys: Mapping[str, Any]) -> tuple[Any, Kind]:
    tables, path = _tables(source)
    changed = _changes(changes, keys)
    kind = solver_of(tables)
    return kind.read(apply_overrides(tables, changed), path, overridden=changed), kind


def _tables(source: CaseLike) -> tuple[dict[str, Any], Path]:
    """Return the tables of a case, and the name of its file in messages."""
    if isinstance(source, str | Path):
        path = library.find_for(str(_home(source)), GRANULAR.verb, CONTINUUM.verb)
        return read_toml(path), path
    if isinstance(source, Mapping):
        return with_absolute_paths(_plain(source), Path()), _OWN_NAMES["case"]
    if hasattr(source, "to_dict"):
        return source.to_dict(), _OWN_NAMES["case"]
    raise InputError(f"case: found {show(source)}, expected a name, the path of a file, a mapping or a case")


def _changes(changes: Mapping[str, Any] | None, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes of a case by dotted key."""
    if changes is not None and not isinstance(changes, Mapping):
        raise InputError(f'found {show(changes)}, expected a mapping such as {{"load.velocity": 10}}')
    if flat := [name for name in keys if name not in case_keys() and name.replace("_", ".", 1) in case_keys()]:
        raise InputError(
            f"{name}: unknown key; did you mean {name.replace('_', '__', 1)}, with two underscores for the dot?"
            for name in flat
        )
    dotted = {name.replace("__", "."): value for name, value in keys.items()}
    given = {str(name): value for name, value in (changes or {}).items()}
    if twice := sorted(set(dotted) & set(given)):
        raise InputError(f"{name}: given twice, in the mapping and as a keyword" for name in twice)
    return parse_overrides(_plain(given | dotted))


def _read_scan(source: str | Path | Mapping[str, Any], changes: Mapping[str, Any], *, here: bool) -> Any:
    from granwave.workflows.scanning.scan_file import load_scan, scan_from_dict

    if isinstance(source, str | Path):
        return load_scan(_home(source), changes, here=here)
    if not isinstance(source, Mapping):
        raise InputError(f"scan: found {show(source)}, expected a name, the path of a file or a mapping")
    data, template, comment = dict(source), None, ""
    if "case" in data and not isinstance(data["case"], str | Path):
        template = {"name": "case", **_tables(data["case"])[0]}
        data["case"] = str(template["name"])
        comment = "# The case was given in Python:\n#\n" + "".join(
            f"# {line}\n" for line in tomli_w.dumps(template).splitlines()
        )
    data = with_absolute_paths(_plain(data), Path())
    return scan_from_dict(
        data, _OWN_NAMES["scan"], changes, here=here, text=comment + tomli_w.dumps(data), template=template
    )


def _plain(value: Any) -> Any:
    """Convert a value to those of TOML: numbers and arrays of numpy, paths and tuples; others stay as they are."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        return _plain(value.tolist())
    return value


def _home(path: str | Path) -> str:
    """Replace a ``~``, as a shell does."""
    return os.path.expanduser(path)


# ---------------------------------------------------------------------- running


def _run_elements(found: Any, kind: Kind, place: Path, *, resume: bool, **how: Any) -> None:
    """Run a case of finite elements."""
    from granwave.workflows.run.directory import held

    run_it: Any
    if kind is SPHERE_CONTACT:
        from granwave.workflows.finite_elements.sphere_contact import run_sphere_contact as run_it
    else:
        from granwave.workflows.finite_elements.punch import run_continuum as run_it
    if not resume:
        kind.check(found, kind.cost(found, 1, how["figures"]), place)
    with held(place):
        run_it(found, place, resume=resume, **how)


def _run_on_ranks(
    found: Case,
    place: Path,
    ranks: int,
    *,
    checkpoint: float,
    figures: bool,
    force: bool,
    resume: bool,
    progress: bool,
) -> None:
    """Run a case on MPI ranks in processes of their own."""
    from granwave.workflows.run.directory import decide

    decide(found, place, resume=resume, force=force, n_ranks=ranks, figures=figures)
    options = {"--force": force, "--resume": resume, "--no-figures": not figures}
    with tempfile.TemporaryDirectory(prefix="granwave-") as scratch:
        file = Path(scratch) / "case.toml"
        file.write_text(found.to_toml(), encoding="utf-8")
        words = ["run", str(file), "-o", str(place), "--checkpoint", str(checkpoint)]
        words += [option for option, wanted in options.items() if wanted]
        with (Path(scratch) / "stderr").open("w+b") as stream:
            shown = progress and os.isatty(2)  # the bar of the first rank
            stderr = None if shown else stream.fileno()
            status = mpi.launch(ranks, words, stdout=subprocess.DEVNULL, stderr=stderr)
            stream.seek(0)
            text = stream.read().decode("utf-8", "replace")
    if status == 130:
        raise KeyboardInterrupt(f"{place}: stopped before its end; resume=True goes on")
    said = [line.removeprefix("granwave: ") for line in text.splitlines() if line.startswith("granwave: ")]
    errors = [line for line in said if not line.startswith("warning: ")]
    if status == 2:
        raise InputError(errors or f"{place}: the ranks refused their input")
    state = record.read(place)
    if status and (state is None or state.state not in (record.REFUSED, record.INTERRUPTED)):
        reason = (state.reason if state else None) or (
            errors[-1] if errors else f"the ranks ended with status {status}"
        )
        raise RunError(reason)


def _raise_unfinished(place: Path) -> None:
    """Raise the error of a run that was interrupted or refused."""
    found = record.read(place)
    if found is not None and found.state == record.INTERRUPTED:
        raise KeyboardInterrupt(f"{place}: stopped before its end; resume=True goes on")
    if found is not None and found.state == record.REFUSED:
        raise RunError(f"{place}: the energy balance was refused; what was computed is kept, granwave.load shows it")


@contextlib.contextmanager
def _words_of_python() -> Iterator[None]:
    """Call options in the messages of errors as they are called here; commands to type stay as they are."""
    try:
        yield
    except InputError as error:
        raise InputError(map(_in_python, error.errors)) from error.__cause__
    except RunError as error:
        raise RunError(_in_python(str(error))) from error.__cause__


def _in_python(line: str) -> str:
    if _COMMAND.search(line):
        return line.removeprefix("--set: ")
    for pattern, word in _WORDS:
        line = pattern.sub(word, line)
    return line
