"""Figures of a comparison: what one shows, and the data of the runs for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.figures.style import Drawing, NotDrawn, attempt
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import (
    MOST_CURVES,
    ComparedRun,
    LackingError,
    places_in_order,
)

_REPLICATE = "one of each set of replicates is drawn"


@dataclass(frozen=True)
class ComparisonFigure:
    """A figure of a comparison.

    Attributes
    ----------
    caption
        What it shows.
    read
        Function that reads the data of a run, or raises `LackingError`.
    draw
        Function that draws the data by run, and measured curves; None: there is nothing.
    units
        SI units of the axes of a measured curve over it; empty: none can lie over it.
    look
        Feature to look for.
    notes
        Function that returns sentences on the data.
    curve
        Function that returns the curve of a run for comparison with a measured curve.
    has_peak
        False if this curve only rises, so that it has no peak.
    most
        Largest number of runs that it shows.
    least
        Smallest number of runs that it shows.
    is_cumulative
        True if it shows largest values or sums up to the end of each run, so that its caption
        states different ends.
    values
        Values of summary.json that a sentence compares if only this figure is requested.
    table
        Function that returns a table of the data for reports, below the figures.
    """

    caption: str
    read: Callable[[ComparedRun], Any]
    draw: Callable[[Mapping[ComparedRun, Any], Sequence[MeasuredCurve]], Drawing | None]
    units: tuple[str, str] | None = None
    look: str = ""
    notes: Callable[[Mapping[ComparedRun, Any]], str] | None = None
    curve: Callable[[Any], SampledCurve] | None = None
    has_peak: bool = True
    most: int = MOST_CURVES
    least: int = 1
    is_cumulative: bool = False
    values: tuple[str, ...] = ()
    table: Callable[[Mapping[ComparedRun, Any]], DocumentTable | None] | None = None


@dataclass(frozen=True, eq=False)
class FigureData:
    """Data of the runs for a figure, and the reasons why other runs have no data.

    Attributes
    ----------
    present
        Data of each run that has data.
    lacking
        Reason by run without it.
    """

    present: dict[ComparedRun, Any] = field(default_factory=dict)
    lacking: dict[ComparedRun, str] = field(default_factory=dict)


def read_figure(figure: ComparisonFigure, runs: Sequence[ComparedRun]) -> FigureData:
    """Read the data of each run for a figure.

    If there are more runs than it can show, an evenly spaced selection is shown; of replicates one
    is shown. The others are named.
    """
    present: dict[ComparedRun, Any] = {}
    lacking = {run: _REPLICATE for run in runs if run.is_repeated}
    for place in places_in_order([run.is_repeated for run in runs], figure.most):
        run = runs[place]
        if len(present) == figure.most:
            lacking[run] = f"only {figure.most} runs are drawn"
            continue
        try:
            curve = attempt(f"a figure of {run.name}", partial(figure.read, run))
        except LackingError as error:
            lacking[run] = str(error)
            continue
        if isinstance(curve, NotDrawn):
            lacking[run] = curve.reason
        else:
            present[run] = curve
    return FigureData(
        {run: present[run] for run in runs if run in present},
        {run: lacking[run] for run in runs if run in lacking},
    )


def itself(curve: SampledCurve) -> SampledCurve:
    return curve
