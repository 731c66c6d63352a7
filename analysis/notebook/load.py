"""Loading of a directory of results by what it holds."""

from __future__ import annotations

from pathlib import Path

from granwave.analysis.notebook.run import Run
from granwave.analysis.notebook.scan import ScanRuns
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import SUITE_INDEX, is_scan


def load(directory: str | Path) -> Run | ScanRuns:
    """Load the results of a run or of a scan.

    Raises
    ------
    InputError
        The directory holds a suite of scans; the message names them.
    MissingOutputError
        It holds neither a run nor a scan.
    OutputFormatError
        The results are damaged.
    """
    path = Path(directory)
    if is_scan(path):
        return ScanRuns(path)
    if (path / SUITE_INDEX).is_file():
        scans = ", ".join(str(place) for place in sorted(path.iterdir()) if is_scan(place))
        raise InputError(f"{path}: is a suite of scans; load one of them: {scans or 'none is there yet'}")
    return Run(path)
