"""Figures of a comparison: curves of several runs on shared axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from typing import Any

import matplotlib.lines as mlines
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from granwave.analysis.document.model import named
from granwave.analysis.figures.series import (
    COLOURS,
    against_time,
    column_name,
    label,
    label_log_axis,
    panels,
)
from granwave.analysis.figures.style import Drawing, NotDrawn, attempt
from granwave.analysis.formatting.numbers import interval, quantity_in
from granwave.analysis.measures.force_decay import Decay, ForceDecay, better_of, objection
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    FORMS,
    GrowthCurves,
    PeaksByDepth,
    SampledCurve,
    dissipation_by_depth,
    energy_shares,
    force_at_bottom,
    front,
    growth,
    has_static_load,
    peaks_by_depth,
    static_force_at_bottom,
)
from granwave.analysis.reports.comparison.fields import (
    MOST_PANELS,
    ForceField,
    difference_notes,
    draw_difference,
    draw_fields,
    force_field,
    scale_notes,
)
from granwave.analysis.reports.comparison.measured import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import (
    MOST_CURVES,
    ComparedRun,
    LackingError,
    spread_first,
)

_UNLIKE = 5.0  # longest over shortest run from which on the axis of time is logarithmic
#: Line styles of the runs, which distinguish curves in grey prints; fits and measured curves are
#: dotted. The styles with longer gaps are drawn over the others.
_LINES: tuple[Any, ...] = (
    "-",
    (0, (9, 1.5)),
    (0, (7, 1.5, 1.5, 1.5)),
    (0, (4, 1.5)),
    (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)),
    (0, (2, 2)),
)
_ABOVE_LINES = 0.01  # step of the order of drawing from a line style to the next
_MICRO = 1e6
_MILLI = 1e3
_KILO = 1e3
_DECADES = 1e-4  # lowest over highest value of a logarithmic axis
_FONT = 7  # font size of legends, points
_LETTER = 0.054  # width of a letter of a legend, inches
_HANDLE = 0.65  # width of its line and gaps, inches
_HANDLE_LENGTH = 4.0  # length of its line, which shows a period of broken lines / font size
_ROW = 0.15  # height of a row of a legend, inches
_FREE_ROWS = 2  # rows of a legend for which a figure has room
_THIN = 0.9  # points
_THICK = 1.6
_MOST_WIDTHS = 6  # runs whose lines have different widths
_MARKERS = ("o", "s", "^", "D", "v", "P")
_MOST_MARKED = 40  # points of a curve with markers
_NOTHING = 1e-9  # fraction of the input: energy that is due to rounding
_POINTS_OF_FIT = 30
_ROOM_ABOVE = 1.06  # upper end of a linear axis / largest value
_ROOM_OF_LOG = 1.4  # end of a logarithmic axis / largest or smallest value
_HIDES = 30.0  # ratio of the largest to the smallest peak that a linear axis hides
_N_LAWS = 2  # laws of decay: exponential and power
_OTHER_LAW = "it follows the other law"
_BELOW = 1e-2  # lowest force of a logarithmic axis, divided by the smallest peak
_LEAST_MEDIAN = 1e-5  # of the largest force of a run; smaller medians are of layers at rest
_WIDE = 10.0  # highest over lowest value from which on an axis is logarithmic


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
    most
        Largest number of runs that it shows.
    is_cumulative
        True if it shows largest values or sums up to the end of each run, so that its caption
        states different ends.
    values
        Values of summary.json that a sentence compares if only this figure is requested.
    """

    caption: str
    read: Callable[[ComparedRun], Any]
    draw: Callable[[Mapping[ComparedRun, Any], Sequence[MeasuredCurve]], Drawing | None]
    units: tuple[str, str] | None = None
    look: str = ""
    notes: Callable[[Mapping[ComparedRun, Any]], str] | None = None
    curve: Callable[[Any], SampledCurve] | None = None
    most: int = MOST_CURVES
    is_cumulative: bool = False
    values: tuple[str, ...] = ()


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

    If there are more runs than it can show, an evenly spaced selection is shown; the others are
    named.
    """
    present: dict[ComparedRun, Any] = {}
    lacking: dict[ComparedRun, str] = {}
    for place in spread_first(len(runs), figure.most):
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


def _styles(runs: Sequence[ComparedRun]) -> dict[ComparedRun, dict[str, Any]]:
    """Return colour and line of each run, which are the same in all figures of a comparison.

    Of a few runs the first has the thickest line, so that it is seen below equal curves; solid
    lines are below broken lines.
    """
    widths = [_THIN] * len(runs)
    if 1 < len(runs) <= _MOST_WIDTHS:
        widths = np.linspace(_THICK, _THIN, len(runs)).tolist()
    styles: dict[ComparedRun, dict[str, Any]] = {}
    for run, width in zip(runs, widths, strict=True):
        turn, place = divmod(run.look, len(COLOURS))
        line = (place + turn) % len(_LINES)
        styles[run] = {
            "color": COLOURS[place],
            "linestyle": _LINES[line],
            "linewidth": width,
            "zorder": mlines.Line2D.zorder + line * _ABOVE_LINES,
            "label": run.label.replace("$", r"\$").lstrip("_") or "run",
        }
    return styles


def _markers(run: ComparedRun, places: Array) -> dict[str, Any]:
    """Return the markers of the curve of a run; none for many points, which would hide its line.

    Markers are hollow and have different shapes, so that equal curves can be distinguished.
    """
    if len(places) > _MOST_MARKED:
        return {}
    return {
        "marker": _MARKERS[run.look % len(_MARKERS)],
        "markersize": 3.5,
        "markerfacecolor": "none",
        "markeredgewidth": 0.8,
    }


def _legend(figure: MatplotlibFigure) -> None:
    """Put the legend of the lines of the first panel above a figure, which grows by its rows."""
    axes = figure.axes[0]
    lines = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
    longest = max(len(str(line.get_label())) for line in lines)
    width, height = figure.get_size_inches()
    n_columns = max(1, int(width / (_HANDLE + _LETTER * longest)))
    n_rows = math.ceil(len(lines) / n_columns)
    figure.set_size_inches(width, height + _ROW * max(0, n_rows - _FREE_ROWS))
    figure.legend(
        handles=lines,
        loc="outside upper center",
        ncols=n_columns,
        fontsize=_FONT,
        handlelength=_HANDLE_LENGTH,
    )


def _end_of_time(axes: Axes, ends: Sequence[float]) -> None:
    """Show the longest run completely; the axis is logarithmic if the lengths of the runs differ a
    lot.
    """
    longest = max(ends) * _MICRO
    shortest = min(ends) * _MICRO
    if 0 < shortest * _UNLIKE < longest:
        axes.set_xscale("log")
        axes.set_xlim(shortest / _UNLIKE**2, longest)
        return
    axes.set_xlim(0, longest or 1.0)


def _force_unit(largest: float) -> tuple[float, str]:
    """Return the unit of forces up to ``largest`` (N): the number of units in a newton, and its
    name.
    """
    return (1 / _KILO, "kN") if largest >= _KILO else (1.0, "N")


def _measured_lines(
    axes: Axes, measured: Sequence[MeasuredCurve], x_scale: float, y_scale: float
) -> dict[str, Array]:
    """Draw measured curves in black, and return their columns."""
    columns: dict[str, Array] = {}
    for curve in measured:
        axes.plot(
            curve.x * x_scale,
            curve.y * y_scale,
            color="black",
            linestyle=":",
            linewidth=1.4,
            label="measured",
            zorder=3,
        )
        columns |= {"measured_x": curve.x, "measured_y": curve.y}
    return columns


def draw_bottom_force(
    curves: Mapping[ComparedRun, SampledCurve], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the force on the bottom against time."""
    figure, axes = panels(2.7)
    largest = max(float(np.abs(curve.y).max(initial=0.0)) for curve in curves.values())
    scale, unit = _force_unit(largest)
    columns: dict[str, Array] = {}
    for run, look in _styles(list(curves)).items():
        curve = curves[run]
        linestyle = look.pop("linestyle")
        against_time(axes, curve.x, curve.y * scale, linestyle, **look)
        name = column_name(run.label)
        columns |= {f"{name}_time_s": curve.x, f"{name}_force_N": curve.y}
    columns |= _measured_lines(axes, measured, _MICRO, scale)
    label(axes, "Time (µs)", f"Force on the bottom ({unit})")
    _end_of_time(axes, [float(curve.x[-1]) for curve in curves.values()])
    _show_small_forces(axes, [scale * float(curve.y.max()) for curve in curves.values()])
    _legend(figure)
    return Drawing(figure, columns)


