"""Record of a run by the driver, `run.json`: state, versions, ranks, attempts; and its checkpoints.

A checkpoint is a LAMMPS restart file, with sizes and checksums of all output files at that step. A
resumed run truncates its output files to these sizes and appends, so that nothing is repeated. Of a
packing whose snapshots are written in parts
(`granwave.lammps_inputs.packing.motion.written_in_parts`) each rank writes its own part, a few a
file where there are many, and any number of ranks can read them.
"""

from __future__ import annotations

import dataclasses
import json
import os
import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave import __version__, plugins
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.files import checksum, read_json, replace_text
from granwave.lammps_inputs.ownership import claim, clear, output_names, own_file, read_marker
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.run_directory import (
    CHECKPOINT_FILE,
    DATA_FILE,
    RANK,
    RECORD_FILE,
    SCRIPT_FILE,
    files_of,
    of_each_rank,
)
from granwave.workflows.run.mpi import on_first
from granwave.workflows.run.ranks import shared

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

    from granwave.workflows.run.lammps_engine import Engine

_PACKAGES = (
    "lammps",
    "mpi4py",
    "mpich",
    "numpy",
    "scipy",
    "ase",
    "MDAnalysis",
    "h5py",
    "matplotlib",
)


@cache
def versions() -> dict[str, str]:
    """Return the versions of granwave, Python and the packages used; "not installed" for missing
    ones.
    """
    return versions_of(_PACKAGES, plugin_built_for_lammps=plugins.lammps_release())


# states of a run
# integrated: only the analysis remains
RUNNING = "running"
INTEGRATED = "integrated"
INTERRUPTED = "interrupted"
FAILED = "failed"
REFUSED = "refused"
FINISHED = "finished"


@dataclasses.dataclass
class Record:
    """Record of one run.

    Attributes
    ----------
    state
        State: running, integrated, interrupted, failed (see ``reason``), refused (energy balance)
        or finished.
    n_steps, end_time_s
        Steps and simulated time so far.
    end_reason
        Why it ended: ``end_time``, ``settled`` (end_time = "auto"), ``longest`` (the same, at its
        limit), ...
    wall_time_s
        Wall time of the time integration, over all sessions of a resumed run.
    nodes
        Names of the nodes of the ranks, each once.
    energy_balance_accepted
        Largest error of the energy balance, over the input, with which the run is accepted.
    attempts
        Rejected timesteps with their errors of the energy balance.
    checkpoint
        Step and file sizes at the last checkpoint.
    """

    state: str = RUNNING
    name: str = ""
    timestep_s: float = 0.0
    n_steps: int = 0
    end_time_s: float = 0.0
    end_reason: str | None = None
    reason: str | None = None
    wall_time_s: float = 0.0
    n_ranks: int = 1
    nodes: list[str] = dataclasses.field(default_factory=list)
    versions: dict[str, str] = dataclasses.field(default_factory=dict)
    energy_balance_accepted: float | None = None
    attempts: list[dict[str, float]] = dataclasses.field(default_factory=list)
    checkpoint: dict[str, Any] | None = None

    def write(self, directory: Path) -> None:
        """Replace the record in ``directory`` atomically."""
        replace_text(directory / RECORD_FILE, json.dumps(dataclasses.asdict(self), indent=2) + "\n")


def read(directory: Path) -> Record | None:
    """Read the record in ``directory``; None if missing or damaged."""
    return _record(read_json(directory / RECORD_FILE))


def recover(directory: Path) -> Record | None:
    """Read the record in result.h5, as of the analysis; None if there is none."""
    from granwave.analysis.result.reader import (
        Result,
    )  # h5py takes longer to load than most commands need

    try:
        with Result(directory) as result:
            return _record(result.record)
    except (MissingOutputError, OutputFormatError, KeyError, ValueError):
        return None


def _record(content: dict[str, Any] | None) -> Record | None:
    try:
        return None if content is None else Record(**content)
    except TypeError:  # keys of another version
        return None


