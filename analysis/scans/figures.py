"""Figures of a scan: dissipation, plastic zone, peak force and wave speed against the varied keys.

Only finished points are shown. Points that differ in ``packing.seed`` only are shown as their mean,
with the 95 % confidence interval as error bar. A quantity that is 0 at all points, such as the
dissipation without yielding, has no figure.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from pandas import DataFrame, Series

from granwave.analysis.figures.style import Drawing, FigureFolder, NotDrawn, attempt, style
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.incomplete_values import incomplete_in
from granwave.analysis.measures.law_range import is_beyond_law
from granwave.analysis.measures.zone_size import Mark, zone_marks
from granwave.analysis.quantities import quantity
from granwave.analysis.scans.abscissae import FEWEST, FEWEST_LEVELS, choices_of_axes, keys_of_curves
from granwave.analysis.scans.curve_points import (
    NOTHING,
    categories_of,
    curve_rows,
    first_of_equal_rows,
    is_one_line,
    points_of,
    table_of_bars,
    table_of_curves,
)
from granwave.analysis.scans.drawing import draw_bars, draw_curves, draw_map
from granwave.analysis.scans.keys import VariedKey, key_of
from granwave.analysis.scans.ordinates import (
    Ordinate,
    Value,
    is_constant,
    ordinates,
    plastic_spheres,
    value_of,
)
from granwave.analysis.scans.result import SEED, PointResult, ScanResult
from granwave.analysis.scans.table import (
    independent_keys,
    labels_of,
    physical,
)

Drawers = dict[str, Callable[[], Drawing | None]]  # functions that draw figures, by name
_OF_A_SCAN = re.compile(r".+_vs_.+|collapse_.+|.+_map")  # names of figures, as below


def draw_scan_figures(scan: str | Path | ScanResult, *, pdf: bool = True) -> list[Path]:
    """Draw the figures of a scan into its ``figures``; figures that no longer apply are removed.

    For each numeric key of three values or more: ``QUANTITY_vs_KEY``, with curves by the other
    keys. If nothing changes along such a key: bars for each value of the category with most values,
    or curves over keys of two values. If velocity and material vary, and the normalised axis has
    three values: ``collapse_QUANTITY``, on normalised axes. If exactly two numeric keys vary and
    fill a grid of three by three or more: ``dissipated_fraction_map``.

    Quantities without variation in any curve have no figure: a quantity that is constant, or zero
    at some points of a curve and constant elsewhere.

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
    for axes in choices_of_axes(data.keys, data.free):
        for name in axes:
            is_numeric = data.keys[name].numeric
            figures |= data.curves_over(name) if is_numeric else data.bars_of(name)
        if figures:
            break
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
        Marks of the plastic zone, by row; see `Mark`.
    ordinates
        Quantities with their values by row; quantities that are 0 at all points are omitted.
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
        if len(points) < FEWEST or not free:
            return None
        units = result.units
        keys = {name: key_of(name, column, units.get(name, "")) for name, column in labels.items()}
        marks = Series({row: int(zone_marks(point.summary)) for row, point in points.items()})
        shown = []
        for ordinate in ordinates(result.varied, list(points.values())):
            values = _values(ordinate.value, points)
            if (values.abs() > NOTHING).any():
                shown.append((ordinate, values))
        return cls(points, keys, free, marks, shown)

    def curves_over(self, name: str) -> Drawers:
        """Return functions that draw all quantities over a key."""
        x = self.keys[name]
        others = keys_of_curves(self.keys, self.free, name)
        curves = curve_rows(self.points, others).values()
        joined = all(is_one_line(rows, x, self.keys.values()) for rows in curves)
        figures: Drawers = {}
        for ordinate, values in self.ordinates:
            table = table_of_curves(x, others, values, self._marks_of(ordinate.key, ordinate.zone))
            if table is not None:
                figures[f"{ordinate.name}_vs_{x.slug}"] = partial(
                    _curves, x, others, ordinate, table, joined=joined
                )
        return figures

    def bars_of(self, name: str) -> Drawers:
        """Return functions that draw bars of all quantities for each value of a key."""
        x = self.keys[name]
        others = [self.keys[other] for other in self.free if other != name]
        figures: Drawers = {}
        for ordinate, all_values in self.ordinates:
            marks = self._marks_of(ordinate.key, ordinate.zone)
            values, merged = self._merged(others, all_values, marks)
            kept = [key for key in others if key not in merged]
            table = table_of_bars(x, kept, values, marks[values.index])
            if table is not None:
                figures[f"{ordinate.name}_vs_{x.slug}"] = partial(
                    _bars, x, kept, ordinate, table, merged
                )
        return figures

    def _merged(
        self, others: Sequence[VariedKey], values: Series, marks: Series
    ) -> tuple[Series, list[VariedKey]]:
        """Return the values to draw, and the keys that do not change them, of whose values only the
        first is drawn.
        """
        merged: list[VariedKey] = []
        for key in others:
            settings = {row: dict(self.points[row].labels) for row in values.index}
            for row in settings:
                for done in merged:
                    del settings[row][done.name]
            if rows := first_of_equal_rows(key, settings, values, marks):
                values = values[rows]
                merged.append(key)
        return values, merged

    def _marks_of(self, key: str, is_of_zone: bool) -> Series:
        """Return all marks of a quantity by row: the end of the run, the range of the law, and the
        boundaries of a plastic zone.
        """
        marks = {}
        for row, point in self.points.items():
            marks[row] = int(self.marks[row]) if is_of_zone else int(Mark.NONE)
            if is_beyond_law(key, point.summary):
                marks[row] |= Mark.LAW
            if key in incomplete_in(point.summary):
                marks[row] |= Mark.END
        return Series(marks, dtype=int)

    def collapses(self) -> Drawers:
        """Return functions that draw dissipation and plastic volume on normalised axes."""
        fraction = "dissipated_fraction"
        figures = {
            f"collapse_{fraction}": self._collapse(
                "velocity_normalised",
                (quantity(fraction).title, fraction),
                _values(value_of(fraction), self.points),
                self._marks_of(fraction, False),
            ),
            "collapse_plastic_volume": self._collapse(
                "energy_input_normalised",
                (r"Plastic zone volume $V_\mathrm{p}/(\pi D^3/6)$", "plastic_volume_in_spheres"),
                _values(plastic_spheres, self.points),
                self._marks_of("n_plastic_spheres", True),
            ),
        }
        return {name: draw for name, draw in figures.items() if draw is not None}

    def _collapse(
        self, key: str, ordinate: tuple[str, str], values: Series, marks: Series
    ) -> Callable[[], Drawing] | None:
        """Return a function that draws values over a normalised quantity; None with fewer than
        three abscissae, or if nothing changes.

        ``ordinate`` has the title and the column of the values.
        """
        title, column = ordinate
        others = keys_of_curves(self.keys, self.free, "load.velocity")
        table = points_of(_values(value_of(key), self.points), values, others, marks)
        if table.x.nunique() < FEWEST_LEVELS or is_constant(table["mean"]):
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


