"""Figures of a scan: what varies against dissipation, plastic zone, peak force and wave speed.

Only points that are done are shown. Points that differ in ``packing.seed`` alone are one: their mean, with its 95 %
confidence interval as error bar. A quantity that is 0 in all of them, as dissipation without yielding, has no figure.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.figures.run_figures import FIGURES_DIRECTORY
from granwave.analysis.figures.style import SUFFIXES, Drawing, save, style
from granwave.analysis.scans.drawing import Series, draw_bars, draw_curves, draw_map
from granwave.analysis.scans.keys import Key, key_of
from granwave.analysis.scans.result import SEED, PointResult, ScanResult
from granwave.analysis.scans.table import determines, independent_keys
from granwave.analysis.statistics import estimate
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case

_UNITS_OF_ITS_OWN = ("load.", "run.", "boundary.", "output.", SEED, "packing.size", "packing.kind")
_TIMES = ("run.", "output.")  # of no physical meaning beside a key that they vary with
_FEWEST = 2  # points in a figure
_MOST_SINGLE = 8  # points that are shown though no two belong to a curve
_NOTHING = 1e-12  # what is shown is about 1 or more, unless it is nothing but rounding

Value = Callable[[PointResult], float]


@dataclasses.dataclass(frozen=True)
class Quantity:
    """Something that is plotted: the start of the figure's name, a title for the axis, a column, a value by point."""

    name: str
    title: str
    column: str
    value: Value


def draw_scan_figures(scan: str | Path | ScanResult, *, pdf: bool = True) -> list[Path]:
    """Draw the figures of a scan into its ``figures``; those that make no sense (any more) are removed.

    For each key that is a number: ``QUANTITY_vs_KEY``, curves by the other keys. Where no key that varies on its own is
    a number, bars for each value of the first. Where velocity and material vary: ``collapse_QUANTITY``, on normalised
    axes. Where just two numeric keys vary and fill a grid: ``dissipated_fraction_map``.

    Parameters
    ----------
    scan
        Its directory; or the scan, whose summaries are then read only once however often the figures are drawn.
    pdf
        Leave a PDF beside each PNG; without, it takes a third of the time (while points come in), and PDFs of an
        earlier state are removed.

    Returns
    -------
    list of Path
        The PNG files that were written.

    Raises
    ------
    MissingOutputError
        There is no scan in the directory.
    OutputFormatError
        Its index is damaged.
    """
    result = scan if isinstance(scan, ScanResult) else ScanResult(scan)
    folder = result.directory / FIGURES_DIRECTORY
    written = []
    with style():
        found = drawings(result)
        if found:
            folder.mkdir(exist_ok=True)
        for name, drawing in found.items():
            save(drawing, folder / name, pdf=pdf)
            written.append(folder / f"{name}.png")
    kept = set(found)
    for path in [*folder.glob("*_vs_*"), *folder.glob("collapse_*"), *folder.glob("*_map.*")]:
        if path.suffix in SUFFIXES and path.stem not in kept:
            path.unlink(missing_ok=True)
    return written


def drawings(result: ScanResult) -> dict[str, Drawing]:
    """The figures of a scan as it is now, by name."""
    points = result.points
    labels = _physical({key: [point.labels.get(key) for point in points] for key in result.varied if key != SEED})
    free = independent_keys(labels)
    rows = [row for row, point in enumerate(points) if point.status == "done"]
    if len(rows) < _FEWEST or not free:
        return {}
    keys = {name: key_of(name, labels[name]) for name in labels}
    units = _Units(result.varied)
    done = [points[row] for row in rows]
    quantities = [one for one in _quantities(units, done) if any(abs(one.value(point)) > _NOTHING for point in done)]
    found: dict[str, Drawing | None] = {}
    for name in _abscissae(keys, free):
        x = keys[name]
        others = _others(keys, free, name)
        for quantity in quantities:
            values = _values(points, rows, quantity.value)
            series = _series(rows, dict(enumerate(x.values)), values, others)
            joined = all(_is_one_line(curve, x, keys.values()) for curve in _curve_rows(rows, others))
            found[f"{quantity.name}_vs_{x.slug}"] = _curves(series, x, others, quantity, joined=joined)
    if not any(keys[name].numeric for name in free):
        x, others = keys[free[0]], [keys[name] for name in free[1:]]
        for quantity in quantities:
            values = _values(points, rows, quantity.value)
            found[f"{quantity.name}_vs_{x.slug}"] = _bars(rows, x, others, values, quantity)
    if "load.velocity" in free and any(name.split(".")[0] == "material" for name in free):
        found |= _collapses(points, rows, _others(keys, free, "load.velocity"))
    fraction = next((quantity for quantity in quantities if quantity.name == "dissipated_fraction"), None)
    if fraction and len(free) == 2 and all(keys[name].numeric for name in free):
        found["dissipated_fraction_map"] = _map(points, rows, keys[free[0]], keys[free[1]], fraction)
    return {name: drawing for name, drawing in found.items() if drawing is not None}


