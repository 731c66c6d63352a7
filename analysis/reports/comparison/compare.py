"""Start of a comparison: checks of the names and of the measured curve."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from granwave.analysis.errors import did_you_mean
from granwave.analysis.reports.comparison.comparison import LEAST_RUNS, Comparison
from granwave.analysis.reports.comparison.figures.registry import FIGURES
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve, read_measured
from granwave.analysis.reports.comparison.subjects import compared_runs
from granwave.analysis.reports.comparison.values import unknown_values
from granwave.analysis.reports.inputs import ReportInputs
from granwave.analysis.reports.kinds import ReportRun
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.own_files import AnyPath

BOTTOM_FORCE = "bottom_force"  # default quantity for a measured curve


def compare_runs(
    runs: Sequence[ReportRun],
    quantities: Sequence[str] = (),
    measured: AnyPath | None = None,
    measured_as: str = BOTTOM_FORCE,
    *,
    shift: float = 0.0,
    scale: float = 1.0,
    left_out: Sequence[str] = (),
) -> Comparison:
    """Compare runs.

    Parameters
    ----------
    runs
        Two at least.
    quantities
        Names of values of summary.json and of figures; by default all results and all figures.
    measured
        File of a measured curve, see `read_measured`.
    measured_as
        Figure that it lies over.
    shift, scale
        Shift of its times or lengths, s or m, and factor of its values.
    left_out
        Messages about unfinished runs without a summary.

    Raises
    ------
    InputError
        There are fewer than two runs, a name is unknown, or the file cannot be read; all faults are
        listed.
    """
    errors: list[Any] = []
    if len(runs) < LEAST_RUNS and measured is None:
        labels = ", ".join(run.label for run in runs) or "none"
        finished = " with results" if left_out else ""
        errors += left_out
        errors.append(
            f"found {len(runs)} run{finished} ({labels}), expected two or more to compare"
        )
    compared = compared_runs(runs)
    names = [name for name in quantities if name not in FIGURES]
    errors += unknown_values(names, compared, tuple(FIGURES))
    curves: dict[str, MeasuredCurve] = {}
    if measured is not None:
        try:
            curves[measured_as] = _measured_curve(measured, measured_as, shift, scale)
        except InputError as error:
            errors += error.items
    if errors:
        raise InputError(errors)
    return Comparison(compared, quantities, curves, left_out)


def compare_inputs(
    inputs: ReportInputs,
    quantities: Sequence[str] = (),
    measured: AnyPath | None = None,
    measured_as: str = BOTTOM_FORCE,
    *,
    shift: float = 0.0,
    scale: float = 1.0,
) -> Comparison:
    """Compare the runs of directories that were read, arguments and errors as of `compare_runs`."""
    runs = [run for run in inputs.results() if run.has_balance]
    return compare_runs(
        runs,
        quantities,
        measured,
        measured_as,
        shift=shift,
        scale=scale,
        left_out=inputs.left_out,
    )


def _measured_curve(path: Any, name: str, shift: float, scale: float) -> MeasuredCurve:
    units = FIGURES[name].units if name in FIGURES else None
    if units is None:
        names = names_for_measured()
        hint = did_you_mean(name, names) or f"expected {', '.join(names)}"
        raise InputError(
            f"--as: found {name}, which cannot be compared with a measured curve; {hint}"
        )
    has_peak = FIGURES[name].has_peak
    return read_measured(path, units, shift=shift, scale=scale, has_peak=has_peak)


def names_for_measured() -> Collection[str]:
    """Return the names of the figures that a measured curve can lie over."""
    return [name for name, figure in FIGURES.items() if figure.units is not None]
