"""Largest and median peak force of each layer of several runs against depth, with the decay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.model import DocumentTable, named, text_table
from granwave.analysis.figures.series import column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import interval
from granwave.analysis.measures.force_decay import (
    Decay,
    ForceDecay,
    PowerDecay,
    accepted,
    decays_within,
    objection,
    reason_against,
)
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    PeaksByDepth,
    SampledCurve,
    has_static_load,
    peaks_by_depth,
)
from granwave.analysis.reports.comparison.figures.axes import (
    draw_measured,
    label_lowest,
    legend_above,
    log_if_wide,
    run_markers,
    run_panels,
    run_styles,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.figures.static_loads import dynamic_notes
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun

_MILLI = 1e3
_POINTS_OF_FIT = 30
_MOST_NAMED = 3  # runs that a sentence of the caption names
_N_LAWS = 2  # laws of decay: exponential and power
_HEADS_OF_FITS = ("Run", "Law", "Constant, standard error", "rms misfit", "Layers")
_SAME_RANGE = 1e-3  # difference of equal ranges of depth, diameters
_LEAST_MEDIAN = 1e-5  # of the largest force of a run; smaller medians are of layers at rest


def draw_peaks(
    peaks: Mapping[ComparedRun, PeaksByDepth], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw the largest and median peak force of each layer against depth, with the fits.

    There is no panel of the median if each layer is one sphere, as in a chain, or if no run has a
    median. Each panel has its own limits. Lines have gaps where layers are left out.
    """
    n_panels = 1 + _have_medians(peaks)
    figure, upper, *others = run_panels(len(peaks), n_panels, 2.0 + 0.7 * n_panels)
    fits = common_fits(peaks)
    columns: dict[str, Array] = {}
    for run, look in run_styles(list(peaks)).items():
        one = peaks[run]
        depth = one.with_gaps(one.depth) * _MILLI
        first = one.with_gaps(np.where(one.is_later, np.nan, one.largest))
        upper.plot(depth, first, **run_markers(run, depth), **look)
        if one.is_later.any():
            later: dict[str, Any] = look | {"linestyle": "", "label": "_later"}
            later |= run_markers(run, depth[:1])
            upper.plot(one.depth[one.is_later] * _MILLI, one.largest[one.is_later], **later)
        for lower in others:
            median = one.with_gaps(np.where(_has_median(one), one.median, np.nan))
            lower.plot(depth, median, **run_markers(run, depth), **look)
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
        if run in fits:
            columns |= _fit_columns(name, fits[run])
    columns |= draw_measured(upper, measured, _MILLI, 1.0)
    label(upper, y=_peak_title(peaks))
    for lower in others:
        upper.set_title("largest of the layer")
        label(lower, y=_median_title(peaks), title="median of the layer")
    label_lowest([upper, *others], len(peaks), "Depth (mm)")
    log_if_wide(upper, *others)
    legend_above(figure)
    return Drawing(figure, columns)


def _has_median(peaks: PeaksByDepth) -> NDArray[np.bool_]:
    """Return True for layers of which at least half of the spheres are loaded: (n_layers,)."""
    return peaks.median > _LEAST_MEDIAN * peaks.largest.max()


