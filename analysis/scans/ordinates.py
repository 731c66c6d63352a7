"""Ordinates of figures of a scan: values of its points, with titles and units."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.units import printed_unit
from granwave.analysis.quantities import QUANTITIES, SCAN_FIGURES
from granwave.analysis.scans.protection import REDUCTION, protects
from granwave.analysis.scans.result import SEED, PointResult
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case

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
    units = _Units(varied)
    scales = {"m": ("D", "diameter", units.length), "N": (r"F_\mathrm{y}", "yield_force", units.force)}
    known = {unit: scale for unit, scale in scales.items() if all(math.isfinite(scale[2](point)) for point in done)}
    found = [_ordinate(name, key, known) for name, key in SCAN_FIGURES.items()]
    left_out = set()
    if not all(math.isfinite(_number(point, "restitution")) for point in done):
        left_out.add("restitution")
    if not any(math.isfinite(_number(point, "plastic_zone_volume_ever_m3")) for point in done):
        left_out.add("plastic_zone_volume")  # of packings: the number of spheres tells it
    if not protects(varied, [point.summary for point in done]):
        left_out.add(REDUCTION)
    return [one for one in found if one.name not in left_out]


def _ordinate(name: str, key: str, scales: Mapping[str, tuple[str, str, Value]]) -> Ordinate:
    """A value of the summary, over the scale of its unit where there is one."""
    entry, number = QUANTITIES[key], plastic_spheres if key == "n_plastic_spheres" else value_of(key)
    if entry.symbol and entry.unit in scales:
        symbol, words, scale = scales[entry.unit]
        title, column = f"{entry.axis} ${entry.symbol}/{symbol}$", f"{name}_over_{words}"
        return Ordinate(name, title, column, lambda point: number(point) / scale(point))
    unit, factor = _SHOWN_IN.get(entry.unit, (entry.unit, 1.0))
    title = entry.title + (f" ({printed_unit(unit)})" if unit else "")
    column = key if unit == entry.unit else f"{name}_{unit.replace('^', '')}"
    return Ordinate(name, title, column, lambda point: factor * number(point))


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


def value_of(name: str) -> Value:
    """Return a function that takes a value of the summary, NaN where there is none."""
    return lambda point: _number(point, name)


def plastic_spheres(point: PointResult) -> float:
    """NaN for a law that does not yield."""
    yields = point.summary.get("plastic_zone_volume_m3") is not None
    return _number(point, "n_plastic_spheres") if yields else math.nan
