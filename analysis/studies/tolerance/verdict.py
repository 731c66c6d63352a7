"""Share of the ideal packing's performance that is left, in plain words, with the confidence of every number."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from granwave.analysis.formatting.numbers import number, with_interval
from granwave.analysis.statistics import Estimate, crossing, differ_significantly, seeds_needed
from granwave.analysis.studies.tolerance.axes import Axis, axes_of, told
from granwave.analysis.studies.tolerance.quantities import DISSIPATED, FORCE, PLASTIC, Measured, Quantity, cut_short
from granwave.analysis.studies.tolerance.runs import IDEAL, Setting

KEPT = 0.9  # of the ideal packing's performance: how large may a tolerance be?
_SAME = 0.005
_MOST_NAMED = 6  # pairs that cannot be told apart
_PRECISE = 0.1  # of the mean: the half-width that a number of seeds is told for


def verdict(measured: Measured, *, asked: bool = False) -> tuple[str, ...]:
    """Say what is left at worst, then a sentence or two for each kind of imperfection and each measure of performance.

    Parameters
    ----------
    asked
        The ideal packing is a point of the scan. Where it is not among the runs and was not asked for, there is nothing
        to compare with, and nothing is said.
    """
    packing = measured.packing
    if IDEAL not in packing.runs:
        said = (
            "The ideal packing (no scatter, no friction) has not finished, so that it cannot be said how much of its "
            "performance is left."
        )
        return (said,) if asked else ()
    axes = axes_of(packing)
    lines = list(_at_worst(measured))
    for axis in axes:
        along = axis.along(packing)
        if len(along) < 2:
            continue
        for quantity in measured.performance:
            same = quantity is PLASTIC and not any(setting.friction for setting in along)  # as all that is dissipated
            if _known(measured, quantity) and not same:
                lines.append(_of_axis(measured, quantity, axis, along))
    return (*lines, *_doubts(measured))


def as_percent(value: Estimate) -> str:
    """A share with its interval: ``16 ± 1.5 %``."""
    return with_interval(value.over(0.01), unit="%")


def tolerance(measured: Measured, quantity: Quantity, axis: Axis, *, surely: bool = False) -> float | None:
    """Up to which imperfection 90 % of the ideal's performance is kept, straight between the settings that were run.

    Parameters
    ----------
    surely
        By the lower end of the confidence intervals, not by the means.

    Returns
    -------
    float or None
        In the unit of the axis; None where 90 % is kept everywhere, or nothing is known.
    """
    found = [(axis.of(setting), measured.left(quantity, setting)) for setting in axis.along(measured.packing)]
    known = [(place, left) for place, left in found if left is not None]
    if surely:
        known = [(place, left) for place, left in known if math.isfinite(left.half_width)]
    return crossing([place for place, _ in known], [left.low if surely else left.mean for _, left in known], KEPT)


def _at_worst(measured: Measured) -> Iterator[str]:
    """Summarise each measure of performance in the worst of all settings."""
    axes, parts = axes_of(measured.packing), []
    for quantity in measured.performance:
        found = {s: left for s in measured.packing.settings if (left := measured.left(quantity, s)) and s != IDEAL}
        if not found:
            continue
        worst = min(found, key=lambda setting: found[setting].mean)
        ideal, value = measured.of(quantity, IDEAL), measured.of(quantity, worst)
        assert ideal is not None and value is not None
        if found[worst].mean >= 1 or differ_significantly(ideal, value) is False:
            parts.append(f"the {quantity.words} nowhere {'higher' if quantity.better == 'less' else 'lower'}")
        else:
            share = as_percent(value.over(ideal.mean))
            parts.append(f"the {quantity.words} at worst {share}, at {told(worst, axes)}")
    if parts:
        yield f"Against the ideal packing's: {'; '.join(parts)}."


def _known(measured: Measured, quantity: Quantity) -> bool:
    ideal = measured.of(quantity, IDEAL)
    return ideal is not None and ideal.exact and ideal.mean != 0


def _of_axis(measured: Measured, quantity: Quantity, axis: Axis, along: Sequence[Setting]) -> str:
    """Describe the course of one quantity along one axis."""
    known = [setting for setting in along if measured.of(quantity, setting) is not None]
    ideal, last = measured.of(quantity, IDEAL), measured.of(quantity, known[-1])
    assert ideal is not None and last is not None
    place, share = axis.show(axis.of(known[-1])), as_percent(last.over(ideal.mean))
    numbers = f"{_in_unit(last, quantity)}{_seeds(measured, known[-1])}; ideal: {_in_unit(ideal, quantity)}"
    text = f"At {axis.words} {place} the {quantity.words} is {share} of the ideal packing's ({numbers})."
    return f"{text} {_kept(measured, quantity, axis, along)}"


def _in_unit(value: Estimate, quantity: Quantity) -> str:
    return with_interval(value, quantity.scale, quantity.unit)


def _seeds(measured: Measured, setting: Setting) -> str:
    n = measured.seeds(setting)
    if setting not in measured.random:
        return ""
    return f", {n} seeds" if n > 1 else ", one seed: its confidence is not known"


def _kept(measured: Measured, quantity: Quantity, axis: Axis, along: Sequence[Setting]) -> str:
    place = tolerance(measured, quantity, axis)
    surely = tolerance(measured, quantity, axis, surely=True)
    left = [found.mean for setting in along if (found := measured.left(quantity, setting))]
    if place is None and surely is None and min(left, default=0.0) >= 1:
        return f"Nowhere is it {'higher' if quantity.better == 'less' else 'lower'} than the ideal packing's."
    share = f"{100 * KEPT:.0f} % of the ideal packing's or more"
    if quantity.better == "less":
        share = f"at most {100 / KEPT:.0f} % of the ideal packing's"
    if place is None:
        text = f"It is {share} at every {axis.words} tried"
        return f"{text}." if surely is None else f"{text}; with confidence up to {axis.show(surely)} only."
    tried = [axis.of(setting) for setting in along]
    below = max((value for value in tried if value <= place), default=0.0)
    above = min((value for value in tried if value > place), default=tried[-1])
    between = f"between {below:g} and {axis.show(above)}"
    if surely is not None and surely < place * (1 - _SAME):
        between += f"; with confidence up to {axis.show(surely)}"
    return f"It is {share} up to about {axis.show(place)} ({between})."


def _doubts(measured: Measured) -> Iterator[str]:
    """Say which differences the seeds do not resolve, and how many seeds would."""
    for quantity in (FORCE, DISSIPATED):
        alike = list(_alike(measured, quantity))
        if alike:
            more = f"; and {len(alike) - _MOST_NAMED} more" if len(alike) > _MOST_NAMED else ""
            named = "; ".join(alike[:_MOST_NAMED]) + more
            yield f"By {quantity.words} these cannot be told apart with the seeds there are: {named}."
    short = sum(cut_short(run) for runs in measured.packing.runs.values() for run in runs)
    if short:
        yield (
            f"In {short} runs the force on the bottom was largest at their very end, so that it may have grown on: "
            "follow them longer (run.end_time)."
        )
    wanted = _most_uncertain(measured)
    if wanted is not None:
        setting, value = wanted
        n = seeds_needed(value.deviation, _PRECISE * abs(value.mean))
        enough = "which there are" if n <= value.n else f"there are {value.n}"
        yield (
            f"The {FORCE.words} differs most from seed to seed at {told(setting)}: by {number(value.deviation)} N "
            f"(standard deviation); its mean to ± {100 * _PRECISE:.0f} % takes {n} seeds, {enough}."
        )


def _alike(measured: Measured, quantity: Quantity) -> Iterator[str]:
    """Neighbouring settings whose means may be equal."""
    for axis in axes_of(measured.packing):
        for base in axis.bases(measured.packing):
            found = [(setting, measured.of(quantity, setting)) for setting in axis.along(measured.packing, base)]
            there = [(setting, value) for setting, value in found if value is not None]
            beside = "" if base == IDEAL else f" at {told(base)}"
            for (first, one), (second, other) in pairwise(there):
                if differ_significantly(one, other) is False:
                    yield f"{axis.words} {axis.of(first):g} and {axis.show(axis.of(second))}{beside}"


def _most_uncertain(measured: Measured) -> tuple[Setting, Estimate] | None:
    found = [(setting, measured.of(FORCE, setting)) for setting in measured.random]
    known = [(s, one) for s, one in found if one is not None and one.n > 1 and one.mean and one.deviation > 0]
    return max(known, key=lambda pair: (pair[1].deviation / abs(pair[1].mean), pair[0]), default=None)