def _quantities(units: _Units, done: Sequence[PointResult]) -> list[Quantity]:
    force_units = [units.force(point) for point in done]
    if all(map(math.isfinite, force_units)):
        force = Quantity(
            "peak_force",
            r"Peak force $F_\mathrm{max}/F_\mathrm{y}$",
            "peak_force_over_yield_force",
            lambda point: _number(point, "peak_force_N") / units.force(point),
        )
    else:
        force = Quantity("peak_force", r"Peak force $F_\mathrm{max}$ (N)", "peak_force_N", _summary("peak_force_N"))
    if all(math.isfinite(units.length(point)) for point in done):
        depth = Quantity(
            "plastic_zone_depth",
            r"Plastic zone depth $z_\mathrm{p}/D$",
            "plastic_zone_depth_over_diameter",
            lambda point: _number(point, "plastic_zone_depth_m") / units.length(point),
        )
    else:
        depth = Quantity(
            "plastic_zone_depth",
            r"Plastic zone depth $z_\mathrm{p}$ (mm)",
            "plastic_zone_depth_mm",
            lambda point: 1e3 * _number(point, "plastic_zone_depth_m"),
        )
    zone = Quantity(  # of a continuum run
        "plastic_zone_volume",
        r"Plastic zone $V_\mathrm{p}$ (mm³)",
        "plastic_zone_volume_mm3",
        lambda point: 1e9 * _number(point, "plastic_zone_volume_m3"),
    )
    rebound = Quantity("restitution", r"Coefficient of restitution $e$", "restitution", _summary("restitution"))
    return [
        *([rebound] if all(math.isfinite(rebound.value(point)) for point in done) else []),
        Quantity(
            "dissipated_fraction",
            r"Dissipated fraction $E_\mathrm{d}/E_0$",
            "dissipated_fraction",
            _summary("dissipated_fraction"),
        ),
        depth,
        *([zone] if any(math.isfinite(_number(point, "plastic_zone_volume_ever_m3")) for point in done) else []),
        Quantity("plastic_spheres", r"Plastic spheres $N_\mathrm{p}$", "n_plastic_spheres", _plastic_spheres),
        force,
        # of the static contact of two spheres
        Quantity("max_force", r"Force at the largest overlap (N)", "max_force_N", _summary("max_force_N")),
        Quantity(
            "force_deviation",
            "Force less the law (%, rms)",
            "force_deviation_rms_percent",
            _summary("force_deviation_rms_percent"),
        ),
        Quantity("wave_speed", r"Wave speed $c$ (m/s)", "wave_speed_m_s", _summary("wave_speed_m_s")),
    ]


class _Units:
    """Yield force and diameter of the points, read from one case of all that share them."""

    def __init__(self, varied: Sequence[str]) -> None:
        self._keys = [key for key in varied if not key.startswith(_UNITS_OF_ITS_OWN)]
        self._known: dict[tuple[Any, ...], tuple[float, float]] = {}

    def force(self, point: PointResult) -> float:
        """F_y, N; NaN where there is none."""
        return self._of(point)[0]

    def length(self, point: PointResult) -> float:
        """D, m; NaN where there is none."""
        return self._of(point)[1]

    def _of(self, point: PointResult) -> tuple[float, float]:
        labels = tuple(point.labels.get(key) for key in self._keys)
        if labels not in self._known:
            self._known[labels] = self._read(point)
        return self._known[labels]

    @staticmethod
    def _read(point: PointResult) -> tuple[float, float]:
        try:
            case = load_case((point.directory or Path()) / "case.toml")
        except (InputError, OSError):
            return math.nan, math.nan
        force = sphere_contact(case).yield_force if case.contact.yields else math.nan
        return force, case.packing.diameter


def _number(point: PointResult, name: str) -> float:
    value = point.summary.get(name)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else math.nan


def _summary(name: str) -> Value:
    return lambda point: _number(point, name)


def _plastic_spheres(point: PointResult) -> float:
    """NaN for a law that does not yield."""
    yields = point.summary.get("plastic_zone_volume_m3") is not None
    return _number(point, "n_plastic_spheres") if yields else math.nan


def _values(points: Sequence[PointResult], rows: Sequence[int], value: Value) -> dict[int, float]:
    """Where there is a value, by row."""
    found = {row: value(points[row]) for row in rows}
    return {row: number for row, number in found.items() if math.isfinite(number)}


