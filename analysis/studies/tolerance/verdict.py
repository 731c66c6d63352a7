"""Share of the ideal packing's performance that is left, in plain words, with the confidence of every number."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.formatting.numbers import number, with_interval
from granwave.analysis.measures.target import reached
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import crossing, differ_significantly, seeds_needed
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.tolerance.packings import Packing
from granwave.analysis.studies.tolerance.quantities import DISSIPATED, FORCE, PLASTIC, Quantity
from granwave.analysis.studies.tolerance.settings import IDEAL, Axis, Setting, is_ideal, told

KEPT = 0.9  # of the ideal packing's performance: how large may a tolerance be?
_SAME = 0.005
_MOST_NAMED = 6  # pairs that cannot be told apart
_PRECISE = 0.1  # of the mean: the half-width that a number of seeds is told for
_LATE = 0.05  # of a run


def verdict(packing: Packing) -> Iterator[str]:
    """Say what is left at worst, then a sentence or two for each kind of imperfection and each measure of performance.

    Without the ideal packing there is nothing to compare with, and nothing is said.
    """
    if IDEAL not in packing.runs:
        return
    yield from _at_worst(packing)
    for axis in packing.axes:
        along = packing.along(axis)
        if len(along) < 2:
            continue
        for quantity in packing.performance:
            same = quantity is PLASTIC and not any(setting.friction for setting in along)  # as all that is dissipated
            if packing.over_ideal(quantity, IDEAL) and not same:
                yield _of_axis(packing, quantity, axis, along)
    yield from _doubts(packing)


def missing(packing: Packing, undone: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Say that the ideal packing has not finished, where it was asked for."""
    if IDEAL not in packing.runs and any(is_ideal(labels, packing.case) for labels in undone):
        yield (
            "The ideal packing (no scatter, no friction) has not finished, so that it cannot be said how much of its "
            "performance is left."
        )


def tolerance(packing: Packing, quantity: Quantity, axis: Axis, *, surely: bool = False) -> float | None:
    """Largest imperfection that leaves 90 % of the performance, straight between the settings that were run.

    Parameters
    ----------
    surely
        By the lower end of the confidence intervals, not by the means.

    Returns
    -------
    float or None
        In the unit of the axis; None where 90 % is kept everywhere, or nothing is known.
    """
    found = [(axis.of(setting), packing.left(quantity, setting)) for setting in packing.along(axis)]
    known = [(place, left) for place, left in found if left and (math.isfinite(left.half_width) or not surely)]
    return crossing([place for place, _ in known], [left.low if surely else left.mean for _, left in known], KEPT)


def _at_worst(packing: Packing) -> Iterator[str]:
    """Summarise each measure of performance in the worst of all settings."""
    parts = []
    for quantity in packing.performance:
        found = {s: left for s in packing.settings if (left := packing.left(quantity, s)) and s != IDEAL}
        if not found:
            continue
        worst, best = (choose(found, key=lambda setting: found[setting].mean) for choose in (min, max))
        if found[worst].mean >= 1 or _differ(packing, quantity, IDEAL, worst) is False:
            parts.append(f"{_from_to(packing, quantity, best)} and is nowhere {_worse(quantity)}")
        else:
            parts.append(_from_to(packing, quantity, worst, " at worst"))
    if parts:
        yield f"Against the ideal packing {'; '.join(parts)}."


def _from_to(packing: Packing, quantity: Quantity, setting: Setting, how: str = "") -> str:
    """Say how far a quantity goes from that of the ideal packing: ``from 1680 N to 1010 N (60 %, at ...)``."""
    values = f"from {_value(packing, quantity, IDEAL)} to {_value(packing, quantity, setting)}"
    return f"the {quantity.words} goes {values}{how} ({_share(packing, quantity, setting)}, at {told(setting)})"


def _of_axis(packing: Packing, quantity: Quantity, axis: Axis, along: Sequence[Setting]) -> str:
    """Describe the course of one quantity along one axis."""
    last = [setting for setting in along if packing.of(quantity, setting)][-1]
    numbers = f"{_value(packing, quantity, last)}{_seeds(packing, last)}; ideal: {_value(packing, quantity, IDEAL)}"
    return (
        f"At {axis.words} {axis.show(axis.of(last))} the {quantity.words} is {_share(packing, quantity, last)} of the "
        f"ideal packing's ({numbers}). {_kept(packing, quantity, axis, along)}"
    )


