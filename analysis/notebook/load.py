"""Loading of a directory of results by what it holds; inferred contact forces for scripts and notebooks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.inference.tables import in_words
from granwave.analysis.notebook.run import Run
from granwave.analysis.notebook.scan import ScanRuns
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import (
    INFERENCE,
    INFERRED_FORCES,
    INFERRED_GRAINS,
    MADE_MEASUREMENT,
    SPECTRA_KINDS,
    SUITE_INDEX,
    is_scan,
)

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset


class InferredForces(Mapping[str, Any]):
    """Inferred contact forces: a mapping of the values of their ``summary.json``, with tables.

    Parameters
    ----------
    summary
        Content of summary.json.
    forces, grains, measurement
        Columns of the tables.

    Attributes
    ----------
    forces
        Rows of forces.csv, one for each candidate contact.
    grains
        Rows of grains.csv, the residuals of each grain.
    measurement
        The measurement that was made of a run; None for a table.
    """

    def __init__(self, summary: Mapping[str, Any], forces: Any, grains: Any, measurement: Any = None) -> None:
        import pandas

        self._summary = dict(summary)
        self.forces: DataFrame = pandas.DataFrame(dict(forces))
        self.grains: DataFrame = pandas.DataFrame(dict(grains))
        self.measurement: DataFrame | None = None if measurement is None else pandas.DataFrame(dict(measurement))

    def __getitem__(self, name: str) -> Any:
        return self._summary[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._summary)

    def __len__(self) -> int:
        return len(self._summary)

    def __repr__(self) -> str:
        return in_words(self)


def load_inferred(directory: Path, summary: Mapping[str, Any]) -> InferredForces:
    """Return the forces that ``granwave infer`` left in a directory.

    Raises
    ------
    OutputFormatError
        A table is missing or damaged.
    """
    import pandas

    made = directory / MADE_MEASUREMENT
    try:
        forces, grains = (pandas.read_csv(directory / name) for name in (INFERRED_FORCES, INFERRED_GRAINS))
        return InferredForces(summary, forces, grains, pandas.read_csv(made) if made.is_file() else None)
    except (OSError, ValueError) as error:
        raise OutputFormatError(
            f"{directory}: {INFERRED_FORCES} or {INFERRED_GRAINS} cannot be read: {error}"
        ) from None


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
        from granwave.analysis.notebook.datasets import load_spectra

        return load_spectra(path)
    run = Run(path)
    return load_inferred(path, run.summary) if run.summary.get("kind") == INFERENCE else run
