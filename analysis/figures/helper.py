"""Helper that draws figures of a run for another process; see `granwave.analysis.figures.side_by_side`.

    python -m granwave.analysis.figures.helper CONNECTION QUEUE

Both are file descriptors: of the connection to that process, and of the pipe with the numbers of shares to draw.
"""

from __future__ import annotations

import gc
import logging
import os
import sys
import warnings
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path

from granwave.analysis.figures.run_figures import painter
from granwave.lammps_inputs.case.run import Figures


def work(
    connection: Connection,
    queue: int,
    shares: Sequence[Sequence[int]],
    directory: Path,
    names: Sequence[str],
    options: Figures,
) -> None:
    """Draw figures until the queue is empty, and send what they give.

    Parameters
    ----------
    connection
        Connection to the process that asked.
    queue
        File descriptor with a byte for each share: its number in ``shares``.
    shares
        Numbers in ``names`` of the figures that are taken at a time.
    directory
        Directory of the run.
    names
        Names of the figures.
    options
        How figures are drawn.
    """
    notes = _Notes()
    logging.getLogger().addHandler(notes)
    with painter(directory, options) as draw:
        while taken := os.read(queue, 1):
            for number in shares[taken[0]]:
                notes.count = 0
                with warnings.catch_warnings(record=True) as found:
                    try:
                        outcome, succeeded = draw(names[number]), True
                    except Exception:
                        outcome, succeeded = None, False
                if found or notes.count:  # to be drawn where they are seen
                    outcome, succeeded = None, False
                connection.send((number, succeeded, outcome))


class _Notes(logging.Handler):
    """Count of warnings in the log."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Count a warning."""
        self.count += 1


def main(arguments: Sequence[str]) -> None:
    """Wait for a request, and do it."""
    gc.freeze()  # modules stay to the end; collections need not look at them
    with Connection(int(arguments[0])) as connection:
        work(connection, int(arguments[1]), *connection.recv())


if __name__ == "__main__":
    main(sys.argv[1:])
