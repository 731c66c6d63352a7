"""Runs in forked copies of a process that has loaded all modules, without MPI, which each run
starts for itself.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import traceback
from collections.abc import Callable

from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.streams import flush
from granwave.workflows.run import mpi
from granwave.workflows.run.launchers import starting
from granwave.workflows.run.leftovers import forget


def load(*, figures: bool = False) -> None:
    """Import the modules that runs need, without starting MPI."""
    import mpi4py

    mpi4py.rc.initialize = mpi4py.rc.finalize = False
    import lammps  # noqa: F401

    with contextlib.suppress(RuntimeError):  # without a library each run names it
        from mpi4py import MPI  # noqa: F401

    import granwave.analysis.pipeline
    import granwave.workflows.run.driver

    if figures:
        import granwave.analysis.figures.run_figures  # noqa: F401


def fork(work: Callable[[], int], log: int, *, starts_mpi: bool = True) -> int:
    """Do work in a copy of this process, which ends with a checkpoint if this process ends; return
    its process id.

    Parameters
    ----------
    work
        Function that returns the exit status.
    log
        Descriptor of the file that the copy writes to.
    starts_mpi
        True if the work needs MPI.
    """
    flush()
    ours = {signal.SIGTERM, signal.SIGINT}
    # block signals until the copy has replaced the handlers of this process
    signal.pthread_sigmask(signal.SIG_BLOCK, ours)
    process = os.fork()
    if process:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ours)
        return process
    status = 1
    try:
        mpi.end_with_parent(signal.SIGTERM)  # after writing a checkpoint
        for number in ours:
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ours)
        os.dup2(log, 1)
        os.dup2(log, 2)
        if starts_mpi:
            mpi.check_library()
            from mpi4py import MPI

            with starting():
                MPI.Init()
        status = work()
        if starts_mpi:
            MPI.Finalize()
    except RunError as error:  # the MPI library is missing
        print(f"granwave: {error}", file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            flush()
            forget()
        os._exit(status)
