"""Largest and median peak force of each layer of several runs against depth, with the decay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from granwave.analysis.document.model import named
from granwave.analysis.figures.series import column_name, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import interval
from granwave.analysis.measures.force_decay import Decay, ForceDecay, better_of, objection
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    PeaksByDepth,
    SampledCurve,
    has_static_load,
    peaks_by_depth,
)
from granwave.analysis.reports.comparison.figures.axes import (
    draw_measured,
    legend_above,
    log_if_wide,
    run_markers,
    run_styles,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.figures.static_loads import dynamic_notes
from granwave.analysis.reports.comparison.measured import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

_MILLI = 1e3
_POINTS_OF_FIT = 30
_N_LAWS = 2  # laws of decay: exponential and power
_OTHER_LAW = "it follows the other law"
_LEAST_MEDIAN = 1e-5  # of the largest force of a run; smaller medians are of layers at rest


def draw_peaks(
    peaks: Mapping[ComparedRun, PeaksByDepth], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the largest and median peak force of each layer against depth, with the fits.

    If each layer is one sphere, as in a chain, there is no panel of the median.
    """
    n_panels = 1 + _have_layers(peaks)
    figure, upper, *others = panels(1.0 + 1.8 * n_panels, rows=n_panels, sharex=True)
    fits = common_fits(peaks)
    columns: dict[str, Array] = {}
    for run, look in run_styles(list(peaks)).items():
        one = peaks[run]
        depth = one.depth * _MILLI
        upper.plot(depth, one.largest, **run_markers(run, depth), **look)
        for lower in others:
            is_loaded = one.median > _LEAST_MEDIAN * one.largest.max()
            lower.plot(depth[is_loaded], one.median[is_loaded], **run_markers(run, depth), **look)
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
    columns |= draw_measured(upper, measured, _MILLI, 1.0)
    label(upper, "" if others else "Depth (mm)", _peak_title(peaks))
    for lower in others:
        upper.set_title("largest of the layer")
        label(lower, "Depth (mm)", _peak_title(peaks), title="median of the layer")
    log_if_wide(upper, *others)
    legend_above(figure)
    return Drawing(figure, columns)


def _peak_title(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the title of the axis of peak forces."""
    is_dynamic = any(has_static_load(run) for run in peaks)
    title = "Peak dynamic force" if is_dynamic else "Peak force"
    if all(one.of_first_wave for one in peaks.values()):
        return f"{title}\nof the first wave (N)"
    return f"{title} (N)"


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


def _peak_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the sentences below the peak forces against depth."""
    notes = [
        _layer_notes(peaks),
        wave_notes(peaks),
        dynamic_notes(peaks),
        decay_notes(peaks),
        _unknown_notes(peaks),
    ]
    return " ".join(filter(None, notes))


def _layer_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on the spheres whose forces are drawn; empty if each layer is one
    sphere.
    """
    return "Largest and median sphere of each layer." if _have_layers(peaks) else ""


def _have_layers(peaks: Mapping[ComparedRun, PeaksByDepth]) -> bool:
    """Return True if the layers of any run have several spheres."""
    return any((one.largest != one.median).any() for one in peaks.values())


def wave_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on the part of the run whose largest force is drawn."""
    first = [run.name for run, one in peaks.items() if one.of_first_wave]
    whole = [run.name for run, one in peaks.items() if not one.of_first_wave]
    parts = []
    if first:
        parts.append(f"of the first wave, before the reflection ({named(first, len(first))})")
    if whole:
        parts.append(f"of the whole run, with any reflections ({named(whole, len(whole))})")
    return f"Largest forces {' and '.join(parts)}."


def _unknown_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on layers that are left out; empty if there are none."""
    parts = [f"{one.n_unknown} ({run.name})" for run, one in peaks.items() if one.n_unknown]
    if not parts:
        return ""
    reasons = "whose force still rises at the end"
    if any(one.of_first_wave for one in peaks.values()):
        reasons += " or also includes the reflection"
    return f"Without layers {reasons}: {', '.join(parts)}."


def _largest(peaks: PeaksByDepth) -> SampledCurve:
    return SampledCurve(peaks.depth, peaks.largest)


PEAK_FORCE_DEPTH = ComparisonFigure(
    "Peak force against depth",
    peaks_by_depth,
    draw_peaks,
    units=("m", "N"),
    notes=_peak_notes,
    curve=_largest,
    is_cumulative=True,
    values=("peak_force_N",),
)