def _share(packing: Packing, quantity: Quantity, setting: Setting) -> str:
    """A share of the ideal packing's value with its interval: ``16 ± 1.5 %``."""
    share = packing.over_ideal(quantity, setting)
    assert share is not None
    return with_interval(share.over(0.01), unit="%")


def _value(packing: Packing, quantity: Quantity, setting: Setting) -> str:
    value = packing.of(quantity, setting)
    assert value is not None
    return with_interval(value, quantity.scale, quantity.unit)


def _seeds(packing: Packing, setting: Setting) -> str:
    n = packing.seeds(setting)
    if not packing.random(setting):
        return ""
    return f", {n} seeds" if n > 1 else ", one seed: its confidence is not known"


def _worse(quantity: Quantity) -> str:
    return "higher" if quantity.better == "less" else "lower"


def _kept(packing: Packing, quantity: Quantity, axis: Axis, along: Sequence[Setting]) -> str:
    """Say up to which imperfection nearly all of the performance is kept."""
    place = tolerance(packing, quantity, axis)
    surely = tolerance(packing, quantity, axis, surely=True)
    left = [found.mean for setting in along if (found := packing.left(quantity, setting))]
    if place is None and surely is None and min(left, default=0.0) >= 1:
        return f"Nowhere is it {_worse(quantity)} than the ideal packing's."
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


def _doubts(packing: Packing) -> Iterator[str]:
    """Say which differences the seeds do not resolve, and how many seeds would."""
    for quantity in (FORCE, DISSIPATED):
        alike = list(_alike(packing, quantity))
        if alike:
            more = f"; and {len(alike) - _MOST_NAMED} more" if len(alike) > _MOST_NAMED else ""
            named = "; ".join(alike[:_MOST_NAMED]) + more
            yield f"By {quantity.words} these cannot be told apart with the seeds there are: {named}."
    short = sum(_cut_short(run) for runs in packing.runs.values() for run in runs)
    if short:
        yield (
            f"In {short} runs the force on the bottom was largest at their very end, so that it may have grown on: "
            "follow them longer (run.end_time)."
        )
    found = [(setting, packing.of(FORCE, setting)) for setting in packing.settings if packing.random(setting)]
    known = [(s, one) for s, one in found if one and one.n > 1 and one.mean and one.deviation > 0]
    if known:
        setting, value = max(known, key=lambda pair: (pair[1].deviation / abs(pair[1].mean), pair[0]))
        n = seeds_needed(value.deviation, _PRECISE * abs(value.mean))
        enough = "which there are" if n <= value.n else f"there are {value.n}"
        yield (
            f"The {FORCE.words} differs most from seed to seed at {told(setting)}: by {number(value.deviation)} N "
            f"(standard deviation); its mean to ± {100 * _PRECISE:.0f} % takes {n} seeds, {enough}."
        )


def _alike(packing: Packing, quantity: Quantity) -> Iterator[str]:
    """Neighbouring settings whose means may be equal."""
    for axis in packing.axes:
        for base in packing.bases(axis):
            beside = "" if base == IDEAL else f" at {told(base)}"
            known = [setting for setting in packing.along(axis, base) if packing.of(quantity, setting)]
            for first, second in pairwise(known):
                if _differ(packing, quantity, first, second) is False:
                    yield f"{axis.words} {axis.of(first):g} and {axis.show(axis.of(second))}{beside}"


def _differ(packing: Packing, quantity: Quantity, first: Setting, second: Setting) -> bool | None:
    one, other = packing.of(quantity, first), packing.of(quantity, second)
    assert one is not None and other is not None
    return differ_significantly(one, other)


def _cut_short(run: FinishedRun) -> bool:
    """The force on the bottom was largest in the last part of the run, so that it may have grown on."""
    try:
        with Result(run.directory) as result:
            found = reached(result)
    except (MissingOutputError, OutputFormatError):  # only the summary was kept
        return False
    return found is not None and bool(found.time[found.force.argmax()] > (1 - _LATE) * found.time[-1])
