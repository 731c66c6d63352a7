"""Checkpoints of a run: a LAMMPS restart file, and sizes and checksums of all output files at that step.

A resumed run truncates its output files to these sizes and appends, so that nothing is repeated.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.files import checksum
from granwave.lammps_inputs.ownership import claim, clear, output_names, own_file, read_marker
from granwave.lammps_inputs.run_directory import CHECKPOINT_FILE, DATA_FILE, RECORD_FILE, SCRIPT_FILE
from granwave.workflows.run.mpi import on_first

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

    from granwave.workflows.run.lammps_engine import Engine

_FILE = re.compile(re.escape(CHECKPOINT_FILE).replace(r"\{\}", r"\d+"))


def write(engine: Engine, comm: Intracomm, directory: Path, previous: dict[str, Any] | None = None) -> dict[str, Any]:
    """Write a checkpoint; the previous one remains until `keep_only` is called with the new one.

    Parameters
    ----------
    previous
        Checkpoint before this one, of whose output files only what was added since is read.

    Returns
    -------
    dict
        Name of the restart file, step, and sizes and CRC-32 for `fault` and `cut_back`.
    """
    name = CHECKPOINT_FILE.format(engine.step)
    on_first(comm, lambda: claim(directory, [name]))
    engine.commands(f"write_restart {name}")
    comm.barrier()
    return on_first(comm, lambda: _record(directory, name, engine.step, previous or {}))


def _record(directory: Path, restart: str, step: int, previous: dict[str, Any]) -> dict[str, Any]:
    outputs = [name for name in output_names(directory) if (directory / name).is_file()]
    sizes = {name: (directory / name).stat().st_size for name in sorted(outputs)}
    whole = {name: (directory / name).stat().st_size for name in (restart, DATA_FILE, SCRIPT_FILE)}
    before = previous.get("sums", {})
    read = {name: (size, before[name]) for name, size in previous.get("sizes", {}).items() if name in before}
    sums = {name: checksum(directory / name, size, after=read.get(name, (0, 0))) for name, size in sizes.items()}
    sums |= {name: checksum(directory / name) for name in whole}
    return {"file": restart, "step": step, "sizes": sizes, "whole": whole, "sums": sums}


def keep_only(directory: Path, checkpoint: dict[str, Any] | None) -> None:
    """Remove the restart files of all checkpoints but this one."""
    marker = read_marker(directory)
    kept = checkpoint["file"] if checkpoint else None
    clear(directory, [name for name in (marker.files if marker else ()) if _FILE.fullmatch(name) and name != kept])


def fault(directory: Path, checkpoint: dict[str, Any]) -> str:
    """Describe why a run cannot go on from a checkpoint: a file that is not what the run wrote; empty if it can.

    Output files may have grown.
    """
    try:
        whole, sums = checkpoint["whole"], checkpoint.get("sums", {})
        for name, size in (whole | checkpoint["sizes"]).items():
            path = directory / name
            if not path.is_file():
                return f"{path}: is missing"
            found = path.stat().st_size
            if found < size or (found != size and name in whole):
                return f"{path}: has {found} bytes, had {size} at the checkpoint"
            if name in sums and checksum(path, size) != sums[name]:
                return f"{path}: is not what the run wrote: its checksum differs"
    except (AttributeError, KeyError, TypeError):
        return f"{directory / RECORD_FILE}: its checkpoint cannot be read"
    return ""


def cut_back(directory: Path, checkpoint: dict[str, Any]) -> None:
    """Truncate the output files to their sizes at the checkpoint."""
    for name in output_names(directory):
        path = own_file(directory, name)
        if path is not None and name in checkpoint["sizes"]:
            os.truncate(path, checkpoint["sizes"][name])
        elif path is not None:
            path.unlink()
