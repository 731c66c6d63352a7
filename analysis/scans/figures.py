"""Figures of a scan: dissipation, plastic zone, peak force and wave speed against the varied keys.

Only finished points are shown. Points that differ in ``packing.seed`` only are shown as their mean, with the 95 %
confidence interval as error bar. A quantity that is 0 at all points, as dissipation without yielding, has no figure.
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

from granwave.analysis.figures.style import Drawing, FigureFolder, NotDrawn, attempt, style
from granwave.analysis.formatting.values import grains_called_in, printed_unit
from granwave.analysis.measures.zone_size import Mark, mark_of
from granwave.analysis.quantities import QUANTITIES, SCAN_FIGURES
from granwave.analysis.scans.drawing import Series, draw_bars, draw_curves, draw_map
from granwave.analysis.scans.keys import Key, key_of
from granwave.analysis.scans.result import REDUCTION, SEED, PointResult, ScanResult, protects
from granwave.analysis.scans.table import TIMES, determines, independent_keys, physical
from granwave.analysis.statistics import estimate
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.run_directory import CASE_FILE

_UNITS_OF_ITS_OWN = ("load.", "run.", "boundary.", "output.", SEED, "packing.size", "packing.kind")
_OF_ZONE = ("plastic_", "zone_")  # names of figures of plastic zones
_SHOWN_IN = {"m": ("mm", 1e3), "m^3": ("mm^3", 1e9)}  # where lengths have no diameter to be divided by

Value = Callable[[PointResult], float]


@dataclasses.dataclass(frozen=True)
class Ordinate:
    """Quantity that is plotted: the start of the figure's name, a title for the axis, a column, a value by point."""

    name: str
    title: str
    column: str
    value: Value

    @property
    def zone(self) -> bool:
        """True for a plastic zone, whose points are marked where it reaches a bound."""
        return self.name.startswith(_OF_ZONE)


def ordinates(varied: Sequence[str], done: Sequence[PointResult]) -> list[Ordinate]:
    """Return what can be shown of points that are done.

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
    known = {unit: scale for unit, scale in scales.items() if all(map(math.isfinite, scale[2].values()))}
    found = [_ordinate(name, key, known) for name, key in SCAN_FIGURES.items()]
    left_out = set()
    if not all(math.isfinite(_number(point, "restitution")) for point in done):
        left_out.add("restitution")
    if not any(math.isfinite(_number(point, "plastic_zone_volume_ever_m3")) for point in done):
        left_out.add("plastic_zone_volume")  # of packings: the number of spheres tells it
    if not protects(varied, [point.summary for point in done]):
        left_out.add(REDUCTION)
    return [one for one in found if one.name not in left_out]


def _ordinate(name: str, key: str, scales: Mapping[str, tuple[str, str, dict[int, float]]]) -> Ordinate:
    """A value of the summary, over the scale of its unit where there is one."""
    entry, number = QUANTITIES[key], plastic_spheres if key == "n_plastic_spheres" else value_of(key)
    if entry.symbol and entry.unit in scales:
        symbol, words, scale = scales[entry.unit]
        title, column = f"{entry.axis} ${entry.symbol}/{symbol}$", f"{name}_over_{words}"
        return Ordinate(name, title, column, lambda point: number(point) / scale[point.number])
    unit, factor = _SHOWN_IN.get(entry.unit, (entry.unit, 1.0))
    title = entry.title + (f" ({printed_unit(unit)})" if unit else "")
    column = key if unit == entry.unit else f"{name}_{unit.replace('^', '')}"
    return Ordinate(name, title, column, lambda point: factor * number(point))


def _scales(varied: Sequence[str], done: Sequence[PointResult]) -> tuple[dict[int, float], dict[int, float]]:
    """Return diameter (m) and yield force (N) of points by number, NaN where there is none; each case is read once."""
    keys = [key for key in varied if not key.startswith(_UNITS_OF_ITS_OWN)]
    known: dict[tuple[Any, ...], tuple[float, float]] = {}
    lengths, forces = {}, {}
    for point in done:
        labels = tuple(point.labels.get(key) for key in keys)
        if labels not in known:
            try:
                case = load_case((point.directory or Path()) / CASE_FILE)
                force = sphere_contact(case).yield_force if case.contact.yields else math.nan
                known[labels] = case.packing.diameter, force
            except (InputError, OSError):
                known[labels] = math.nan, math.nan
        lengths[point.number], forces[point.number] = known[labels]
    return lengths, forces


def _number(point: PointResult, name: str) -> float:
    value = point.summary.get(name)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else math.nan


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

Marks = Mapping[int, Mark]
_OF_A_SCAN = re.compile(r".+_vs_.+|collapse_.+|.+_map")  # names of figures, as below


def draw_scan_figures(scan: str | Path | ScanResult, *, pdf: bool = True) -> list[Path]:
    """Draw the figures of a scan into its ``figures``; those that no longer apply are removed.

    For each numeric key: ``QUANTITY_vs_KEY``, with curves by the other keys. If no independent key is numeric: bars for
    each value of the first. If velocity and material vary: ``collapse_QUANTITY``, on normalised axes. If exactly two
    numeric keys vary and fill a grid: ``dissipated_fraction_map``.

    Parameters
    ----------
    scan
        Directory of the scan, or the scan itself, whose summaries are cached if figures are drawn repeatedly.
    pdf
        False to omit the PDF of each figure, which saves half of the time, and to remove earlier ones.

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
    folder = FigureFolder(result.directory)
    with style():
        found = drawings(result)
        for name, drawing in found.items():
            folder.save(drawing, name, formats=("pdf",) if pdf else ())
    folder.remove(*(name for name in folder.names() if _OF_A_SCAN.fullmatch(name) and name not in found))
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


