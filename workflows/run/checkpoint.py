"""Checkpoints of a run: a LAMMPS restart file, and the sizes of all output files at that step.

A resumed run truncates its output files to these sizes and appends, so that nothing is repeated.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.ownership import claim, clear, output_names, own_file, read_marker
from granwave.lammps_inputs.run_directory import CHECKPOINT_FILE, DATA_FILE, SCRIPT_FILE
from granwave.workflows.run.mpi import on_first

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

    from granwave.workflows.run.lammps_engine import Engine

_FILE = re.compile(re.escape(CHECKPOINT_FILE).replace(r"\{\}", r"\d+"))


def write(engine: Engine, comm: Intracomm, directory: Path) -> dict[str, Any]:
    """Write a checkpoint; the previous one remains until `keep_only` is called with the new one.

    Returns
    -------
    dict
        Name of the restart file, step, and sizes for `usable` and `cut_back`.
    """
    name = CHECKPOINT_FILE.format(engine.step)
    on_first(comm, lambda: claim(directory, [name]))
    engine.commands(f"write_restart {name}")
    comm.barrier()
    outputs = [name for name in output_names(directory) if (directory / name).is_file()]
    sizes = {name: (directory / name).stat().st_size for name in sorted(outputs)}
    whole = {file: (directory / file).stat().st_size for file in (name, DATA_FILE, SCRIPT_FILE)}
    return {"file": name, "step": engine.step, "sizes": sizes, "whole": whole}


def keep_only(directory: Path, checkpoint: dict[str, Any] | None) -> None:
    """Remove the restart files of all checkpoints but this one."""
    marker = read_marker(directory)
    kept = checkpoint["file"] if checkpoint else None
    clear(directory, [name for name in (marker.files if marker else ()) if _FILE.fullmatch(name) and name != kept])


def usable(directory: Path, checkpoint: dict[str, Any] | None) -> bool:
    """Return True if all files of the checkpoint exist with the same sizes; output files may have grown.

    Return False for a damaged record.
    """
    if checkpoint is None:
        return False
    try:
        for name, size in checkpoint["whole"].items():
            if not (directory / name).is_file() or (directory / name).stat().st_size != size:
                return False
        paths = {directory / name: size for name, size in checkpoint["sizes"].items()}
        return all(path.is_file() and path.stat().st_size >= size for path, size in paths.items())
    except (AttributeError, KeyError, TypeError):
        return False


def cut_back(directory: Path, checkpoint: dict[str, Any]) -> None:
    """Truncate the output files to their sizes at the checkpoint."""
    for name in output_names(directory):
        path = own_file(directory, name)
        if path is not None and name in checkpoint["sizes"]:
            os.truncate(path, checkpoint["sizes"][name])
        elif path is not None:
            path.unlink()
