"""Loading of a directory of results by what it holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from granwave.analysis.notebook.inferred import InferredForces, load_inferred
from granwave.analysis.notebook.run import Run
from granwave.analysis.notebook.scan import ScanRuns
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import INFERENCE, SPECTRA_KINDS, SUITE_INDEX, is_scan

if TYPE_CHECKING:
    from xarray import Dataset


def load(directory: str | Path) -> Run | ScanRuns | InferredForces | Dataset | dict[str, Dataset]:
    """Load the results of a run, a scan, an inference, or of bands, modes and transmission.

    The last three are datasets, as `bands` returns them; of several in one directory a dictionary by their names.

    Raises
    ------
    InputError
        The directory holds a suite of scans; the message names them.
    MissingOutputError
        It holds no such results.
    OutputFormatError
        The results are damaged.
    """
    path = Path(directory)
    if is_scan(path):
        return ScanRuns(path)
    if (path / SUITE_INDEX).is_file():
        scans = ", ".join(str(place) for place in sorted(path.iterdir()) if is_scan(place))
        raise InputError(f"{path}: is a suite of scans; load one of them: {scans or 'none is there yet'}")
    if any((path / f"{kind}.json").is_file() for kind in SPECTRA_KINDS):
        from granwave.analysis.notebook.spectra import load_spectra

        return load_spectra(path)
    run = Run(path)
    return load_inferred(path, run.summary) if run.summary.get("kind") == INFERENCE else run
