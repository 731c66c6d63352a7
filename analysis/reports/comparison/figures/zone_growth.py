"""Growth of the plastic zone of several runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from granwave.analysis.document.model import named
from granwave.analysis.figures.series import column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    GrowthCurves,
    SampledCurve,
    growth,
)
from granwave.analysis.reports.comparison.figures.axes import (
    end_notes,
    label_lowest,
    last_change,
    legend_above,
    run_panels,
    run_styles,
    show_times_up_to,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

_MICRO = 1e6
_MILLI = 1e3
_NO_GROWTH = "number and depth grow by less than 1 %"


def draw_growth(
    zones: Mapping[ComparedRun, GrowthCurves], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw number and depth of the yielded spheres against time."""
    figure, upper, lower = run_panels(len(zones), 2, 3.4)
    columns: dict[str, Array] = {}
    for run, look in run_styles(list(zones)).items():
        zone = zones[run]
        upper.step(zone.time * _MICRO, zone.spheres, where="post", **look)
        lower.step(zone.time * _MICRO, zone.depth * _MILLI, where="post", **look)
        name = column_name(run.label)
        columns |= {
            f"{name}_time_s": zone.time,
            f"{name}_yielded_spheres": zone.spheres,
            f"{name}_depth_m": zone.depth,
        }
    label(upper, y="Yielded spheres")
    label(lower, y="Deepest yield (mm)")
    ends = _ends(zones)
    first_yields = {run: float(zone.time[1]) for run, zone in zones.items()}
    for axes in (upper, lower):
        axes.set_ylim(bottom=0)
        show_times_up_to(axes, ends, first_yields, _last_change(zones))
    label_lowest([upper, lower], len(zones), "Time (µs)")
    legend_above(figure)
    return Drawing(figure, columns)


def _ends(zones: Mapping[ComparedRun, GrowthCurves]) -> dict[ComparedRun, float]:
    """Return the ends of runs, s."""
    return {run: float(zone.time[-1]) for run, zone in zones.items()}


def _last_change(zones: Mapping[ComparedRun, GrowthCurves]) -> float:
    """Return the time, s, after which the zone of no run grows noticeably."""
    times = [0.0]
    for zone in zones.values():
        for values in (zone.spheres, zone.depth):
            times.append(last_change(SampledCurve(zone.time, values), float(values[-1])))
    return max(times)


def growth_notes(zones: Mapping[ComparedRun, GrowthCurves]) -> str:
    """Return sentences on runs whose largest depths are equal, and on the axis of time; empty if
    there are none.
    """
    of_axis = end_notes(_ends(zones), _last_change(zones), _NO_GROWTH)
    return " ".join(filter(None, [_equal_depths(zones), of_axis]))


def _equal_depths(zones: Mapping[ComparedRun, GrowthCurves]) -> str:
    """Return a sentence on runs whose largest depths are equal; empty if there are none."""
    names: dict[str, list[str]] = {}
    for run, zone in zones.items():
        names.setdefault(quantity_in(float(zone.depth[-1]), "m"), []).append(run.name)
    parts = [
        f"{depth} in {named(runs, len(runs))}" for depth, runs in names.items() if len(runs) > 1
    ]
    if not parts:
        return ""
    return f"Equal largest depths: {'; '.join(parts)}."


ZONE_GROWTH = ComparisonFigure(
    "Growth of the plastic zone: number and largest depth of yielded spheres",
    growth,
    draw_growth,
    notes=growth_notes,
    values=("n_plastic_spheres", "plastic_zone_depth_m"),
)
