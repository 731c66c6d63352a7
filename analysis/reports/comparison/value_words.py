"""Sentences and notes on the values of a comparison of runs."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from granwave.analysis.document.model import named
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.measures.law_range import BEYOND_LAW, contacts_beyond_law
from granwave.analysis.reports.comparison.compared_value import MARK, PARTIAL, ComparedValue, factor
from granwave.analysis.reports.comparison.ends import AT_THE_END, have_unlike_ends
from granwave.analysis.reports.comparison.energy_inputs import have_unlike_inputs
from granwave.analysis.reports.comparison.subjects import (
    ComparedRun,
    names_in_words,
    names_with_cases,
)
from granwave.analysis.reports.comparison.values import SAME, differing_values, of_families

_HARDLY = 5e-3  # relative difference of values that a sentence leaves out next to larger ones
NOT_COMPARED = "Not compared, since they depend on the end time of a run"
_ALL_COMPLETE = "that are complete in every run"  # follows "results"
_COMPLETE = "that is complete in every run"  # follows "result"
_MOST_LABELS = 6  # truncated values that a sentence lists
_MOST_NAMED = 4  # runs with an equal value that a sentence lists
_UNLIKE_INPUTS = ", with dissimilar inputs"  # follows the ratio of packings and blocks
_IN_DIGITS = 1e-6  # relative difference below which results agree to a number of digits
_PERCENT = 100.0


def sentence(
    values: Sequence[ComparedValue],
    runs: Sequence[ComparedRun],
    *,
    asked: bool = False,
    stated: Collection[str] = (),
) -> str:
    """Return the value that differs most in a sentence, with both values and the ratio, and
    further values of other kinds in a second sentence.

    Of similar values only the first is used.

    Parameters
    ----------
    asked
        True if the values were requested by name, so that others may differ.
    stated
        Names of values that other sentences state.
    """
    main = _main_values(values, asked=asked)
    others_stated = any(value.name in stated for value in main)
    compared = [value for value in main if value.name not in stated]
    other = "other " if others_stated else ""
    different = differing_values(compared)
    if not different:
        if others_stated:
            return ""
        return _without_difference(values, compared, runs, asked=asked)
    is_truncated = any(value.is_cut for value in values)
    distinct = _distinct_values(different)
    if not distinct:
        largest = max(different, key=lambda value: value.spread)
        results = f"{other}results {_ALL_COMPLETE}" if is_truncated else f"{other}results"
        return f"{results[0].upper()}{results[1:]} {_agreement(largest)}."
    named_first = of_families(_most_different_first(distinct) if asked else distinct)
    most, *others = [_clause(value, names_with_cases(runs)) for value in named_first]
    most = f"{most}{_UNLIKE_INPUTS if have_unlike_inputs(runs) else ''}"
    if asked:
        return f"The requested values differ most in {'; '.join([most, *others])}."
    text = f"The {other}main results differ most in {most}."
    if is_truncated:
        text = f"Of the {other}results {_ALL_COMPLETE}, the largest difference is in {most}."
    if others:
        text = f"{text} Further differences: {'; '.join(others)}."
    return f"{text} {_uncounted(values, distinct, runs)}".rstrip()


def _uncounted(
    values: Sequence[ComparedValue], counted: Sequence[ComparedValue], runs: Sequence[ComparedRun]
) -> str:
    """Return a sentence on larger ratios in the table than those that a sentence counts, with the
    reasons; empty without them.
    """
    largest = max(value.spread for value in counted)
    names = {value.name for value in counted}
    parts: list[str] = []
    for value in values:
        reason = _why_uncounted(value, runs)
        if reason and value.name not in names and value.ratio and value.spread > largest:
            parts.append(f"{_in_sentence(value.label)} ({reason})")
    return f"Larger ratios that are not counted: {_listed_labels(parts)}." if parts else ""


def _why_uncounted(value: ComparedValue, runs: Sequence[ComparedRun]) -> str:
    """Return the reason for which a sentence does not count a value that has a ratio; empty for a
    value that it may count, and for a value at the arbitrary end of a run.
    """
    if value.is_main or value.name in AT_THE_END:
        return ""
    if value.is_of_input:
        return "it depends on the input, which differs"
    if value.incomplete:
        names = named([runs[place].name for place in sorted(value.incomplete)], _MOST_NAMED)
        return f"incomplete in {names}"
    return ""


def named_values(values: Sequence[ComparedValue], stated: Collection[str] = ()) -> list[str]:
    """Return the names of the values that `sentence` states; parameters as there."""
    compared = [value for value in _main_values(values) if value.name not in stated]
    return [value.name for value in of_families(_distinct_values(differing_values(compared)))]


def _main_values(values: Sequence[ComparedValue], *, asked: bool = False) -> list[ComparedValue]:
    """Return the values that a sentence may compare."""
    return [value for value in values if (value.is_complete if asked else value.is_main)]


def _distinct_values(different: Sequence[ComparedValue]) -> list[ComparedValue]:
    """Return the values that differ by enough for a sentence."""
    return [value for value in different if value.spread > _HARDLY and not value.is_negligible]


def _most_different_first(values: Sequence[ComparedValue]) -> list[ComparedValue]:
    """Return requested values in the order of their ratios: zeros next to numbers and different
    signs first, and values of which a run has none last.
    """
    return sorted(values, key=lambda value: (not value.has_complete_runs, -value.spread))


def _agreement(value: ComparedValue) -> str:
    """Return the largest difference of results that hardly differ, in words: in per cent, or as the
    number of digits in which they agree.
    """
    relative = math.expm1(value.spread)
    label = _in_sentence(value.label)
    if relative < _IN_DIGITS:
        digits = math.floor(-math.log10(relative))
        return f"agree to {digits} digits or more (largest difference: {label})"
    return f"differ by at most {plain(f'{_PERCENT * relative:.2g}')} % ({label})"


def _without_difference(
    values: Sequence[ComparedValue],
    compared: Sequence[ComparedValue],
    runs: Sequence[ComparedRun],
    *,
    asked: bool,
) -> str:
    """Return the sentence on runs whose compared values are equal, or that have none."""
    end = "an earlier end" if have_unlike_ends(runs) else "the end of a run"
    names = names_in_words([run.name for run in runs])
    is_truncated = any(value.is_cut for value in values)
    reasons = [f"{end} truncates it"] if is_truncated else []
    if any(value.is_growing for value in values):
        reasons.append("it still grows at the end of a run")
    is_alike = not any(value.differs_in_meaning for value in values)
    if not is_alike:
        are_packings = all(run.has_spheres for run in runs)
        who = "packings with and without walls" if are_packings else "packings and blocks"
        reasons.append(f"{who} define it differently")
    if any(value.is_limited for value in values):
        reasons.append("a boundary limits the plastic zone")
    if any(value.is_unresolved for value in values):
        reasons.append("the plastic zone of a run is not resolved")
    if reasons and not compared:
        which = "requested value" if asked else "result"
        state = "complete" if is_alike else "comparable"
        return f"No {which} is {state} in {names}: {', or '.join(reasons)}."
    if asked:
        return f"The requested values do not differ between {names}, or a run lacks them."
    if any(value.is_of_input and value.is_complete and value.spread > SAME for value in values):
        return "Only energies and sizes of the plastic zone differ, which depend on the input."
    has_truncated = any(value.is_truncated or value.incomplete for value in values)
    result = f"result {_COMPLETE}" if has_truncated else "result"
    return f"No {result} differs between {names}."


def equal_in_figures(values: Sequence[ComparedValue], runs: Sequence[ComparedRun]) -> str:
    """Return the sentence on runs of which only figures were requested, and whose values of these
    figures are equal; empty if a value differs, or is not complete in all runs.

    Parameters
    ----------
    values
        Values that describe the figures.
    """
    if differing_values(values) or not all(value.is_complete for value in values):
        return ""
    names = names_in_words([run.name for run in runs])
    labels = "; ".join(_in_sentence(value.label) for value in values)
    return f"Equal in {names}: {labels}. The curves and fits of the requested figures may differ."


def truncation_note(values: Sequence[ComparedValue]) -> str:
    """Return a sentence on values that an earlier end truncates; empty if there are none."""
    truncated = [value for value in values if value.is_truncated and not value.is_growing]
    labels = [_in_sentence(value.label) for value in truncated]
    if not labels:
        return ""
    return f"{NOT_COMPARED}: {_listed_labels(labels)}."


def partial_note(values: Sequence[ComparedValue], names: Sequence[str]) -> str:
    """Return sentences on the runs whose end truncates values of which other runs are compared, by
    the values that it truncates in the same runs; empty if there are none.

    Parameters
    ----------
    names
        Names of the runs: (n_runs,).
    """
    partial = [value for value in values if value.places_left_out]
    if not partial:
        return ""
    labels: dict[frozenset[int], list[str]] = {}
    for value in partial:
        labels.setdefault(value.incomplete, []).append(_in_sentence(value.label))
    parts: list[str] = []
    for places, of_places in labels.items():
        cut = named([names[place] for place in sorted(places)], _MOST_NAMED)
        parts.append(f"in {cut}: {_listed_labels(of_places)}")
    first, *others = parts
    more = "".join(f" {part[0].upper()}{part[1:]}." for part in others)
    return f"{PARTIAL} ({MARK} in tables), and not part of ratios, {first}.{more}"


def _listed_labels(labels: Sequence[str]) -> str:
    """Return labels of values, which may contain commas, in a list; of many labels the first."""
    left = len(labels) - _MOST_LABELS
    more = f" and {left} more" if left > 0 else ""
    return f"{'; '.join(labels[:_MOST_LABELS])}{more}"


def beyond_law_note(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on runs with contacts beyond the range of the law; empty without them."""
    counts = {run.name: contacts_beyond_law(run.run.summary) for run in runs}
    names = [f"{name} ({count})" for name, count in counts.items() if count]
    if not names:
        return ""
    return (
        f"Contacts beyond overlaps of 0.2 R*, the limit of the law: {named(names, _MOST_NAMED)}. "
        f"Forces, overlaps and dissipation of these runs are extrapolated ({BEYOND_LAW} in tables)."
    )


