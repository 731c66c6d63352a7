"""Errors that end a run, with advice on how to continue it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.directories import free_space
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import DISK_IS_FULL


def with_advice(
    error: RunError | OSError, directory: Path, saved: Mapping[str, Any] | None, reserve: float
) -> RunError:
    """Return an error of the integration with advice that fits the state of the directory.

    Parameters
    ----------
    saved
        Record of the last checkpoint; None without a checkpoint.
    reserve
        Disk space to be kept free, bytes.
    """
    where = "from the beginning, since there is no checkpoint"
    if saved:
        where = f"from the checkpoint at step {saved['step']}"
    resume = f"then run the same command with resume=True to continue {where}"
    if isinstance(error, OSError):
        return RunError(
            f"{_cause(error, directory)}; results so far are kept; {_cure(error)}, {resume}"
        )
    if free_space(directory) < reserve:
        return type(error)(
            f"{directory}: the disk is full: {error}; results so far are kept; free disk space, "
            f"{resume}"
        )
    return error


def unfinished_analysis(error: OSError, directory: Path) -> RunError:
    """Return the error for an analysis that the file system ended, with advice."""
    return RunError(
        f"{_cause(error, directory)}; the output of LAMMPS is kept; {_cure(error)}, then run the "
        "same command with resume=True to analyse it"
    )


def describe_removal(places: Iterable[Path]) -> str:
    """Describe that one of the paths of a run was removed or moved meanwhile; empty if not."""
    missing = next((path for path in places if not path.exists()), None)
    if missing is None:
        return ""
    return (
        f"{missing}: was removed or moved during the run, which cannot be resumed; do not "
        "change the directory, and run the case again with force=True"
    )


def _cause(error: OSError, directory: Path) -> str:
    return f"{error.filename or directory}: {error.strerror or error}"


def _cure(error: OSError) -> str:
    return "free disk space" if error.errno in DISK_IS_FULL else "fix this"