_MOST_PARTS = 64  # files of a checkpoint in parts; more ranks share them
# in the name of the file that LAMMPS writes beside the parts, in place of the number of a rank
_BASE = "base"
_FILE = re.compile(re.escape(CHECKPOINT_FILE).replace(r"\{\}", rf"\d+(\.({RANK}|{_BASE}))?"))


def write_checkpoint(
    engine: Engine,
    comm: Intracomm,
    directory: Path,
    previous: dict[str, Any] | None = None,
    *,
    parts: bool = False,
) -> dict[str, Any]:
    """Write a checkpoint; the previous one remains until `keep_checkpoint` is called with the new
    one.

    Parameters
    ----------
    previous
        Checkpoint before this one, of whose output files only what was added since is read.
    parts
        Each rank writes its own.

    Returns
    -------
    dict
        Name of the restart file, step, and sizes and CRC-32 for `checkpoint_fault` and `cut_back`.
    """
    name = CHECKPOINT_FILE.format(engine.step)
    name = of_each_rank(name) if parts else name
    names = list(dict.fromkeys([name, name.replace(RANK, _BASE)]))

    def prepare() -> None:
        clear(directory, names)  # parts of a session that was killed, perhaps on more ranks
        claim(directory, names)

    def describe(ranks: Processes) -> dict[str, Any]:
        outputs = sorted(name for name in output_names(directory) if (directory / name).is_file())
        written = [file for name in names for file in files_of(directory, name)]
        sizes, whole = (
            {name: (directory / name).stat().st_size for name in group}
            for group in (outputs, [*written, DATA_FILE, SCRIPT_FILE])
        )
        earlier = previous or {}
        before = earlier.get("sums", {})
        read = {
            name: (size, before[name])
            for name, size in earlier.get("sizes", {}).items()
            if name in before
        }
        tasks = [
            (directory / name, size, read.get(name, (0, 0)))
            for name, size in (sizes | whole).items()
        ]
        sums = dict(zip(sizes | whole, ranks.map(_sum, tasks), strict=True))
        return {
            "file": name,
            "step": engine.step,
            "sizes": sizes,
            "whole": whole,
            "sums": sums,
            "version": __version__,
        }

    on_first(comm, prepare)
    engine.commands(f"write_restart {name}" + f" nfile {min(comm.size, _MOST_PARTS)}" * parts)
    comm.barrier()
    return shared(comm, describe)


def _sum(task: tuple[Path, int, tuple[int, int]]) -> int:
    path, size, after = task
    return checksum(path, size, after=after)


def keep_checkpoint(directory: Path, checkpoint: dict[str, Any] | None) -> None:
    """Remove the restart files of all checkpoints but this one."""
    kept = (checkpoint["file"], checkpoint["file"].replace(RANK, _BASE)) if checkpoint else ()
    clear(
        directory,
        [
            name
            for name in read_marker(directory).files
            if _FILE.fullmatch(name) and name not in kept
        ],
    )


def checkpoint_fault(
    directory: Path, checkpoint: dict[str, Any], processes: Processes = ALONE
) -> str:
    """Describe why a run cannot go on from a checkpoint; empty if it can. ``processes`` read its
    files.

    It is of another minor version, whose restart files may differ, or a file is not what the run
    wrote. Output files may have grown.
    """
    try:
        made = str(checkpoint.get("version", ""))
        if made.split(".")[:2] != __version__.split(".")[:2]:
            found = f"of granwave {made}" if made else "of a version before 0.3"
            return f"{directory}: its checkpoint is {found}, expected one of {__version__}"
        whole = checkpoint["whole"]
        sums = checkpoint.get("sums", {})
        sizes = whole | checkpoint["sizes"]
        for name, size in sizes.items():
            path = directory / name
            if not path.is_file():
                return f"{path}: is missing"
            found = path.stat().st_size
            if found < size or (found != size and name in whole):
                return f"{path}: has {found} bytes, had {size} at the checkpoint"
        tasks = [(directory / name, sizes[name], (0, 0)) for name in sums]
        for (path, *_), now, before in zip(
            tasks, processes.map(_sum, tasks), sums.values(), strict=True
        ):
            if now != before:
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
