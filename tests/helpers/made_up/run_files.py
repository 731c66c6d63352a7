"""Files of runs on the disk: summaries, and runs that tests damage, without the checksums that
would detect the damage first.
"""

from __future__ import annotations

import json
from pathlib import Path

from granwave.lammps_inputs.result_directory import ResultDirectory


def summary(directory):
    return json.loads((directory / "summary.json").read_text())


def without_clock(directory):
    return {
        key: value
        for key, value in summary(directory).items()
        if key not in ("wall_time_s", "sphere_steps_per_s", "n_ranks")
    }


def without_checksums(directory: Path) -> Path:
    """Remove sizes and checksums of the output from the marker, as if LAMMPS had been run by hand."""
    results = ResultDirectory(directory)
    marker = results.marker.copy()
    marker.files = dict.fromkeys(marker.files)
    results.write(marker)
    return directory
