"""``python -m granwave.workflows``: the command line, as the MPI launcher starts it."""

import sys

from granwave.workflows import mpi
from granwave.workflows.cli import main

status = main()
if mpi.launched():
    # `python -m mpi4py` takes any other exit status than 0 for a crash and aborts with a message of its own
    mpi.leave(status)
sys.exit(status)