def _figures(result: ScanResult) -> dict[str, Callable[[], Drawing | None]]:
    """Return functions that draw what a scan may show, by name."""
    points = result.points
    labels = physical({key: [point.labels.get(key) for point in points] for key in result.varied if key != SEED})
    free = independent_keys(labels)
    rows, units = [row for row, point in enumerate(points) if point.status == "done"], result.units
    if len(rows) < _FEWEST or not free:
        return {}
    keys = {name: key_of(name, labels[name], units.get(name, "")) for name in labels}
    done = [points[row] for row in rows]
    marks = {row: mark_of(points[row].summary) for row in rows}
    shown = [one for one in ordinates(result.varied, done) if any(abs(one.value(point)) > _NOTHING for point in done)]
    found: dict[str, Callable[[], Drawing | None]] = {}
    for name in _abscissae(keys, free):
        x = keys[name]
        others = _others(keys, free, name)
        joined = all(_is_one_line(curve, x, keys.values()) for curve in _curve_rows(rows, others))
        for one in shown:
            draw = partial(_curves, points, rows, x, others, one, marks, joined=joined)
            found[f"{one.name}_vs_{x.slug}"] = draw
    if not any(keys[name].numeric for name in free):
        x, others = keys[free[0]], [keys[name] for name in free[1:]]
        for one in shown:
            found[f"{one.name}_vs_{x.slug}"] = partial(_bars, points, rows, x, others, one, marks)
    if "load.velocity" in free and any(name.split(".")[0] == "material" for name in free):
        found |= _collapses(points, rows, _others(keys, free, "load.velocity"), marks)
    fraction = next((quantity for quantity in shown if quantity.name == "dissipated_fraction"), None)
    if fraction and len(free) == 2 and all(keys[name].numeric for name in free):
        found["dissipated_fraction_map"] = partial(_map, points, rows, keys[free[0]], keys[free[1]], fraction)
    return found


def _values(points: Sequence[PointResult], rows: Sequence[int], value: Value) -> dict[int, float]:
    """Return the finite values by row."""
    found = {row: value(points[row]) for row in rows}
    return {row: number for row, number in found.items() if math.isfinite(number)}


def _abscissae(keys: dict[str, Key], free: Sequence[str]) -> list[str]:
    """Return the independent numeric keys, and those that are equivalent to one of them, except run times."""
    chosen = []
    for name, key in keys.items():
        alike = [other for other in free if determines(key.labels, keys[other].labels)]
        along = bool(alike) and not name.startswith(TIMES)
        if key.numeric and len(set(key.values)) > 1 and (name in free or along):
            chosen.append(name)
    return chosen


def _others(keys: dict[str, Key], free: Sequence[str], x: str) -> list[Key]:
    """Return the keys that distinguish curves over ``x``: all but those that its values determine.

    A key with fewer values than ``x`` groups the points, even if no abscissa occurs with two of its values.
    """
    chosen = [keys[name] for name in free if name != x and not determines(keys[x].labels, keys[name].labels)]
    for key in keys.values():
        groups = determines(keys[x].labels, key.labels) and not determines(key.labels, keys[x].labels)
        distinguished = list(zip(*(other.labels for other in chosen), strict=True))
        if groups and len(set(key.labels)) > 1 and not (distinguished and determines(distinguished, key.labels)):
            chosen.append(key)
    return chosen


def _curve_rows(rows: Sequence[int], others: Sequence[Key]) -> list[list[int]]:
    """Group the points by curve: equal labels of ``others``."""
    curves: dict[tuple[Any, ...], list[int]] = {}
    for row in rows:
        curves.setdefault(tuple(key.labels[row] for key in others), []).append(row)
    return list(curves.values())


def _is_one_line(rows: Sequence[int], x: Key, keys: Iterable[Key]) -> bool:
    """True if all other varying keys are monotonic in the abscissa, so that points may be joined."""
    for key in keys:
        if not key.numeric or not determines([x.labels[row] for row in rows], [key.labels[row] for row in rows]):
            continue
        steps = np.diff([value for _, value in sorted({(x.values[row], key.values[row]) for row in rows})])
        if np.any(steps > 0) and np.any(steps < 0):
            return False
    return True


