"""``python -m granwave.workflows`` and the ``granwave`` command: start-up that Ctrl-C can interrupt
at once.
"""

import os
import sys

if __name__ == "__main__" and not sys.flags.safe_path:
    del sys.path[0]  # remove the working directory, whose files may have the names of modules


def run() -> int:
    """Run the command line; return the exit status."""
    try:
        from granwave.workflows.cli.main import main

        return main()
    except KeyboardInterrupt:
        print("granwave: stopped", file=sys.stderr, flush=True)
        os._exit(130)  # modules may be half imported, so the usual clean-up could fail


if __name__ == "__main__":
    status = run()
    from granwave.workflows.run import mpi

    if mpi.launched():
        # `python -m mpi4py` treats any non-zero exit status as a crash and aborts with a message of
        # its own
        mpi.leave(status)
    if status == 130:
        # Python would end by a signal if the error has passed through code generated from text, as
        # in dataclasses
        from granwave.lammps_inputs.streams import flush
        from granwave.workflows.run.leftovers import remove_own

        flush()
        remove_own()
        os._exit(status)
    sys.exit(status)
