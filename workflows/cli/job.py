"""Job of a single command on a cluster.

    python -m granwave.workflows.cli.job NAME.job

Before the time limit it gets SIGTERM, writes a checkpoint and ends; the next job of its chain
continues. Exit status: exit status of the command; 0 if an earlier job has finished the work.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from granwave.lammps_inputs.files import read_json
from granwave.workflows.cli.main import main as granwave
from granwave.workflows.cluster.job import RECORD, is_ended, note_end
from granwave.workflows.run import mpi


def main(arguments: Sequence[str]) -> int:
    """Run the command of a job; return its exit status."""
    folder = Path(arguments[0])
    if is_ended(folder):
        return 0
    record = read_json(folder / RECORD)
    if record is None:
        print(f"granwave: {folder / RECORD}: is missing or damaged; submit again", file=sys.stderr)
        return 2
    for name in set(os.environ) - set(mpi.alone()):
        del os.environ[name]  # the command is no rank of the program that started this job
    words = record["words"]
    if record["ranks"] > 1:
        status = mpi.launch(record["ranks"], words, record["launcher"], remedy="submit it again")
    else:
        status = granwave(words)
    note_end(folder, status)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