def _clause(value: ComparedValue, names: Sequence[str]) -> str:
    """Return label, values and ratio: ``peak force 1.2 kN (a) and 2.4 kN (b), a factor of 2``."""
    label = _in_sentence(value.label)
    numbers = value.numbers
    joint = "and"
    if len(numbers) > 2:
        numbers = [min(numbers), max(numbers)]
        joint = "to"
    first, last = [_end_in_words(value, size, names) for size in numbers]
    text = f"{label}, {first} {joint} {last}"
    if value.ratio is None:
        return text
    return f"{text}, a ratio of {factor(value.ratio)}"


def _end_in_words(value: ComparedValue, size: float, names: Sequence[str]) -> str:
    """Return a value with the runs that have it: ``1.2 kN (a)``; with the mark of contacts beyond
    the range of the law.
    """
    mark = f" {BEYOND_LAW}" if value.beyond_law & frozenset(_places_with(value, size)) else ""
    return f"{value.text(size)}{mark} ({_runs_with(value, size, names)})"


def _places_with(value: ComparedValue, size: float) -> list[int]:
    """Return the positions of the runs in which a value has a size."""
    return [
        place
        for place, number in enumerate(value.values)
        if number is not None and math.isclose(number, size, rel_tol=SAME)
    ]


def _runs_with(value: ComparedValue, size: float, names: Sequence[str]) -> str:
    """Return the names of the runs in which a value has a size; of many runs the first names."""
    return named([names[place] for place in _places_with(value, size)], _MOST_NAMED)


def _in_sentence(label: str) -> str:
    """Return a label within a sentence."""
    return label[:1].lower() + label[1:]
