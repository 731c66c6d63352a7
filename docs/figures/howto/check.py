"""Picture of a packing before the run, as `granwave check --picture` draws it."""

import subprocess
import sys
from pathlib import Path

from page_figures import save

PICTURE = "packing.png"
command = [
    Path(sys.executable).with_name("granwave"),
    "check",
    "fcc-small",
    "--set",
    "packing.size=[12,12,6]",
    "--picture",
    PICTURE,
]
subprocess.run(command, check=True, capture_output=True)
save(PICTURE, "packing")
