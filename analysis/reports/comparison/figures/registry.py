"""The figures of a comparison by name."""

from __future__ import annotations

from granwave.analysis.reports.comparison.figures.bottom_force import BOTTOM_FORCE
from granwave.analysis.reports.comparison.figures.dissipation_depth import DISSIPATION_DEPTH
from granwave.analysis.reports.comparison.figures.energies import ENERGIES
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.figures.fronts import FRONTS
from granwave.analysis.reports.comparison.figures.peak_force_depth import PEAK_FORCE_DEPTH
from granwave.analysis.reports.comparison.figures.sections import (
    PEAK_FORCE_DIFFERENCE,
    PEAK_FORCE_FIELD,
)
from granwave.analysis.reports.comparison.figures.zone_growth import ZONE_GROWTH

#: Figures by their names, which ``--as`` and ``--quantity`` take, in their order.
FIGURES: dict[str, ComparisonFigure] = {
    "bottom_force": BOTTOM_FORCE,
    "peak_force_depth": PEAK_FORCE_DEPTH,
    "energies": ENERGIES,
    "dissipation_depth": DISSIPATION_DEPTH,
    "zone_growth": ZONE_GROWTH,
    "fronts": FRONTS,
    "peak_force_field": PEAK_FORCE_FIELD,
    "peak_force_difference": PEAK_FORCE_DIFFERENCE,
}
