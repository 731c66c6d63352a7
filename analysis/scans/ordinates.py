"""Quantities that figures of a scan show: their titles, and their values in units or divided by a
scale.

Lengths are divided by the diameter, volumes by its cube, and forces by the yield force, if all
points have the same. A scale that varies from point to point would change the order of the values:
they are then in their unit, as in the sentences and tables of a report.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pandas import Series

from granwave.analysis.document.model import is_number
from granwave.analysis.formatting.values import printed_unit
from granwave.analysis.quantities import quantity, scan_figures
from granwave.analysis.scans.means import is_mostly_known, with_values
from granwave.analysis.scans.result import REDUCTION, SEED, PointResult, protects
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import read_stored_case
from granwave.lammps_inputs.run_directory import CASE_FILE

_UNITS_OF_ITS_OWN = ("load.", "run.", "boundary.", "output.", SEED, "packing.size", "packing.kind")
_OF_ZONE = ("plastic_", "zone_")  # names of figures of plastic zones
#: Units of lengths and volumes that are not divided by the diameter, with the factor from SI.
_SHOWN_IN = {"m": ("mm", 1e3), "m^3": ("mm^3", 1e9)}
Value = Callable[[PointResult], float]
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
    key
        Name of the value in the summary.
    """

    name: str
    title: str
    column: str
    value: Value
    key: str = ""

    @property
    def zone(self) -> bool:
        """True for a plastic zone; its points are marked if the zone reaches a boundary."""
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
    if _is_common(lengths):
        volumes = {number: length**3 for number, length in lengths.items()}
        scales["m"] = ("D", "diameter", lengths)
        scales["m^3"] = ("D^3", "diameter_cubed", volumes)
    if _is_common(forces):
        scales["N"] = (r"F_\mathrm{y}", "yield_force", forces)
    present = with_values([point.summary for point in done])
    left_out = set()
    if not is_mostly_known([point.summary.get("restitution") for point in done]):
        left_out.add("restitution")
    if any(math.isfinite(_number(point, "n_plastic_spheres")) for point in done):
        left_out.add("plastic_zone_volume")  # shown by the number of spheres
    if not protects(varied, [point.summary for point in done]):
        left_out.add(REDUCTION)
    return [
        _ordinate(name, key, scales)
        for name, key in scan_figures(present).items()
        if name not in left_out
    ]


def _is_common(scale: Mapping[int, float]) -> bool:
    """Return True for a scale that is known and the same at all points."""
    sizes = Series(scale, dtype=float)
    return bool(sizes.notna().all()) and is_constant(sizes)


def _ordinate(name: str, key: str, scales: Mapping[str, _Scale]) -> Ordinate:
    """A value of the summary, divided by the scale of its unit if it has one."""
    entry = quantity(key)
    number = plastic_spheres if key == "n_plastic_spheres" else value_of(key)
    if entry.symbol and entry.unit in scales:
        symbol, words, sizes = scales[entry.unit]
        title = f"{entry.axis} ${entry.symbol}/{symbol}$"
        column = f"{name}_over_{words}"
        return Ordinate(name, title, column, lambda point: number(point) / sizes[point.number], key)
    unit, factor = _SHOWN_IN.get(entry.unit, (entry.unit, 1.0))
    title = entry.title + (f" ({printed_unit(unit)})" if unit else "")
    column = key if unit == entry.unit else f"{name}_{unit.replace('^', '')}"
    return Ordinate(name, title, column, lambda point: factor * number(point), key)


def _scales(
    varied: Sequence[str], done: Sequence[PointResult]
) -> tuple[dict[int, float], dict[int, float]]:
    """Return the diameter (m) and the yield force (N) of points by number; NaN if unknown. Each
    case is read once.
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
    """Return a function that returns a value of the summary of a point; NaN without this value."""
    return lambda point: _number(point, name)


def plastic_spheres(point: PointResult) -> float:
    """Return the number of yielded spheres of a point; NaN for a law that does not yield."""
    yields = point.summary.get("plastic_zone_volume_m3") is not None
    return _number(point, "n_plastic_spheres") if yields else math.nan


_SAME = 1e-6  # relative difference of equal values


def is_constant(values: Series) -> bool:
    """Return True for values that differ by no more than rounding."""
    largest = values.abs().max()
    return bool(values.empty or values.max() - values.min() <= _SAME * largest)
