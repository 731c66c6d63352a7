"""Work that the first rank distributes: it hands tasks to all ranks in turn, and takes their
results in order.

A rank holds one result until the first rank receives it, so that memory does not grow with the
number of ranks.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.processes import Processes, Result, Task
from granwave.workflows.run.mpi import on_first, wait_for

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm, Request

# ranks up to which the first one works too; with more ranks it only collects results
_MOST_WORKING = 8


def shared(
    comm: Intracomm,
    work: Callable[[Processes], Result],
    stopped: Callable[[], bool] = lambda: False,
    most: int | None = None,
) -> Result:
    """Do ``work`` on the first rank with the help of the others; return its result, or raise its
    error, on all.

    Parameters
    ----------
    stopped
        Function that returns True if a stop was requested; KeyboardInterrupt is then raised before
        the next task.
    most
        Largest number of ranks that work; None: all.
    """

    def led() -> Result:
        ranks = _Ranks(comm, stopped, most)
        try:
            return work(ranks)
        finally:
            ranks.end()

    if comm.rank:
        with Interrupts():  # the first rank answers them
            _serve(comm)
    return on_first(comm, led)


class _Ranks(Processes):
    """Ranks that work for the first rank."""

    def __init__(self, comm: Intracomm, stopped: Callable[[], bool], most: int | None) -> None:
        working = comm.size if most is None else min(most, comm.size)
        self._comm = comm
        self._stopped = stopped
        self._first = int(working > _MOST_WORKING)
        self.number = working - self._first
        self._given: deque[tuple[int, Any, Request | None]] = (
            deque()
        )  # rank, task of the first, what was sent

    def map(self, work: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[Result]:
        try:
            for number, task in enumerate(tasks):
                rank = self._first + number % self.number
                sent = (
                    self._comm.isend((work, task), rank) if rank else None
                )  # it may be sending a result
                self._given.append((rank, task, sent))
                if (
                    len(self._given) >= 2 * self.number
                ):  # when a rank has done one, the next task is ready
                    yield self._take(work)
            while self._given:
                yield self._take(work)
        finally:
            self._await()

    def _take(self, work: Callable[[Any], Result]) -> Result:
        if self._stopped():
            raise KeyboardInterrupt
        rank, task, sent = self._given.popleft()
        if sent is None:
            return work(task)
        result, error = self._receive(rank, sent)
        if error is not None:
            raise error
        return result

    def _receive(self, rank: int, sent: Request) -> Any:
        wait_for(self._comm, rank)
        received = self._comm.recv(source=rank, tag=0)
        sent.wait()
        return received

    def _await(self) -> None:
        """Wait for distributed work that is no longer needed."""
        while self._given:
            rank, _, sent = self._given.popleft()
            if sent is not None:
                self._receive(rank, sent)

    def end(self) -> None:
        """Dismiss the other ranks."""
        self._await()
        for rank in range(1, self._comm.size):
            self._comm.send(None, rank)


def _serve(comm: Intracomm) -> None:
    """Work on the tasks that the first rank distributes, until there are no more."""
    while True:
        wait_for(comm, 0)
        if (found := comm.recv(source=0, tag=0)) is None:
            return
        work, task = found
        answer: tuple[Any, Exception | None]
        try:
            answer = work(task), None
        except Exception as error:
            answer = None, error
        comm.send(answer, 0)
