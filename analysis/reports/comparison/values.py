"""Values that a comparison of runs shows, in the order of their differences."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

from granwave.analysis.document.model import label_of, unit_of_value
from granwave.analysis.errors import did_you_mean
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.incomplete_values import growing_values
from granwave.analysis.measures.law_range import is_beyond_law
from granwave.analysis.measures.zone_resolution import error_of
from granwave.analysis.quantities import SIZES_BY_LAYERS, quantities, report_columns
from granwave.analysis.reports.comparison.compared_value import (
    ROUNDING,
    STILL_GROWING,
    ComparedValue,
    digits,
)
from granwave.analysis.reports.comparison.definitions import WITH_WALLS, has_walls_in_some
from granwave.analysis.reports.comparison.ends import (
    AT_THE_END,
    growing_names,
    has_few_complete,
    is_limited_by_end,
    is_zone_size,
    limited_names,
    truncated_runs,
    unresolved_names,
)
from granwave.analysis.reports.comparison.energy_inputs import have_same_input
from granwave.analysis.reports.comparison.redefined import redefined_names
from granwave.analysis.reports.comparison.subjects import MOST_SIDE_BY_SIDE, ComparedRun
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
    "impactor_velocity_m_s", "energy_input_normalised", "energy_kinetic_J",
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
_OF_PARTS = ("sensor_", "line_", "wall_")  # beginnings of values of a part that has a name
SAME = 1e-9  # relative difference of values that are equal
_IN_SENTENCE = 3
_JOULE = "J"


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
            growing=frozenset(
                n
                for n, run in enumerate(runs)
                if name in growing_by_run[run] or name in growing_values(run.run.summary)
            ),
        )
        values.append(value)
    return values


def _without_repetitions(values: Sequence[ComparedValue]) -> list[ComparedValue]:
    """Return the values, of equal values of one unit only one: a complete value before a value
    without a ratio, and others before the values of `_REPEATING`.
    """
    kept: dict[tuple[str, tuple[str, ...]], ComparedValue] = {}
    for value in sorted(values, key=lambda one: (bool(one.without_ratio), one.name in _REPEATING)):
        kept.setdefault((value.unit, tuple(map(digits, value.values))), value)
    names = {value.name for value in kept.values()}
    return [value for value in values if value.name in names]


def shown_values(
    values: Sequence[ComparedValue], most: int, *, asked: bool, stated: Collection[str] = ()
) -> Sequence[ComparedValue]:
    """Return the values that a table shows: the requested values, or the values of the sentences
    and the first other results without values at the arbitrary end of a run; of many runs only
    values that differ. Sizes of the plastic zone are the interpolated ones, as in the sentences.

    Parameters
    ----------
    most
        Number of results.
    asked
        True if the values were requested by name.
    stated
        Names of the values that sentences state.
    """
    if asked:
        return values
    shown = [value for value in values if value.name not in AT_THE_END]
    if any(len(value.values) > MOST_SIDE_BY_SIDE for value in shown):
        shown = differing_values(shown)
    names = {value.name for value in shown if None not in value.values}
    by_layers = {name for name, between in SIZES_BY_LAYERS.items() if between in names}
    shown = [value for value in shown if value.name not in by_layers]
    first = [value.name for value in shown if value.name in stated]
    first += [value.name for value in shown if value.name not in stated]
    return [value for value in shown if value.name in first[:most]]


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
    return [value for value in values if value.spread > SAME and not value.is_within_errors]


def of_families(values: Sequence[ComparedValue]) -> list[ComparedValue]:
    """Return the first values of different families, as many as a sentence lists."""
    chosen: dict[str, ComparedValue] = {}
    for value in values:
        chosen.setdefault(_family(value.name), value)
    return list(chosen.values())[:_IN_SENTENCE]


def _outcomes(runs: Sequence[ComparedRun]) -> list[str]:
    """Return the names of the results that the runs have, in the order of reports."""
    left_out = {*_NO_OUTCOME, *unlike_names(runs)}
    names = [name for name in (*report_columns(), *_FURTHER) if name not in left_out]
    keys = _keys(runs)
    of_parts = [key for key in keys if key.startswith(_OF_PARTS) and key not in quantities()]
    return [name for name in [*names, *of_parts] if name in keys]


def unlike_names(runs: Sequence[ComparedRun]) -> set[str]:
    """Return the names of values that the kinds or versions of these runs define differently."""
    names = redefined_names(runs)
    if len({run.run.kind for run in runs}) > 1:
        names |= {*_OF_ONE_KIND}
    return names


def _unlike_at_walls(runs: Sequence[ComparedRun]) -> tuple[str, ...]:
    """Return the names of values that include forces on walls only in some of the runs."""
    return (WITH_WALLS,) if has_walls_in_some(runs) else ()


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
    growing: frozenset[int] = frozenset(),
) -> ComparedValue:
    numbers = [_number(name, run) for run in runs]
    finite = [None if value is None or not math.isfinite(value) else value for value in numbers]
    largest = max((abs(value) for value in finite if value is not None), default=0.0)
    values = [
        0.0 if value is not None and abs(value) <= ROUNDING * largest else value for value in finite
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
        differs_in_meaning=name in (*unlike_names(runs), *_unlike_at_walls(runs)),
        incomplete=incomplete,
        growing=growing,
        is_unresolved=is_unresolved,
        errors=tuple(error_of(name, run.run.summary) for run in runs),
        beyond_law=frozenset(
            place for place, run in enumerate(runs) if is_beyond_law(name, run.run.summary)
        ),
    )


def _rank(value: ComparedValue) -> tuple[bool, bool, float]:
    """Return the order of a value: zeros next to numbers and different signs, then the most
    different; values that a compared run lacks or that are truncated or limited, and negligible
    fractions come last, of these values that still grow first.
    """
    is_last = not value.has_complete_runs or value.is_negligible
    return is_last, is_last and value.without_ratio != STILL_GROWING, -value.spread


def _family(name: str) -> str:
    """Return the common beginning of similar names; the name if it is the only one."""
    for beginnings in _FAMILIES:
        if name.startswith(beginnings):
            return beginnings[0]
    return name


def _number(name: str, run: ComparedRun) -> float | None:
    """Return a value of a run; None for the largest force and overlap of contacts that it does not
    have.
    """
    value = run.run.number(name)
    if name in _OF_PAIRS and has_no_pairs(run.run.summary):
        return None
    return None if name == WITH_WALLS and value == 0 else value
