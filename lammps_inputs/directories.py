"""Rules for directories of results: start, resume or refuse; unsuitable places; full disks.

A directory that holds results is refused by default. ``--resume`` continues them if they are of the same case,
``--force`` replaces what granwave wrote. Files that granwave did not write are always kept, see
`granwave.lammps_inputs.run_directory`.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import head
from granwave.lammps_inputs.ownership import refuse_foreign, refuse_other_kind, refuse_results, results_in
from granwave.lammps_inputs.run_state import check_case, tables_as_run


def decide(
    directory: Path,
    kind: str,
    names: Iterable[str],
    *,
    resume: bool,
    force: bool,
    case: Mapping[str, Any],
    read: Callable[[Mapping[str, Any]], Mapping[str, Any]],
) -> bool:
    """Decide between resuming the results in a directory and a new start, without changing anything.

    Parameters
    ----------
    kind
        Kind of results, see `granwave.lammps_inputs.run_directory`.
    names
        Names of the files that will be written.
    case
        The case as tables, all defaults filled in.
    read
        Function that returns the same for the tables of the case that was run; called only to resume.

    Returns
    -------
    bool
        True: keep and continue the results. False: start anew, after `clear`.

    Raises
    ------
    InputError
        The directory holds results and neither ``resume`` nor ``force`` was given; it holds another case, or files that
        granwave did not write and would overwrite; it is unsuitable for results; or both options were given.
    """
    check_directory(directory, resume=resume, force=force)
    refuse_other_kind(directory, kind)
    if resume and results_in(directory) and (there := tables_as_run(directory)) is not None:
        check_case(directory)
        refuse_other_case(directory, read(there), case)
        return True
    if not force:
        refuse_results(directory)
    refuse_foreign(directory, names)
    return False


def check_directory(directory: Path, *, resume: bool, force: bool) -> None:
    """Raise InputError if a directory is unsuitable for results, or if both ``resume`` and ``force`` are given."""
    if resume and force:
        raise InputError(
            "--resume and --force exclude each other: one goes on with what is there, the other replaces it"
        )
    results_directory(directory, force=force)


def refuse_source(directory: Path, name: str, source: Path | None) -> None:
    """Raise InputError if the case ``name`` takes its dents from a file among the results that it would replace."""
    if source is None:
        return
    there = source.resolve()
    places = [(directory / result).resolve() for result in results_in(directory)]
    if any(place in (there, *there.parents) for place in places):
        raise InputError(
            f"{name}: contact.initial_overlap: {source}: is among the results that would be replaced; "
            "choose another directory with -o"
        )


def refuse_other_case(directory: Path, there: Mapping[str, Any], here: Mapping[str, Any]) -> None:
    """Raise InputError if two cases, as tables, differ."""
    if there != here:
        keys = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
        raise InputError(
            f"{directory}: holds another case (different: {', '.join(keys)}); --force replaces it, or choose another "
            "directory with -o"
        )


# ---------------------------------------------------------------------- places


def output_path(name: str | Path) -> Path:
    """Return the path of a file or directory to be written.

    Raises
    ------
    InputError
        The name is empty, or begins with a "~" that the shell did not replace.
    """
    if not str(name):
        raise InputError('found the empty name "", expected that of a file or directory (. is the present directory)')
    path = Path(name)
    if path.parts and path.parts[0].startswith("~"):
        raise InputError(f"{path}: the shell did not replace {path.parts[0]}; write the whole path, or $HOME")
    return path


def results_directory(name: str | Path, *, force: bool = False) -> Path:
    """Return the absolute path of a directory for results.

    Parameters
    ----------
    force
        True to replace existing results.

    Raises
    ------
    InputError
        As in `output_path`; or it is a file, the root or the home directory, or, with ``force``, a link to a directory
        that holds results.
    """
    path = output_path(name)
    try:
        there = path.resolve()
        is_file = there.exists() and not there.is_dir()
        with contextlib.suppress(FileNotFoundError):
            path.lstat()
    except (OSError, RuntimeError, ValueError) as error:  # too long, links in a circle, a NUL
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; choose another directory with -o") from None
    if is_file:
        raise InputError(f"{path}: is a file, expected a directory; choose another with -o")
    places = {Path(there.anchor): "the root directory"}
    with contextlib.suppress(RuntimeError, OSError):  # a user without a home
        places[Path.home().resolve()] = "your home directory"
    if there in places:
        raise InputError(f"{path}: is {places[there]}; choose a directory for the results alone with -o")
    if force and path.is_symlink() and results_in(path):
        raise InputError(
            f"{path}: is a link to {there}, and --force removes nothing through a link; give that directory with -o"
        )
    return path.absolute()


def refuse_other_file(path: Path, own: bytes) -> None:
    """Raise InputError if a file to be written exists and granwave did not write it.

    Parameters
    ----------
    own
        Regular expression that matches every file of this kind that granwave writes.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a directory, expected the name of a file; choose another with -o")
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise InputError(f"{path}: the directory {path.absolute().parent} cannot be written to; choose another with -o")
    if os.path.lexists(path) and not re.search(own, head(path)):
        raise InputError(f"{path}: is there, and granwave did not write it; choose another name with -o")


# ---------------------------------------------------------------------- disks


def check_disk(
    directory: Path, needed: float, *, what: str = "the results", spare: float = 0.0, remedy: str = "fewer run.frames"
) -> None:
    """Raise InputError if the disk has too little free space.

    Parameters
    ----------
    needed
        Space that ``what`` needs, bytes; 0 is never refused.
    what
        Name of the files, for the message.
    spare
        Space that must stay free, bytes.
    remedy
        Alternative to another directory, for the message.

    Raises
    ------
    InputError
        The free space is less than both together.
    """
    free = free_space(directory)
    if needed and needed + spare > free:
        message = disk_space_message(what, needed, spare, free)
        raise InputError(f"{directory}: {message}; choose another directory with -o, or {remedy}")


def free_space(directory: Path) -> float:
    """Return the free space on the disk of a directory, bytes; the directory need not exist yet."""
    return shutil.disk_usage(next(path for path in (directory, *directory.parents) if path.exists())).free


def disk_space_message(what: str, needed: float, spare: float, free: float) -> str:
    """Describe the disk space that is needed, must stay free and is free; all in bytes."""
    left = f" and {_gigabytes(spare)} must stay free" if spare else ""
    return f"{what} need about {_gigabytes(needed)}{left}, {_gigabytes(free)} are free there"


def _gigabytes(size: float) -> str:
    return f"{size / 1e9:.3g} GB"
