"""Tables of a study of tolerances: means by setting, and largest imperfections."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

from granwave.analysis import statistics
from granwave.analysis.document.model import BLANK, Cell, DocumentTable, TableColumn
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.studies.study import numeric, table_of
from granwave.analysis.studies.tolerance.quantities import (
    DISSIPATED,
    FORCE,
    IDEAL,
    PERFORMANCE,
    TABULATED,
    Setting,
    ToleranceQuantity,
    in_words,
)
from granwave.analysis.studies.tolerance.runs import Means, PackingRuns

KEPT = 0.9  # fraction of the ideal packing's performance that defines the largest tolerance
_SAME = 0.005
_PRECISE = 0.1  # half-width of the confidence interval / mean, for the number of seeds
_KEPT_HEADINGS = (
    "Imperfection",
    "Quantity",
    "Ideal",
    "Largest value in the scan",
    "There",
    "Relative to ideal",
    "Seeds",
    "Retained up to",
    "With confidence up to",
)
_ALIKE_HEADINGS = ("Imperfection", "Quantity", "From", "To", "At")

Heading = str | tuple[str, str]  # heading of a column, with its unit
Columns = Mapping[Heading, Mapping[Setting, Cell]]


def tables(packing: PackingRuns) -> Iterator[DocumentTable]:
    """Means of all settings, performance against the ideal packing, largest tolerances, and
    settings that the seeds do not distinguish.
    """
    means = _means(packing)
    if means:
        settings = list(packing.runs)
        yield _by_setting(packing, "Mean and 95 % confidence interval", means, settings)
    against = _shares_of_ideal(packing)
    if against:
        settings = [setting for setting in packing.runs if setting != IDEAL]
        yield _by_setting(packing, "Against the ideal packing", against, settings)
    kept = list(_kept(packing))
    if kept:
        caption = (
            f"Largest imperfections with at least {100 * KEPT:.0f} % of the performance of the "
            f"ideal packing (a force of at most {100 / KEPT:.0f} %)"
        )
        yield _of_texts(packing, caption, _KEPT_HEADINGS, kept)
    alike = list(_alike(packing))
    if alike:
        caption = "Neighbouring settings whose means do not differ significantly"
        yield _of_texts(packing, caption, _ALIKE_HEADINGS, alike)


def _by_setting(
    packing: PackingRuns, caption: str, columns: Columns, settings: Sequence[Setting]
) -> DocumentTable:
    """Return a table with a row for each setting: its imperfections, its seeds, and columns."""
    imperfections = ((axis.heading, axis.unit) for axis in packing.axes)
    headings = (*numeric(*imperfections, key=True), *numeric("Seeds", *columns))
    rows = []
    for setting in settings:
        row = [Cell(f"{axis.of(setting):g}", axis.of(setting)) for axis in packing.axes]
        seeds = len(packing.runs[setting]) if packing.random(setting) else 0
        row.append(Cell(_seeds(packing, setting), seeds))
        row += [cells.get(setting, Cell(BLANK)) for cells in columns.values()]
        rows.append(tuple(row))
    return table_of(caption + packing.suffix, headings, rows, sortable=True)


def _of_texts(
    packing: PackingRuns, caption: str, headings: Sequence[str], rows: Sequence[tuple[str, ...]]
) -> DocumentTable:
    """Return a table of texts, whose first two columns name imperfection and quantity."""
    columns = [TableColumn(heading, key=n < 2) for n, heading in enumerate(headings)]
    return table_of(caption + packing.suffix, columns, rows)


def _means(packing: PackingRuns) -> Columns:
    """Means of all quantities that have a value, and the number of seeds that a precise force
    requires.
    """
    columns: dict[Heading, Mapping[Setting, Cell]] = {}
    for quantity in packing.shown(TABULATED):
        columns[quantity.heading, quantity.unit] = {
            setting: Cell(with_interval(mean, quantity.scale), mean.mean)
            for setting, mean in packing.means(quantity).items()
        }
    needed = {}
    for setting, mean in packing.means(FORCE).items():
        if mean.n > 1 and mean.mean and mean.deviation > 0:
            n = statistics.seeds_needed(mean.deviation, _PRECISE * abs(mean.mean))
            needed[setting] = Cell(str(n), n)
    if needed:
        columns[f"Seeds for the force to ± {100 * _PRECISE:.0f} %"] = needed
    return columns


def _shares_of_ideal(packing: PackingRuns) -> Columns:
    """Performance in per cent of the performance of the ideal packing."""
    columns: dict[Heading, Mapping[Setting, Cell]] = {}
    for quantity in packing.shown(PERFORMANCE):
        shares = packing.over_ideal(quantity)
        if shares and packing.left(quantity):
            columns[quantity.heading, "% of ideal"] = {
                setting: _share_cell(share) for setting, share in shares.items()
            }
    return columns


def _seeds(packing: PackingRuns, setting: Setting) -> str:
    return str(len(packing.runs[setting])) if packing.random(setting) else "not random"


def _share_cell(share: statistics.Estimate) -> Cell:
    ideal = statistics.exactly(1.0)
    alike = not share.exact and statistics.differ_significantly(ideal, share) is False
    remark = ", not significantly different" if alike else ""
    return Cell(with_interval(share.over(0.01)) + remark, 100 * share.mean)


def _kept(packing: PackingRuns) -> Iterator[tuple[str, ...]]:
    """Rows of `_KEPT_HEADINGS`: values without and with most of each imperfection, and the largest
    imperfection that keeps nearly all performance.
    """
    if IDEAL not in packing.runs:
        return
    for axis in packing.axes:
        along = packing.along(axis).get(IDEAL)
        if not along:
            continue
        for quantity in packing.shown(PERFORMANCE, along):
            left = packing.left(quantity)
            if len(left) < 2:
                continue
            means = packing.means(quantity)
            last = [setting for setting in along if setting in means][-1]
            yield (
                axis.heading,
                quantity.heading,
                with_interval(means[IDEAL], quantity.scale, quantity.unit),
                axis.show(axis.of(last)),
                with_interval(means[last], quantity.scale, quantity.unit),
                with_interval(packing.over_ideal(quantity)[last].over(0.01), unit="%"),
                _seeds(packing, last),
                *_largest_kept(axis, along, left),
            )


def _largest_kept(
    axis: ToleranceQuantity, along: Sequence[Setting], left: Means
) -> tuple[str, str]:
    """Largest imperfection with which the fraction `KEPT` of the performance is left, and the
    largest with which the lower ends of the confidence intervals are still above this fraction.
    """
    shares = {axis.of(setting): left[setting] for setting in along if setting in left}
    lows = {x: share.low for x, share in shares.items() if math.isfinite(share.half_width)}
    largest = statistics.crossing(list(shares), [share.mean for share in shares.values()], KEPT)
    confident = statistics.crossing(list(lows), list(lows.values()), KEPT)
    text = "all values in the scan"
    if largest is not None:
        tried = [axis.of(setting) for setting in along]
        after = bisect.bisect_right(tried, largest)
        between = f"between {tried[after - 1]:g} and {axis.show(tried[after])}"
        text = f"about {axis.show(largest)} ({between})"
    if confident is None or (largest is not None and confident >= largest * (1 - _SAME)):
        return text, BLANK
    return text, axis.show(confident)


def _alike(packing: PackingRuns) -> Iterator[tuple[str, ...]]:
    """Rows of `_ALIKE_HEADINGS`: neighbouring settings whose means may be equal."""
    for axis, quantity in itertools.product(packing.axes, (FORCE, DISSIPATED)):
        means = packing.means(quantity)
        for base, along in packing.along(axis).items():
            place = in_words(base) if base != IDEAL else ""
            settings = [setting for setting in along if setting in means]
            for first, second in itertools.pairwise(settings):
                if statistics.differ_significantly(means[first], means[second]) is not False:
                    continue
                yield (
                    axis.heading,
                    quantity.heading,
                    axis.show(axis.of(first)),
                    axis.show(axis.of(second)),
                    place,
                )
