"""The study of tolerances: verdict, tables and figures of every packing that was run both ideal and imperfect."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence

from granwave.analysis.document.cells import BLANK
from granwave.analysis.document.model import Cell, Table
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import differ_significantly, exactly
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tables import numeric, table_of
from granwave.analysis.studies.titles import bottom_label, impact_title
from granwave.analysis.studies.tolerance import figures
from granwave.analysis.studies.tolerance.packings import Packing, packings
from granwave.analysis.studies.tolerance.quantities import Quantity
from granwave.analysis.studies.tolerance.settings import IDEAL, Setting
from granwave.analysis.studies.tolerance.verdict import missing, verdict

__all__ = ["missing", "name", "pictures", "select", "tables", "title", "verdict"]

TEXT = (
    "Means over the seeds and their 95 % confidence intervals (Student). Values without an interval are of "
    "packings in which nothing is random, or of a single seed. With a diameter scatter, diameters lie between the "
    "nominal one and so much less. A lower peak force and a larger dissipated share protect better."
)


def select(runs: Sequence[FinishedRun]) -> list[Packing]:
    """Packings that were run with at least two settings, named and told apart."""
    found = packings(runs)
    titles = [f"{impact_title(packing.case)}, {bottom_label(packing.case)}" for packing in found]
    return [
        dataclasses.replace(packing, name="tolerances" + (f"-{n}" if n > 1 else ""), title=title, label=label)
        for n, (packing, title, label) in enumerate(zip(found, titles, _labels(titles), strict=True), start=1)
    ]


def name(packing: Packing) -> str:
    """``tolerances``, ``tolerances-2``."""
    return packing.name


def title(packing: Packing) -> str:
    """By packing and impact."""
    return f"Tolerances: {packing.title}" + (_told(packing) if packing.label not in packing.title else "")


def pictures(packing: Packing) -> Iterator[Picture]:
    """Quantities against each imperfection, maps of two, and the confidence that the seeds give."""
    for axis in packing.axes:
        drawing = figures.against(packing, axis)
        if drawing is not None:
            random = any(packing.random(setting) for setting in packing.tried(axis))
            what = "means, 95 % confidence bands, and single runs as dots" if random else "nothing is random here"
            seen = "An imperfection matters from where a band leaves the value at 0, which is the ideal packing's"
            yield Picture(f"_{axis.name}", f"Against {axis.words}: {what}{_told(packing)}. {seen}", drawing)
    for across, up in itertools.combinations(packing.axes, 2):
        drawing = figures.left_of_ideal(packing, across, up)
        if drawing is not None:
            caption = f"{across.words.capitalize()} and {up.words} together, in per cent of the ideal packing's"
            seen = "Numbers that change along rows and columns alike tell that both imperfections matter"
            yield Picture(f"_{across.name}_{up.name}", f"{caption}{_told(packing)}. {seen}", drawing)
    drawing = figures.seeds(packing)
    if drawing is not None:
        caption = "Confidence of the mean of the first n seeds, and what the scatter of all of them makes of n"
        seen = "Where the curves have fallen to the precision that is wanted, there are seeds enough"
        yield Picture("_seeds", f"{caption}{_told(packing)}. {seen}", drawing)


def tables(packing: Packing) -> Iterator[Table]:
    """Means of all settings, and those of performance against the ideal packing."""
    axes = numeric(*((axis.words.capitalize(), axis.unit) for axis in packing.axes), key=True)
    heads = (*axes, *numeric("Seeds"))
    shown, settings = packing.shown(), packing.settings
    columns = numeric(*((one.words.capitalize(), one.unit) for one in shown))
    rows = [(*_heads(packing, s), *(_value(packing, s, one) for one in shown)) for s in settings]
    yield table_of(f"Mean and 95 % confidence interval{_told(packing)}", (*heads, *columns), rows, sortable=True)
    kept = [one for one in packing.performance if any(packing.left(one, setting) for setting in settings)]
    if kept:
        columns = numeric(*((one.words.capitalize(), "% of the ideal's") for one in kept))
        rows = [(*_heads(packing, s), *(_over_ideal(packing, s, one) for one in kept)) for s in settings if s != IDEAL]
        yield table_of(f"Against the ideal packing{_told(packing)}", (*heads, *columns), rows, sortable=True)


def _labels(titles: Sequence[str]) -> list[str]:
    """Label each of several packings for captions; empty for a single one."""
    if len(titles) < 2:
        return [""] * len(titles)
    parts = [title.split(", ") for title in titles]
    own = [", ".join(part for part in words if not all(part in other for other in parts)) for words in parts]
    if len(set(own)) < len(own):  # they differ in what no title says
        own = [", ".join(filter(None, (words, f"packing {n}"))) for n, words in enumerate(own, start=1)]
    return own


def _told(packing: Packing) -> str:
    """End of a caption: the packing, where there are several."""
    return f" ({packing.label})" if packing.label else ""


def _heads(packing: Packing, setting: Setting) -> Iterator[Cell]:
    for axis in packing.axes:
        yield Cell(f"{axis.of(setting):g}", axis.of(setting))
    n = packing.seeds(setting)
    yield Cell(str(n), n) if packing.random(setting) else Cell("not random", 0)


def _value(packing: Packing, setting: Setting, quantity: Quantity) -> Cell:
    found = packing.of(quantity, setting)
    return Cell(with_interval(found, quantity.scale), found.mean) if found else Cell(BLANK)


def _over_ideal(packing: Packing, setting: Setting, quantity: Quantity) -> Cell:
    share = packing.over_ideal(quantity, setting)
    if share is None:
        return Cell(BLANK)
    alike = not share.exact and differ_significantly(exactly(1.0), share) is False
    return Cell(with_interval(share.over(0.01)) + (", not to be told from it" if alike else ""), 100 * share.mean)
