"""Paths for results and files: unsuitable paths, and full disks."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from pathlib import Path

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import head


def output_path(name: str | Path) -> Path:
    """Return the path of a file or directory to be written.

    Raises
    ------
    InputError
        The name is empty, or begins with a "~" that the shell did not replace.
    """
    if not str(name):
        raise InputError(
            'found the empty name "", expected a file or directory (. is the current directory)'
        )
    path = Path(name)
    if path.parts and path.parts[0].startswith("~"):
        raise InputError(
            f"{path}: the shell did not expand {path.parts[0]}; use the full path, or $HOME"
        )
    return path


def results_directory(name: str | Path) -> Path:
    """Return the absolute path of a directory for results.

    Raises
    ------
    InputError
        As in `output_path`; or it is a file, the root or the home directory.
    """
    path = output_path(name)
    try:
        there = path.resolve()
        is_file = there.exists() and not there.is_dir()
        with contextlib.suppress(FileNotFoundError):
            path.lstat()
    except (OSError, RuntimeError, ValueError) as error:  # too long, circular links, a NUL
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; choose another directory with directory=...") from None
    if is_file:
        raise InputError(
            f"{path}: is a file, expected a directory; choose another with directory=..."
        )
    places = {Path(there.anchor): "the root directory"}
    with contextlib.suppress(RuntimeError, OSError):  # a user without a home directory
        places[Path.home().resolve()] = "your home directory"
    if there in places:
        raise InputError(
            f"{path}: is {places[there]}; choose a separate directory for the results with "
            "directory=..."
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
        raise InputError(
            f"{path}: is a directory, expected the name of a file; "
            "choose another with directory=..."
        )
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise InputError(
            f"{path}: the directory {path.absolute().parent} cannot be written to; "
            "choose another with directory=..."
        )
    if os.path.lexists(path) and not re.search(own, head(path)):
        raise InputError(
            f"{path}: exists, and granwave did not write it; choose another name with directory=..."
        )


def check_disk(
    directory: Path,
    needed: float,
    *,
    what: str = "the results",
    spare: float = 0.0,
    remedy: str = "fewer run.frames",
) -> None:
    """Raise InputError if the disk has too little free space.

    Parameters
    ----------
    needed
        Space that ``what`` needs, bytes; 0 is never rejected.
    what
        Name of the files, for the message.
    spare
        Space that must stay free, bytes.
    remedy
        Alternative to another directory, for the message.
    """
    if needed and needed + spare > (free := free_space(directory)):
        message = disk_space_message(what, needed, spare, free)
        raise InputError(
            f"{directory}: {message}; choose another directory with directory=..., or {remedy}"
        )


def free_space(directory: Path) -> float:
    """Return the free space on the disk of a directory, bytes; the directory need not exist yet."""
    return shutil.disk_usage(
        next(path for path in (directory, *directory.parents) if path.exists())
    ).free


def disk_space_message(what: str, needed: float, spare: float, free: float) -> str:
    """Describe the disk space that is needed, must stay free and is free; all in bytes."""
    needed, spare, free = (size / 1e9 for size in (needed, spare, free))
    left = f" and {spare:.3g} GB must stay free" if spare else ""
    return f"{what} require about {needed:.3g} GB{left}, but only {free:.3g} GB are free"


def label_of(case: str, directory: Path) -> str:
    """Return the name of a run in messages: its case, and its directory if that is named otherwise.

    Examples
    --------
    >>> label_of("fcc-small", Path("runs/brass-10"))
    'fcc-small in brass-10'
    """
    name = directory.resolve().name
    return case if name == case else f"{case} in {name}"
