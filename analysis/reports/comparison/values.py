"""Values of the summaries of several runs: which differ most, by which factor."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from granwave.analysis.document.model import Cell, label_of, named, unit_of_value
from granwave.analysis.errors import did_you_mean
from granwave.analysis.formatting.numbers import (
    interval_in_any_unit,
    number,
    plain,
    quantity_in,
)
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.zone_resolution import error_of, percent_with_error
from granwave.analysis.quantities import quantities, report_columns
from granwave.analysis.reports.comparison.ends import (
    AT_THE_END,
    growing_names,
    has_few_complete,
    have_unlike_ends,
    is_limited_by_end,
    is_zone_size,
    limited_names,
    truncated_runs,
    unresolved_names,
)
from granwave.analysis.reports.comparison.energy_inputs import have_same_input
from granwave.analysis.reports.comparison.subjects import (
    MOST_SIDE_BY_SIDE,
    ComparedRun,
    names_in_words,
    names_with_cases,
)
from granwave.analysis.reports.sentences import share
from granwave.analysis.summary_table import has_no_pairs

#: Values that are no results: input, method, and accuracy.
_NO_OUTCOME = (
    "energy_input_J", "energy_input_normalised", "velocity_normalised", "energy_balance_error",
    "energy_balance_accepted", "deck_changed", "n_spheres", "n_elements", "n_cylinders",
    "n_contacts", "end_time_s", "wall_time_s", "contacts_beyond_law", "zone_cut",
    "sides_periodic", "wave_return_share",
    "packing_mass_kg", "packing_height_m", "unprotected_peak_force_N",
    "unprotected_ground_peak_force_N", "dissipated_fraction_error", "artificial_viscosity_fraction",
)  # fmt: skip
#: Values that kinds of runs do not share, or define in another way.
_OF_ONE_KIND = (
    "plastic_zone_volume_m3", "plastic_zone_depth_m", "plastic_zone_radius_m", "peak_force_N",
    "impactor_velocity_m_s",
)  # fmt: skip
#: Values that are left out where they equal another value in every run.
_REPEATING = (
    "ground_peak_force_N", "target_peak_force_N", "peak_force_with_walls_N", "plastic_fraction",
    "ground_peak_reduction",
)  # fmt: skip
#: Beginnings of the names of similar values; a sentence has only one of each.
_FAMILIES = (
    ("plastic_fraction", "dissipated_fraction", "energy_dissipated"),
    ("n_plastic", "n_dissipating"),
    ("plastic_zone", "zone_"),
    ("peak_force",),
    ("wall_", "unprotected", "ground", "target", "energy_target", "peak_reduction"),
)
#: Results of summaries that the tables of results in reports do not have.
_FURTHER = ("energy_dissipated_J", "energy_kinetic_J", "peak_overlap_m", "restitution")
#: Values of the contacts between spheres, which a run without loaded contacts does not have.
_OF_PAIRS = ("peak_force_N", "peak_force_error_N", "peak_overlap_m")
_WITH_WALLS = "peak_force_with_walls_N"
_OF_PARTS = ("sensor_", "line_", "wall_")  # beginnings of values of a part that has a name
_ROUNDING = 1e-12  # value / largest value of the runs that counts as zero
_SAME = 1e-9  # relative difference of values that are equal
_NO_FRACTION = 1e-3  # fraction that counts as zero next to zero
_HARDLY = 5e-3  # relative difference of values that a sentence leaves out next to larger ones
#: In place of the ratio of a value that the end of a run truncates, that still grows at this end,
#: or that a boundary limits.
TRUNCATED = "truncated"
STILL_GROWING = "still growing"
NOT_COMPARED = "Not compared, since they depend on the end time of a run"
LIMITED = "limited"
#: The same for a value of a plastic zone that the mesh of a run does not resolve.
NOT_RESOLVED = "not resolved"
#: The same for a value that kinds of runs define differently.
DIFFERENT_MEANING = "defined differently"
MARK = "*"  # after a value that the end of its run truncates
PARTIAL = "Truncated by the end of the run"
_PAIR = 2
_IN_SENTENCE = 3
_ALL_COMPLETE = "that are complete in every run"  # follows "results"
_COMPLETE = "that is complete in every run"  # follows "result"
_MOST_LABELS = 6  # truncated values that a sentence lists
_MOST_NAMED = 4  # runs with an equal value that a sentence lists
_IN_DIGITS = 1e-6  # relative difference below which results agree to a number of digits
_FRACTION = "_fraction"  # end of the names of fractions
_PERCENT = 100.0
_JOULE = "J"


@dataclass(frozen=True)
class ComparedValue:
    """A value of the summary in each run.

    Attributes
    ----------
    name
        Its key in summary.json.
    values
        By run; None where a run does not have it: (n_runs,).
    label
        Name in words.
    unit
        SI unit; empty if there is none.
    is_truncated
        True if ends of runs truncate it so that too few runs are complete, or if it still grows; it
        then has no ratio.
    incomplete
        Positions of the runs whose end truncates it; the ratio is of the other runs.
    is_limited
        True for a size of plastic zones of which a boundary limits at least one, so that it has no
        ratio.
    is_growing
        True for a truncated value if it still grows at the end of a run.
    is_of_input
        True for an energy in J or a size of the plastic zone, of runs with different inputs, which
        depends on the input.
    differs_in_meaning
        True for a value that the kinds of these runs define differently, so that it has no ratio.
    is_unresolved
        True for a value of plastic zones of which the mesh of a run does not resolve at least one,
        so that it has no ratio.
    errors
        Large uncertainties, by run; None where there is none: (n_runs,), or empty.
    """

    name: str
    values: tuple[float | None, ...]
    label: str
    unit: str
    is_truncated: bool = False
    is_limited: bool = False
    is_growing: bool = False
    is_of_input: bool = False
    differs_in_meaning: bool = False
    incomplete: frozenset[int] = frozenset()
    is_unresolved: bool = False
    errors: tuple[float | None, ...] = ()

    @property
    def places_left_out(self) -> frozenset[int]:
        """Positions of the runs that are not compared, because others are complete."""
        return frozenset() if self.is_truncated and not self.is_growing else self.incomplete

    @property
    def marked_places(self) -> frozenset[int]:
        """Positions of the runs whose end truncates it; none for two runs, where a word in place of
        the ratio shows this.
        """
        return self.incomplete if len(self.values) > _PAIR else frozenset()

    @property
    def compared(self) -> list[float | None]:
        """Values of the runs that are compared: of all, if the value is truncated."""
        return [value for n, value in enumerate(self.values) if n not in self.places_left_out]

    @property
    def is_cut(self) -> bool:
        """True if the end of any run truncates it."""
        return bool(self.incomplete) or (self.is_truncated and not self.is_growing)

    @property
    def compared_numbers(self) -> list[float]:
        """Values of the runs that are compared, of those that have it."""
        return [value for value in self.compared if value is not None]

    @property
    def numbers(self) -> list[float]:
        """Values of the runs that have it."""
        return [value for value in self.values if value is not None]

    @property
    def is_zero(self) -> bool:
        """True if it is zero in every run."""
        return not any(self.numbers)

    @property
    def ratio(self) -> float | None:
        """Ratio of the second to the first value of two runs; for more runs, of the largest to the
        smallest magnitude, without the runs whose end truncates the value.

        None for a single run, if a compared run has no value or the value zero, if the value is
        truncated, still grows or is limited, or if runs define it differently.
        """
        numbers = self.compared_numbers
        if self.without_ratio or None in self.compared or not all(numbers):
            return None
        if len(numbers) < 2:
            return None
        if len(self.values) == _PAIR:
            return numbers[1] / numbers[0]
        smallest, *_, largest = sorted(numbers, key=abs)
        return largest / smallest

    @property
    def without_ratio(self) -> str:
        """Words in place of the ratio of a value that is truncated, still grows, is limited or not
        resolved, or that runs define differently; empty otherwise.
        """
        if self.is_unresolved and not self.differs_in_meaning:
            return NOT_RESOLVED
        return self._without_ratio_if_resolved

    @property
    def _without_ratio_if_resolved(self) -> str:
        """The same words of a value whose uncertainty is disregarded."""
        if self.differs_in_meaning:
            return DIFFERENT_MEANING
        if self.is_truncated and not self.is_growing:
            return TRUNCATED
        if self.is_limited:
            return LIMITED
        return STILL_GROWING if self.is_growing else ""

    @property
    def is_complete(self) -> bool:
        """True for a value that every run has and defines in the same way, that neither the end of
        a run nor a boundary limits, and that is resolved or has a known uncertainty.
        """
        return self._is_known and not self.incomplete and None not in self.values

    @property
    def has_complete_runs(self) -> bool:
        """True for a value that the runs have whose end does not truncate it, that neither grows
        nor is limited, and that is resolved or has a known uncertainty.
        """
        return self._is_known and None not in self.compared

    @property
    def _is_known(self) -> bool:
        """True for a value that has a ratio, or has none only since it is uncertain."""
        if self.is_unresolved and not any(self.errors):
            return False
        return not self._without_ratio_if_resolved

    @property
    def is_main(self) -> bool:
        """True for a complete value that is no value at an arbitrary instant, and no energy or size
        of runs with different inputs.
        """
        return self.is_complete and not self.is_of_input and self.name not in AT_THE_END

    @property
    def is_negligible(self) -> bool:
        """True for fractions that are zero in a run and hardly more in the others."""
        sizes = [abs(number) for number in self.compared_numbers]
        is_fraction = self.name.endswith(_FRACTION)
        return is_fraction and min(sizes, default=0.0) == 0 and max(sizes) < _NO_FRACTION

    @property
    def is_within_errors(self) -> bool:
        """True if the values agree within their uncertainties."""
        if not any(self.errors):
            return False
        known = [
            (value, error or 0.0)
            for value, error in zip(self.values, self.errors, strict=True)
            if value is not None
        ]
        lowest = min(value + error for value, error in known)
        highest = max(value - error for value, error in known)
        return highest <= lowest

    @property
    def spread(self) -> float:
        """Logarithm of largest over smallest magnitude; infinite for zero next to a number."""
        numbers = self.compared_numbers
        sizes = [abs(number) for number in numbers]
        if len(sizes) < 2 or not any(sizes):
            return 0.0
        if min(sizes) <= _ROUNDING * max(sizes) or min(numbers) < 0 < max(numbers):
            return math.inf
        return math.log(max(sizes) / min(sizes))

    def text(self, value: float) -> str:
        """Return a value in words: ``1.2 kN``, ``34 %``, with its uncertainty ``0.32 ± 0.23 %``."""
        error = self.error_at(self.values.index(value)) if value in self.values else None
        if error and self.name.endswith(_FRACTION):
            return percent_with_error(value, error)
        if error:
            return interval_in_any_unit(value, error, self.unit)
        if self.name.endswith(_FRACTION):
            return share(value)
        prefixed = self.unit.isalpha() and self.unit != "kg"
        return quantity_in(value, self.unit if prefixed else "") + (
            f" {self.unit}" if self.unit and not prefixed else ""
        )

    def error_at(self, place: int) -> float | None:
        """Return the uncertainty of the value of the run at a position; None if it is small or
        unknown.
        """
        return self.errors[place] if self.errors else None


def compared_values(runs: Sequence[ComparedRun], names: Iterable[str] = ()) -> list[ComparedValue]:
    """Return the values of the runs: the requested values, or all results, the most different
    first: values that are zero in one run, or have different signs, and then by their ratio.

    Values that are zero in every run, or equal another value in every run, such as the force on
    the ground below a bottom at rest, are omitted unless they are requested by name.
    """
    asked = list(names)
    wanted = asked or _outcomes(runs)
    values = _limited_values(wanted, runs)
    if asked:
        return values
    shown = [value for value in values if len(value.numbers) > 1 and not value.is_zero]
    return sorted(_without_repetitions(shown), key=_rank)


def results_and_details(runs: Sequence[ComparedRun]) -> list[ComparedValue]:
    """Return all results, and all details that the ends of runs or boundaries limit, such as the
    50 % sizes of the plastic zone.
    """
    details = [name for name in _keys(runs) if is_limited_by_end(name)]
    return _limited_values(list(dict.fromkeys([*_outcomes(runs), *details])), runs)


def _limited_values(names: Sequence[str], runs: Sequence[ComparedRun]) -> list[ComparedValue]:
    """Return values with the limits by the ends of runs and by boundaries."""
    truncated = truncated_runs(names, runs)
    limited = limited_names(names, runs)
    unresolved = unresolved_names(names, runs)
    growing_by_run = {run: growing_names(names, [run]) for run in runs}
    values: list[ComparedValue] = []
    for name in names:
        cut = truncated.get(name, frozenset())
        is_truncated = has_few_complete(name, runs, cut)
        is_growing = not is_truncated and any(
            name in growing for run, growing in growing_by_run.items() if run not in cut
        )
        value = _value(
            name,
            runs,
            is_truncated=is_truncated or is_growing,
            is_limited=name in limited,
            is_growing=is_growing,
            is_unresolved=name in unresolved,
            incomplete=frozenset(n for n, run in enumerate(runs) if run in cut),
        )
        values.append(value)
    return values


def _without_repetitions(values: Sequence[ComparedValue]) -> list[ComparedValue]:
    """Return the values, of equal values of one unit only one: a complete value before a value
    without a ratio, and others before the values of `_REPEATING`.
    """
    kept: dict[tuple[str, tuple[str, ...]], ComparedValue] = {}
    for value in sorted(values, key=lambda one: (bool(one.without_ratio), one.name in _REPEATING)):
        kept.setdefault((value.unit, tuple(map(_digits, value.values))), value)
    names = {value.name for value in kept.values()}
    return [value for value in values if value.name in names]


def _digits(number: float | None) -> str:
    """Return a number with as many digits as equal values have."""
    return "" if number is None else f"{number:.9e}"


def shown_values(
    values: Sequence[ComparedValue], most: int, *, asked: bool
) -> Sequence[ComparedValue]:
    """Return the values that a table shows: the requested values, or the first results without
    values at the arbitrary end of a run; of many runs only values that differ.

    Parameters
    ----------
    most
        Number of results.
    asked
        True if the values were requested by name.
    """
    if asked:
        return values
    shown = [value for value in values if value.name not in AT_THE_END]
    if any(len(value.values) > MOST_SIDE_BY_SIDE for value in shown):
        shown = differing_values(shown)
    return shown[:most]


def unknown_values(
    names: Iterable[str], runs: Sequence[ComparedRun], figures: Sequence[str]
) -> list[str]:
    """Return a message for each name that is neither a number in a summary nor a figure."""
    present = {name for name in _keys(runs) if _value(name, runs).numbers}
    faults: list[str] = []
    for name in names:
        if name in present:
            continue
        what = "is not a value of summary.json"
        if name in quantities():
            what = "is not a number in any of these runs"
        hint = did_you_mean(name, [*present, *figures])
        more = hint or f"expected a name of summary.json, or of {', '.join(figures)}"
        faults.append(f"--quantity: found {name}, which {what}; {more}")
    return faults


def differing_values(values: Iterable[ComparedValue]) -> list[ComparedValue]:
    """Return the values that differ by more than rounding and their uncertainties."""
    return [value for value in values if value.spread > _SAME and not value.is_within_errors]


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
    compared = [value for value in values if (value.is_complete if asked else value.is_main)]
    others_stated = any(value.name in stated for value in compared)
    compared = [value for value in compared if value.name not in stated]
    other = "other " if others_stated else ""
    different = differing_values(compared)
    if not different:
        if others_stated:
            return ""
        return _without_difference(values, compared, runs, asked=asked)
    is_truncated = any(value.is_cut for value in values)
    distinct = [value for value in different if value.spread > _HARDLY and not value.is_negligible]
    if not distinct:
        largest = max(different, key=lambda value: value.spread)
        results = f"{other}results {_ALL_COMPLETE}" if is_truncated else f"{other}results"
        return f"{results[0].upper()}{results[1:]} {_agreement(largest)}."
    most, *others = [_clause(value, names_with_cases(runs)) for value in _of_families(distinct)]
    if asked:
        return f"The requested values differ most in {'; '.join([most, *others])}."
    text = f"The {other}main results differ most in {most}."
    if is_truncated:
        text = f"Of the {other}results {_ALL_COMPLETE}, the largest difference is in {most}."
    if not others:
        return text
    return f"{text} Further differences: {'; '.join(others)}."


def _of_families(values: Sequence[ComparedValue]) -> list[ComparedValue]:
    """Return the first values of different families, as many as a sentence lists."""
    chosen: dict[str, ComparedValue] = {}
    for value in values:
        chosen.setdefault(_family(value.name), value)
    return list(chosen.values())[:_IN_SENTENCE]


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
        reasons.append("packings and blocks define it differently")
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
    if any(value.is_of_input and value.is_complete and value.spread > _SAME for value in values):
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
    return f"{NOT_COMPARED}: {named(labels, _MOST_LABELS)}."


def partial_note(values: Sequence[ComparedValue], names: Sequence[str]) -> str:
    """Return a sentence on the runs whose end truncates values of which other runs are compared;
    empty if there are none.

    Parameters
    ----------
    names
        Names of the runs: (n_runs,).
    """
    partial = [value for value in values if value.places_left_out]
    if not partial:
        return ""
    places = sorted(frozenset().union(*(value.incomplete for value in partial)))
    cut = named([names[place] for place in places], _MOST_NAMED)
    labels = named([_in_sentence(value.label) for value in partial], _MOST_LABELS)
    return f"{PARTIAL} ({MARK} in tables), and not part of ratios: values of {cut} ({labels})."


def marked(cell: Cell, *, is_marked: bool) -> Cell:
    """Return the cell of a value, with the mark of a value that the end of its run truncates."""
    if not is_marked or cell.value is None:
        return cell
    return replace(cell, text=f"{cell.text}{MARK}", meaning=f"{PARTIAL}.")


def factor(ratio: float) -> str:
    """Return a ratio as text with three digits."""
    return number(ratio)


def _clause(value: ComparedValue, names: Sequence[str]) -> str:
    """Return label, values and ratio: ``peak force 1.2 kN (a) and 2.4 kN (b), a factor of 2``."""
    label = _in_sentence(value.label)
    numbers = value.numbers
    joint = "and"
    if len(numbers) > 2:
        numbers = [min(numbers), max(numbers)]
        joint = "to"
    first, last = [f"{value.text(size)} ({_runs_with(value, size, names)})" for size in numbers]
    text = f"{label}, {first} {joint} {last}"
    if value.ratio is None:
        return text
    return f"{text}, a ratio of {factor(value.ratio)}"


def _runs_with(value: ComparedValue, size: float, names: Sequence[str]) -> str:
    """Return the names of the runs in which a value has a size; of many runs the first names."""
    equal = [
        name
        for number, name in zip(value.values, names, strict=True)
        if number is not None and math.isclose(number, size, rel_tol=_SAME)
    ]
    return named(equal, _MOST_NAMED)


def _in_sentence(label: str) -> str:
    """Return a label within a sentence."""
    return label[:1].lower() + label[1:]


def _outcomes(runs: Sequence[ComparedRun]) -> list[str]:
    """Return the names of the results that the runs have, in the order of reports."""
    left_out = {*_NO_OUTCOME, *unlike_names(runs)}
    names = [name for name in (*report_columns(), *_FURTHER) if name not in left_out]
    keys = _keys(runs)
    of_parts = [key for key in keys if key.startswith(_OF_PARTS) and key not in quantities()]
    return [name for name in [*names, *of_parts] if name in keys]


def unlike_names(runs: Sequence[ComparedRun]) -> set[str]:
    """Return the names of values that the kinds of these runs define differently."""
    return {*_OF_ONE_KIND} if len({run.run.kind for run in runs}) > 1 else set()


def _keys(runs: Sequence[ComparedRun]) -> list[str]:
    """Return the keys of all summaries, each once."""
    keys: dict[str, None] = {}
    for run in runs:
        keys |= dict.fromkeys(run.run.summary)
    return list(keys)


def _value(
    name: str,
    runs: Sequence[ComparedRun],
    *,
    is_truncated: bool = False,
    is_limited: bool = False,
    is_growing: bool = False,
    is_unresolved: bool = False,
    incomplete: frozenset[int] = frozenset(),
) -> ComparedValue:
    numbers = [_number(name, run) for run in runs]
    finite = [None if value is None or not math.isfinite(value) else value for value in numbers]
    largest = max((abs(value) for value in finite if value is not None), default=0.0)
    values = [
        0.0 if value is not None and abs(value) <= _ROUNDING * largest else value
        for value in finite
    ]
    called = grains_called_in([run.run.summary for run in runs])
    unit = unit_of_value(name)
    is_absolute = unit == _JOULE or is_zone_size(name)
    is_of_input = is_absolute and not have_same_input(runs)
    return ComparedValue(
        name,
        tuple(values),
        label_of(name, called),
        unit,
        is_truncated=is_truncated,
        is_limited=is_limited,
        is_growing=is_growing,
        is_of_input=is_of_input,
        differs_in_meaning=name in unlike_names(runs),
        incomplete=incomplete,
        is_unresolved=is_unresolved,
        errors=tuple(error_of(name, run.run.summary) for run in runs),
    )


def _number(name: str, run: ComparedRun) -> float | None:
    """Return a value of a run; None for the largest force and overlap of contacts that it does not
    have.
    """
    value = run.run.number(name)
    if name in _OF_PAIRS and has_no_pairs(run.run.summary):
        return None
    return None if name == _WITH_WALLS and value == 0 else value


def _rank(value: ComparedValue) -> tuple[bool, float]:
    """Return the order of a value: zeros next to numbers and different signs, then the most
    different; values that a compared run lacks or that are truncated or limited, and negligible
    fractions come last.
    """
    return not value.has_complete_runs or value.is_negligible, -value.spread


def _family(name: str) -> str:
    """Return the common beginning of similar names; the name if it is the only one."""
    for beginnings in _FAMILIES:
        if name.startswith(beginnings):
            return beginnings[0]
    return name