def _curves(
    x: VariedKey,
    others: Sequence[VariedKey],
    quantity: Ordinate,
    table: DataFrame,
    *,
    joined: bool,
) -> Drawing:
    """Draw curves of a table of `table_of_curves`."""
    columns = (x.column, quantity.column)
    return draw_curves(
        table, x.title, quantity.title, others, columns, scale=x.naming.scale, joined=joined
    )


def _bars(
    x: VariedKey,
    others: Sequence[VariedKey],
    quantity: Ordinate,
    table: DataFrame,
    merged: Sequence[VariedKey],
) -> Drawing:
    """Draw bars of a table of `table_of_bars`."""
    ticks = [x.tick(x.values.index(category)) for category in categories_of(x)]
    columns = (x.column, quantity.column)
    return draw_bars(table, ticks, x.title, quantity.title, others, columns, merged=merged)


def _map(x: VariedKey, y: VariedKey, quantity: Ordinate, values: Series) -> Drawing | None:
    columns = sorted(set(x.values))
    lines = sorted(set(y.values))
    if min(len(columns), len(lines)) < FEWEST_LEVELS:
        return None
    if len(set(zip(x.values, y.values, strict=True))) != len(columns) * len(lines):
        return None  # no grid
    rows = values.dropna().index
    cells = values[rows].groupby([Series(y.values)[rows], Series(x.values)[rows]]).mean()
    if len(cells) < FEWEST:
        return None
    table = cells.unstack().reindex(index=lines, columns=columns).to_numpy()
    return draw_map(table, (columns, lines), (x, y), quantity.title, quantity.column)
