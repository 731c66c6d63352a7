"""Scans for scripts and notebooks, and loading of a directory of results by its content."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.analysis.errors import MissingDataError, MissingOutputError
from granwave.analysis.notebook.run import Run, frame_of
from granwave.analysis.quantities import scan_columns
from granwave.analysis.scans.result import PointResult, ScanResult
from granwave.analysis.scans.table import (
    Columns,
    column_unit,
    read_scan,
    scan_statistics,
    scan_table,
)
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import load as load_reference
from granwave.lammps_inputs.result_directory import ResultDirectory

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

_POINT = "point"  # name of the index of the table
_SHOWN: dict[str, Any] = {
    "max_rows": 20,
    "float_format": "{:.5g}".format,
    "na_rep": "",
}  # columns of the table


class ScanRuns:
    """Results of a scan; iterating over it gives its finished points as runs.

    ``scan[3]`` is the run of the point number 3 of the table, ``len(scan)`` the number of finished
    points.

    Parameters
    ----------
    directory
        Directory of the scan.

    Attributes
    ----------
    directory
        Absolute path of the directory.
    name
        Name of the scan.
    varied
        Varied keys.

    Raises
    ------
    MissingOutputError
        The directory does not hold a scan.
    OutputFormatError
        Its index is damaged.
    """

    def __init__(self, directory: str | Path) -> None:
        self.result = ScanResult(directory)
        self.directory = self.result.directory.absolute()
        self.name = self.result.name
        self.varied = self.result.varied

    @cached_property
    def points(self) -> tuple[PointResult, ...]:
        """All points in order, with status and reason of a failure, as read at the first use."""
        return self.result.points

    @property
    def _done(self) -> list[PointResult]:
        return [point for point in self.points if point.status == "done"]

    def __len__(self) -> int:
        return len(self._done)

    def __iter__(self) -> Iterator[Run]:
        return (_run(point) for point in self._done)

    def __getitem__(self, number: int) -> Run:
        """Return the run of a point by its number, from 1.

        Raises
        ------
        MissingDataError
            There is no such point, or it is not finished (also a KeyError).
        """
        point = next((point for point in self.points if point.number == number), None)
        if point is None:
            raise MissingDataError(
                f"scan {self.name}: has no point {number}; it has 1 to {len(self.points)}"
            )
        if point.status != "done":
            reason = f": {point.reason}".rstrip(": ")
            raise MissingDataError(f"scan {self.name}: point {number} is {point.status}{reason}")
        return _run(point)

    @cached_property
    def table(self) -> pandas.DataFrame:
        """Points by number: varied keys, status and all values of their summaries; units in
        ``attrs["units"]``.
        """
        columns = {_POINT: [point.number for point in self.points], **scan_table(self.result)}
        return _frame(columns, self.result.units, _POINT)

    @cached_property
    def means(self) -> pandas.DataFrame | None:
        """Means, deviations and 95 % intervals over points that differ only in the seed; None if it
        does not vary.

        Columns ``NAME.mean``, ``NAME.std`` and ``NAME.ci95``, and ``n``, the number of points of
        each mean.
        """
        columns = scan_statistics(self.result)
        return _frame(columns, self.result.units) if columns else None

    def to_xarray(self) -> xarray.Dataset:
        """Convert the table to a Dataset with a dimension for each independent key.

        Raises
        ------
        ValueError
            The points do not fill a grid with one point at each position.
        """
        return read_scan(self.directory).to_xarray()

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures of the scan."""
        from granwave.analysis.figures.style import style
        from granwave.analysis.scans.figures import drawings

        with style():
            return tuple(drawings(self.result))

    def figure(self, name: str) -> Axes | list[Axes]:
        """Draw a figure for further editing; see `granwave.analysis.notebook.run.Run.figure`.

        Raises
        ------
        MissingDataError
            There is no figure of this name.
        """
        from granwave.analysis.figures.series import draw_axes, no_figure
        from granwave.analysis.scans.figures import drawings

        axes = draw_axes(lambda: drawings(self.result).get(name))
        if axes is None:
            raise no_figure(f"scan {self.name}", name, self.figures)
        return axes

    def __repr__(self) -> str:
        table = self._brief.to_string(**_SHOWN) if self.points else ""
        return f"{self._title}\n{table}\n\nresults in {self.directory}"

    def _repr_html_(self) -> str:
        title = html.escape(self._title)
        place = html.escape(f"results in {self.directory}")
        return f"<p>{title}</p>\n{self._brief.to_html(**_SHOWN)}\n<p>{place}</p>"

    @property
    def _title(self) -> str:
        n = len(self.points)
        done = len(self)
        return f"scan {self.name}: {n} point{'s'[: n != 1]}, {'all' if done == n else done} done"

    @property
    def _brief(self) -> pandas.DataFrame:
        """Columns of the table that are shown."""
        table = self.table
        shown = [
            one.name
            for one in scan_columns()
            if one.name in table and table[one.name].notna().any()
        ]
        status = [] if len(self) == len(self.points) else ["status"]
        return table[[*self.varied, *status, *shown]]


def _frame(columns: Columns, units: Mapping[str, str], index: str = "") -> pandas.DataFrame:
    found = {name: "1" if name == _POINT else column_unit(name, units) for name in columns}
    return frame_of(columns, found, index)


def _run(point: PointResult) -> Run:
    assert point.directory is not None  # it is done
    return Run(point.directory, point.labels)


def load(directory: str | Path) -> Any:
    """Load the results of a run, a scan, a search for a design, an inference, or of bands, modes
    and transmission.

    The last three are datasets, as returned by `bands`; if there are several in one directory, a
    dictionary by name.

    Returns
    -------
    Run, ScanRuns, Designs, InferredForces, Dataset or dict
        The results, according to the content of the directory.

    Raises
    ------
    InputError
        The directory holds a suite of scans; the message names them.
    MissingOutputError
        It holds no such results, or those of an extension that is missing.
    OutputFormatError
        The results are damaged.
    """
    path = Path(directory)
    if files.is_scan(path):
        return ScanRuns(path)
    if (path / files.SUITE_INDEX).is_file():
        scans = ", ".join(str(place) for place in sorted(path.iterdir()) if files.is_scan(place))
        raise InputError(
            f"{path}: is a suite of scans; load one of them: {scans or 'none exists yet'}"
        )
    kind = ResultDirectory(path).kind
    if not kind.installed:
        raise MissingOutputError(f"{path}: {kind.why_no_run}")
    return load_reference(kind.loader)(path) if kind.loader else Run(path)
