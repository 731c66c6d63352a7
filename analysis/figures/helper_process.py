"""Start of a process that helps to draw figures, with as little to load before as possible.

The command that draws figures starts one with its first lines, so that the drawing library is loaded there while the
command line is still read here.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

PROCESSES = "GRANWAVE_FIGURE_PROCESSES"  # environment variable: largest number of processes that draw
_HELPER = "granwave.analysis.figures.helper"


@dataclass(frozen=True)
class HelperProcess:
    """Process that helps to draw.

    Attributes
    ----------
    process
        The process.
    connection
        Connection to it.
    """

    process: subprocess.Popen[bytes]
    connection: Connection

    @classmethod
    def start(cls, queue: int) -> HelperProcess:
        """Start one; ``queue`` is the file descriptor from which it takes the numbers of shares."""
        ours, theirs = Pipe()
        try:
            with theirs:
                fds = (theirs.fileno(), queue)
                command = [sys.executable, "-P", "-m", _HELPER, *map(str, fds)]
                silent: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
                # a new session: Ctrl-C reaches this process alone, which then ends its helpers
                process = subprocess.Popen(command, pass_fds=fds, start_new_session=True, **silent)
        except OSError:
            ours.close()
            raise
        return cls(process, ours)

    def end(self) -> None:
        """End it, whether or not it is at work."""
        self.process.kill()
        self.process.wait()


@dataclass(frozen=True)
class Queue:
    """Pipe with a byte for each share of figures, and a helper that waits at it.

    Attributes
    ----------
    end, entry
        File descriptors to read from and to write to.
    helper
        A process that was started before it was known that it is needed; None if there is none.
    """

    end: int
    entry: int
    helper: HelperProcess | None = None


_EARLY: list[Queue] = []  # at most one


def start_early() -> None:
    """Start a helper on a machine of several cores, for the figures that this program is about to draw.

    One that nothing takes ends with this program, which ends its connection.
    """
    if PROCESSES not in os.environ and len(os.sched_getaffinity(0)) > 1:
        queue = Queue(*os.pipe())
        with contextlib.suppress(OSError):  # with fewer helpers this process draws more
            queue = Queue(queue.end, queue.entry, HelperProcess.start(queue.end))
        _EARLY.append(queue)


def take_queue() -> Queue:
    """Return the queue of a helper that was started early, once; or a new one."""
    return _EARLY.pop() if _EARLY else Queue(*os.pipe())