def _series(
    rows: Sequence[int], x: dict[int, float], y: dict[int, float], others: Sequence[Key], marks: Marks | None = None
) -> list[Series]:
    """Make curves of points with equal labels of ``others``; points at one abscissa are averaged.

    Parameters
    ----------
    marks
        Marks of plastic zones by row; a mean gets the most severe one of its points.
    """
    curves = _curve_rows([row for row in rows if row in y and row in x], others)
    series = []
    for members in sorted(curves, key=lambda members: [_order(key, members[0]) for key in others]):
        places: dict[float, list[int]] = {}
        for row in members:
            places.setdefault(float(f"{x[row]:.12g}"), []).append(row)
        at = sorted(places)
        found = [estimate([y[row] for row in places[place]]) for place in at]
        label = ", ".join(key.text(members[0]) for key in others)
        series.append(
            Series(
                label=label,
                row=members[0],
                x=np.array(at),
                mean=np.array([one.mean for one in found]),
                deviation=np.array([one.deviation for one in found]),
                half_width=np.array([one.half_width for one in found]),
                count=np.array([one.n for one in found]),
                marks=None if marks is None else np.array([max(marks[row] for row in places[place]) for place in at]),
            )
        )
    return series


def _order(key: Key, row: int) -> Any:
    """Return the sort key of a point: numbers by size, text in the order of the scan."""
    return key.values[row] if key.numeric else key.values.index(key.values[row])


def _enough(series: Sequence[Series]) -> bool:
    return sum(len(curve.x) for curve in series) >= _FEWEST


def _curves(
    points: Sequence[PointResult],
    rows: Sequence[int],
    x: Key,
    others: Sequence[Key],
    quantity: Ordinate,
    marks: Marks,
    *,
    joined: bool,
) -> Drawing | None:
    """None where there are no curves: too few points, or many settings each at one abscissa."""
    values = _values(points, rows, quantity.value)
    series = _series(rows, dict(enumerate(x.values)), values, others, marks if quantity.zone else None)
    if not _enough(series) or len({place for curve in series for place in curve.x.tolist()}) < _FEWEST:
        return None
    if len(series) > _MOST_SINGLE and all(len(curve.x) == 1 for curve in series):
        return None
    columns = (x.column, quantity.column)
    return draw_curves(series, x.title, quantity.title, others, columns, scale=x.naming.scale, joined=joined)


def _bars(
    points: Sequence[PointResult],
    rows: Sequence[int],
    x: Key,
    others: Sequence[Key],
    quantity: Ordinate,
    marks: Marks,
) -> Drawing | None:
    values = _values(points, rows, quantity.value)
    categories = list(dict.fromkeys(x.values))
    places = {row: float(categories.index(x.values[row])) for row in rows}
    series = _series(rows, places, values, others, marks if quantity.zone else None)
    if not _enough(series):
        return None
    ticks = [x.tick(x.values.index(category)) for category in categories]
    return draw_bars(series, ticks, x.title, quantity.title, others, (x.column, quantity.column))


def _collapses(
    points: Sequence[PointResult], rows: Sequence[int], others: Sequence[Key], marks: Marks
) -> dict[str, Callable[[], Drawing | None]]:
    """Return functions that draw the collapse of materials on normalised axes."""
    found: dict[str, Callable[[], Drawing | None]] = {}
    fraction, volume = "dissipated_fraction", "plastic_volume_in_spheres"
    of_volume = r"Plastic zone volume $V_\mathrm{p}/(\pi D^3/6)$"
    for name, key, column, title, value in (
        (f"collapse_{fraction}", "velocity_normalised", fraction, QUANTITIES[fraction].title, value_of(fraction)),
        ("collapse_plastic_volume", "energy_input_normalised", volume, of_volume, plastic_spheres),
    ):
        x, y = _values(points, rows, value_of(key)), _values(points, rows, value)
        series = _series(rows, x, y, others, marks if value is plastic_spheres else None)
        if _enough(series):
            titles, columns = (QUANTITIES[key].title, title), (key, column)
            found[name] = partial(draw_curves, series, *titles, others, columns, joined=False, chosen=False)
    return found


def _map(points: Sequence[PointResult], rows: Sequence[int], x: Key, y: Key, quantity: Ordinate) -> Drawing | None:
    values = _values(points, rows, quantity.value)
    columns, lines = sorted(set(x.values)), sorted(set(y.values))
    if len(set(zip(x.values, y.values, strict=True))) != len(columns) * len(lines):
        return None  # no grid
    cells: dict[tuple[int, int], list[float]] = {}
    for row, value in values.items():
        cells.setdefault((lines.index(y.values[row]), columns.index(x.values[row])), []).append(value)
    if len(cells) < _FEWEST:
        return None
    table = np.full((len(lines), len(columns)), np.nan)
    for place, found in cells.items():
        table[place] = np.mean(found)
    return draw_map(table, (columns, lines), (x, y), quantity.title, quantity.column)
