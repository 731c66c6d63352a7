"""``python -m granwave.workflows`` and the ``granwave`` command: start-up that Ctrl-C can interrupt at once."""

import os
import sys


def run() -> int:
    """Run the command line; return the exit status."""
    try:
        from granwave.workflows.cli.parser import main

        status = main()
    except KeyboardInterrupt:
        print("granwave: stopped", file=sys.stderr, flush=True)
        os._exit(130)  # modules may be half imported, so the usual clean-up could fail
    if sys.argv[1:2] == ["figures"] and "mpi4py.MPI" not in sys.modules:
        sys.stderr.flush()  # standard output is flushed
        os._exit(status)  # files and helpers are closed; to take the drawing library apart takes as long as a figure
    return status


if __name__ == "__main__":
    status = run()
    from granwave.workflows.run import mpi

    if mpi.launched():
        # `python -m mpi4py` takes any exit status but 0 for a crash and aborts with a message of its own
        mpi.leave(status)
    sys.exit(status)
