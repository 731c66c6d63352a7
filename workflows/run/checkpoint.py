"""Checkpoints of a run: a LAMMPS restart file, and how long every output file was at that moment.

A resumed run cuts its output files back to those lengths and appends, so that nothing is there twice.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.deck.deck import DATA_FILE, SCRIPT_FILE

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

    from granwave.workflows.run.lammps_engine import Engine

_PREFIX, _SUFFIX = "checkpoint-", ".restart"


def write(engine: Engine, comm: Intracomm, directory: Path) -> dict[str, Any]:
    """Write a checkpoint; the one before stays until `keep_only` is told that this one is on record.

    Returns
    -------
    dict
        What `cut_back` needs, and the file to go on from.
    """
    name = f"{_PREFIX}{engine.step}{_SUFFIX}"
    engine.commands(f"write_restart {name}")
    comm.barrier()
    sizes = {str(path.relative_to(directory)): path.stat().st_size for path in sorted((directory / "dumps").iterdir())}
    whole = {file: (directory / file).stat().st_size for file in (name, DATA_FILE, SCRIPT_FILE)}
    return {"file": name, "step": engine.step, "sizes": sizes, "whole": whole}


def keep_only(directory: Path, checkpoint: dict[str, Any] | None) -> None:
    """Remove the restart files of all checkpoints but this one."""
    for path in directory.glob(f"{_PREFIX}*{_SUFFIX}"):
        if checkpoint is None or path.name != checkpoint["file"]:
            path.unlink(missing_ok=True)


def usable(directory: Path, checkpoint: dict[str, Any] | None) -> bool:
    """The checkpoint's files are all there: what grows no shorter than it was, the rest as it was."""
    if checkpoint is None:
        return False
    for name, size in checkpoint["whole"].items():
        if not (directory / name).is_file() or (directory / name).stat().st_size != size:
            return False
    paths = {directory / name: size for name, size in checkpoint["sizes"].items()}
    return all(path.is_file() and path.stat().st_size >= size for path, size in paths.items())


def cut_back(directory: Path, checkpoint: dict[str, Any]) -> None:
    """Bring the output files back to what they were at the checkpoint."""
    for path in (directory / "dumps").iterdir():
        size = checkpoint["sizes"].get(str(path.relative_to(directory)))
        if size is None:
            path.unlink()
        else:
            os.truncate(path, size)
