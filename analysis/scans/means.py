"""Means of a scan over replicates, with their trends in words, for the start of a report and the
end of a scan.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.document.model import is_number, show
from granwave.analysis.formatting.numbers import (
    in_any_unit,
    interval,
    interval_in_any_unit,
    quantity_in,
)
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.collision import TOUCHING_ENERGY
from granwave.analysis.measures.incomplete_values import incomplete_in
from granwave.analysis.measures.law_range import (
    BEYOND_LAW,
    BEYOND_LAW_MEANING,
    is_beyond_law,
)
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.measures.zone_size import Mark, is_collision, mark_of
from granwave.analysis.quantities import quantity, scan_figures
from granwave.analysis.scans.effects import (
    LineOfMeans,
    along,
    has_no_effect,
    line_of,
    mixed_in_words,
    order_in_words,
    trend_of,
)
from granwave.analysis.scans.keys import VariedKey, key_of
from granwave.analysis.scans.result import REDUCTION, SEED, PointResult, ScanResult, protects
from granwave.analysis.scans.table import (
    CONFIDENCE,
    COUNT,
    MEAN,
    labels_of,
    physical,
    scan_statistics,
)
from granwave.analysis.scans.trends import SAME, Trend, significant_steps
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import read_stored_case
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.run_directory import CASE_FILE

_CLEAR = 0.05  # change of a quantity, relative to its largest value, that is worth a headline
WORTH = 1e-12  # smallest value that is not rounding
NOT_FINAL = "†"  # mark of a value in a table that the end of a run limits
_AIMS = (REDUCTION, "restitution", "transmission")  # values for which scans are made
_STRONG = 0.4  # change from which on quantities count as equally strong
#: Main quantities: the one that changes most comes first, of similar or strong changes in this
#: order.
RANKED = (
    "dissipated_fraction",
    "wall_peak_force_N",
    "peak_force_N",
    "peak_force_with_walls_N",
    "max_force_N",
)
#: Quantities that come first, in this order.
_MAIN = (*_AIMS, *RANKED, "n_plastic_spheres")
_OF_ZONE = ("n_plastic_", "plastic_zone_", "zone_")  # names of values of the plastic zone
_YIELDED = "n_plastic_spheres"
_OF_PACKING = ("packing.", "striker", "replace")  # keys whose values change a random packing
_RESTITUTION = "restitution"
_MOST_MISSING = 3  # most points without a value that a sentence names
_SINGLE = (
    "Each random packing was run once, so that its scatter is unknown: set replicates in the scan "
    "file."
)
_BETWEEN = "peak_force_N"  # force of contacts between spheres
_WITH_WALLS = "peak_force_with_walls_N"


@dataclasses.dataclass(frozen=True)
class Means:
    """Values of a scan: a row for each combination of its keys without the seed that has finished
    points.

    Attributes
    ----------
    keys
        Varied keys with more than one value, with their values by row; without run times that
        follow from other keys.
    counts
        Number of points of each row.
    values
        Means by name of the quantity, one for each row; None where unknown.
    half_widths
        Half-widths of the 95 % confidence intervals; None without replicates.
    single
        True for rows of a single random packing, whose interval is unknown.
    reasons
        Reason of each row for an unknown restitution; empty without one.
    protection
        True if the scan concerns the protection of a target; see
        `granwave.analysis.scans.result.protects`.
    called
        Word for the grains of its runs.
    has_limited_zones
        True if the plastic zone of a point reaches a boundary, which limits its values.
    incomplete
        Rows with a point whose end limits a value, by name of the quantity; see
        `granwave.analysis.measures.incomplete_values`.
    beyond_law
        Rows with a point of which contacts beyond the range of the law determine a value, by name
        of the quantity; see `granwave.analysis.measures.law_range`.
    without_zone
        Rows in which no contact yields.
    """

    keys: tuple[VariedKey, ...]
    counts: tuple[int, ...]
    values: Mapping[str, Sequence[float | None]]
    half_widths: Mapping[str, Sequence[float | None]]
    single: tuple[bool, ...]
    reasons: tuple[str, ...]
    protection: bool = False
    called: str = SPHERES
    has_limited_zones: bool = False
    incomplete: Mapping[str, frozenset[int]] = dataclasses.field(default_factory=dict)
    beyond_law: Mapping[str, frozenset[int]] = dataclasses.field(default_factory=dict)
    without_zone: frozenset[int] = frozenset()

    @property
    def figures(self) -> dict[str, str]:
        """Values that figures show, by the names of figures."""
        return scan_figures(_present(self.values))

    def quantities(self) -> list[tuple[str, str]]:
        """Return the quantities that have figures, as names of figure and value: first those for
        which scans are made and those that vary clearly, then those that vary by less than
        `_CLEAR`, then those that vary within their confidence intervals, then constant ones. Of the
        main quantities the one with the largest relative change comes first, and quantities that
        the end of a run limits, or that are extrapolated beyond the law, come last.

        A value for which scans are made may be unknown at some points; see `is_mostly_known`.
        """
        quantities = []
        for number, (name, key) in enumerate(self.figures.items()):
            known = self.known_rows(key)
            if key == REDUCTION and not self.protection:
                continue
            is_known = len(known) == len(self.counts)
            is_usable = is_known or (key in _AIMS and is_mostly_known(self.values.get(key, ())))
            if is_usable and len(known) > 1 and self._largest(key) > WORTH:
                rank = _MAIN.index(key) if key in _MAIN else len(_MAIN) + number
                change = self._change(key)
                is_slight = change <= _CLEAR and key not in _AIMS
                is_limited = self.has_limited_zones and key.startswith(_OF_ZONE)
                is_unclear = self._are_within_intervals(key, *self._ends(key))
                own = self._rank_among_main(key, rank)
                order = (change <= SAME, is_unclear, is_limited, is_slight, *own, rank)
                quantities.append((*order, name, key))
        return [(name, key) for *_, name, key in sorted(quantities)]

    def _rank_among_main(self, key: str, rank: int) -> tuple[int, float]:
        """Return the order of a main quantity by its relative change; others keep their order.

        Parameters
        ----------
        rank
            Order of the quantity among all.
        """
        if key not in RANKED:
            return (-1 if key in _AIMS else rank), 0.0
        is_final = not self.incomplete.get(key) and not self.beyond_law.get(key)
        change = min(self._change(key), _STRONG) if is_final else 0.0
        return len(_AIMS), -round(change, 1)

    def varies_clearly(self, name: str) -> bool:
        """Return True if a quantity varies by more than `_CLEAR`, and than its intervals."""
        is_within = self._are_within_intervals(name, *self._ends(name))
        return self._change(name) > _CLEAR and not is_within

    def varies(self, name: str) -> bool:
        """Return True if the values of a quantity differ by more than rounding."""
        return self._change(name) > SAME

    def known_rows(self, name: str) -> list[int]:
        """Return the rows with a value of a quantity."""
        values = self.values.get(name, ())
        return [row for row, value in enumerate(values) if value is not None]

    def _largest(self, name: str) -> float:
        """Return the largest magnitude of a quantity."""
        return max(abs(value) for value in self.values[name] if value is not None)

    def _change(self, name: str) -> float:
        """Return the range of a quantity, divided by its largest magnitude."""
        values = [value for value in self.values[name] if value is not None]
        largest = self._largest(name)
        return (max(values) - min(values)) / largest if largest else 0.0

    def sentence(self, main: str) -> str:
        """Return a sentence with the range of a quantity, the points at its ends, and the trends
        with each key; then what the intervals do not support, and the points without a value.
        """
        low, high = self._ends(main)
        label = quantity(main).label
        most = self.in_words(main, high)
        known = self.known_rows(main)
        is_whole = len(known) == len(self.counts)
        text = f"{label}: {most} at {'all' if is_whole else 'the other'} points."
        if self.varies(main):
            least = self.in_words(main, low)
            without = self._without_effect(main)
            ends = [self.setting(row, without) for row in (low, high)]
            text = f"{label}: from {least} ({ends[0]}) to {most} ({ends[1]})."
            text += self._comparison(main, low, high)
        if not is_whole:
            text += f" {self._unknown(main)}"
        if rows := self.incomplete.get(main):
            text += (
                f" It is not final at {len(rows)} of {len(self.counts)} points, where the end of "
                f"the run limits it ({self._named(sorted(rows))}): increase run.end_time."
            )
        if rows := self.beyond_law.get(main):
            text += (
                f" At {len(rows)} of {len(self.counts)} points ({self._named(sorted(rows))}) it is "
                "extrapolated: overlaps of contacts exceed 0.2 R*, the limit of the law."
            )
        return in_grains(text, self.called)

    def _comparison(self, main: str, low: int, high: int) -> str:
        """Return the trends of a quantity, and remarks on the spread of random packings; each
        sentence after a space.
        """
        text = ""
        trends = self._trends(main)
        if trends:
            text += f" It {_in_series(trends)}."
        if self._are_within_intervals(main, low, high):
            text += " This difference is within the 95 % confidence intervals."
        if any(self.single):
            text += f" {_SINGLE}"
        return text

    def _are_within_intervals(self, main: str, low: int, high: int) -> bool:
        """Return True if both intervals are known and the difference does not exceed them."""
        rows = (low, high)
        values = np.array([self.values[main][row] or 0.0 for row in rows])
        widths = np.array([self._half_width(main, row, is_varied=True) for row in rows])
        return bool(np.isfinite(widths).all()) and not significant_steps(values, widths).any()

    def _unknown(self, main: str) -> str:
        """Return a sentence on the points without a value of a quantity, with the reason."""
        known = self.known_rows(main)
        missing = [row for row in range(len(self.counts)) if row not in known]
        if self._lack_zone(main, missing):
            return (
                f"There is no plastic zone at {len(missing)} of {len(self.counts)} points "
                f"({self._named(missing)})."
            )
        reasons = {self.reasons[row] for row in missing} if main == _RESTITUTION else set()
        reason = f", because {reasons.pop()}" if len(reasons) == 1 and "" not in reasons else ""
        return (
            f"It is unknown at {len(missing)} of {len(self.counts)} points "
            f"({self._named(missing)}){reason}."
        )

    def _named(self, rows: Sequence[int]) -> str:
        """Return the settings of rows in words; of many rows the first ones."""
        named = "; ".join(self.setting(row) for row in rows[:_MOST_MISSING])
        more = len(rows) - _MOST_MISSING
        return f"{named} and {more} more" if more > 0 else named

    def _lack_zone(self, name: str, rows: Iterable[int]) -> bool:
        """Return True for a value of the plastic zone and rows in which no contact yields."""
        return name.startswith(_OF_ZONE) and self.without_zone.issuperset(rows)

    def range_in_words(self, name: str) -> str:
        """Return the range of a quantity, its trends, and the number of points without it; without
        the points at the ends.
        """
        low, high = self._ends(name)
        parts = [f"{self.in_words(name, low)} to {self.in_words(name, high)}", *self._trends(name)]
        known = self.known_rows(name)
        missing = [row for row in range(len(self.counts)) if row not in known]
        if missing:
            state = "no plastic zone" if self._lack_zone(name, missing) else "unknown"
            parts.append(f"{state} at {len(missing)} of {len(self.counts)} points")
        if rows := self.incomplete.get(name):
            parts.append(f"not final at the end of the run at {len(rows)} of {len(self.counts)}")
        if rows := self.beyond_law.get(name):
            parts.append(f"extrapolated beyond the law at {len(rows)} of {len(self.counts)}")
        return in_grains("; ".join(parts), self.called)

    def _ends(self, name: str) -> tuple[int, int]:
        """Return the rows of the smallest and of the largest value."""
        values = {row: self.values[name][row] or 0.0 for row in self.known_rows(name)}
        return min(values, key=values.__getitem__), max(values, key=values.__getitem__)

    def _half_width(self, name: str, row: int, *, is_varied: bool) -> float:
        """Return the half-width of the interval of a row: 0 for an exact value, NaN if unknown.

        Parameters
        ----------
        is_varied
            True if the compared rows are different random packings; the values of one packing are
            exact.
        """
        half_width = self.half_widths[name][row]
        if half_width is not None:
            return half_width
        return math.nan if is_varied and self.single[row] else 0.0

    def _trends(self, main: str) -> list[str]:
        """Return the effects of the keys on a quantity: ``rises with diameter and velocity``, the
        order of the values of keys without numbers, and the keys without an effect; none if the end
        of a run limits the quantity, since a trend may then come from the end.
        """
        if self.incomplete.get(main):
            return []
        without = self._without_effect(main)
        effective = [key for key in self.keys if key not in without]
        keys_of_trend: dict[str, list[str]] = {}
        orders = []
        for key in effective:
            lines = self._lines(main, key)
            if not key.numeric:
                others = [other for other in effective if other != key]
                orders.append(order_in_words(key, lines, others))
                continue
            trend, reservation = trend_of(lines)
            if trend is not None:
                keys_of_trend.setdefault(trend, []).append(key.words + reservation)
            else:
                orders.append(mixed_in_words(key, lines))
        trends = [
            f"{word} with {' and '.join(keys_of_trend[word])}"
            for word in (Trend.RISES, Trend.FALLS)
            if word in keys_of_trend
        ]
        if without:
            orders.append(f"does not depend on {' and '.join(key.words for key in without)}")
        return [*trends, *filter(None, orders)]

    def _without_effect(self, main: str) -> list[VariedKey]:
        """Return the keys that do not change a quantity at any combination of the other keys."""
        if not self.varies(main):
            return []
        return [key for key in self.keys if has_no_effect(self._lines(main, key))]

    def _lines(self, main: str, key: VariedKey) -> list[LineOfMeans]:
        """Return the lines of known means of a quantity along a key, of two points or more."""
        is_varied = is_of_packing(key.name)
        lines = []
        others = [other for other in self.keys if other != key]
        for line in along(key, others, len(self.counts)):
            rows = [row for row in line if self.values[main][row] is not None]
            means = [self.values[main][row] or 0.0 for row in rows]
            widths = [self._half_width(main, row, is_varied=is_varied) for row in rows]
            if len(rows) > 1:
                lines.append(line_of(key, rows, means, widths))
        return lines

    def text(self, name: str, row: int) -> str:
        """Return a mean with its interval, if it has one, and with its marks."""
        mean = self.values[name][row]
        half = self.half_widths[name][row]
        text = interval(mean, half) if mean is not None and half else show(mean)
        return f"{text} {self.marks(name, row)}".rstrip()

    def marks(self, name: str, row: int) -> str:
        """Return the marks of a known mean that the end of a run limits, or that contacts beyond
        the range of the law determine; empty without them.
        """
        marks = [mark for mark, _, rows in self._marked_rows(name) if row in rows]
        return " ".join(marks)

    def remark(self, names: Iterable[str]) -> str:
        """Return the meanings of the marks of these quantities; empty without a mark."""
        meanings: dict[str, str] = {}
        for name in names:
            for mark, meaning, rows in self._marked_rows(name):
                if rows:
                    meanings[mark] = f"{mark} {meaning}"
        return "; ".join(meanings.values())

    def _marked_rows(self, name: str) -> list[tuple[str, str, frozenset[int]]]:
        """Return the marks of a quantity with their meanings and the rows with a known mean."""
        known = self.known_rows(name)
        limited = self.incomplete.get(name, frozenset()).intersection(known)
        beyond = self.beyond_law.get(name, frozenset()).intersection(known)
        return [
            (NOT_FINAL, "still changes at the end of the run", limited),
            (BEYOND_LAW, BEYOND_LAW_MEANING, beyond),
        ]

    def in_words(self, name: str, row: int) -> str:
        """Return a mean with its unit, and its interval if it has one."""
        mean = self.values[name][row]
        half = self.half_widths[name][row]
        unit = quantity(name).unit
        if mean is None:
            return show(mean)
        return interval_in_any_unit(mean, half, unit) if half else in_any_unit(mean, unit)

    def setting(self, row: int, without: Sequence[VariedKey] = ()) -> str:
        """Return the values of the keys of a row in words, without some keys."""
        parts = []
        for key in self.keys:
            if key not in without:
                unit = f" {key.naming.unit}" if key.naming.unit and key.numeric else ""
                parts.append(f"{key.label} {key.tick(row)}{unit}")
        return ", ".join(parts)


def means_of(scan: ScanResult) -> Means:
    """Average the finished points of a scan over the seeds; without seeds each point is a row."""
    names = [key for key in scan.varied if key != SEED]
    done = [point for point in scan.points if point.status == "done"]
    summaries = [point.summary for point in done]
    if SEED in scan.varied:
        table = scan_statistics(scan)
        counts = table.get(COUNT, [])
        means = {key.removesuffix(MEAN): table[key] for key in table if key.endswith(MEAN)}
        widths = {name: table[name + CONFIDENCE] for name in means}
        labels = {name: table[name] for name in names}
    else:
        counts = [1] * len(done)
        means = _numbers(summaries)
        widths = dict.fromkeys(means, [None] * len(done))
        labels = labels_of(done, names)
    kept = [row for row, count in enumerate(counts) if count]
    groups = _groups(scan, names)
    keys = [
        key_of(name, column, scan.units.get(name, ""))
        for name, column in physical(_rows_of(labels, kept)).items()
    ]
    return Means(
        tuple(key for key in keys if len(set(key.values)) > 1),
        tuple(counts[row] for row in kept),
        _rows_of(means, kept),
        _rows_of(widths, kept),
        _single_packings(groups, names),
        tuple(_reason(group[0].summary) for group in groups),
        protects(scan.varied, summaries),
        grains_called_in(summaries),
        has_limited_zones=any(
            mark_of(summary) is Mark.CUT or is_unresolved(summary) for summary in summaries
        ),
        incomplete=_incomplete_rows(groups),
        beyond_law=_rows_beyond_law(groups, means),
        without_zone=frozenset(row for row, group in enumerate(groups) if _lacks_zone(group)),
    )


def _incomplete_rows(groups: Sequence[Sequence[PointResult]]) -> dict[str, frozenset[int]]:
    """Return the rows with a point whose end limits a value, by name of the value."""
    rows: dict[str, set[int]] = {}
    for row, group in enumerate(groups):
        for name in set().union(*(incomplete_in(point.summary) for point in group)):
            rows.setdefault(name, set()).add(row)
    return {name: frozenset(of_name) for name, of_name in rows.items()}


def _rows_beyond_law(
    groups: Sequence[Sequence[PointResult]], names: Iterable[str]
) -> dict[str, frozenset[int]]:
    """Return the rows with a point of which contacts beyond the range of the law determine a value,
    by name of the value.
    """
    rows: dict[str, frozenset[int]] = {}
    for name in names:
        marked = [row for row, group in enumerate(groups) if _has_beyond_law(name, group)]
        if marked:
            rows[name] = frozenset(marked)
    return rows


def _has_beyond_law(name: str, group: Sequence[PointResult]) -> bool:
    """Return True if contacts beyond the range of the law determine a value of any point."""
    return any(is_beyond_law(name, point.summary) for point in group)


def _lacks_zone(group: Sequence[PointResult]) -> bool:
    """Return True for points in which no contact yields."""
    return all(point.summary.get(_YIELDED) == 0 for point in group)


def _groups(scan: ScanResult, names: Sequence[str]) -> list[list[PointResult]]:
    """Return the finished points, grouped by replicates: a list for each row of the means."""
    groups: dict[tuple[Any, ...], list[PointResult]] = {}
    for point in scan.points:
        setting: tuple[Any, ...] = (point.number,)
        if SEED in scan.varied:
            setting = tuple(point.labels.get(name) for name in names)
        done = [point] if point.status == "done" else []
        groups.setdefault(setting, []).extend(done)
    return [group for group in groups.values() if group]


def _single_packings(
    groups: Sequence[Sequence[PointResult]], names: Sequence[str]
) -> tuple[bool, ...]:
    """Return True for each group of a single point whose packing depends on the seed.

    Points that differ in other keys than those of the packing are alike, and are read once.
    """
    of_packing = [name for name in names if is_of_packing(name)]
    known: dict[tuple[Any, ...], bool] = {}
    single = []
    for group in groups:
        point = group[0]
        setting = tuple(point.labels.get(name) for name in of_packing)
        if len(group) == 1 and setting not in known:
            known[setting] = has_random_packing(point.directory or Path())
        single.append(len(group) == 1 and known[setting])
    return tuple(single)


def has_random_packing(directory: Path) -> bool:
    """Return True if the packing of a run depends on the seed; False if its case is unknown."""
    try:
        return is_random(read_stored_case(directory / CASE_FILE))
    except (InputError, OSError):
        return False


def is_of_packing(key: str) -> bool:
    """Return True for a key of a case whose values change a random packing."""
    return key.startswith(_OF_PACKING)


def _reason(summary: Mapping[str, Any]) -> str:
    """Return the reason for an unknown restitution: bodies that touch at the end of a collision;
    empty if it is known, or for other runs.
    """
    names = ("energy_elastic_J", "energy_input_J", "end_time_s")
    numbers = [float(summary[name]) for name in names if is_number(summary.get(name))]
    is_unknown = is_collision(summary) and summary.get(_RESTITUTION) is None
    if not is_unknown or len(numbers) < len(names):
        return ""
    stored, given, end = numbers
    if stored <= TOUCHING_ENERGY * given:
        return ""
    return (
        f"the bodies still touch at the end of the run ({quantity_in(end, 's')}); set run.end_time"
    )


def _in_series(clauses: Sequence[str]) -> str:
    """Join clauses with commas, with "and" before a last one that is no trend."""
    *first, last = clauses
    if not first:
        return last
    word = "" if last.startswith(("rises with", "falls with")) else "and "
    return f"{', '.join(first)}, {word}{last}"


def is_mostly_known(values: Sequence[float | None]) -> bool:
    """Return True if at least half of the values are known, so that a scan is made for them."""
    return 2 * sum(value is not None for value in values) >= len(values)


def with_values(summaries: Iterable[Mapping[str, Any]]) -> set[str]:
    """Return the quantities that these summaries have, for `scan_figures`."""
    return _present(_numbers(list(summaries)))


def _present(columns: Mapping[str, Sequence[float | None]]) -> set[str]:
    """Return the quantities with a value; without the force between spheres if a point has forces
    at walls only.
    """
    present = {name for name, values in columns.items() if set(values) - {None}}
    between = columns.get(_BETWEEN, ())
    of_all = columns.get(_WITH_WALLS, ())
    if any(force == 0 and every for force, every in zip(between, of_all, strict=False)):
        present.discard(_BETWEEN)
    return present


def _numbers(summaries: Sequence[Mapping[str, Any]]) -> dict[str, list[float | None]]:
    """Return the numbers of summaries by quantity; None if there is no number."""
    columns: dict[str, list[float | None]] = {}
    for name in dict.fromkeys(itertools.chain.from_iterable(summaries)):
        values: list[Any] = [summary.get(name) for summary in summaries]
        columns[name] = [float(value) if is_number(value) else None for value in values]
    return columns


def _rows_of(columns: Mapping[str, Sequence[Any]], rows: Sequence[int]) -> dict[str, list[Any]]:
    """Return some rows of each column."""
    picked = {}
    for name, column in columns.items():
        picked[name] = [column[row] for row in rows]
    return picked
