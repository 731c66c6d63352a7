"""``python -m granwave.workflows`` and the ``granwave`` command: start-up, in which Ctrl-C is heard at once."""

import os
import sys


def run() -> int:
    """The command line; returns the exit status."""
    try:
        from granwave.workflows.cli.parser import main

        return main()
    except KeyboardInterrupt:
        print("granwave: stopped", file=sys.stderr, flush=True)
        os._exit(130)  # what was half imported cannot be used any more, not even to leave


if __name__ == "__main__":
    status = run()
    from granwave.workflows.run import mpi

    if mpi.launched():
        # `python -m mpi4py` takes any other exit status than 0 for a crash and aborts with a message of its own
        mpi.leave(status)
    sys.exit(status)
