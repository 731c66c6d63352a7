"""Sentences that compare the protection by several runs: force on the bottom, depth of the zone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from granwave.analysis.document.model import named
from granwave.analysis.formatting.numbers import number, plain, quantity_in
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.measures.zone_size import Mark, mark_of
from granwave.analysis.reports.comparison.curves import (
    has_peak_at_bottom,
    static_force_at_bottom,
)
from granwave.analysis.reports.comparison.ends import GROWING, truncated_runs
from granwave.analysis.reports.comparison.energy_inputs import have_same_input
from granwave.analysis.reports.comparison.subjects import ComparedRun, names_in_words
from granwave.analysis.reports.setting import target_of

_FORCE = "wall_peak_force_N"
_REDUCTION = "peak_reduction"
_SPHERES = "n_spheres"
_DEPTH = "zone_depth_90_interpolated_m"
#: Values that the sentences state, directly or as their ratio.
_OF_FORCE = (_FORCE, "wall_dynamic_peak_force_N", "target_peak_force_N", _REDUCTION)
_OF_DEPTH = (_DEPTH, "zone_depth_90_m")
_DEPTH_OF_ZONE = "The 90 % depth of the plastic zone, interpolated between layers,"
#: Ratio of a value to the best one.
_TIMES_HIGH = "{} times as high"
_TIMES_DEEP = "{} times as deep"
_SAME = 5e-3  # relative difference of results that are called equal
_IN_DIGITS = 1e-6  # relative difference below which results agree to a number of digits
_ROUNDING = 1e-12  # relative difference of results that differ by rounding only
_MOST_LISTED = 4  # runs that a sentence lists; of more the best and the worst
_LEAST_RUNS = 2
_COLLISION = (1, 2)  # numbers of spheres without layers


@dataclass(frozen=True)
class _Entry:
    """A run with its value, m, N or 1."""

    name: str
    value: float


@dataclass(frozen=True)
class Ranking:
    """Order of runs by a value.

    Attributes
    ----------
    sentence
        Sentence with the order and the values.
    names
        Values of the summaries that it states, directly or as their ratio.
    """

    sentence: str
    names: tuple[str, ...]


@dataclass(frozen=True)
class _Phrase:
    """Templates of a sentence that orders runs by a value.

    Attributes
    ----------
    best
        Takes the name of the best run, the degree, and its value.
    best_equal
        The same for the names of several runs with this value.
    equal
        Takes the value that all runs have.
    times
        Takes the ratio of a value to the best one.
    of_two, of_more
        Degree, of two runs and of more.
    """

    best: str
    best_equal: str
    equal: str
    times: str
    of_two: str
    of_more: str


def protection_sentences(runs: Sequence[ComparedRun], names: Sequence[str]) -> list[str]:
    """Return the sentences of `protection_rankings`."""
    return [ranking.sentence for ranking in protection_rankings(runs, names)]


def protection_rankings(
    runs: Sequence[ComparedRun], names: Sequence[str], dependence: str = ""
) -> list[Ranking]:
    """Return the orders of the runs by their protection, with all values and their ratios.

    Runs with the same input are ordered by the peak force on the bottom, above its static force if
    there is one; others by the peak force relative to the impact without the packing. Runs
    that end before the wave reaches the bottom, or whose force there still rises at the end, are
    left out. Values that an earlier end of a run truncates are not ranked. The second sentence
    orders the runs by the interpolated depth of 90 % of the plastic dissipation; it leaves out
    collisions of two spheres, and zones that reach a boundary or still grow, and there is none with
    different inputs. The module `definitions` names these runs.

    Parameters
    ----------
    names
        Names of the runs in sentences: (n_runs,).
    dependence
        Settings of the model, if the runs differ in nothing else; the sentences then state that
        the values depend on them, and no run protects better. See `models.model_dependence`.
    """
    rankings: list[Ranking] = []
    if force := _force_sentence(runs, names, dependence):
        rankings.append(Ranking(force, _OF_FORCE))
    if depth := _depth_sentence(runs, names, dependence):
        rankings.append(Ranking(depth, _OF_DEPTH))
    return rankings


def _force_sentence(runs: Sequence[ComparedRun], names: Sequence[str], dependence: str) -> str:
    """Return the order of the runs by the peak force below the packing; empty without one."""
    place = "target" if all(target_of(run.run.case) for run in runs) else "bottom"
    compared = names
    early = truncated_runs([_FORCE], runs).get(_FORCE, ())
    kept = [n for n, run in enumerate(runs) if has_peak_at_bottom(run) and run not in early]
    runs = [runs[n] for n in kept]
    names = [names[n] for n in kept]
    if have_same_input([run for run in runs if run.run.number(_FORCE)]):
        static = [static_force_at_bottom(run) for run in runs]
        force = "peak dynamic force" if any(static) else "peak force"
        entries = _entries(_FORCE, runs, names, static)
        phrase = _phrase_of_force(force, place)
        if dependence:
            phrase = _phrase_of_dependence(f"The {force} on the {place}", dependence, _TIMES_HIGH)
        return _ordered(phrase, entries, partial(quantity_in, unit="N"), compared)
    relative = [_Entry(entry.name, 1 / entry.value) for entry in _entries(_REDUCTION, runs, names)]
    name = (
        f"Inputs differ; the peak force on the {place} relative to the same impact without the "
        "packing"
    )
    phrase = _phrase_of_reduction(name)
    if dependence:
        phrase = _phrase_of_dependence(name, dependence, _TIMES_HIGH)
    return _ordered(phrase, relative, number, compared)


def _phrase_of_force(force: str, place: str) -> _Phrase:
    """Return the templates for the force on the bottom.

    Parameters
    ----------
    force
        Name of the force.
    place
        Place of the force: bottom or target.
    """
    return _Phrase(
        f"{{}} protects the {place} {{}}: its {force} is {{}}",
        f"{{}} protect the {place} {{}}: their {force} is {{}}",
        f"The {force} on the {place} is {{}}",
        _TIMES_HIGH,
        "better",
        "best",
    )


def _phrase_of_reduction(relative: str) -> _Phrase:
    """Return the templates for the force relative to the impact without the packing, from its
    name.
    """
    ordered = f"{relative} is {{1}}, {{2}}, in {{0}}"
    return _Phrase(ordered, ordered, f"{relative} is {{}}", _TIMES_HIGH, "lower", "lowest")


def _phrase_of_dependence(value: str, dependence: str, times: str) -> _Phrase:
    """Return the templates for a value that depends on settings of the model, and ranks no runs.

    Parameters
    ----------
    value
        Name of the value, at the beginning of a sentence.
    dependence
        As of `protection_rankings`.
    times
        As of `_Phrase`.
    """
    settings = dependence.replace("{", "{{").replace("}", "}}")  # names of runs may have braces
    depends = f"{value} depends on {settings}: it is {{2}} in {{0}}"
    return _Phrase(depends, depends, f"{value} is {{}}", times, "", "")


def _depth_sentence(runs: Sequence[ComparedRun], names: Sequence[str], dependence: str) -> str:
    """Return the order of the runs by the depth of the plastic zone; empty without two zones."""
    if not have_same_input([run for run in runs if run.run.number(_DEPTH)]):
        return ""
    complete = [place for place, run in enumerate(runs) if _has_complete_zone(run)]
    early = truncated_runs([_DEPTH], [runs[place] for place in complete]).get(_DEPTH, ())
    complete = [place for place in complete if runs[place] not in early]
    entries = _entries(
        _DEPTH, [runs[place] for place in complete], [names[place] for place in complete]
    )
    phrase = _phrase_of_depth()
    if dependence:
        phrase = _phrase_of_dependence(_DEPTH_OF_ZONE, dependence, _TIMES_DEEP)
    text = _ordered(phrase, entries, partial(quantity_in, unit="m"), names)
    without = [
        name
        for run, name in zip(runs, names, strict=True)
        if not run.run.number(_DEPTH) and run.has_spheres
    ]
    if not text or not without or len(without) > _MOST_LISTED:
        return text
    return f"{text} No plastic dissipation below the impact: {', '.join(without)}."


def _phrase_of_depth() -> _Phrase:
    """Return the templates for the depth of the plastic zone."""
    return _Phrase(
        "{} has the {} plastic zone: its 90 % depth, interpolated between layers, is {}",
        "{} have the {} plastic zones: their 90 % depth, interpolated between layers, is {}",
        f"{_DEPTH_OF_ZONE} is {{}}",
        _TIMES_DEEP,
        "shallower",
        "shallowest",
    )


def _has_complete_zone(run: ComparedRun) -> bool:
    """Return True if neither a boundary nor the end of the run limits the depth of the zone."""
    summary = run.run.summary
    is_collision = run.run.number(_SPHERES) in _COLLISION
    growing = summary.get(GROWING) or ()
    is_whole = mark_of(summary) is not Mark.CUT and "depth" not in growing
    return not is_collision and is_whole and not is_unresolved(summary)


def _ordered(
    phrase: _Phrase,
    entries: Sequence[_Entry],
    text: Callable[[float], str],
    compared: Sequence[str],
) -> str:
    """Return the runs in the order of their values; empty for fewer than two.

    Parameters
    ----------
    compared
        Names of the runs of the comparison, also without such a value.
    """
    if len(entries) < _LEAST_RUNS:
        return ""
    rising = sorted(entries, key=lambda entry: entry.value)
    first = rising[0]
    last = rising[-1]
    if last.value <= first.value * (1 + _SAME):
        return _equal(phrase, rising, text, compared)
    degree = phrase.of_two if len(rising) == _LEAST_RUNS else phrase.of_more
    equal = [entry for entry in rising if entry.value <= first.value * (1 + _SAME)]
    names: dict[tuple[str, str], list[str]] = {}
    for entry in rising[len(equal) :]:
        ratio = phrase.times.format(number(entry.value / first.value))
        names.setdefault((text(entry.value), ratio), []).append(entry.name)
    parts = [
        f"{value} in {names_in_words(runs)} ({ratio})" for (value, ratio), runs in names.items()
    ]
    best = phrase.best.format(first.name, degree, text(first.value))
    if len(equal) > 1:
        listed = names_in_words([entry.name for entry in equal])
        values = dict.fromkeys([text(first.value), text(equal[-1].value)])
        best = phrase.best_equal.format(listed, degree, " to ".join(values))
    if len(rising) > _MOST_LISTED:
        ranked = {entry.name for entry in rising}
        others = [name for name in compared if name not in ranked]
        which = f"{len(rising)} ranked runs" if others else f"{len(rising)} runs"
        text_of_largest = f"{best}. The largest value of the {which} is {parts[-1]}"
        if not others:
            return f"{text_of_largest}."
        return f"{text_of_largest}; not ranked: {named(others, _MOST_LISTED)}."
    listed = " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))
    return f"{best}, compared with {listed}."


def _equal(
    phrase: _Phrase, rising: Sequence[_Entry], text: Callable[[float], str], compared: Sequence[str]
) -> str:
    """Return the sentence on runs whose values hardly differ, as of `_ordered`; with the smallest
    and the largest value, unless they are equal with the digits of a sentence.
    """
    first = rising[0]
    last = rising[-1]
    difference = last.value / first.value - 1
    percent = plain(f"{100 * difference:.1g}")
    runs = "both runs" if len(rising) == _LEAST_RUNS else f"all {len(rising)} runs"
    if len(rising) < len(compared):
        runs = names_in_words([entry.name for entry in rising])
    least = text(first.value)
    most = text(last.value)
    if least == most:
        return f"{phrase.equal.format(least)} in {runs}, {_agreement(difference, percent)}."
    if len(rising) == _LEAST_RUNS:
        values = f"{least} in {first.name} and {most} in {last.name}"
        return f"{phrase.equal.format(values)}, {percent} % apart."
    values = f"between {least} ({first.name}) and {most} ({last.name})"
    return f"{phrase.equal.format(values)} in {runs}, at most {percent} % apart."


def _agreement(difference: float, percent: str) -> str:
    """Return a relative difference, and its text in per cent, in words."""
    if difference < _ROUNDING:
        return "equal to within rounding"
    if difference < _IN_DIGITS:
        return f"equal to {math.floor(-math.log10(difference))} digits or more"
    return f"within {percent} %"


def _entries(
    key: str,
    runs: Sequence[ComparedRun],
    names: Sequence[str],
    subtracted: Sequence[float] | None = None,
) -> list[_Entry]:
    """Return the runs that have a value above zero.

    Parameters
    ----------
    subtracted
        Subtracted from the value of each run, such as its static force, N: (n_runs,).
    """
    entries: list[_Entry] = []
    for place, (run, name) in enumerate(zip(runs, names, strict=True)):
        value = run.run.number(key) or 0.0
        if subtracted is not None:
            value -= subtracted[place]
        if value > 0 and run.run.number(_SPHERES) != 1:  # one sphere is the impact without packing
            entries.append(_Entry(name, value))
    return entries
