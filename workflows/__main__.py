"""``python -m granwave.workflows``: the command line, as the MPI launcher starts it."""

import sys

from granwave.workflows.cli import main

sys.exit(main())
