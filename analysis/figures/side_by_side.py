"""Drawing of the figures of a run in several processes.

Helpers are programs of their own, `granwave.analysis.figures.helper`, not copies of this process, which may hold
threads, MPI and open files. They load the drawing library, which takes most of a second, while the run is analysed.
Then they and this process take shares of the figures from a common queue: a pipe with one byte for each share, the
longest first, so that all end at about the same time. This process alone writes files, in the order of the figures,
from what the helpers send. A figure that fails in a helper, or gives a warning there, is drawn again here, so that
errors and warnings are those of drawing in one process.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import available_memory

PROCESSES = "GRANWAVE_FIGURE_PROCESSES"  # environment variable: largest number of processes that draw
USUAL_FIGURES = 18  # of a packing; a chain has ten
_MOST_PROCESSES = 4  # with more, loading the drawing library costs more than they gain
_LEAST_FIGURES = 4  # for each process
_MEMORY = 0.5e9  # bytes for each helper: 0.4 with 155 520 spheres
_HELPER = "granwave.analysis.figures.helper"

Contents = Mapping[str, bytes]  # of the files of a figure, by suffix
Outcome = Contents | None  # None: the figure does not apply


@contextlib.contextmanager
def helpers(n_figures: int) -> Iterator[Helpers]:
    """Start helpers for so many figures, none on a single core; they end with the ``with`` block.

    Raises
    ------
    InputError
        The environment does not give a number of processes.
    """
    found = Helpers()
    try:
        with contextlib.suppress(OSError):  # with fewer helpers this process draws more
            for _ in range(_processes(n_figures) - 1):
                found.start()
        yield found
    finally:
        found.end()


def _processes(n_figures: int) -> int:
    """Return the number of processes that draw, this one included."""
    asked = os.environ.get(PROCESSES, str(_MOST_PROCESSES))
    if not asked.isdecimal():
        raise InputError(f"{PROCESSES}: found {asked!r} in the environment, expected a number of processes")
    room = 1 + int(available_memory() / _MEMORY)
    return max(1, min(int(asked), len(os.sched_getaffinity(0)), n_figures // _LEAST_FIGURES, room))


class Helpers:
    """Processes that draw figures beside this one; made by `helpers`."""

    def __init__(self) -> None:
        self._queue, entry = os.pipe()
        self._entry: int | None = entry
        self._processes: list[subprocess.Popen[bytes]] = []
        self._connections: list[Connection] = []
        self._receivers: list[threading.Thread] = []
        self._news = threading.Condition()
        self._received: dict[int, tuple[bool, Outcome]] = {}  # success and outcome, by number of the figure
        self._at_work = 0  # helpers that may still send something

    def start(self) -> None:
        """Start a helper."""
        ours, theirs = Pipe()
        self._connections.append(ours)
        with theirs:
            fds = (theirs.fileno(), self._queue)
            command = [sys.executable, "-P", "-m", _HELPER, *map(str, fds)]
            silent: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
            # a new session: Ctrl-C reaches this process alone, which then ends its helpers
            self._processes.append(subprocess.Popen(command, pass_fds=fds, start_new_session=True, **silent))

    def end(self) -> None:
        """End the helpers, whether or not they are at work."""
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.wait()
        for receiver in self._receivers:
            receiver.join()  # the connection ended with the helper
        for connection in self._connections:
            connection.close()
        os.close(self._queue)
        self._close_entry()

    def _close_entry(self) -> None:
        if self._entry is not None:
            os.close(self._entry)
        self._entry = None

    def draw(
        self,
        names: Sequence[str],
        draw: Callable[[str], Outcome],
        request: tuple[Any, ...],
        shares: Sequence[Sequence[int]] | None = None,
    ) -> Iterator[Outcome]:
        """Draw figures; yield the outcome of each, in order. To be called once.

        Parameters
        ----------
        names
            Names of the figures.
        draw
            Function that draws a figure in this process.
        request
            Arguments of `granwave.analysis.figures.helper.work` after the shares, to be pickled.
        shares
            Numbers of the figures that one process takes at a time, in the order in which they are taken; at most 256.
            By default each figure alone, in their order.
        """
        shares = [[number] for number in range(len(names))] if shares is None else shares
        if self._entry is None:
            raise ValueError("these helpers have drawn; start others")
        os.write(self._entry, bytes(range(len(shares))))
        self._close_entry()  # so that readers find the end
        self._at_work = len(self._processes)
        for connection in self._connections[: self._at_work]:
            with contextlib.suppress(OSError):  # the helper has died
                connection.send((shares, *request))
            self._receivers.append(threading.Thread(target=self._receive, args=(connection,), daemon=True))
            self._receivers[-1].start()
        own: dict[int, tuple[bool, Outcome]] = {}
        for number, name in enumerate(names):
            while number not in own and number not in self._received and (taken := self._take()) is not None:
                for one in shares[taken]:
                    own[one] = (True, draw(name)) if one == number else _attempt(draw, names[one])
            succeeded, outcome = own.pop(number) if number in own else self._wait_for(number)
            yield outcome if succeeded else draw(name)

    def _take(self) -> int | None:
        """Take the number of a share from the queue; None if all are taken."""
        taken = os.read(self._queue, 1)
        return taken[0] if taken else None

    def _receive(self, connection: Connection) -> None:
        """Take what a helper sends, until its end."""
        with contextlib.suppress(EOFError, OSError):
            while True:
                number, *found = connection.recv()
                with self._news:
                    self._received[number] = tuple(found)
                    self._news.notify()
        with self._news:
            self._at_work -= 1
            self._news.notify()

    def _wait_for(self, number: int) -> tuple[bool, Outcome]:
        """Wait for a figure from a helper, which fails if all have ended."""
        with self._news:
            self._news.wait_for(lambda: number in self._received or not self._at_work)
            return self._received.pop(number, (False, None))


def _attempt(draw: Callable[[str], Outcome], name: str) -> tuple[bool, Outcome]:
    """Draw a figure; if it fails, it is drawn again in its turn, and the error is raised then."""
    try:
        return True, draw(name)
    except Exception:
        return False, None
