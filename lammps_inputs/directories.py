"""The rules of an output directory that may hold results: start, go on, or leave it alone.

Nothing is ever overwritten unasked: ``--resume`` goes on with what is there if it is of the same case, ``--force``
replaces it, and without either a directory that holds results is refused.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.deck import CASE_FILE
from granwave.lammps_inputs.errors import InputError

_SHOWN = 3  # names of results in a message


def decide(
    directory: Path,
    results: Iterable[str],
    *,
    resume: bool,
    force: bool,
    case: Mapping[str, Any],
    read: Callable[[Path], Mapping[str, Any]],
) -> bool:
    """Is there something of the same case to go on with? If not, a new start is allowed. Changes nothing.

    Parameters
    ----------
    results
        Names of the files and directories that a study of this kind leaves.
    case
        The case as tables, all defaults filled in.
    read
        Gives the same of the case.toml that is there; called only to resume.

    Returns
    -------
    bool
        True: the results there may be kept or continued, as far as they go. False: start, after `clear`.

    Raises
    ------
    InputError
        The directory holds results and neither ``resume`` nor ``force`` was given, or holds another case, or is a
        file; or both were given.
    """
    check_directory(directory, resume=resume, force=force)
    if resume and (directory / CASE_FILE).exists():
        refuse_other_case(directory, read(directory / CASE_FILE), case)
        return True
    if not force:
        refuse_results(directory, results)
    return False


def results_in(directory: Path, results: Iterable[str]) -> list[str]:
    """Those of ``results`` that a directory holds."""
    return [name for name in results if (directory / name).exists()]


def clear(directory: Path, results: Iterable[str]) -> None:
    """Remove ``results`` from a directory, and nothing else."""
    for name in results_in(directory, results):
        path = directory / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def check_directory(directory: Path, *, resume: bool, force: bool) -> None:
    """Raise InputError where a directory cannot be one, or where it shall be both kept and replaced."""
    if resume and force:
        raise InputError(
            "--resume and --force exclude each other: one goes on with what is there, the other replaces it"
        )
    if directory.exists() and not directory.is_dir():
        raise InputError(f"{directory}: is a file, expected a directory; choose another with -o")


def refuse_results(
    directory: Path,
    results: Iterable[str],
    ways: str = "--resume goes on with them, --force replaces them",
) -> None:
    """Raise InputError where a directory holds ``results``; ``ways`` are those that lead on."""
    found = results_in(directory, results)
    if found:
        names = ", ".join(found[:_SHOWN]) + (", ..." if len(found) > _SHOWN else "")
        raise InputError(f"{directory}: already holds results ({names}); {ways}, or choose another directory with -o")


def refuse_source(directory: Path, results: Iterable[str], name: str, source: Path | None) -> None:
    """Raise InputError where the case ``name`` takes its dents from a file among the ``results`` that it replaces."""
    if source is None:
        return
    places = [(directory / result).resolve() for result in results]
    if any(place in (source, *source.parents) for place in places):
        raise InputError(
            f"{name}: contact.initial_overlap: {source}: is among the results that would be replaced; "
            "choose another directory with -o"
        )


def refuse_other_case(directory: Path, there: Mapping[str, Any], here: Mapping[str, Any]) -> None:
    """Raise InputError where two cases, as tables, differ."""
    if there != here:
        keys = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
        raise InputError(
            f"{directory}: holds another case (different: {', '.join(keys)}); --force replaces it, or choose another "
            "directory with -o"
        )


def check_disk(
    directory: Path,
    needed: float,
    *,
    what: str = "the results",
    spare: float = 0.0,
    remedy: str = "fewer run.frames",
) -> None:
    """Refuse what does not fit on the disk.

    Parameters
    ----------
    needed
        Bytes that ``what`` need; nothing is refused that needs none.
    spare
        Bytes that must be left.
    remedy
        What else would do.

    Raises
    ------
    InputError
        There is less.
    """
    place = next(path for path in (directory, *directory.parents) if path.exists())
    free = shutil.disk_usage(place).free
    if needed and needed + spare > free:
        raise InputError(
            f"{directory}: {what} need about {needed / 1e9:.3g} GB, {free / 1e9:.3g} GB are free there; "
            f"choose another directory with -o, or {remedy}"
        )
