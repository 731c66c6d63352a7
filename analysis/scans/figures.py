"""Figures of a scan: dissipation, plastic zone, peak force and wave speed against the varied keys.

Only finished points are shown. Points that differ in ``packing.seed`` only are shown as their mean,
with the 95 % confidence interval as error bar. A quantity that is 0 at all points, such as the
dissipation without yielding, has no figure.
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
from granwave.analysis.scans.table import (
    TIMES,
    determines,
    independent_keys,
    labels_of,
    physical,
)
from granwave.analysis.statistics import estimate
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import read_stored_case
from granwave.lammps_inputs.run_directory import CASE_FILE

_UNITS_OF_ITS_OWN = ("load.", "run.", "boundary.", "output.", SEED, "packing.size", "packing.kind")
_OF_ZONE = ("plastic_", "zone_")  # names of figures of plastic zones
#: Units of lengths that are not divided by the diameter, with the factor from SI.
_SHOWN_IN = {"m": ("mm", 1e3), "m^3": ("mm^3", 1e9)}

Value = Callable[[PointResult], float]
Drawers = dict[str, Callable[[], Drawing | None]]  # functions that draw figures, by name
_Scale = tuple[str, str, dict[int, float]]  # symbol, words, and size by number of the point


@dataclasses.dataclass(frozen=True)
class Ordinate:
    """Quantity that is plotted.

    Attributes
    ----------
    name
        Start of the figure's name.
    title, column
        Title of the axis, and name of the column of data.
    value
        Function that returns the value of a point.
    """

    name: str
    title: str
    column: str
    value: Value

    @property
    def zone(self) -> bool:
        """True for a plastic zone; its points are marked where the zone reaches a boundary."""
        return self.name.startswith(_OF_ZONE)


def ordinates(varied: Sequence[str], done: Sequence[PointResult]) -> list[Ordinate]:
    """Return the quantities that can be shown of finished points.

    Parameters
    ----------
    varied
        Keys that vary in the scan.
    """
    lengths, forces = _scales(varied, done)
    scales: dict[str, _Scale] = {}
    if all(map(math.isfinite, lengths.values())):
        scales["m"] = ("D", "diameter", lengths)
    if all(map(math.isfinite, forces.values())):
        scales["N"] = (r"F_\mathrm{y}", "yield_force", forces)
    with_value: set[str] = set()
    for point in done:
        with_value |= {key for key, value in point.summary.items() if value is not None}
    shown = [_ordinate(name, key, scales) for name, key in scan_figures(with_value).items()]
    left_out = set()
    if not all(math.isfinite(_number(point, "restitution")) for point in done):
        left_out.add("restitution")
    if any(math.isfinite(_number(point, "n_plastic_spheres")) for point in done):
        left_out.add("plastic_zone_volume")  # shown by the number of spheres
    if not protects(varied, [point.summary for point in done]):
        left_out.add(REDUCTION)
    return [ordinate for ordinate in shown if ordinate.name not in left_out]


def _ordinate(name: str, key: str, scales: Mapping[str, _Scale]) -> Ordinate:
    """A value of the summary, divided by the scale of its unit if it has one."""
    entry = quantity(key)
    number = plastic_spheres if key == "n_plastic_spheres" else value_of(key)
    if entry.symbol and entry.unit in scales:
        symbol, words, sizes = scales[entry.unit]
        title = f"{entry.axis} ${entry.symbol}/{symbol}$"
        column = f"{name}_over_{words}"
        return Ordinate(name, title, column, lambda point: number(point) / sizes[point.number])
    unit, factor = _SHOWN_IN.get(entry.unit, (entry.unit, 1.0))
    title = entry.title + (f" ({printed_unit(unit)})" if unit else "")
    column = key if unit == entry.unit else f"{name}_{unit.replace('^', '')}"
    return Ordinate(name, title, column, lambda point: factor * number(point))


def _scales(
    varied: Sequence[str], done: Sequence[PointResult]
) -> tuple[dict[int, float], dict[int, float]]:
    """Return the diameter (m) and the yield force (N) of points by number; NaN without.

    Each case is read once.
    """
    keys = [key for key in varied if not key.startswith(_UNITS_OF_ITS_OWN)]
    scales: dict[tuple[Any, ...], tuple[float, float]] = {}
    lengths = {}
    forces = {}
    for point in done:
        labels = tuple(point.labels.get(key) for key in keys)
        if labels not in scales:
            try:
                case = read_stored_case((point.directory or Path()) / CASE_FILE)
                force = sphere_contact(case).yield_force if case.contact.yields else math.nan
                scales[labels] = (case.packing.diameter, force)
            except (InputError, OSError):
                scales[labels] = (math.nan, math.nan)
        diameter, force = scales[labels]
        lengths[point.number] = diameter
        forces[point.number] = force
    return lengths, forces


def _number(point: PointResult, name: str) -> float:
    value = point.summary.get(name)
    return float(value) if value is not None and is_number(value) else math.nan


def value_of(name: str) -> Value:
    """Return a function that returns a value of the summary of a point; NaN without."""
    return lambda point: _number(point, name)


def plastic_spheres(point: PointResult) -> float:
    """Return the number of yielded spheres of a point; NaN for a law that does not yield."""
    yields = point.summary.get("plastic_zone_volume_m3") is not None
    return _number(point, "n_plastic_spheres") if yields else math.nan


_FEWEST = 2  # smallest number of points in a figure
_MOST_SINGLE = 8  # largest number of curves if each has a single point
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
        drawn = drawings(result)
        for name, drawing in drawn.items():
            folder.save(drawing, name, formats=("pdf",) if pdf else ())
    folder.remove(
        *(name for name in folder.names() if _OF_A_SCAN.fullmatch(name) and name not in drawn)
    )
    return folder.written


def drawings(result: ScanResult) -> dict[str, Drawing | NotDrawn]:
    """Draw the figures of the present state of a scan; return them by name."""
    drawn: dict[str, Drawing | NotDrawn] = {}
    called = grains_called_in(point.summary for point in result.points if point.status == "done")
    for name, draw in _figures(result).items():
        drawing = attempt(f"figure {name}", draw)
        if isinstance(drawing, Drawing):
            drawing.call_grains(called)
        if drawing is not None:
            drawn[name] = drawing
    return drawn


def _figures(result: ScanResult) -> Drawers:
    """Return functions that draw the figures of a scan, by name."""
    data = _Data.of(result)
    if data is None:
        return {}
    figures: Drawers = {}
    for name in _abscissae(data.keys, data.free):
        figures |= data.curves_over(name)
    if not any(data.keys[name].numeric for name in data.free):
        figures |= data.bars()
    if "load.velocity" in data.free and any(map(_is_of_material, data.free)):
        figures |= data.collapses()
    if len(data.free) == 2 and all(data.keys[name].numeric for name in data.free):
        figures |= data.map_of_dissipation()
    return figures


def _is_of_material(key: str) -> bool:
    return key.split(".")[0] == "material"


@dataclasses.dataclass(frozen=True)
class _Data:
    """Finished points of a scan, with the quantities that figures show.

    Attributes
    ----------
    points
        Finished points by row of the scan.
    keys
        Varied keys by name.
    free
        Names of the independent keys.
    marks
        `Mark` of the plastic zone, by row.
    ordinates
        Quantities with their values by row; quantities that are 0 at all points are left out.
    """

    points: dict[int, PointResult]
    keys: dict[str, VariedKey]
    free: list[str]
    marks: Series
    ordinates: list[tuple[Ordinate, Series]]

    @classmethod
    def of(cls, result: ScanResult) -> _Data | None:
        """Return the data of a scan; None with too few points, or without an independent key."""
        names = [key for key in result.varied if key != SEED]
        labels = physical(labels_of(result.points, names))
        free = independent_keys(labels)
        points = {row: point for row, point in enumerate(result.points) if point.status == "done"}
        if len(points) < _FEWEST or not free:
            return None
        units = result.units
        keys = {name: key_of(name, column, units.get(name, "")) for name, column in labels.items()}
        marks = Series({row: int(mark_of(point.summary)) for row, point in points.items()})
        shown = []
        for ordinate in ordinates(result.varied, list(points.values())):
            values = _values(ordinate.value, points)
            if (values.abs() > _NOTHING).any():
                shown.append((ordinate, values))
        return cls(points, keys, free, marks, shown)

    def curves_over(self, name: str) -> Drawers:
        """Return functions that draw all quantities over a key."""
        x = self.keys[name]
        others = _others(self.keys, self.free, name)
        curves = _curve_rows(self.points, others).values()
        joined = all(_is_one_line(rows, x, self.keys.values()) for rows in curves)
        figures: Drawers = {}
        for ordinate, values in self.ordinates:
            marks = self.marks * ordinate.zone
            figures[f"{ordinate.name}_vs_{x.slug}"] = partial(
                _curves, x, others, ordinate, values, marks, joined=joined
            )
        return figures

    def bars(self) -> Drawers:
        """Return functions that draw bars of all quantities for each value of the first key."""
        x, *others = (self.keys[name] for name in self.free)
        figures: Drawers = {}
        for ordinate, values in self.ordinates:
            marks = self.marks * ordinate.zone
            figures[f"{ordinate.name}_vs_{x.slug}"] = partial(
                _bars, x, others, ordinate, values, marks
            )
        return figures

    def collapses(self) -> Drawers:
        """Return functions that draw dissipation and plastic volume on normalised axes."""
        fraction = "dissipated_fraction"
        figures = {
            f"collapse_{fraction}": self._collapse(
                "velocity_normalised",
                (quantity(fraction).title, fraction),
                _values(value_of(fraction), self.points),
                self.marks * False,
            ),
            "collapse_plastic_volume": self._collapse(
                "energy_input_normalised",
                (r"Plastic zone volume $V_\mathrm{p}/(\pi D^3/6)$", "plastic_volume_in_spheres"),
                _values(plastic_spheres, self.points),
                self.marks,
            ),
        }
        return {name: draw for name, draw in figures.items() if draw is not None}

    def _collapse(
        self, key: str, ordinate: tuple[str, str], values: Series, marks: Series
    ) -> Callable[[], Drawing] | None:
        """Return a function that draws values over a normalised quantity; None with too few points.

        ``ordinate`` has the title and the column of the values.
        """
        title, column = ordinate
        others = _others(self.keys, self.free, "load.velocity")
        table = points_of(_values(value_of(key), self.points), values, others, marks)
        if len(table) < _FEWEST:
            return None
        titles = (quantity(key).title, title)
        columns = (key, column)
        return partial(draw_curves, table, *titles, others, columns, joined=False, chosen=False)

    def map_of_dissipation(self) -> Drawers:
        """Return a function that draws the dissipated fraction over two keys."""
        x, y = (self.keys[name] for name in self.free)
        for ordinate, values in self.ordinates:
            if ordinate.name == "dissipated_fraction":
                return {"dissipated_fraction_map": partial(_map, x, y, ordinate, values)}
        return {}


def _values(value: Value, points: Mapping[int, PointResult]) -> Series:
    """Return a value of points by row."""
    return Series({row: value(point) for row, point in points.items()}, dtype=float)


def _abscissae(keys: dict[str, VariedKey], free: Sequence[str]) -> list[str]:
    """Return the independent numeric keys, and keys that are equivalent to one of them, except run
    times.
    """
    chosen = []
    for name, key in keys.items():
        alike = [other for other in free if determines(key.labels, keys[other].labels)]
        along = bool(alike) and not name.startswith(TIMES)
        if key.numeric and len(set(key.values)) > 1 and (name in free or along):
            chosen.append(name)
    return chosen


def _others(keys: dict[str, VariedKey], free: Sequence[str], x: str) -> list[VariedKey]:
    """Return the keys that distinguish curves over ``x``: the keys that ``x`` does not determine.

    A key with fewer values than ``x`` distinguishes curves too, although ``x`` determines it.
    """
    abscissae = keys[x].labels
    chosen = [
        keys[name] for name in free if name != x and not determines(abscissae, keys[name].labels)
    ]
    for key in keys.values():
        has_fewer = determines(abscissae, key.labels) and not determines(key.labels, abscissae)
        if has_fewer and len(set(key.labels)) > 1:
            settings = list(zip(*(other.labels for other in chosen), strict=True))
            if not settings or not determines(settings, key.labels):
                chosen.append(key)
    return chosen


def _curve_rows(
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


def _is_one_line(rows: Sequence[int], x: VariedKey, keys: Iterable[VariedKey]) -> bool:
    """Return True if all other varying keys are monotonic in the abscissa, so that points may be
    joined.
    """
    abscissae = [x.labels[row] for row in rows]
    for key in keys:
        if key.numeric and determines(abscissae, [key.labels[row] for row in rows]):
            points = sorted({(x.values[row], key.values[row]) for row in rows})
            steps = np.diff([value for _, value in points])
            if np.any(steps > 0) and np.any(steps < 0):
                return False
    return True


def points_of(x: Series, y: Series, others: Sequence[VariedKey], marks: Series) -> DataFrame:
    """Return the points of curves, as `granwave.analysis.scans.drawing` takes them; points at the
    same abscissa are averaged.

    Parameters
    ----------
    x, y, marks
        Abscissa, value and `Mark` by row of the scan; a mean gets the most severe mark of its
        points.
    others
        Keys that distinguish curves.
    """
    table = DataFrame({"x": x, "y": y, "mark": marks}).dropna()
    names = ["mean", "deviation", "half_width", "count", "mark"]
    curves = []
    for curve, members in enumerate(_curve_rows(table.index, others).values()):
        places = table.loc[members].groupby(table.x.map(lambda value: float(f"{value:.12g}")))
        rows = []
        for (_, values), mark in zip(places.y, places["mark"].max(), strict=True):
            mean = estimate(values.tolist())
            rows.append((mean.mean, mean.deviation, mean.half_width, mean.n, mark))
        points = DataFrame(rows, columns=names)
        curves.append(points.assign(curve=curve, row=members[0], x=list(places.groups)))
    if not curves:
        return DataFrame(columns=["curve", "row", "x", *names])
    return concat(curves, ignore_index=True)


def _curves(
    x: VariedKey,
    others: Sequence[VariedKey],
    quantity: Ordinate,
    values: Series,
    marks: Series,
    *,
    joined: bool,
) -> Drawing | None:
    """Draw curves; None for too few points, or for many curves that all have a single point."""
    table = points_of(Series(x.values, dtype=float)[values.index], values, others, marks)
    sizes = table.groupby("curve").size()
    if len(table) < _FEWEST or table.x.nunique() < _FEWEST:
        return None
    if len(sizes) > _MOST_SINGLE and (sizes == 1).all():
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
