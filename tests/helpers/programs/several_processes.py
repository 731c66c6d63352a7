"""Processes of this machine in place of the ranks of MPI."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from granwave.lammps_inputs.processes import Processes


class SeveralProcesses(Processes):
    """Processes that work on tasks in turn; to be used in a ``with`` block."""

    def __init__(self, number: int) -> None:
        self.number = number
        context = multiprocessing.get_context("fork")
        self._each = [ProcessPoolExecutor(1, context) for _ in range(number)]

    def map(self, work: Callable[[Any], Any], tasks: Iterable[Any]) -> Iterator[Any]:
        futures = [self._each[n % self.number].submit(work, task) for n, task in enumerate(tasks)]
        return (future.result() for future in futures)

    def __enter__(self) -> SeveralProcesses:
        return self

    def __exit__(self, *_: object) -> None:
        for one in self._each:
            one.shutdown()
