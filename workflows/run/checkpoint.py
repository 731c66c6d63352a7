"""Writing of checkpoints.

A checkpoint is a LAMMPS restart file, with sizes and checksums of all output files at that step. A
resumed run truncates its output files to these sizes and appends, so that nothing is repeated. If
snapshots are written in parts (`granwave.lammps_inputs.packing.motion.written_in_parts`), each rank
writes its own part of a checkpoint. More than `MOST_PARTS` ranks share files. Any number of ranks
can read the parts. Checkpoints have more parts than dumps, because the run waits for them every
minute.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from granwave import __version__
from granwave.lammps_inputs.processes import Processes
from granwave.lammps_inputs.run_directory import (
    CHECKPOINT_FILE,
    DATA_FILE,
    MOST_PARTS,
    SCRIPT_FILE,
    files_of,
    of_each_rank,
)
from granwave.workflows.run.directory import RunDirectory, checkpoint_files, sum_of_part
from granwave.workflows.run.mpi import on_first
from granwave.workflows.run.ranks import shared

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

    from granwave.workflows.run.lammps_engine import Engine


def write_checkpoint(
    engine: Engine,
    comm: Intracomm,
    results: RunDirectory,
    previous: dict[str, Any] | None = None,
    *,
    parts: bool = False,
) -> dict[str, Any]:
    """Write a checkpoint; the previous one remains until `RunDirectory.keep_checkpoint` is called
    with the new one.

    Parameters
    ----------
    previous
        Checkpoint before this one; only the additions to its output files since are read.
    parts
        Each rank writes its own.

    Returns
    -------
    dict
        Name of the restart file, step, and sizes and CRC-32 for `RunDirectory.checkpoint_fault` and
        `RunDirectory.cut_back`.
    """
    name = CHECKPOINT_FILE.format(engine.step)
    if parts:
        name = of_each_rank(name)
    names = checkpoint_files(name)

    def prepare() -> None:
        results.clear(names)  # parts of a session that was killed, perhaps on more ranks
        results.claim(names)

    def describe(ranks: Processes) -> dict[str, Any]:
        outputs = sorted(name for name in results.output_names() if (results / name).is_file())
        written: list[str] = []
        for part in names:
            written += files_of(results.path, part)
        sizes = {name: (results / name).stat().st_size for name in outputs}
        fixed = [*written, DATA_FILE, SCRIPT_FILE]
        whole = {name: (results / name).stat().st_size for name in fixed}
        read = _read_before(previous or {})
        tasks = [
            (results / name, size, read.get(name, (0, 0))) for name, size in (sizes | whole).items()
        ]
        sums = dict(zip(sizes | whole, ranks.map(sum_of_part, tasks), strict=True))
        return {
            "file": name,
            "step": engine.step,
            "sizes": sizes,
            "whole": whole,
            "sums": sums,
            "version": __version__,
        }

    on_first(comm, prepare)
    command = f"write_restart {name}"
    if parts:
        command = f"{command} nfile {min(comm.size, MOST_PARTS)}"
    engine.commands(command)
    comm.barrier()
    return shared(comm, describe)


def _read_before(previous: dict[str, Any]) -> dict[str, tuple[int, int]]:
    """Return sizes and CRC-32 of the output files at an earlier checkpoint, by name."""
    sums = previous.get("sums", {})
    sizes = previous.get("sizes", {})
    return {name: (size, sums[name]) for name, size in sizes.items() if name in sums}
