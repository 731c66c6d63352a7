"""``python -m granwave.workflows`` and the ``granwave`` command: start-up, in which Ctrl-C is heard at once."""

import sys


def run() -> int:
    """The command line; returns the exit status."""
    try:
        from granwave.workflows.cli import main

        return main()
    except KeyboardInterrupt:
        print("granwave: stopped", file=sys.stderr)
        return 130


if __name__ == "__main__":
    status = run()
    from granwave.workflows import mpi

    if mpi.launched():
        # `python -m mpi4py` takes any other exit status than 0 for a crash and aborts with a message of its own
        mpi.leave(status)
    sys.exit(status)
