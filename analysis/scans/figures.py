"""Figures of a scan: dissipation, plastic zone, peak force and wave speed against the varied keys.

Only finished points are shown. Points that differ in ``packing.seed`` only are shown as their mean,
with the 95 % confidence interval as error bar. A quantity that is 0 at all points, as dissipation
without yielding, has no figure.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pandas import DataFrame, Series, concat

from granwave.analysis.document.model import is_number
from granwave.analysis.figures.style import Drawing, FigureFolder, NotDrawn, attempt, style
from granwave.analysis.formatting.values import grains_called_in, printed_unit
from granwave.analysis.measures.zone_size import mark_of
from granwave.analysis.quantities import quantity, scan_figures
from granwave.analysis.scans.drawing import draw_bars, draw_curves, draw_map
from granwave.analysis.scans.keys import VariedKey, key_of
from granwave.analysis.scans.result import REDUCTION, SEED, PointResult, ScanResult, protects
from granwave.analysis.scans.table import TIMES, determines, independent_keys, physical
from granwave.analysis.statistics import estimate
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import read_stored_case
from granwave.lammps_inputs.run_directory import CASE_FILE

_UNITS_OF_ITS_OWN = ("load.", "run.", "boundary.", "output.", SEED, "packing.size", "packing.kind")
_OF_ZONE = ("plastic_", "zone_")  # names of figures of plastic zones
_SHOWN_IN = {
    "m": ("mm", 1e3),
    "m^3": ("mm^3", 1e9),
}  # where lengths have no diameter to be divided by

Value = Callable[[PointResult], float]


@dataclasses.dataclass(frozen=True)
class Ordinate:
    """Quantity that is plotted: the start of the figure's name, a title for the axis, a column, a
    value by point.
    """

    name: str
    title: str
    column: str
    value: Value

    @property
    def zone(self) -> bool:
        """True for a plastic zone; its points are marked where it reaches a boundary."""
        return self.name.startswith(_OF_ZONE)


def ordinates(varied: Sequence[str], done: Sequence[PointResult]) -> list[Ordinate]:
    """Return the quantities that figures can show of finished points.

    Parameters
    ----------
    varied
        Keys that vary in the scan.
    """
    lengths, forces = _scales(varied, done)
    scales: dict[str, tuple[str, str, dict[int, float]]] = {
        "m": ("D", "diameter", lengths),
        "N": (r"F_\mathrm{y}", "yield_force", forces),
    }
    known = {
        unit: scale for unit, scale in scales.items() if all(map(math.isfinite, scale[2].values()))
    }
    there = {key for point in done for key, value in point.summary.items() if value is not None}
    found = [_ordinate(name, key, known) for name, key in scan_figures(there).items()]
    left_out = set()
    if not all(math.isfinite(_number(point, "restitution")) for point in done):
        left_out.add("restitution")
    if any(math.isfinite(_number(point, "n_plastic_spheres")) for point in done):
        left_out.add("plastic_zone_volume")  # the number of spheres tells it
    if not protects(varied, [point.summary for point in done]):
        left_out.add(REDUCTION)
    return [one for one in found if one.name not in left_out]


def _ordinate(
    name: str, key: str, scales: Mapping[str, tuple[str, str, dict[int, float]]]
) -> Ordinate:
    """A value of the summary, over the scale of its unit where there is one."""
    entry = quantity(key)
    number = plastic_spheres if key == "n_plastic_spheres" else value_of(key)
    if entry.symbol and entry.unit in scales:
        symbol, words, scale = scales[entry.unit]
        title = f"{entry.axis} ${entry.symbol}/{symbol}$"
        column = f"{name}_over_{words}"
        return Ordinate(name, title, column, lambda point: number(point) / scale[point.number])
    unit, factor = _SHOWN_IN.get(entry.unit, (entry.unit, 1.0))
    title = entry.title + (f" ({printed_unit(unit)})" if unit else "")
    column = key if unit == entry.unit else f"{name}_{unit.replace('^', '')}"
    return Ordinate(name, title, column, lambda point: factor * number(point))


def _scales(
    varied: Sequence[str], done: Sequence[PointResult]
) -> tuple[dict[int, float], dict[int, float]]:
    """Return diameter (m) and yield force (N) of points by number, NaN where there is none; each
    case is read once.
    """
    keys = [key for key in varied if not key.startswith(_UNITS_OF_ITS_OWN)]
    known: dict[tuple[Any, ...], tuple[float, float]] = {}
    lengths = {}
    forces = {}
    for point in done:
        labels = tuple(point.labels.get(key) for key in keys)
        if labels not in known:
            try:
                case = read_stored_case((point.directory or Path()) / CASE_FILE)
                force = sphere_contact(case).yield_force if case.contact.yields else math.nan
                known[labels] = case.packing.diameter, force
            except (InputError, OSError):
                known[labels] = math.nan, math.nan
        lengths[point.number], forces[point.number] = known[labels]
    return lengths, forces


def _number(point: PointResult, name: str) -> float:
    value = point.summary.get(name)
    return float(value) if value is not None and is_number(value) else math.nan


def value_of(name: str) -> Value:
    """Return a function that takes a value of the summary, NaN where there is none."""
    return lambda point: _number(point, name)


def plastic_spheres(point: PointResult) -> float:
    """NaN for a law that does not yield."""
    yields = point.summary.get("plastic_zone_volume_m3") is not None
    return _number(point, "n_plastic_spheres") if yields else math.nan


_FEWEST = 2  # points of a figure
_MOST_SINGLE = 8  # curves of a single point that are shown
_NOTHING = 1e-12  # magnitude below which values are due to rounding

_OF_A_SCAN = re.compile(r".+_vs_.+|collapse_.+|.+_map")  # names of figures, as below


def draw_scan_figures(scan: str | Path | ScanResult, *, pdf: bool = True) -> list[Path]:
    """Draw the figures of a scan into its ``figures``; figures that no longer apply are removed.

    For each numeric key: ``QUANTITY_vs_KEY``, with curves by the other keys. If no independent key
    is numeric: bars for each value of the first. If velocity and material vary:
    ``collapse_QUANTITY``, on normalised axes. If exactly two numeric keys vary and fill a grid:
    ``dissipated_fraction_map``.

    Parameters
    ----------
    scan
        Directory of the scan, or the scan itself, whose summaries are cached if figures are drawn
        repeatedly.
    pdf
        False to omit the PDF of each figure, which saves half of the time, and to remove earlier
        ones.

    Returns
    -------
    list of Path
        Paths of the PNG files.

    Raises
    ------
    MissingOutputError
        There is no scan in the directory.
    OutputFormatError
        The index of the scan is damaged.
    """
    result = scan if isinstance(scan, ScanResult) else ScanResult(scan)
    folder = FigureFolder(result.results)
    with style():
        found = drawings(result)
        for name, drawing in found.items():
            folder.save(drawing, name, formats=("pdf",) if pdf else ())
    folder.remove(
        *(name for name in folder.names() if _OF_A_SCAN.fullmatch(name) and name not in found)
    )
    return folder.written


def drawings(result: ScanResult) -> dict[str, Drawing | NotDrawn]:
    """Draw the figures of the present state of a scan; return them by name."""
    found: dict[str, Drawing | NotDrawn] = {}
    called = grains_called_in(point.summary for point in result.points if point.status == "done")
    for name, draw in _figures(result).items():
        drawing = attempt(f"figure {name}", draw)
        if isinstance(drawing, Drawing):
            drawing.call_grains(called)
        if drawing is not None:
            found[name] = drawing
    return found


Drawer = Callable[[], Drawing | None]


@dataclasses.dataclass(frozen=True)
class ScanContent:
    """Finished points of a scan, for its figures.

    Attributes
    ----------
    points
        Points by row.
    rows
        Rows of the finished points.
    keys
        Varied keys by name, without the seed.
    free
        Names of the independent keys.
    shown
        Quantities that are not zero everywhere, with their values by row.
    marks
        Mark of the plastic zone, by row.
    """

    points: Sequence[PointResult]
    rows: list[int]
    keys: dict[str, VariedKey]
    free: Sequence[str]
    shown: list[tuple[Ordinate, Series]]
    marks: Series

    @property
    def numeric(self) -> list[str]:
        """Names of the independent keys that are numbers."""
        return [name for name in self.free if self.keys[name].numeric]

    def values(self, value: Value) -> Series:
        """Return the values of the finished points, by row."""
        return _values(self.points, self.rows, value)

    def marks_of(self, quantity: Ordinate) -> Series:
        """Return the marks by row; none of a quantity that is no plastic zone."""
        return self.marks * quantity.zone


def _values(points: Sequence[PointResult], rows: Sequence[int], value: Value) -> Series:
    return Series({row: value(points[row]) for row in rows}, dtype=float)


def _figures(result: ScanResult) -> dict[str, Drawer]:
    """Return functions that draw what a scan may show, by name."""
    content = _content(result)
    if content is None:
        return {}
    return (
        _curve_figures(content)
        | _bar_figures(content)
        | _collapse_figures(content)
        | _map_figures(content)
    )


def _content(result: ScanResult) -> ScanContent | None:
    """Return the content of a scan; None with too few finished points, or without a free key."""
    points = result.points
    varied = [key for key in result.varied if key != SEED]
    labels = physical({key: [point.labels.get(key) for point in points] for key in varied})
    free = independent_keys(labels)
    rows = [row for row, point in enumerate(points) if point.status == "done"]
    if len(rows) < _FEWEST or not free:
        return None
    shown = []
    for ordinate in ordinates(result.varied, [points[row] for row in rows]):
        values = _values(points, rows, ordinate.value)
        if (values.abs() > _NOTHING).any():
            shown.append((ordinate, values))
    units = result.units
    return ScanContent(
        points=points,
        rows=rows,
        keys={name: key_of(name, labels[name], units.get(name, "")) for name in labels},
        free=free,
        shown=shown,
        marks=Series({row: int(mark_of(points[row].summary)) for row in rows}),
    )


def _curve_figures(content: ScanContent) -> dict[str, Drawer]:
    """Curves of each quantity over each numeric key."""
    figures: dict[str, Drawer] = {}
    for name in _abscissae(content.keys, content.free):
        x = content.keys[name]
        others = _others(content.keys, content.free, name)
        curves = _curve_rows(content.rows, others).values()
        joined = all(_is_one_line(curve, x, content.keys.values()) for curve in curves)
        for ordinate, values in content.shown:
            marks = content.marks_of(ordinate)
            figures[f"{ordinate.name}_vs_{x.slug}"] = partial(
                _curves, x, others, ordinate, values, marks, joined=joined
            )
    return figures


def _bar_figures(content: ScanContent) -> dict[str, Drawer]:
    """Bars of each quantity by the first key, if no key is numeric."""
    if content.numeric:
        return {}
    x, *others = (content.keys[name] for name in content.free)
    return {
        f"{ordinate.name}_vs_{x.slug}": partial(
            _bars, x, others, ordinate, values, content.marks_of(ordinate)
        )
        for ordinate, values in content.shown
    }


def _collapse_figures(content: ScanContent) -> dict[str, Drawer]:
    """Quantities of several velocities and materials on normalised axes."""
    materials = [name for name in content.free if name.split(".")[0] == "material"]
    if "load.velocity" not in content.free or not materials:
        return {}
    fraction = quantity("dissipated_fraction")
    collapses = {
        "collapse_dissipated_fraction": _collapse(
            content,
            "velocity_normalised",
            Ordinate(
                "dissipated_fraction",
                fraction.title,
                "dissipated_fraction",
                value_of("dissipated_fraction"),
            ),
        ),
        "collapse_plastic_volume": _collapse(
            content,
            "energy_input_normalised",
            Ordinate(
                "plastic_volume",
                r"Plastic zone volume $V_\mathrm{p}/(\pi D^3/6)$",
                "plastic_volume_in_spheres",
                plastic_spheres,
            ),
        ),
    }
    return {name: drawer for name, drawer in collapses.items() if drawer is not None}


def _collapse(content: ScanContent, x: str, ordinate: Ordinate) -> Drawer | None:
    """Curves of an ordinate over a normalised value of the summaries; None for too few points."""
    others = _others(content.keys, content.free, "load.velocity")
    table = points_of(
        content.values(value_of(x)),
        content.values(ordinate.value),
        others,
        content.marks_of(ordinate),
    )
    if len(table) < _FEWEST:
        return None
    titles = (quantity(x).title, ordinate.title)
    columns = (x, ordinate.column)
    return partial(draw_curves, table, *titles, others, columns, joined=False, chosen=False)


def _map_figures(content: ScanContent) -> dict[str, Drawer]:
    """Map of the dissipated share over two numeric keys."""
    if len(content.free) != 2 or len(content.numeric) != 2:
        return {}
    x, y = (content.keys[name] for name in content.free)
    for ordinate, values in content.shown:
        if ordinate.name == "dissipated_fraction":
            return {"dissipated_fraction_map": partial(_map, x, y, ordinate, values)}
    return {}


def _abscissae(keys: dict[str, VariedKey], free: Sequence[str]) -> list[str]:
    """Return the independent numeric keys and their equivalents, except run times."""
    chosen = []
    for name, key in keys.items():
        alike = [other for other in free if determines(key.labels, keys[other].labels)]
        along = bool(alike) and not name.startswith(TIMES)
        if key.numeric and len(set(key.values)) > 1 and (name in free or along):
            chosen.append(name)
    return chosen


def _others(keys: dict[str, VariedKey], free: Sequence[str], x: str) -> list[VariedKey]:
    """Return the keys that distinguish curves over ``x``: all keys that the values of ``x`` do not
    determine.

    A key with fewer values than ``x`` groups the points, even if no abscissa occurs with two of its
    values.
    """
    chosen = [
        keys[name]
        for name in free
        if name != x and not determines(keys[x].labels, keys[name].labels)
    ]
    for key in keys.values():
        groups = determines(keys[x].labels, key.labels) and not determines(
            key.labels, keys[x].labels
        )
        distinguished = list(zip(*(other.labels for other in chosen), strict=True))
        if (
            groups
            and len(set(key.labels)) > 1
            and not (distinguished and determines(distinguished, key.labels))
        ):
            chosen.append(key)
    return chosen


def _curve_rows(
    rows: Iterable[int], others: Sequence[VariedKey]
) -> dict[tuple[Any, ...], list[int]]:
    """Group the points by curve: equal values of ``others``, numbers by size, text in the order of
    the scan.
    """
    curves: dict[tuple[Any, ...], list[int]] = {}
    for row in rows:
        place = tuple(
            key.values[row] if key.numeric else key.values.index(key.values[row]) for key in others
        )
        curves.setdefault(place, []).append(row)
    return {place: curves[place] for place in sorted(curves)}


def _is_one_line(rows: Sequence[int], x: VariedKey, keys: Iterable[VariedKey]) -> bool:
    """True if all other varying keys are monotonic in the abscissa, so that points may be joined."""
    for key in keys:
        if not key.numeric or not determines(
            [x.labels[row] for row in rows], [key.labels[row] for row in rows]
        ):
            continue
        steps = np.diff(
            [value for _, value in sorted({(x.values[row], key.values[row]) for row in rows})]
        )
        if np.any(steps > 0) and np.any(steps < 0):
            return False
    return True


def points_of(x: Series, y: Series, others: Sequence[VariedKey], marks: Series) -> DataFrame:
    """Return the points of curves, as `granwave.analysis.scans.drawing` takes them; those at one
    abscissa are averaged.

    Parameters
    ----------
    x, y, marks
        Abscissa, value and `Mark` by row of the scan; a mean gets the most severe mark of its
        points.
    others
        Keys that tell curves apart.
    """
    table = DataFrame({"x": x, "y": y, "mark": marks}).dropna()
    names = ["mean", "deviation", "half_width", "count", "mark"]
    curves = []
    for curve, members in enumerate(_curve_rows(table.index, others).values()):
        places = table.loc[members].groupby(table.x.map(lambda value: float(f"{value:.12g}")))
        means = [estimate(values.tolist()) for _, values in places.y]
        found = [(one.mean, one.deviation, one.half_width, one.n) for one in means]
        rows = [(*one, mark) for one, mark in zip(found, places["mark"].max(), strict=True)]
        curves.append(
            DataFrame(rows, columns=names).assign(
                curve=curve, row=members[0], x=list(places.groups)
            )
        )
    return (
        concat(curves, ignore_index=True)
        if curves
        else DataFrame(columns=["curve", "row", "x", *names])
    )


def _curves(
    x: VariedKey,
    others: Sequence[VariedKey],
    quantity: Ordinate,
    values: Series,
    marks: Series,
    *,
    joined: bool,
) -> Drawing | None:
    """None where there are no curves: too few points, or many settings each at one abscissa."""
    table = points_of(Series(x.values, dtype=float)[values.index], values, others, marks)
    sizes = table.groupby("curve").size()
    if (
        len(table) < _FEWEST
        or table.x.nunique() < _FEWEST
        or (len(sizes) > _MOST_SINGLE and (sizes == 1).all())
    ):
        return None
    columns = (x.column, quantity.column)
    return draw_curves(
        table, x.title, quantity.title, others, columns, scale=x.naming.scale, joined=joined
    )


def _bars(
    x: VariedKey, others: Sequence[VariedKey], quantity: Ordinate, values: Series, marks: Series
) -> Drawing | None:
    categories = list(dict.fromkeys(x.values))
    places = Series([categories.index(value) for value in x.values])
    table = points_of(places[values.index], values, others, marks)
    if len(table) < _FEWEST:
        return None
    ticks = [x.tick(x.values.index(category)) for category in categories]
    return draw_bars(table, ticks, x.title, quantity.title, others, (x.column, quantity.column))


def _map(x: VariedKey, y: VariedKey, quantity: Ordinate, values: Series) -> Drawing | None:
    columns = sorted(set(x.values))
    lines = sorted(set(y.values))
    if len(set(zip(x.values, y.values, strict=True))) != len(columns) * len(lines):
        return None  # no grid
    rows = values.dropna().index
    cells = values[rows].groupby([Series(y.values)[rows], Series(x.values)[rows]]).mean()
    if len(cells) < _FEWEST:
        return None
    table = cells.unstack().reindex(index=lines, columns=columns).to_numpy()
    return draw_map(table, (columns, lines), (x, y), quantity.title, quantity.column)