def _physical(labels: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """Without run times and the like that only follow the other keys."""
    others = [column for name, column in labels.items() if not name.startswith(_TIMES)]
    together = list(zip(*others, strict=True))
    return {
        name: column
        for name, column in labels.items()
        if not name.startswith(_TIMES) or not others or not determines(together, column)
    }


def _abscissae(keys: dict[str, Key], free: Sequence[str]) -> list[str]:
    """Numeric keys that vary on their own, and those that go along with one of them (run times apart)."""
    chosen = []
    for name, key in keys.items():
        alike = [other for other in free if determines(key.labels, keys[other].labels)]
        along = bool(alike) and not name.startswith(_TIMES)
        if key.numeric and len(set(key.values)) > 1 and (name in free or along):
            chosen.append(name)
    return chosen


def _others(keys: dict[str, Key], free: Sequence[str], x: str) -> list[Key]:
    """The keys that tell the curves over ``x`` apart: all but those that go along with it, a value for a value.

    A key with fewer values sorts the points, even where no abscissa occurs with two of them.
    """
    chosen = [keys[name] for name in free if name != x and not determines(keys[x].labels, keys[name].labels)]
    for key in keys.values():
        sorts = determines(keys[x].labels, key.labels) and not determines(key.labels, keys[x].labels)
        told = list(zip(*(other.labels for other in chosen), strict=True))
        if sorts and len(set(key.labels)) > 1 and not (told and determines(told, key.labels)):
            chosen.append(key)
    return chosen


def _curve_rows(rows: Sequence[int], others: Sequence[Key]) -> list[list[int]]:
    """The points of each curve: those of equal labels of ``others``."""
    curves: dict[tuple[Any, ...], list[int]] = {}
    for row in rows:
        curves.setdefault(tuple(key.labels[row] for key in others), []).append(row)
    return list(curves.values())


def _is_one_line(rows: Sequence[int], x: Key, keys: Iterable[Key]) -> bool:
    """What goes along with the abscissa grows or falls with it, so that a line from point to point means something."""
    for key in keys:
        if not key.numeric or not determines([x.labels[row] for row in rows], [key.labels[row] for row in rows]):
            continue
        steps = np.diff([value for _, value in sorted({(x.values[row], key.values[row]) for row in rows})])
        if np.any(steps > 0) and np.any(steps < 0):
            return False
    return True


def _series(rows: Sequence[int], x: dict[int, float], y: dict[int, float], others: Sequence[Key]) -> list[Series]:
    """Points by curve: those of equal labels of ``others``; points of one abscissa become their mean."""
    curves = _curve_rows([row for row in rows if row in y and row in x], others)
    series = []
    for members in sorted(curves, key=lambda members: [_order(key, members[0]) for key in others]):
        places: dict[float, list[float]] = {}
        for row in members:
            places.setdefault(float(f"{x[row]:.12g}"), []).append(y[row])
        at = sorted(places)
        found = [estimate(places[place]) for place in at]
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
            )
        )
    return series


def _order(key: Key, row: int) -> Any:
    """Numbers by size, text in the order of the scan."""
    return key.values[row] if key.numeric else key.values.index(key.values[row])


def _enough(series: Sequence[Series]) -> bool:
    return sum(len(curve.x) for curve in series) >= _FEWEST


def _curves(series: list[Series], x: Key, others: Sequence[Key], quantity: Quantity, *, joined: bool) -> Drawing | None:
    """None where there are no curves: too few points, or many settings each at one abscissa."""
    if not _enough(series) or len({place for curve in series for place in curve.x.tolist()}) < _FEWEST:
        return None
    if len(series) > _MOST_SINGLE and all(len(curve.x) == 1 for curve in series):
        return None
    columns = (x.column, quantity.column)
    return draw_curves(series, x.title, quantity.title, others, columns, scale=x.naming.scale, joined=joined)


def _bars(
    rows: Sequence[int], x: Key, others: Sequence[Key], values: dict[int, float], quantity: Quantity
) -> Drawing | None:
    categories = list(dict.fromkeys(x.values))
    series = _series(rows, {row: float(categories.index(x.values[row])) for row in rows}, values, others)
    if not _enough(series):
        return None
    ticks = [x.tick(x.values.index(category)) for category in categories]
    return draw_bars(series, ticks, x.title, quantity.title, others, (x.column, quantity.column))


def _collapses(points: Sequence[PointResult], rows: Sequence[int], others: Sequence[Key]) -> dict[str, Drawing | None]:
    """Materials fall together on one curve (thesis 5.3)."""
    velocity = _values(points, rows, _summary("velocity_normalised"))
    energy = _values(points, rows, _summary("energy_input_normalised"))
    dissipated = _values(points, rows, _summary("dissipated_fraction"))
    plastic = _values(points, rows, _plastic_spheres)
    drawings: dict[str, Drawing | None] = {}
    for name, x, y, titles, columns in (
        (
            "collapse_dissipated_fraction",
            velocity,
            dissipated,
            (r"Normalised impact velocity $\hat{v}_0$", r"Dissipated fraction $E_\mathrm{d}/E_0$"),
            ("velocity_normalised", "dissipated_fraction"),
        ),
        (
            "collapse_plastic_volume",
            energy,
            plastic,
            (
                r"Input energy $E_0/(F_\mathrm{y}\alpha_\mathrm{y})$",
                r"Plastic zone volume $V_\mathrm{p}/(\pi D^3/6)$",
            ),
            ("energy_input_normalised", "plastic_volume_in_spheres"),
        ),
    ):
        series = _series(rows, x, y, others)
        if _enough(series):
            drawings[name] = draw_curves(series, *titles, others, columns, joined=False, chosen=False)
    return drawings


def _map(points: Sequence[PointResult], rows: Sequence[int], x: Key, y: Key, quantity: Quantity) -> Drawing | None:
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
