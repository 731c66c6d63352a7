"""Start of MPI: launchers that fork their ranks on this machine and end on request; and an
explanation if the MPI library ends the process instead of raising an error.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

logger = logging.getLogger(__name__)

# environment variable: file that the first rank makes when MPI has started
STARTED_FILE = "GRANWAVE_STARTED_FILE"
# settings of MPICH's launcher; inside a job it would start the ranks by the commands of the cluster
_FORKED = {"HYDRA_LAUNCHER": "fork", "HYDRA_BOOTSTRAP": "fork", "HYDRA_RMK": "user"}
# MPICH: a rank that waits offers its core to other processes after each poll. By default it does so
# after a thousand polls, and two ranks next to two busy processes took 65 s for a run of 3 s
_YIELDING = {"MPIR_CVAR_POLLS_BEFORE_YIELD": "1"}
_NOT_STARTED = "MPI cannot be started: "
_OF_JOBS = "SLURM_"  # prefix of the variables by which launchers recognise a job of Slurm
_LOOK = 0.2  # s between checks of a launcher
_PATIENCE = 5.0  # s that a launcher without ranks has to end after a request
_SLOW = 30.0  # s without ranks until a warning
OTHERS_FIRST = 1.0  # s that ranks leave the first one to print the same error
_LEAST_FILE_SIZE = 64 * 2**20  # bytes; shared memory of a rank
# prefixes of variables by which users and sites change how MPI works
_OF_LIBRARY = ("UCX_", "FI_", "MPICH_", "MPIR_CVAR_", "OMPI_MCA_", "PRTE_MCA_")
_SETTINGS = (*_OF_LIBRARY, "HYDRA_", _OF_JOBS)


def of_this_machine(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment in which a launcher forks its ranks on this machine, also within a job
    of Slurm or another batch system, and in which ranks that wait offer their cores to others.
    """
    kept = {name: value for name, value in environment.items() if not name.startswith(_OF_JOBS)}
    return _YIELDING | kept | _FORKED


def _chosen(environment: Mapping[str, str], prefixes: tuple[str, ...]) -> list[str]:
    """Return the settings of MPI that a user or site chose."""
    names = [name for name in environment if name.startswith(prefixes)]
    return sorted(name for name in names if _YIELDING.get(name) != environment[name])


def wait_for_end(
    launcher: subprocess.Popen[bytes], requests: Callable[[], int], started: Path
) -> int | None:
    """Wait until a launcher ends; return its exit status, None if it was killed.

    Before its ranks have started, a launcher is killed some seconds after a request to stop;
    afterwards it is killed at the second request.

    Parameters
    ----------
    requests
        Function that returns the number of requests to stop so far.
    started
        File that exists when the ranks have started.
    """
    begin = time.monotonic()
    asked: float | None = None
    warned = False
    while True:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return launcher.wait(_LOOK)
        now = time.monotonic()
        count = requests()
        if count and asked is None:
            asked = now
        waiting = not started.exists()
        if count > 1 or (asked is not None and waiting and now > asked + _PATIENCE):
            kill_session(launcher)
            return None
        if waiting and not warned and now > begin + _SLOW:
            warned = True
            logger.warning(
                "the launcher %s has not started a rank after %.0f s; press Ctrl-C to stop it%s",
                launcher.args[0] if isinstance(launcher.args, list) else launcher.args,
                _SLOW,
                environment_settings(),
            )


def kill_session(process: subprocess.Popen[bytes]) -> None:
    """Kill a process that leads a session, and its children."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()


def environment_settings() -> str:
    """Return the names of set variables that change the start of MPI, for the end of a message."""
    names = _chosen(os.environ, _SETTINGS)
    return f"; settings of MPI: {', '.join(names)}" if names else ""


# ---------------------------------------------------------------------- the library


@contextlib.contextmanager
def starting(*, first: bool = True) -> Iterator[None]:
    """Explain why MPI could not be started if its library ends this process within a ``with``
    block.

    Parameters
    ----------
    first
        False on ranks that leave the error message to the first rank.
    """
    library = ctypes.CDLL(None)
    if not hasattr(library, "__cxa_atexit"):
        yield
        return
    at_work = True

    def explain(_: object) -> None:
        if not at_work:
            return
        if not first:
            time.sleep(OTHERS_FIRST)
        if sys.stderr is not None:
            print(f"granwave: {start_fault(os.environ)}", file=sys.stderr, flush=True)
        os._exit(1)

    called = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(explain)
    owner = ctypes.create_string_buffer(1)
    library.__cxa_atexit(called, None, owner)
    try:
        yield
    finally:
        at_work = False
        library.__cxa_finalize(owner)  # Python may be gone at the end of the process


def start_fault(environment: Mapping[str, str]) -> str:
    """Describe why MPI could not be started; without a known reason, refer to its own messages."""
    return (
        known_fault(environment)
        or f"{_NOT_STARTED}see the lines above; granwave doctor checks the installation"
    )


def known_fault(environment: Mapping[str, str]) -> str:
    """Describe why MPI could not be started, from variables and limits that are known to stop it;
    empty without one of these.
    """
    what = _NOT_STARTED
    if "PMIX_RANK" in environment and "PMI_RANK" not in environment:
        return (
            f"{what}PMIX_RANK={environment['PMIX_RANK']} is set, as by srun --mpi=pmix, which "
            "this MPI library does not support; use srun --mpi=pmi2, or unset it: env -u "
            "PMIX_RANK granwave ..."
        )
    if "PMI_FD" in environment and not _is_open(environment["PMI_FD"]):
        return (
            f"{what}PMI_FD={environment['PMI_FD']} is not (or no longer) a connection to a "
            "launcher; unset it: env -u PMI_FD -u PMI_RANK -u PMI_SIZE granwave ..., or start "
            "ranks with --np"
        )
    if "PMI_PORT" in environment:
        return (
            f"{what}no launcher answers at PMI_PORT={environment['PMI_PORT']}; unset it: env -u "
            "PMI_PORT -u PMI_ID granwave ..., or start ranks with --np"
        )
    size = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    if 0 <= size < _LEAST_FILE_SIZE:
        return (
            f"{what}the size of files is limited to {size / 1024:.0f} kB, but its shared memory "
            "requires more; raise the limit: ulimit -f unlimited"
        )
    if chosen := _chosen(environment, _OF_LIBRARY):
        name = next((one for one in ("UCX_TLS", "UCX_NET_DEVICES") if one in chosen), chosen[0])
        others = f" ({len(chosen) - 1} more such variables are set)" if len(chosen) > 1 else ""
        return f"{what}{name}={environment[name]} may be the reason{others}; unset it: env -u {name} granwave ..."
    return ""


def _is_open(descriptor: str) -> bool:
    try:
        os.fstat(int(descriptor))
    except (OSError, ValueError, OverflowError):
        return False
    return True
