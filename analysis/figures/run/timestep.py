"""The automatic timestep of a run, and the error of its energy balance."""

from __future__ import annotations

import numpy as np

from granwave.analysis.figures.run.histories import time_axis
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, legend_above, new_figure
from granwave.analysis.result.reader import Result, misfit, moved_mass, work_on_packing

_NANO, _MICRO = 1e9, 1e6
_LEAST = 1e-3  # of the tolerance: where the axis of the error begins


def timestep(result: Result) -> Drawing | None:
    """Draw the timestep against time, and below it the error of the balance: measured, expected, and allowed."""
    given = result.largest_input
    if not given or not result.has("energy/timestep"):
        return None
    time, step = result["energy/time"], result["energy/timestep"]
    error = misfit(result.ledger) / given
    work = work_on_packing(result.ledger, moved_mass(result.assembly))
    expected = np.abs(result["energy/expected_error"]) * work / given
    figure = new_figure(3.2)
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.step(time * _MICRO, step * _NANO, where="pre", color=BLUE)
    upper.set_yscale("log", base=2)
    upper.yaxis.set_major_formatter("{x:.3g}")
    upper.set_ylabel("Timestep (ns)")
    for values, colour, label in ((error, GREY, "measured"), (expected, ORANGE, "expected")):
        lower.semilogy(time * _MICRO, np.where(values > 0, values, np.nan), color=colour, linewidth=0.8, label=label)
    tolerance = result.case.run.energy_tolerance
    lower.set_ylim(_LEAST * tolerance, 3 * tolerance)
    lower.axhline(tolerance, color="black", linestyle=":", linewidth=0.8, label="tolerance")
    lower.set_ylabel("|Residual|\n/ input")
    legend_above(lower, 3)
    time_axis(lower, time)
    columns = {"time_s": time, "timestep_s": step, "residual_over_input": error, "expected_over_input": expected}
    return Drawing(figure, columns)
