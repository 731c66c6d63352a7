"""Points of curves and bars of a scan: means over random packings, with their error bars.

There is no table for quantities that do not change along any curve, or for too few points.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from pandas import DataFrame, Series, concat

from granwave.analysis.scans.abscissae import FEWEST
from granwave.analysis.scans.keys import VariedKey
from granwave.analysis.scans.ordinates import is_constant
from granwave.analysis.scans.table import (
    determines,
)
from granwave.analysis.statistics import estimate

_MOST_SINGLE = 8  # largest number of curves if each has a single point
NOTHING = 1e-12  # magnitude below which values are due to rounding


def curve_rows(
    rows: Iterable[int], others: Sequence[VariedKey]
) -> dict[tuple[Any, ...], list[int]]:
    """Group the points by curve, with equal values of ``others``.

    Numbers are in rising order, words in the order of the scan.
    """

    def rank(key: VariedKey, row: int) -> float:
        value = key.values[row]
        return value if key.numeric else key.values.index(value)

    curves: dict[tuple[Any, ...], list[int]] = {}
    for row in rows:
        curves.setdefault(tuple(rank(key, row) for key in others), []).append(row)
    return {ranks: curves[ranks] for ranks in sorted(curves)}


def is_one_line(rows: Sequence[int], x: VariedKey, keys: Iterable[VariedKey]) -> bool:
    """Return True if all other varying keys are monotonic in the abscissa, so that points may be
    joined; False if each point belongs to a separate category.
    """
    abscissae = [x.labels[row] for row in rows]
    for key in keys:
        labels = [key.labels[row] for row in rows]
        if not determines(abscissae, labels):
            continue
        if not key.numeric and len(set(labels)) > 1:
            return False
        if key.numeric:
            points = sorted({(x.values[row], key.values[row]) for row in rows})
            steps = np.diff([value for _, value in points])
            if np.any(steps > 0) and np.any(steps < 0):
                return False
    return True


def first_of_equal_rows(
    key: VariedKey, settings: Mapping[int, Mapping[str, Any]], values: Series, marks: Series
) -> list[int]:
    """Return a row for each combination of the other keys, if a key changes neither values nor
    marks at any of them; empty if it does, or if no two points differ in this key only.

    Parameters
    ----------
    settings
        Values of all varied keys by row.
    """
    groups: dict[tuple[Any, ...], list[int]] = {}
    for row, setting in settings.items():
        others = tuple(value for name, value in setting.items() if name != key.name)
        groups.setdefault(others, []).append(row)
    if all(len(rows) < FEWEST for rows in groups.values()):
        return []
    for rows in groups.values():
        is_same = is_constant(values[rows]) and marks[rows].nunique() == 1
        if not is_same or values[rows].isna().nunique() > 1:
            return []
    return [rows[0] for rows in groups.values()]


def points_of(x: Series, y: Series, others: Sequence[VariedKey], marks: Series) -> DataFrame:
    """Return the points of curves in the form for `granwave.analysis.scans.drawing`; points at the
    same abscissa are averaged.

    Parameters
    ----------
    x, y, marks
        Abscissa, value and marks (see `Mark`) by row of the scan; a mean has the marks of all its
        points.
    others
        Keys that distinguish curves.
    """
    table = DataFrame({"x": x, "y": y, "mark": marks}).dropna()
    names = ["mean", "deviation", "half_width", "count", "mark"]
    curves = []
    for curve, members in enumerate(curve_rows(table.index, others).values()):
        places = table.loc[members].groupby(table.x.map(lambda value: float(f"{value:.12g}")))
        rows = []
        for (_, values), (_, marks_here) in zip(places.y, places["mark"], strict=True):
            mean = estimate(values.tolist())
            mark = int(np.bitwise_or.reduce(marks_here.to_numpy()))
            rows.append((mean.mean, mean.deviation, mean.half_width, mean.n, mark))
        points = DataFrame(rows, columns=names)
        curves.append(points.assign(curve=curve, row=members[0], x=list(places.groups)))
    if not curves:
        return DataFrame(columns=["curve", "row", "x", *names])
    return concat(curves, ignore_index=True)


def table_of_curves(
    x: VariedKey, others: Sequence[VariedKey], values: Series, marks: Series
) -> DataFrame | None:
    """Return the points of curves; None for too few points, for many curves that all have a single
    point, and for curves that do not change.
    """
    table = points_of(Series(x.values, dtype=float)[values.index], values, others, marks)
    sizes = table.groupby("curve").size()
    if len(table) < FEWEST or table.x.nunique() < FEWEST:
        return None
    if len(sizes) > _MOST_SINGLE and (sizes == 1).all():
        return None
    if (sizes > 1).any() and not any(_changes(part) for _, part in table.groupby("curve")):
        return None
    return table


def _changes(points: DataFrame) -> bool:
    """Return True for a curve whose values differ, other than from zero to one value and back."""
    values = points["mean"][points["mean"].abs() > NOTHING]
    if len(values) == 1:
        return len(points) > 1
    return not is_constant(values)


def table_of_bars(
    x: VariedKey, others: Sequence[VariedKey], values: Series, marks: Series
) -> DataFrame | None:
    """Return the values of bars; None for too few bars, and for equal bars."""
    categories = categories_of(x)
    places = Series([categories.index(value) for value in x.values])
    table = points_of(places[values.index], values, others, marks)
    if len(table) < FEWEST or is_constant(table["mean"]):
        return None
    return table


def categories_of(x: VariedKey) -> list[Any]:
    """Return the values of a key, each once."""
    return list(dict.fromkeys(x.values))
