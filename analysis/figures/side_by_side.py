"""Drawing of the figures of a run in several processes.

Helpers are separate programs, not copies of this process, which may have threads, MPI and open
files. They load the drawing library, which takes most of a second, while the run is analysed. Then
they and this process take batches of figures, the longest first, so that all end at about the same
time: a thread for each helper passes it one batch after another. Only this process writes files,
in the order of the figures, from the output of the helpers. A figure that fails in a helper, or
gives a warning there, is drawn again here, so that errors and warnings do not depend on the number
of processes.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any

from granwave.lammps_inputs.case.figures import Figures, figure_names
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import available_memory

# environment variable: largest number of processes that draw
PROCESSES = "GRANWAVE_FIGURE_PROCESSES"
_USUAL_FIGURES = 6  # figures that are drawn by default
_SHARE = 0.5  # fraction of all figures that apply to a run
_MOST_PROCESSES = 4  # with more processes, loading matplotlib takes longer than they save
_LEAST_FIGURES = 4  # fewest figures for each process
_MEMORY = 0.5e9  # bytes per helper: 0.4 with 155 520 spheres
_HELPER = "granwave.analysis.figures.run_figures"

Contents = Mapping[str, bytes]  # contents of the files of a figure, by suffix
Outcome = Contents | None  # None: the figure does not apply


def number_expected(options: Figures, names: Sequence[str] | None = None) -> int:
    """Return the expected number of figures, by name or by request."""
    if names or options.only:
        return len(names or options.only)
    return int(_SHARE * len(figure_names())) if options.all else _USUAL_FIGURES


@contextlib.contextmanager
def helpers(n_figures: int) -> Iterator[Helpers]:
    """Start helpers for a number of figures, none on a single core; the ``with`` block ends them.

    Raises
    ------
    InputError
        The environment does not give a number of processes.
    """
    started = Helpers()
    try:
        with contextlib.suppress(OSError):  # with fewer helpers this process draws more figures
            for _ in range(_processes(n_figures) - 1):
                started.start()
        yield started
    finally:
        started.end()


def _processes(n_figures: int) -> int:
    """Return the number of processes that draw, this one included."""
    setting = os.environ.get(PROCESSES, str(_MOST_PROCESSES))
    if not setting.isdecimal():
        raise InputError(
            f"{PROCESSES}: found {setting!r} in the environment, expected a number of processes"
        )
    room = 1 + int(available_memory() / _MEMORY)
    return max(
        1, min(int(setting), len(os.sched_getaffinity(0)), n_figures // _LEAST_FIGURES, room)
    )


class Helpers:
    """Processes that draw figures together with this process; made by `helpers`."""

    def __init__(self) -> None:
        self._processes: list[subprocess.Popen[bytes]] = []
        # one thread for each helper; None before drawing
        self._threads: ThreadPoolExecutor | None = None

    def start(self) -> None:
        """Start a helper."""
        pipes: dict[str, Any] = {
            "stdin": subprocess.PIPE,
            "stdout": subprocess.PIPE,
            "stderr": subprocess.DEVNULL,
        }
        command = [sys.executable, "-P", "-m", _HELPER]
        # a new session: Ctrl-C reaches this process only, which then ends its helpers
        self._processes.append(subprocess.Popen(command, start_new_session=True, **pipes))

    def end(self) -> None:
        """End the helpers, even if they are still drawing."""
        for process in self._processes:
            process.kill()
        if self._threads is not None:
            self._threads.shutdown(cancel_futures=True)  # the helpers have closed their pipes
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
            Arguments of `granwave.analysis.figures.run_figures.work` after its pipes, to be
            pickled.
        shares
            Numbers of the figures that one process takes at a time, in the order in which they are
            taken. By default each figure alone, in their order.
        """
        if self._threads is not None:
            raise ValueError("these processes have been used; start new ones")
        self._threads = ThreadPoolExecutor(len(self._processes) or 1)
        if not self._processes:
            yield from map(draw, names)
            return
        idle: SimpleQueue[subprocess.Popen[bytes]] = SimpleQueue()
        for process in self._processes:
            with contextlib.suppress(OSError):
                pickle.dump(request, process.stdin)  # type: ignore[arg-type]
            idle.put(process)
        waiting: dict[Future[Any], Sequence[int]] = {}
        future_of: dict[int, Future[Any]] = {}  # futures by the number of a figure
        for share in shares or [[number] for number in range(len(names))]:
            future = self._threads.submit(_drawn_beside, idle, share)
            waiting[future] = share
            future_of |= dict.fromkeys(share, future)
        drawn: dict[int, tuple[bool, Outcome]] = {}
        for number, name in enumerate(names):
            while number not in drawn and not future_of[number].done():
                share = self._take(waiting)
                if not share:
                    break
                drawn |= {n: _attempt(draw, names[n]) for n in share}
            if number not in drawn:
                drawn |= future_of[number].result()
            succeeded, outcome = drawn.pop(number)
            yield outcome if succeeded else draw(name)

    def _take(self, waiting: dict[Future[Any], Sequence[int]]) -> Sequence[int]:
        """Take a batch that no helper has started; empty if there is none."""
        return next((waiting.pop(future) for future in list(waiting) if future.cancel()), ())


def _drawn_beside(
    idle: SimpleQueue[subprocess.Popen[bytes]], share: Sequence[int]
) -> dict[int, tuple[bool, Outcome]]:
    """Let an idle helper draw a batch; return the success and outcome of each figure by number.

    If the helper dies, no figure has succeeded.
    """
    process = idle.get()
    assert process.stdin is not None and process.stdout is not None
    try:
        pickle.dump(share, process.stdin)
        process.stdin.flush()
        return {number: pickle.load(process.stdout) for number in share}
    except (EOFError, OSError, pickle.UnpicklingError):
        return dict.fromkeys(share, (False, None))
    finally:
        idle.put(process)


def _attempt(draw: Callable[[str], Outcome], name: str) -> tuple[bool, Outcome]:
    """Draw a figure; a figure that fails is drawn again later, and its error is raised then."""
    try:
        return True, draw(name)
    except Exception:
        return False, None
