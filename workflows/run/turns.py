"""Turns of the threads of a process: LAMMPS and matplotlib support one run at a time.

Both have process-wide state. A thread that calls `granwave.run` waits for the thread that
is running; separate processes are independent.
"""

from __future__ import annotations

import contextlib
import logging
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from granwave.lammps_inputs.errors import InputError

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm

logger = logging.getLogger(__name__)


class _Turn:
    """Lock of the process, which its forked copies do not inherit."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        os.register_at_fork(after_in_child=self._renew)

    def _renew(self) -> None:
        self.lock = threading.RLock()


_TURN = _Turn()


@contextlib.contextmanager
def turn(directory: Path | None = None) -> Iterator[None]:
    """Wait until no other thread of this process is running, and keep the others waiting within a
    ``with`` block; blocks of one thread may be nested.
    """
    lock = _TURN.lock
    if not lock.acquire(blocking=False):
        logger.info("%s: waiting for another run of this process", directory or "LAMMPS")
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


def refuse_threads_of_ranks(comm: Intracomm) -> None:
    """Raise InputError on all ranks if a run on several starts in a thread: its turn may differ
    from rank to rank.
    """
    if comm.size > 1 and threading.current_thread() is not threading.main_thread():
        raise InputError(
            f"found a run in a thread on {comm.size} MPI ranks, expected a run in the main "
            "thread; call it there, or start ranks from a single process with ranks=N"
        )
