"""MPI ranks: communicator, work on the first rank, launch of ranks, and abort on errors.

mpi4py is imported only where a communicator is needed.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import logging
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from types import ModuleType, TracebackType
from typing import IO, TYPE_CHECKING, Any, NoReturn, TypeVar

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.streams import flush
from granwave.workflows.run import mpi_library
from granwave.workflows.run.launchers import (
    OTHERS_FIRST,
    STARTED_FILE,
    of_this_machine,
    starting,
    wait_for_end,
)
from granwave.workflows.run.leftovers import clear, note_segments, scratch_directory

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm


T = TypeVar("T")
logger = logging.getLogger(__name__)

# set by the launchers of MPICH, Slurm (PMI, PMIx) and Open MPI
_RANK_VARIABLES = ("PMI_RANK", "PMIX_RANK", "OMPI_COMM_WORLD_RANK")
_ALLOWED = (
    "OMPI_ALLOW_"  # permissions that the user gives Open MPI, such as to run as root in a container
)
_LAUNCHER_PREFIXES = ("PMI_", "PMIX_", "HYDRA_", "HYDI_", "OMPI_", "MPI_LOCAL", "MPIR_")
# s of waiting at full speed, and then between looks
_IMPATIENT = 0.1
_PAUSE = 0.01
_LOOK = 0.5  # s between checks for a stop file
_LAST_OUTPUT = 1.0  # s to wait for the output of ranks that were killed
_MOST_RANKS = 8  # largest number of ranks per core that are started here
_C_LIBRARY = ctypes.CDLL(None) if sys.platform == "linux" else None
_SET_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of <sys/prctl.h>
_FIRST_IS_READY = 1  # tag of a message
PYTHON = (sys.executable, "-P")  # takes no modules from the working directory
# environment variable with the same effect on all Python processes started below
SAFE_PATH = "PYTHONSAFEPATH"
# environment variable: file whose existence asks all ranks to stop
STOP_FILE = "GRANWAVE_STOP_FILE"
# environment variable: number of ranks requested from the launcher
EXPECTED_RANKS = "GRANWAVE_RANKS"
# environment variable: file for the message of an abort
LAST_WORDS_FILE = "GRANWAVE_LAST_WORDS_FILE"
_KEPT_OUTPUT = 65536  # bytes of the last output of ranks
_TOLD_BY = 60  # bytes that identify a message in the output


def launched() -> bool:
    """Return True if this process was started by an MPI launcher."""
    return any(name in os.environ for name in _RANK_VARIABLES)


def is_first() -> bool:
    """Return True on the first rank, or without a launcher; from the environment, without the MPI
    library.
    """
    return all(os.environ.get(name, "0") == "0" for name in _RANK_VARIABLES)


def alone() -> dict[str, str]:
    """Return the environment without the variables of MPI launchers, for processes that are not
    ranks.
    """
    return {
        name: value
        for name, value in os.environ.items()
        if name.startswith(_ALLOWED) or not name.startswith(_LAUNCHER_PREFIXES)
    }


def world() -> Intracomm:
    """Return the communicator of all ranks; an uncaught error on one of them aborts all.

    Raises
    ------
    RunError
        The ranks of the launcher are not connected, so that each would run alone.
    """
    clear()
    library = _started(first=is_first())
    note_segments()

    if STARTED_FILE in os.environ:
        with contextlib.suppress(OSError):
            Path(os.environ[STARTED_FILE]).touch()
    comm = library.COMM_WORLD
    expected = int(os.environ.get(EXPECTED_RANKS, comm.size))
    if comm.size != expected:
        raise RunError(
            f"found {comm.size} rank(s), expected {expected}: the launcher and the MPI library do "
            "not match; with Slurm try another --mpi of srun (srun --mpi=list), pmi2 for MPICH"
        )
    if comm.size > 1:

        def abort_all(
            kind: type[BaseException], error: BaseException, trace: TracebackType | None
        ) -> None:
            sys.__excepthook__(kind, error, trace)
            flush()
            _note_last_words("".join(traceback.format_exception(kind, error, trace)))
            comm.Abort(1)

        sys.excepthook = abort_all
        end_with_parent()
    return comm


def this_process() -> Intracomm:
    """Return the communicator of this process only."""
    return _started().COMM_SELF


def _started(*, first: bool = True) -> ModuleType:
    """Import mpi4py and start MPI, after a check of its library.

    Raises
    ------
    RunError
        LAMMPS cannot be loaded with the MPI library that mpi4py finds.
    """
    is_imported = "mpi4py.MPI" in sys.modules  # by `forks.load`, for copies of this process
    check_library(first=first)
    with starting(first=first):
        from mpi4py import MPI

        if not MPI.Is_initialized():
            if is_imported:
                MPI.Init()
            else:
                MPI.Init_thread()
            atexit.register(_finalise)
    return MPI


def check_library(*, first: bool = True) -> None:
    """Check that LAMMPS can be loaded with the MPI library of this process, before MPI starts.

    Parameters
    ----------
    first
        False on ranks that leave the error message to the first rank.

    Raises
    ------
    RunError
        It cannot.
    """
    if mpi_library.is_in_environment():
        return
    fault = mpi_library.library_fault()
    if not fault:
        return
    if not first:
        time.sleep(OTHERS_FIRST)
    remedy = mpi_library.installation_of_mpich()
    raise RunError(f"MPI cannot be started: {fault}; install MPICH: {remedy}")


def _finalise() -> None:
    """End MPI, if it was started."""
    library = sys.modules.get("mpi4py.MPI")
    if library is not None and library.Is_initialized() and not library.Is_finalized():
        library.Finalize()


def nodes(comm: Intracomm) -> list[str]:
    """Return the names of the nodes of all ranks, each once; collective."""
    mine = os.environ.get("SLURMD_NODENAME") or os.uname().nodename
    return sorted(set(comm.allgather(mine)))


def leave(status: int) -> NoReturn:
    """Finalise MPI and end this rank with an exit status; collective.

    Python ends as usual: MPICH's launcher sometimes treats ranks that leave by ``os._exit`` as
    killed.
    """
    _finalise()
    sys.exit(status)


def abort(comm: Intracomm, message: str, status: int = 1) -> NoReturn:
    """Abort all ranks with an exit status; the message is logged, with the options of the command
    line.
    """
    logger.error("granwave: %s", message)
    _note_last_words(f"granwave: {message}\n")
    comm.Abort(status)
    raise SystemExit(status)


def _note_last_words(text: str) -> None:
    """Write the message of an abort where `launch` finds it; launchers may end before they have
    passed on the last output of the ranks.
    """
    if LAST_WORDS_FILE in os.environ:
        with contextlib.suppress(OSError):
            Path(os.environ[LAST_WORDS_FILE]).write_text(text)


def on_first(comm: Intracomm, work: Callable[[], T]) -> T:
    """Do ``work`` on the first rank; return its result, or raise its error, on all ranks."""
    outcome: tuple[T | None, BaseException | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (work(), None)
        except (Exception, KeyboardInterrupt) as error:
            outcome = (None, error)
        for rank in range(1, comm.size):
            comm.send(None, rank, _FIRST_IS_READY)
    else:  # the first rank may need this processor for its work
        wait_for(comm, 0, _FIRST_IS_READY)
        comm.recv(source=0, tag=_FIRST_IS_READY)
    result, fault = comm.bcast(outcome) if comm.size > 1 else outcome
    if fault is not None:
        raise fault
    return result  # type: ignore[return-value]


def wait_for(comm: Intracomm, rank: int, tag: int = 0) -> None:
    """Wait for a message, after a short time without use of the processor."""
    begin = time.monotonic()
    while not comm.Iprobe(rank, tag):
        if time.monotonic() > begin + _IMPATIENT:
            time.sleep(_PAUSE)


def find_mpiexec() -> str | None:
    """Return the path of mpiexec: in the environment, or otherwise, for a site's MPI, in PATH; None
    if there is none.
    """
    own = Path(sys.prefix) / "bin" / "mpiexec"
    return str(own) if own.exists() else shutil.which("mpiexec")


def command(n_ranks: int, arguments: Sequence[str], launcher: Sequence[str] = ()) -> list[str]:
    """Return the command that runs ``granwave ARGUMENTS`` on several ranks.

    Parameters
    ----------
    launcher
        Command such as ``srun --mpi=pmi2``; by default the command that `find_mpiexec` finds.

    Raises
    ------
    InputError
        There is no mpiexec.
    """
    if not launcher:
        mpiexec = find_mpiexec()
        if mpiexec is None:
            raise InputError(
                f"--np {n_ranks}: no mpiexec in {Path(sys.prefix) / 'bin'} or in PATH; install "
                f"MPICH: {mpi_library.installation_of_mpich()}; or load the site's MPI"
            )
        launcher = [mpiexec]
    return [
        *launcher,
        "-n",
        str(n_ranks),
        *PYTHON,
        "-m",
        "mpi4py",
        "-m",
        "granwave.workflows",
        *arguments,
    ]


def start(
    words: Sequence[str],
    n_ranks: int,
    stop: Path,
    stdout: int,
    stderr: int,
    *,
    launcher: Sequence[str] = (),
    **variables: str,
) -> subprocess.Popen[bytes]:
    """Start a `command` in a separate session; its ranks stop when the file ``stop`` exists, or
    this process ends.

    Parameters
    ----------
    launcher
        As in `command`; by default the ranks are forked on this machine.
    variables
        Further environment variables of the ranks.
    """
    environment = dict(os.environ) if launcher else of_this_machine(os.environ)
    environment |= {STOP_FILE: str(stop), EXPECTED_RANKS: str(n_ranks), **variables}
    return subprocess.Popen(
        words,
        env=environment,
        stdout=stdout,
        stderr=stderr,
        start_new_session=True,
        preexec_fn=end_with_parent,
    )


def launch(
    n_ranks: int,
    arguments: Sequence[str],
    launcher: Sequence[str] = (),
    *,
    stdout: int | None = None,
    stderr: int | None = None,
    remedy: str = "continue with resume=True",
) -> int:
    """Run ``granwave ARGUMENTS`` on several ranks of this machine; Ctrl-C makes them stop with a
    checkpoint.

    Parameters
    ----------
    launcher
        As in `command`.
    stdout, stderr
        File descriptors that the ranks write to; by default the descriptors of this process.
    remedy
        Advice for ranks that were killed.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        There is no mpiexec.
    RunError
        LAMMPS cannot be loaded with the MPI library of this process.
    """
    words = command(n_ranks, arguments, launcher)
    check_library()

    errors = bytearray()  # standard error of the ranks

    def pass_on(stream: IO[bytes], number: int, kept: bytearray | None) -> None:
        """Copy the output of a file descriptor of this process, as long as it is read."""
        with stream:
            while found := os.read(stream.fileno(), 65536):
                if kept is not None:
                    kept += found
                    del kept[:-_KEPT_OUTPUT]
                _write(number, found)

    with scratch_directory() as scratch:
        stop = scratch / "stop"
        started = scratch / "started"
        last_words = scratch / "last-words"
        # its output passes through this process: mpiexec ends the ranks if nobody reads it
        out = subprocess.PIPE if stdout is None else stdout
        variables: dict[str, Any] = {STARTED_FILE: str(started), LAST_WORDS_FILE: str(last_words)}
        ranks = start(words, n_ranks, stop, out, subprocess.PIPE, launcher=launcher, **variables)
        error_number = 2 if stderr is None else stderr
        copies = [(ranks.stdout, 1, None), (ranks.stderr, error_number, errors)]
        readers = [
            threading.Thread(target=pass_on, args=copy, daemon=True)
            for copy in copies
            if copy[0] is not None
        ]
        with Interrupts(stop.touch) as requests:
            for reader in readers:
                reader.start()
            status = wait_for_end(ranks, lambda: requests.count, started)
            for reader in readers:
                reader.join(None if status is not None else _LAST_OUTPUT)
        if last_words.is_file():
            text = last_words.read_bytes()
            if text[:_TOLD_BY] not in errors:
                _write(error_number, text)
    if status is None:
        print(f"granwave: stopped; the launcher {words[0]} was ended", file=sys.stderr)
        return 130
    if status not in (0, 1, 2, 130, 141):
        print(f"granwave: the ranks were killed (status {status}); {remedy}", file=sys.stderr)
        return 1
    return status


def _write(number: int, text: bytes) -> None:
    """Write to a file descriptor, as long as it is read."""
    with contextlib.suppress(OSError):
        while text:
            text = text[os.write(number, text) :]


def launch_unseen(
    n_ranks: int, arguments: Sequence[str], launcher: Sequence[str] = ()
) -> tuple[int, list[str]]:
    """Run ranks as `launch` does, without their output; return exit status and lines of standard
    error.
    """
    with tempfile.TemporaryFile() as said:
        status = launch(
            n_ranks, arguments, launcher, stdout=subprocess.DEVNULL, stderr=said.fileno()
        )
        said.seek(0)
        return status, said.read().decode("utf-8", "replace").strip().splitlines()


def errors_in(lines: Iterable[str]) -> list[str]:
    """Return the errors among the lines that granwave has printed, without its name."""
    ours = [line.removeprefix("granwave: ") for line in lines if line.startswith("granwave: ")]
    return [line for line in ours if not line.startswith("warning: ")]


def check_cores(n_ranks: int) -> None:
    """Warn of more ranks than cores, which wait for each other; reject many more.

    Raises
    ------
    InputError
        There would be more than `_MOST_RANKS` ranks a core.
    """
    cores = len(os.sched_getaffinity(0))
    found = f"{n_ranks} ranks on {cores} core{'s' if cores > 1 else ''}"
    if n_ranks > _MOST_RANKS * cores:
        raise InputError(
            f"--np {n_ranks}: found {found}, expected one rank per core and at most "
            f"{_MOST_RANKS}; use --np {cores}, or start them nevertheless with mpiexec -n "
            f"{n_ranks} granwave run ..."
        )
    if n_ranks > cores:
        logger.warning(
            "%s: ranks that share a core wait for each other; --np %d is faster", found, cores
        )


def end_with_parent(number: int = signal.SIGKILL) -> None:
    """Let the system send this process a signal when its parent ends, also if the parent was
    killed; on Linux only.
    """
    if _C_LIBRARY is not None:
        _C_LIBRARY.prctl(_SET_PARENT_DEATH_SIGNAL, number)


class StopRequest(Interrupts):
    """Requests to stop by Ctrl-C, SIGTERM or stop file, the same on all ranks."""

    def __init__(self, comm: Intracomm) -> None:
        super().__init__()
        self._comm = comm
        self._file = os.environ.get(STOP_FILE)

    def _in_file(self) -> bool:
        return bool(self._file and os.path.exists(self._file))

    def noticed(self) -> bool:
        """Return True if a stop was requested on this rank."""
        return self.count > 0 or self._in_file()

    @contextlib.contextmanager
    def answered_at_once(self, answer: Callable[[], object]) -> Iterator[None]:
        """Call ``answer`` in a thread after a request, also while LAMMPS executes a command."""
        reading, writing = os.pipe()
        os.set_blocking(writing, False)

        def watch() -> None:
            asked = False
            while True:
                ready = bool(select.select([reading], [], [], _LOOK)[0])
                if ready and not os.read(reading, 64):
                    return  # at the end of the block
                asked = asked or ready or self._in_file()
                if asked:
                    answer()

        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        before = None
        try:
            with contextlib.suppress(ValueError):  # only the main thread can handle signals
                before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
            yield
        finally:
            if before is not None:
                signal.set_wakeup_fd(before)
            os.close(writing)
            watcher.join()
            os.close(reading)

    def wanted(self) -> bool:
        """Return True if a stop was requested on any rank; collective."""
        mine = self.noticed()
        return mine if self._comm.size == 1 else bool(self._comm.allreduce(int(mine)))
