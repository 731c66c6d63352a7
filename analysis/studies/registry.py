"""Studies by the name or path that a scan or suite file gives: ``study = "tolerance"``, ``study =
"mine.py"``.

A built-in study is a module with

    TITLE, TEXT                        title, and what was run in a few sentences; or `title(group)`, `text(group)`
    select(runs) -> list of groups     the runs that it is about, put together; a study is made of each group
    rows(group) -> Row ...             tables of ours against a source, against theory, as a verification, and alone
    pictures(group) -> Picture ...     figures with captions

and, where they are wanted, `title(group)`, `name(group)` (short, for links and files),
`tables(group)` (with notes on them) and `verdict(group)`. `missing(group, undone)` are sentences
for the end of the verdict about points of its scans that failed or were not run, as values of the
keys that vary. `NEEDS` describes the runs that the study needs, for a warning if there are none.
`RUN_TYPE` is the class of the runs that `select` gets, usually
`granwave.analysis.studies.runs.FinishedRun`. A group is whatever `select` makes of the runs.
Without `name` a study has the name of its entry in this file; several groups are then numbered, and
so are their pictures. `make_studies` in `study` puts it together.

A comparison, which a report makes of all its runs, has `can_compare(runs)` too, True where there
are enough of them, and `remarks(runs)`, which yields notes for the end of its section.

Your own studies are Python files that a scan file, a suite file or ``granwave report --study``
names by path.

    '''Title of the study in one line.

    What was run, in a few sentences.'''
    import granwave as gw

    def rows(runs):
        for run in runs:
            yield gw.Row("Peak force", "N", ours=run["peak_force_N"], theory=92.7)

    def pictures(runs):
        yield gw.Picture("peak_force", "Caption", figure, {"velocity_m_s": velocity, "force_N":
        force})

``rows`` or ``pictures`` may be omitted; ``tables(runs)`` yields tables of the study's own, each as
caption and columns by heading with unit: ``"All impacts", {"Velocity (m/s)": velocity, "Largest
force (N)": force}``. ``runs`` is a list of `granwave.Run`: all finished runs of the scans that name
the file, or of the report, with the values of the varied keys in ``run.labels``. ``verdict(runs)``,
sentences for the top of the report, and the further functions of built-in studies may be there. The
code runs only when a scan or report is made with its path: the directory of a scan holds the path,
but a later ``granwave report`` of it loads no file that was not named again.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added_by_name

_HERE = "granwave.analysis.studies"
_OF_THE_CORE: dict[str, str] = {
    "protected-height": f"{_HERE}.protection.heights",
    "protected-bottoms": f"{_HERE}.protection.bottoms",
    "protected-spectrum": f"{_HERE}.protection.spectrum",
    "protected-checks": f"{_HERE}.protection.checks",
    "tolerance": f"{_HERE}.tolerance",
}


def _in_order(added: Mapping[str, str]) -> dict[str, str]:
    """Return all studies, by name, with the studies of extensions before or after the core's."""
    first = next(iter(_OF_THE_CORE))
    before = {name: added[name] for name in sorted(added) if name < first}
    after = {name: added[name] for name in sorted(added) if name > first}
    return before | _OF_THE_CORE | after


#: Module of each study, in the order of a report.
STUDIES: dict[str, str] = _in_order(added_by_name("studies"))

#: Studies of all runs of a report, in a separate section.
COMPARISON: dict[str, str] = added_by_name("comparisons")

SUFFIX = ".py"
_PARTS = ("rows", "pictures", "tables")
_PREFIX = "study_"  # beginning of the name of a module that was loaded from a file


def is_study_file(name: str) -> bool:
    """True for the path of a study's file, False for the name of a built-in study."""
    return name.endswith(SUFFIX)


def is_loaded(module: Any) -> bool:
    """True for a study that was loaded from a file of the user's."""
    return str(getattr(module, "__name__", "")).startswith(_PREFIX)


def find_studies(names: Sequence[str], directory: Path) -> tuple[list[str], list[str]]:
    """Find studies by name or path.

    Parameters
    ----------
    names
        Names of built-in studies, and paths of files.
    directory
        Folder that relative paths start from.

    Returns
    -------
    tuple
        Names and absolute paths; and the faults of the others, one line each.
    """
    found = []
    errors = []
    for name in names:
        if name in STUDIES:
            found.append(name)
        elif not is_study_file(name):
            errors.append(
                f"found {name}, expected one of: {', '.join(STUDIES)}; or the path of a file NAME{SUFFIX}"
            )
        else:
            path = str((directory / name).resolve())
            try:
                load_study(path)
                found.append(path)
            except InputError as error:
                errors += error.errors
    return found, errors


def load_study(path: str) -> ModuleType:
    """Load the file of a study, with ``TITLE`` and ``TEXT`` from its docstring where it has none.

    Raises
    ------
    InputError
        The file is missing, cannot be loaded, or has neither ``rows`` nor ``pictures`` nor
        ``tables``.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"{path}: no such file, expected the Python file of a study")
    return _load(file, file.stat().st_mtime_ns)


@cache
def _load(file: Path, changed: int) -> ModuleType:
    """Load a file again when it has changed, as in a notebook."""
    path = str(file)
    spec = importlib.util.spec_from_file_location(f"{_PREFIX}{file.stem}", file)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: cannot be loaded, expected the Python file of a study")
    module = importlib.util.module_from_spec(spec)
    before = set(sys.modules)
    sys.path.insert(0, str(file.parent))  # only this study can import the modules in its folder
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise InputError(f"{path}: cannot be loaded: {type(error).__name__}: {error}") from None
    finally:
        sys.path.remove(str(file.parent))
        for name in set(sys.modules) - before:
            if Path(getattr(sys.modules[name], "__file__", None) or "/").parent == file.parent:
                del sys.modules[name]
    if not any(callable(getattr(module, part, None)) for part in _PARTS):
        raise InputError(
            f"{path}: found neither rows(runs), pictures(runs) nor tables(runs), expected one of these"
        )
    title, _, text = inspect.cleandoc(module.__doc__ or file.stem).partition("\n\n")
    defaults = {
        "TITLE": " ".join(title.split()).rstrip("."),
        "TEXT": " ".join(text.split()),
        "select": _all,
    }
    for name, value in defaults.items():
        if not hasattr(module, name):
            setattr(module, name, value)
    return module


def _all(runs: list[object]) -> list[list[object]]:
    """One group of all runs."""
    return [runs] if runs else []
