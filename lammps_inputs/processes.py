"""Processes that share work: a single process, or several, such as the ranks of
`granwave.workflows.run.ranks`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


class Processes:
    """Only this process.

    Attributes
    ----------
    number
        Number of processes that work.
    """

    number = 1

    def map(self, work: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[Result]:
        """Iterate over the results of tasks, in their order, as ``map`` does; the first error ends
        the iteration.

        Task n of a call is always done by process n % ``number``. Function, tasks and results go
        from process to process: they must be small or few, and picklable.
        """
        return map(work, tasks)


ALONE = Processes()