def _show_small_forces(axes: Axes, peaks: Sequence[float]) -> None:
    """Make the vertical axis logarithmic if a linear axis would hide the lowest peak.

    Parameters
    ----------
    peaks
        Largest force of each run, in the unit of the axis: (n_runs,).
    """
    present = [peak for peak in peaks if peak > 0]
    if not present or max(present) < _HIDES * min(present):
        axes.axhline(0, color="black", linewidth=0.4, zorder=0)
        return
    axes.set_yscale("log")
    axes.set_ylim(min(present) * _BELOW, 2 * max(present))


def draw_energies(
    curves: Mapping[ComparedRun, Mapping[str, SampledCurve]], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw kinetic, elastic and dissipated energy divided by the input against time, a panel each.

    A form of energy that is zero in every run has no panel.
    """
    forms = [form for form in FORMS if _has_energy(curves, form)]
    figure, *stack = panels(1.0 + 1.1 * len(forms), rows=len(forms), sharex=True)
    columns: dict[str, Array] = {}
    ends: list[float] = []
    for run, look in _styles(list(curves)).items():
        linestyle = look.pop("linestyle")
        for axes, form in zip(stack, forms, strict=True):
            curve = curves[run][form]
            against_time(axes, curve.x, curve.y, linestyle, **look)
            name = column_name(run.label)
            columns |= {f"{name}_time_s": curve.x, f"{name}_{form}_over_input": curve.y}
        ends.append(float(curves[run][forms[0]].x[-1]))
    for axes, form in zip(stack, forms, strict=True):
        label(axes, y=form.capitalize())
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    label(stack[-1], "Time (µs)")
    _end_of_time(stack[-1], ends)
    figure.supylabel("Energy / input", fontsize=8)
    _legend(figure)
    return Drawing(figure, columns)


def _has_energy(curves: Mapping[ComparedRun, Mapping[str, SampledCurve]], form: str) -> bool:
    return any(np.abs(shares[form].y).max() > _NOTHING for shares in curves.values())


def draw_peaks(
    peaks: Mapping[ComparedRun, PeaksByDepth], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the largest and median peak force of each layer against depth, with the fits.

    If each layer is one sphere, as in a chain, there is no panel of the median.
    """
    has_layers = any((one.largest != one.median).any() for one in peaks.values())
    n_panels = 1 + has_layers
    figure, upper, *others = panels(1.0 + 1.8 * n_panels, rows=n_panels, sharex=True)
    fits = common_fits(peaks)
    columns: dict[str, Array] = {}
    for run, look in _styles(list(peaks)).items():
        one = peaks[run]
        depth = one.depth * _MILLI
        is_first = ~one.is_later
        upper.plot(depth[is_first], one.largest[is_first], **_markers(run, depth), **look)
        if one.is_later.any():
            later: dict[str, Any] = look | {"linestyle": "", "label": "_later"}
            later |= _markers(run, depth[one.is_later][:1])
            upper.plot(depth[one.is_later], one.largest[one.is_later], **later)
        for lower in others:
            is_loaded = one.median > _LEAST_MEDIAN * one.largest.max()
            lower.plot(depth[is_loaded], one.median[is_loaded], **_markers(run, depth), **look)
        if run in fits:
            decay = fits[run]
            ends = np.linspace(decay.first, decay.last, _POINTS_OF_FIT)
            fit = decay(ends)
            upper.plot(ends * _MILLI, fit, color=look["color"], linestyle=":", linewidth=1.6)
        name = column_name(run.label)
        columns |= {
            f"{name}_depth_m": one.depth,
            f"{name}_largest_N": one.largest,
            f"{name}_median_N": one.median,
        }
    columns |= _measured_lines(upper, measured, _MILLI, 1.0)
    label(upper, "" if others else "Depth (mm)", _peak_title(peaks))
    for lower in others:
        upper.set_title("largest of the layer")
        label(lower, "Depth (mm)", _median_title(peaks), title="median of the layer")
    _log_if_wide(upper, *others)
    _legend(figure)
    return Drawing(figure, columns)


def _force_title(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the kind of the peak forces."""
    is_dynamic = any(has_static_load(run) for run in peaks)
    return "Peak dynamic force" if is_dynamic else "Peak force"


def _median_title(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the title of the axis of medians, which are of the whole run except in chains."""
    title = _force_title(peaks)
    if all(one.of_first_wave for one in peaks.values()):
        return f"{title}\nof the run (N)"
    return f"{title} (N)"


def _peak_title(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the title of the axis of the largest peak forces."""
    title = _force_title(peaks)
    if all(one.of_first_wave for one in peaks.values()):
        return f"{title}\nof the first wave (N)"
    return f"{title} (N)"


def _log_if_wide(*panels_of_figure: Axes) -> None:
    """Give the vertical axes of all panels one scale, logarithmic if their lines together span more
    than a decade, otherwise linear from 0.
    """
    lines = list(chain.from_iterable(axes.lines for axes in panels_of_figure))
    values = np.concatenate([np.asarray(line.get_ydata()) for line in lines] or [np.ones(1)])
    is_wide = len(values) and values.max() > _WIDE * values.min()
    positive = values[values > 0]
    for axes in panels_of_figure:
        if is_wide and len(positive):
            axes.set_yscale("log")
            axes.set_ylim(positive.min() / _ROOM_OF_LOG, positive.max() * _ROOM_OF_LOG)
            label_log_axis(axes, positive.max() / positive.min())
        else:
            axes.set_ylim(0, _ROOM_ABOVE * values.max(initial=0.0))


def common_fits(peaks: Mapping[ComparedRun, PeaksByDepth]) -> dict[ComparedRun, Decay]:
    """Return the fits of the runs that have one, by the law that fits all runs better.

    The law is the same for all runs, so that its constants can be compared: the exponential or the
    power that describes more runs, of two that describe equally many the one with the smaller sum
    of squared misfits. Runs that it does not describe have no fit.
    """
    laws = [_described(peaks, number) for number in range(_N_LAWS)]
    return min(laws, key=lambda fits: (-len(fits), sum(fit.misfit**2 for fit in fits.values())))


def _described(peaks: Mapping[ComparedRun, PeaksByDepth], number: int) -> dict[ComparedRun, Decay]:
    """Return the fits of one of the laws that describe the forces of a run, by run."""
    fits = {run: one.decays[number] for run, one in peaks.items() if one.decays is not None}
    return {run: fit for run, fit in fits.items() if not objection(fit)}


def decay_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return sentences on the fits of the decay, and on runs without a fit."""
    fits = common_fits(peaks)
    without = _without_fit(peaks, fits)
    if not fits:
        return without
    is_exponential = isinstance(next(iter(fits.values())), ForceDecay)
    law = "exponential, F ~ exp(-bz), fitted" if is_exponential else "power law, F ~ z^-n, fitted"
    constant = "b" if is_exponential else "n"
    parts = [
        f"{_constant(fit)} ({run.name}, {fit.n_layers} layers, rms {100 * fit.misfit:.2g} %)"
        for run, fit in fits.items()
    ]
    fitted = (
        f"Dotted: {law} to the largest force between the impacted and the last layer; {constant} "
        f"and its standard error: {'; '.join(parts)}."
    )
    return f"{fitted} {without}".rstrip()


def _constant(fit: Decay) -> str:
    """Return the constant of a fit with its standard error."""
    if isinstance(fit, ForceDecay):
        return f"{interval(fit.rate, fit.error)} per m"
    return interval(fit.exponent, fit.error)


def _without_fit(
    peaks: Mapping[ComparedRun, PeaksByDepth], fits: Mapping[ComparedRun, Decay]
) -> str:
    """Return a sentence on the runs without a fit of the decay, by reason; empty if there is
    none.
    """
    reasons: dict[str, list[str]] = {}
    for run, one in peaks.items():
        if run not in fits:
            reasons.setdefault(_refusal(one), []).append(run.name)
    parts = [f"{', '.join(names)} ({reason})" for reason, names in reasons.items()]
    return f"Without a fit: {'; '.join(parts)}." if parts else ""


def _refusal(peaks: PeaksByDepth) -> str:
    """Return the reason why the forces of a run have no fit: that of the better law."""
    if peaks.decays is None:
        return peaks.no_decay
    return objection(better_of(peaks.decays)) or _OTHER_LAW


def draw_dissipation(
    curves: Mapping[ComparedRun, SampledCurve], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the dissipated fraction of the input by layer."""
    figure, axes = panels(2.7)
    columns: dict[str, Array] = {}
    highest = max(float(curve.y.max()) for curve in curves.values())
    for run, look in _styles(list(curves)).items():
        curve = curves[run]
        shown = curve.y > 0
        axes.plot(curve.x[shown] * _MILLI, curve.y[shown], **_markers(run, curve.x), **look)
        name = column_name(run.label)
        columns |= {f"{name}_depth_m": curve.x, f"{name}_dissipated_over_input": curve.y}
    label(axes, "Depth (mm)", "Dissipation of the layer / input")
    _log_if_wide(axes)
    if axes.get_yscale() == "log":
        axes.set_ylim(bottom=max(axes.get_ylim()[0], _DECADES * highest))
    _legend(figure)
    return Drawing(figure, columns)


def draw_growth(
    zones: Mapping[ComparedRun, GrowthCurves], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw number and depth of the yielded spheres against time."""
    figure, upper, lower = panels(3.4, rows=2, sharex=True)
    columns: dict[str, Array] = {}
    for run, look in _styles(list(zones)).items():
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
    label(lower, "Time (µs)", "Deepest yield (mm)")
    for axes in (upper, lower):
        axes.set_ylim(bottom=0)
    _end_of_time(lower, [float(zone.time[-1]) for zone in zones.values()])
    _legend(figure)
    return Drawing(figure, columns)


def growth_notes(zones: Mapping[ComparedRun, GrowthCurves]) -> str:
    """Return a sentence on runs whose curves end on one line, since their deepest yield is equal;
    empty if there are none.
    """
    names: dict[str, list[str]] = {}
    for run, zone in zones.items():
        names.setdefault(quantity_in(float(zone.depth[-1]), "m"), []).append(run.name)
    parts = [
        f"{depth} in {named(runs, len(runs))}" for depth, runs in names.items() if len(runs) > 1
    ]
    if not parts:
        return ""
    return f"Curves of equal largest depth end on one line: {'; '.join(parts)}."


def draw_fronts(
    curves: Mapping[ComparedRun, SampledCurve], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the times at which the front of the wave reached each layer or bead."""
    figure, axes = panels(2.7)
    columns: dict[str, Array] = {}
    for run, look in _styles(list(curves)).items():
        curve = curves[run]
        axes.plot(curve.x * _MILLI, curve.y * _MICRO, **_markers(run, curve.x), **look)
        name = column_name(run.label)
        columns |= {f"{name}_depth_m": curve.x, f"{name}_arrival_s": curve.y}
    columns |= _measured_lines(axes, measured, _MILLI, _MICRO)
    label(axes, "Depth (mm)", "Arrival of the front (µs)")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    _legend(figure)
    return Drawing(figure, columns)


def static_notes(curves: Mapping[ComparedRun, Any]) -> str:
    """Return the static forces on the bottom in a sentence; empty without a static load."""
    forces = {run.name: static_force_at_bottom(run) for run in curves}
    parts = [f"{quantity_in(force, 'N')} ({name})" for name, force in forces.items() if force]
    if not parts:
        return ""
    return f"The forces include the static force before the impact: {', '.join(parts)}."


def dynamic_notes(curves: Mapping[ComparedRun, Any]) -> str:
    """Return a sentence on forces that are drawn above the static forces; empty without a static
    load.
    """
    names = [run.name for run in curves if has_static_load(run)]
    if not names:
        return ""
    return f"Forces above the static force of each contact: {named(names, len(names))}."


def _peak_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the sentences below the peak forces against depth."""
    notes = [wave_notes(peaks), dynamic_notes(peaks), decay_notes(peaks), _unknown_notes(peaks)]
    return " ".join(filter(None, notes))


def wave_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on the part of the run whose largest force is drawn."""
    first = [run.name for run, one in peaks.items() if one.of_first_wave]
    whole = [run.name for run, one in peaks.items() if not one.of_first_wave]
    parts = []
    if first:
        parts.append(f"of the first wave, before the reflection ({named(first, len(first))})")
    if whole:
        parts.append(f"of the whole run, with any reflections ({named(whole, len(whole))})")
    later = [
        f"{np.count_nonzero(one.is_later)} ({run.name})"
        for run, one in peaks.items()
        if one.is_later.any()
    ]
    if not later:
        return f"Largest forces {' and '.join(parts)}."
    return (
        f"Largest forces {' and '.join(parts)}. Markers without a line (not fitted): the force of "
        "the layer was largest after a reflection from the base may have arrived; number of "
        f"layers: {', '.join(later)}."
    )


def _unknown_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on layers that are left out; empty if there are none."""
    parts = [f"{one.n_unknown} ({run.name})" for run, one in peaks.items() if one.n_unknown]
    if not parts:
        return ""
    reasons = "whose force still rises at the end"
    if any(one.is_chain and one.n_unknown for one in peaks.values()):
        reasons += " or also includes the reflection"
    return f"Without layers {reasons}: {', '.join(parts)}."


def _field_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return the sentences below the peak forces on sections."""
    return " ".join(filter(None, [dynamic_notes(fields), scale_notes(fields)]))


def _difference_notes(fields: Mapping[ComparedRun, ForceField]) -> str:
    """Return the sentences below the difference of the peak forces."""
    return " ".join(filter(None, [dynamic_notes(fields), difference_notes(fields)]))


def speed_notes(curves: Mapping[ComparedRun, SampledCurve]) -> str:
    """Return sentences on the front speeds of the runs, and on runs without one."""
    speeds = [(run.name, run.run.number("wave_speed_m_s")) for run in curves]
    parts = [f"{speed:.4g} m/s ({name})" for name, speed in speeds if speed is not None]
    without = [name for name, speed in speeds if speed is None]
    sentences: list[str] = []
    if parts:
        sentences.append(f"Speed of the front in the deeper half: {', '.join(parts)}.")
    if without:
        listed = named(without, len(without))
        sentences.append(
            f"No speed of the front, which requires nine layers that the wave reached: {listed}."
        )
    return " ".join(sentences)


def draw_field_panels(
    fields: Mapping[ComparedRun, ForceField], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw peak forces on sections side by side."""
    return draw_fields(fields)


def draw_field_difference(
    fields: Mapping[ComparedRun, ForceField], measured: Sequence[MeasuredCurve]
) -> Drawing | None:
    """Draw the difference of peak forces, of runs with the same grains."""
    return draw_difference(fields) if len(fields) > 1 else None


def _largest(peaks: PeaksByDepth) -> SampledCurve:
    return SampledCurve(peaks.depth, peaks.largest)


def _itself(curve: SampledCurve) -> SampledCurve:
    return curve


#: Figures by their names, which ``--as`` and ``--quantity`` take, in their order.
FIGURES: dict[str, ComparisonFigure] = {
    "bottom_force": ComparisonFigure(
        "Force on the bottom against time", force_at_bottom, draw_bottom_force,
        units=("s", "N"), notes=static_notes, curve=_itself,
        values=(
            "wall_peak_force_N", "wall_dynamic_peak_force_N", "wall_impulse_Ns",
            "wall_dynamic_impulse_Ns", "base_arrival_s",
        ),
    ),
    "peak_force_depth": ComparisonFigure(
        "Peak force against depth: largest and median sphere of each layer", peaks_by_depth,
        draw_peaks, units=("m", "N"), notes=_peak_notes, curve=_largest, is_cumulative=True,
        values=("peak_force_N",),
    ),
    "energies": ComparisonFigure(
        "Kinetic, elastic and dissipated energy against time, relative to the input", energy_shares,
        draw_energies,
        look="Once a curve is constant, the impact is over.", values=("dissipated_fraction",),
    ),
    "dissipation_depth": ComparisonFigure(
        "Dissipation by layer, relative to the input", dissipation_by_depth, draw_dissipation,
        is_cumulative=True, values=("dissipated_fraction", "zone_depth_90_interpolated_m"),
    ),
    "zone_growth": ComparisonFigure(
        "Growth of the plastic zone: number and largest depth of yielded spheres", growth,
        draw_growth, notes=growth_notes, values=("n_plastic_spheres", "plastic_zone_depth_m"),
    ),
    "fronts": ComparisonFigure(
        "Arrival of the front of the wave at each layer", front, draw_fronts, units=("m", "s"),
        notes=speed_notes, curve=_itself, values=("wave_speed_m_s",),
    ),
    "peak_force_field": ComparisonFigure(
        "Peak force on the lattice plane below the impact in which spheres touch, the largest of "
        "the run, on a common colour scale", force_field,
        draw_field_panels, look="White: no contact force.", notes=_field_notes, most=MOST_PANELS,
        is_cumulative=True, values=("peak_force_N",),
    ),
    "peak_force_difference": ComparisonFigure(
        "Difference of the peak force of corresponding grains", force_field,
        draw_field_difference, notes=_difference_notes, most=MOST_PANELS, is_cumulative=True,
        values=("peak_force_N",),
    ),
}  # fmt: skip
