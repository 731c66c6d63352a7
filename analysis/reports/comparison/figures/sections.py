"""Peak forces of several runs on their sections, and the differences of corresponding grains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from granwave.analysis.figures.style import Drawing
from granwave.analysis.reports.comparison.fields import (
    MOST_PANELS,
    ForceField,
    difference_notes,
    draw_difference,
    draw_fields,
    force_field,
    plane_notes,
    scale_notes,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.figures.static_loads import dynamic_notes
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun


def draw_field_panels(
    fields: Mapping[ComparedRun, ForceField], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw peak forces on sections side by side."""
    return draw_fields(fields)


def _field_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return the sentences below the peak forces on sections."""
    notes = [plane_notes(fields), dynamic_notes(fields), scale_notes(fields)]
    return " ".join(filter(None, notes))


def draw_field_difference(
    fields: Mapping[ComparedRun, ForceField], measured: Sequence[MeasuredCurve]
) -> Drawing | None:
    """Draw the difference of peak forces, of runs with the same grains."""
    return draw_difference(fields) if len(fields) >= PEAK_FORCE_DIFFERENCE.least else None


def _difference_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return the sentences below the difference of the peak forces."""
    return " ".join(filter(None, [dynamic_notes(fields), difference_notes(fields)]))


PEAK_FORCE_FIELD = ComparisonFigure(
    "Peak force on a section below the impact, the largest of the run, on a common colour scale",
    force_field,
    draw_field_panels,
    look="White with an outline: no contact force; without an outline: no sphere.",
    notes=_field_notes,
    most=MOST_PANELS,
    is_cumulative=True,
    values=("peak_force_N",),
)


PEAK_FORCE_DIFFERENCE = ComparisonFigure(
    "Difference of the peak force of corresponding grains",
    force_field,
    draw_field_difference,
    notes=_difference_notes,
    most=MOST_PANELS,
    least=2,
    is_cumulative=True,
    values=("peak_force_N",),
)