def median_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on runs without a median force; empty if there are none."""
    names = [run.name for run, one in peaks.items() if not _has_median(one).any()]
    if not _have_layers(peaks) or not names:
        return ""
    if len(names) == len(peaks):
        return (
            "No panel of the medians: in every run more than half of the spheres of each layer "
            "stay at rest."
        )
    listed = named(names, len(names))
    return f"No median, since more than half of the spheres of each layer stay at rest: {listed}."


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


def common_decays(
    peaks: Mapping[ComparedRun, PeaksByDepth],
) -> dict[ComparedRun, tuple[ForceDecay, PowerDecay] | str]:
    """Return the fits of each run by both laws to the depths in diameters that all runs with fits
    have, or the reason why a run has no fits.

    Constants of different ranges would differ where the forces follow no law exactly, even for
    equal forces.
    """
    limits = _common_range(peaks)
    decays: dict[ComparedRun, tuple[ForceDecay, PowerDecay] | str] = {}
    for run, one in peaks.items():
        if one.decays is None or limits is None:
            decays[run] = one.no_decay
        else:
            decays[run] = decays_within(one.decays, one.depth, one.largest, limits)
    return decays


def _common_range(peaks: Mapping[ComparedRun, PeaksByDepth]) -> tuple[float, float] | None:
    """Return the smallest and largest depth, in diameters, of the layers that can be fitted in all
    runs with fits; None without fits.
    """
    ranges = _ranges(peaks)
    if not ranges:
        return None
    return max(first for first, _ in ranges), min(last for _, last in ranges)


def _ranges(peaks: Mapping[ComparedRun, PeaksByDepth]) -> list[tuple[float, float]]:
    """Return the ranges of depth, in diameters, of the layers of each run that can be fitted."""
    powers = [one.decays[1] for one in peaks.values() if one.decays is not None]
    return [(fit.first / fit.diameter, fit.last / fit.diameter) for fit in powers]


def common_fits(peaks: Mapping[ComparedRun, PeaksByDepth]) -> dict[ComparedRun, Decay]:
    """Return the fits of the runs that have one, by the law that fits all runs better.

    Law and range of depths are the same for all runs, so that the constants can be compared: the
    exponential or the power that describes more runs, of two that describe equally many the one
    with the smaller sum of squared misfits. Runs that it does not describe have no fit.
    """
    decays = common_decays(peaks)
    laws = [_described(decays, number) for number in range(_N_LAWS)]
    return min(laws, key=lambda fits: (-len(fits), sum(fit.misfit**2 for fit in fits.values())))


def _described(
    decays: Mapping[ComparedRun, tuple[ForceDecay, PowerDecay] | str], number: int
) -> dict[ComparedRun, Decay]:
    """Return the fits of one of the laws that describe the forces of a run, by run."""
    fits = {run: both[number] for run, both in decays.items() if not isinstance(both, str)}
    return {run: fit for run, fit in fits.items() if not objection(fit)}


def decay_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on the fits of the decay, whose constants are in `decay_table`."""
    fits = common_fits(peaks)
    if not fits:
        return "No run has a fit, see the table of the decay."
    law = _law(next(iter(fits.values())))
    common = ", one law for all runs" if len(_ranges(peaks)) > 1 else ""
    return f"Dotted: {law}{common}, see the table of the decay."


def decay_table(peaks: Mapping[ComparedRun, PeaksByDepth]) -> DocumentTable:
    """Return the table of the fits: law, constant, misfit and layers of each run, or the reason why
    it has no fit. A law that describes a run better than the common law has its own row.
    """
    fits = common_fits(peaks)
    rows: list[tuple[str, ...]] = []
    for run, both in common_decays(peaks).items():
        better = accepted(both)
        if run in fits:
            rows.append((run.name, *_cells(fits[run])))
        if better is None:
            rows.append((run.name, f"none: {reason_against(both)}", "", "", ""))
        elif type(better) is not type(fits.get(run)):
            rows.append((run.name, *_cells(better, ", not drawn")))
    caption = "Decay of the largest peak force"
    if _ranges(peaks):
        caption = f"{caption}, fitted {_fitted_layers(peaks)}"
    return text_table(caption, _HEADS_OF_FITS, rows)


def _cells(fit: Decay, remark: str = "") -> tuple[str, ...]:
    """Return law, constant, misfit and number of layers of a fit in words."""
    symbol = "b" if isinstance(fit, ForceDecay) else "n"
    constant = f"{symbol} = {_constant(fit)}"
    return f"{_law(fit)}{remark}", constant, f"{100 * fit.misfit:.2g} %", str(fit.n_layers)


