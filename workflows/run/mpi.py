"""MPI ranks: who am I, do something on the first rank for all, start more ranks, and never hang on an error.

Without MPI in sight (one process, not started by a launcher) nothing here imports mpi4py.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, NoReturn, TypeVar

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.run.interrupts import Interrupts

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

T = TypeVar("T")

# set by the launchers of MPICH, Slurm (PMI, PMIx) and Open MPI
_RANK_VARIABLES = ("PMI_RANK", "PMIX_RANK", "OMPI_COMM_WORLD_RANK")
_LAUNCHER_PREFIXES = ("PMI_", "PMIX_", "HYDRA_", "HYDI_", "OMPI_", "MPI_LOCAL", "MPIR_")
STOP_FILE = "GRANWAVE_STOP_FILE"  # variable: a file whose presence asks all ranks to stop
EXPECTED_RANKS = "GRANWAVE_RANKS"  # variable: how many ranks the launcher was asked for


def launched() -> bool:
    """This process was started by an MPI launcher."""
    return any(name in os.environ for name in _RANK_VARIABLES)


def is_first() -> bool:
    """This process is the first rank of its launcher, or was started by none; asks no MPI library."""
    return all(os.environ.get(name, "0") == "0" for name in _RANK_VARIABLES)


def alone() -> dict[str, str]:
    """The environment without what a launcher left in it: for a process that is no rank of this one's."""
    return {name: value for name, value in os.environ.items() if not name.startswith(_LAUNCHER_PREFIXES)}


def world() -> Intracomm:
    """The communicator of all ranks; an uncaught error on one of them aborts all.

    Raises
    ------
    RunError
        The launcher's ranks do not know of each other: each would run by itself.
    """
    from mpi4py import MPI

    comm = MPI.COMM_WORLD
    expected = int(os.environ.get(EXPECTED_RANKS, comm.size))
    if comm.size != expected:
        raise RunError(
            f"found {comm.size} rank(s), expected {expected}: the launcher and the MPI library do not fit each other; "
            "with Slurm try another --mpi of srun (srun --mpi=list), pmi2 for MPICH"
        )
    if comm.size > 1:
        sys.excepthook = _abort_all
    return comm


def nodes(comm: Intracomm) -> list[str]:
    """Names of the machines that the ranks run on, each once; a collective call."""
    mine = os.environ.get("SLURMD_NODENAME") or os.uname().nodename
    return sorted(set(comm.allgather(mine)))


def _abort_all(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    sys.__excepthook__(kind, error, trace)
    sys.stderr.flush()
    from mpi4py import MPI

    MPI.COMM_WORLD.Abort(1)


def leave(status: int) -> NoReturn:
    """End this rank with an exit status, in step with the others."""
    from mpi4py import MPI

    MPI.Finalize()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def abort(comm: Intracomm, message: str) -> NoReturn:
    """End all ranks, wherever they are, with exit status 1."""
    print(f"granwave: {message}", file=sys.stderr, flush=True)
    comm.Abort(1)
    raise SystemExit(1)


def on_first(comm: Intracomm, work: Callable[[], T]) -> T:
    """Do ``work`` on the first rank and give its result, or its error, to all."""
    outcome: tuple[T | None, Exception | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (work(), None)
        except Exception as error:
            outcome = (None, error)
    if comm.size > 1:
        outcome = comm.bcast(outcome)
    result, fault = outcome
    if fault is not None:
        raise fault
    return result  # type: ignore[return-value]


def command(n_ranks: int, arguments: Sequence[str], launcher: Sequence[str] = ()) -> list[str]:
    """Return the command that runs ``granwave ARGUMENTS`` on several ranks.

    Parameters
    ----------
    launcher
        Such as ``srun --mpi=pmi2``; by default the environment's mpiexec.

    Raises
    ------
    InputError
        There is no mpiexec.
    """
    if not launcher:
        mpiexec = Path(sys.prefix) / "bin" / "mpiexec"
        if not mpiexec.exists():
            raise InputError(
                f"--np {n_ranks}: no mpiexec in {mpiexec.parent}; install granwave into a virtual environment, "
                "or start the ranks yourself: mpiexec -n N granwave run ..."
            )
        launcher = [str(mpiexec)]
    return [*launcher, "-n", str(n_ranks), sys.executable, "-m", "mpi4py", "-m", "granwave.workflows", *arguments]


def launch(n_ranks: int, arguments: Sequence[str]) -> int:
    """Run ``granwave ARGUMENTS`` on several ranks of this machine; Ctrl-C asks them to stop cleanly.

    Returns
    -------
    int
        The exit status.

    Raises
    ------
    InputError
        There is no mpiexec.
    """
    words = command(n_ranks, arguments)
    with tempfile.TemporaryDirectory(prefix="granwave-") as scratch:
        stop = Path(scratch) / "stop"
        environment = {**os.environ, STOP_FILE: str(stop), EXPECTED_RANKS: str(n_ranks)}
        ranks = subprocess.Popen(words, env=environment, start_new_session=True)
        with Interrupts(stop.touch):
            status = ranks.wait()
    if status not in (0, 1, 2, 130):
        print(f"granwave: the ranks were killed (status {status}); go on with --resume", file=sys.stderr)
        return 1
    return status


class StopRequest(Interrupts):
    """Ctrl-C and SIGTERM as a question that is asked between pieces of work, the same answer on all ranks."""

    def __init__(self, comm: Intracomm) -> None:
        super().__init__()
        self._comm = comm
        self._file = os.environ.get(STOP_FILE)

    def wanted(self) -> bool:
        """Somebody asked to stop; a collective call."""
        mine = self.count > 0 or bool(self._file and os.path.exists(self._file))
        return mine if self._comm.size == 1 else bool(self._comm.allreduce(int(mine)))
