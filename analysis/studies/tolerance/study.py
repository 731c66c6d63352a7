"""The study of tolerances: verdict, tables and figures of every packing that was run both ideal and imperfect."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from granwave.analysis.document.cells import BLANK
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.figures.style import style
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import Estimate, differ_significantly
from granwave.analysis.studies.study import Picture, Study
from granwave.analysis.studies.titles import bottom_label, impact_title
from granwave.analysis.studies.tolerance import figures
from granwave.analysis.studies.tolerance.axes import Axis, axes_of
from granwave.analysis.studies.tolerance.quantities import Measured, Quantity, measure
from granwave.analysis.studies.tolerance.runs import IDEAL, Packing, Setting, is_ideal
from granwave.analysis.studies.tolerance.verdict import verdict


def studies(packings: Sequence[Packing], undone: Sequence[Mapping[str, Any]] = ()) -> list[Study]:
    """One for each packing.

    Parameters
    ----------
    undone
        Points of scans that failed or were not run, as values of the keys that vary.
    """
    titles = [f"{impact_title(packing.case)}, {bottom_label(packing.case)}" for packing in packings]
    with style():
        return [
            _study(measure(packing), number, title, own, any(is_ideal(labels, packing) for labels in undone))
            for number, (packing, title, own) in enumerate(zip(packings, titles, _own(titles), strict=True), start=1)
        ]


def _own(titles: Sequence[str]) -> list[str]:
    """Label each of several packings for captions; empty for a single one."""
    if len(titles) < 2:
        return [""] * len(titles)
    parts = [title.split(", ") for title in titles]
    own = [", ".join(part for part in words if not all(part in other for other in parts)) for words in parts]
    if len(set(own)) < len(own):  # they differ in what no title says
        own = [", ".join(filter(None, (words, f"packing {n}"))) for n, words in enumerate(own, start=1)]
    return own


def _study(measured: Measured, number: int, title: str, own: str, ideal_undone: bool) -> Study:
    name = "tolerances" if number == 1 else f"tolerances-{number}"
    told = f" ({own})" if own else ""
    title += told if own not in title else ""
    return Study(
        name,
        f"Tolerances: {title}",
        "Means over the seeds and their 95 % confidence intervals (Student). Values without an interval are of "
        "packings in which nothing is random, or of a single seed. With a diameter scatter, diameters lie between the "
        "nominal one and so much less. A lower peak force and a larger dissipated share protect better.",
        pictures=tuple(_pictures(measured, name.replace("-", "_"), told)),
        tables=tuple(_tables(measured, told)),
        verdict=verdict(measured, asked=ideal_undone),
    )


def _pictures(measured: Measured, name: str, told: str) -> Iterator[Picture]:
    """Figures; ``told`` stands behind each caption."""
    axes = axes_of(measured.packing)
    for axis in axes:
        drawing = figures.against(measured, axis)
        if drawing is not None:
            random = not measured.random.isdisjoint(axis.tried(measured.packing))
            what = "means, 95 % confidence bands, and single runs as dots" if random else "nothing is random here"
            caption = f"Against {axis.words}: {what}"
            yield Picture(f"{name}_{axis.name}", caption + told, drawing)
    for across, up in itertools.combinations(axes, 2):
        drawing = figures.left_of_ideal(measured, across, up)
        if drawing is not None:
            caption = f"{across.words.capitalize()} and {up.words} together, in per cent of the ideal packing's"
            yield Picture(f"{name}_{across.name}_{up.name}", caption + told, drawing)
    drawing = figures.convergence(measured)
    if drawing is not None:
        caption = "Confidence of the mean of the first n seeds, and what the scatter of all of them makes of n"
        yield Picture(f"{name}_seeds", caption + told, drawing)


def _tables(measured: Measured, told: str) -> Iterator[Table]:
    """Tables; ``told`` stands behind each caption."""
    axes = axes_of(measured.packing)
    quantities = measured.shown()
    heads = tuple(Column(axis.words.capitalize(), axis.unit, numeric=True, key=True) for axis in axes)
    rows = tuple(
        (
            *_setting(setting, axes),
            _seeds(measured, setting),
            *(_value(measured.of(one, setting), one.scale) for one in quantities),
        )
        for setting in measured.packing.settings
    )
    seeds = Column("Seeds", numeric=True)
    columns = tuple(Column(one.words.capitalize(), one.unit, numeric=True) for one in quantities)
    yield Table(f"Mean and 95 % confidence interval{told}", (*heads, seeds, *columns), rows, sortable=True)
    kept = [
        one for one in measured.performance if any(measured.left(one, setting) for setting in measured.packing.settings)
    ]
    if kept:
        columns = tuple(Column(one.words.capitalize(), "% of the ideal's", numeric=True) for one in kept)
        rows = tuple(
            (
                *_setting(setting, axes),
                _seeds(measured, setting),
                *(_over_ideal(measured, setting, one) for one in kept),
            )
            for setting in measured.packing.settings
            if setting != IDEAL
        )
        yield Table(f"Against the ideal packing{told}", (*heads, seeds, *columns), rows, sortable=True)


def _setting(setting: Setting, axes: Sequence[Axis]) -> Iterator[Cell]:
    for axis in axes:
        yield Cell(f"{axis.of(setting):g}", axis.of(setting))


def _seeds(measured: Measured, setting: Setting) -> Cell:
    n = measured.seeds(setting)
    return Cell(str(n), n) if setting in measured.random else Cell("not random", 0)


def _value(found: Estimate | None, scale: float) -> Cell:
    return Cell(BLANK) if found is None else Cell(with_interval(found, scale), found.mean)


def _over_ideal(measured: Measured, setting: Setting, quantity: Quantity) -> Cell:
    ideal, now = measured.of(quantity, IDEAL), measured.of(quantity, setting)
    if ideal is None or now is None or not ideal.exact or not ideal.mean:
        return Cell(BLANK)
    share = now.over(ideal.mean / 100)
    doubt = ", not to be told from it" if differ_significantly(ideal, now) is False and not now.exact else ""
    return Cell(with_interval(share) + doubt, share.mean)