def _fitted_layers(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the layers of the fits in words: all of a run, or those at the common depths."""
    ranges = _ranges(peaks)
    if np.ptp(np.array(ranges), axis=0).max() < _SAME_RANGE:
        return "between the impacted and the last layer"
    limits = _common_range(peaks)
    assert limits is not None
    return f"at the depths that all fitted runs have, {limits[0]:.2g} to {limits[1]:.2g} diameters"


def _value_and_error(fit: Decay) -> tuple[float, float]:
    """Return the constant of a fit and its standard error: 1/m, or without a unit."""
    if isinstance(fit, ForceDecay):
        return fit.rate, fit.error
    return fit.exponent, fit.error


def _fit_columns(name: str, fit: Decay) -> dict[str, Array]:
    """Return the columns of a fit in the data of the figure."""
    unit = "_per_m" if isinstance(fit, ForceDecay) else ""
    constant, error = _value_and_error(fit)
    return {
        f"{name}_decay{unit}": np.array([constant]),
        f"{name}_decay_error{unit}": np.array([error]),
        f"{name}_decay_rms": np.array([fit.misfit]),
    }


def _law(fit: Decay) -> str:
    """Return the name and the formula of the law of a fit."""
    if isinstance(fit, ForceDecay):
        return "exponential, F ~ exp(-bz)"
    return "power law, F ~ z^-n"


def _constant(fit: Decay) -> str:
    """Return the constant of a fit with its standard error."""
    if isinstance(fit, ForceDecay):
        return f"{interval(fit.rate, fit.error)} per m"
    return interval(fit.exponent, fit.error)


def _peak_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return the sentences below the peak forces against depth."""
    notes = [
        _layer_notes(peaks),
        wave_notes(peaks),
        dynamic_notes(peaks),
        median_notes(peaks),
        decay_notes(peaks),
        _unknown_notes(peaks),
    ]
    return " ".join(filter(None, notes))


def _layer_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on the spheres whose forces are drawn; empty if each layer is one
    sphere.
    """
    if _have_medians(peaks):
        return "Largest and median sphere of each layer."
    return "Largest sphere of each layer." if _have_layers(peaks) else ""


def _have_medians(peaks: Mapping[ComparedRun, PeaksByDepth]) -> bool:
    """Return True if the layers of any run have several spheres, and a median force."""
    return _have_layers(peaks) and any(bool(_has_median(one).any()) for one in peaks.values())


def _have_layers(peaks: Mapping[ComparedRun, PeaksByDepth]) -> bool:
    """Return True if the layers of any run have several spheres."""
    return any((one.largest != one.median).any() for one in peaks.values())


def wave_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on the part of the run whose largest force is drawn."""
    first = [run.name for run, one in peaks.items() if one.of_first_wave]
    whole = [run.name for run, one in peaks.items() if not one.of_first_wave]
    parts = []
    is_common = not (first and whole)
    if first:
        names = "" if is_common else f" ({named(first, len(first))})"
        parts.append(f"of the first wave, before the reflection{names}")
    if whole:
        names = "" if is_common else f" ({named(whole, len(whole))})"
        parts.append(f"of the whole run, with any reflections{names}")
    if not any(one.is_later.any() for one in peaks.values()):
        return f"Largest forces {' and '.join(parts)}."
    return (
        f"Largest forces {' and '.join(parts)}. Markers without a line may include a reflection, "
        "and are not fitted."
    )


def _unknown_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return sentences on layers that are left out; empty if there are none."""
    return " ".join(filter(None, [_awaited_notes(peaks), _hidden_notes(peaks)]))


def _hidden_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on layers whose first peak the reflection hides; empty if there are
    none.
    """
    counts = _counts_of_runs({run: one.n_hidden for run, one in peaks.items()})
    if not counts:
        return ""
    return f"Without layers at which the reflection hides the peak of the first wave: {counts}."


def _awaited_notes(peaks: Mapping[ComparedRun, PeaksByDepth]) -> str:
    """Return a sentence on layers that a larger pulse may still reach; empty if there are none."""
    counts = _counts_of_runs({run: one.n_unknown for run, one in peaks.items()})
    if not counts:
        return ""
    reasons = "that a larger pulse may still reach after the end"
    if any(one.is_chain and one.n_unknown for one in peaks.values()):
        reasons += " or after the reflection"
    return f"Without layers {reasons}: {counts}."


def _counts_of_runs(counts: Mapping[ComparedRun, int]) -> str:
    """Return numbers of layers with the runs that have them; of many runs each number once, with
    its runs.
    """
    positive = {run: count for run, count in counts.items() if count}
    if len(positive) <= _MOST_NAMED:
        return ", ".join(f"{count} ({run.name})" for run, count in positive.items())
    names: dict[int, list[str]] = {}
    for run, count in positive.items():
        names.setdefault(count, []).append(run.name)
    return "; ".join(f"{count} ({', '.join(runs)})" for count, runs in names.items())


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
    table=decay_table,
)
