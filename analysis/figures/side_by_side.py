"""Drawing of the figures of a run in several processes.

Helpers are programs of their own, not copies of this process, which may hold threads, MPI and open files. They load the
drawing library, which takes most of a second, while the run is analysed. Then they and this process take shares of the
figures, the longest first, so that all end at about the same time: a thread for each helper hands it one share after
the other. This process alone writes files, in the order of the figures, from what the helpers send. A figure that fails
in a helper, or gives a warning there, is drawn again here, so that errors and warnings are those of drawing in one
process.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import available_memory

PROCESSES = "GRANWAVE_FIGURE_PROCESSES"  # environment variable: largest number of processes that draw
USUAL_FIGURES = 18  # of a packing; a chain has ten
_MOST_PROCESSES = 4  # with more, loading the drawing library costs more than they gain
_LEAST_FIGURES = 4  # for each process
_MEMORY = 0.5e9  # bytes for each helper: 0.4 with 155 520 spheres
_HELPER = "granwave.analysis.figures.run_figures"

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
        self._processes: list[subprocess.Popen[bytes]] = []
        self._threads: list[threading.Thread] = []
        self._left: deque[Sequence[int]] | None = None  # shares that no process has taken; None before drawing
        self._drawn: list[Future[tuple[bool, Outcome]]] = []  # success and outcome of each figure

    def start(self) -> None:
        """Start a helper."""
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        command = [sys.executable, "-P", "-m", _HELPER]
        # a new session: Ctrl-C reaches this process alone, which then ends its helpers
        self._processes.append(subprocess.Popen(command, start_new_session=True, **pipes))

    def end(self) -> None:
        """End the helpers, whether or not they are at work."""
        for process in self._processes:
            process.kill()
        for thread in self._threads:
            thread.join()  # the pipe ended with the helper
        for process in self._processes:
            process.communicate()

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
            Arguments of `granwave.analysis.figures.run_figures.work` after its pipes, to be pickled.
        shares
            Numbers of the figures that one process takes at a time, in the order in which they are taken. By default
            each figure alone, in their order.
        """
        if self._left is not None:
            raise ValueError("these helpers have drawn; start others")
        self._left = deque([[number] for number in range(len(names))] if shares is None else shares)
        self._drawn = [Future() for _ in names]
        for process in self._processes:
            self._threads.append(threading.Thread(target=self._hand_out, args=(process, request), daemon=True))
            self._threads[-1].start()
        for number, name in enumerate(names):
            while not self._drawn[number].done() and (share := self._take()):
                for one in share:
                    self._drawn[one].set_result(_attempt(draw, names[one]))
            succeeded, outcome = self._drawn[number].result()
            yield outcome if succeeded else draw(name)

    def _take(self) -> Sequence[int]:
        """Take a share for this process; empty if all are taken."""
        with contextlib.suppress(IndexError):
            return self._left.popleft() if self._left else ()
        return ()

    def _hand_out(self, process: subprocess.Popen[bytes], request: tuple[Any, ...]) -> None:
        """Let a helper draw one share after the other, until all are taken or it ends."""
        share: Sequence[int] = ()
        assert self._left is not None and process.stdin is not None and process.stdout is not None
        with contextlib.suppress(IndexError, EOFError, OSError, pickle.UnpicklingError):
            pickle.dump(request, process.stdin)
            while True:
                share = self._left.popleft()
                pickle.dump(share, process.stdin)
                process.stdin.flush()
                for number in share:
                    self._drawn[number].set_result(pickle.load(process.stdout))
        for number in share:
            if not self._drawn[number].done():
                self._drawn[number].set_result((False, None))


def _attempt(draw: Callable[[str], Outcome], name: str) -> tuple[bool, Outcome]:
    """Draw a figure; if it fails, it is drawn again in its turn, and the error is raised then."""
    try:
        return True, draw(name)
    except Exception:
        return False, None
