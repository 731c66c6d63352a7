"""Quantities that figures of a scan show: values of its points, with titles and units."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.scans.result import SEED, PointResult
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case

_UNITS_OF_ITS_OWN = ("load.", "run.", "boundary.", "output.", SEED, "packing.size", "packing.kind")

Value = Callable[[PointResult], float]


@dataclasses.dataclass(frozen=True)
class Quantity:
    """Something that is plotted: the start of the figure's name, a title for the axis, a column, a value by point.

    Attributes
    ----------
    zone
        It is of a plastic zone, whose points are marked where it reaches a bound.
    """

    name: str
    title: str
    column: str
    value: Value
    zone: bool = False


def quantities(varied: Sequence[str], done: Sequence[PointResult]) -> list[Quantity]:
    """Return what can be shown of points that are done.

    Parameters
    ----------
    varied
        Keys that vary in the scan.
    """
    units = _Units(varied)
    force_units = [units.force(point) for point in done]
    if all(map(math.isfinite, force_units)):
        force = Quantity(
            "peak_force",
            r"Peak force $F_\mathrm{max}/F_\mathrm{y}$",
            "peak_force_over_yield_force",
            lambda point: _number(point, "peak_force_N") / units.force(point),
        )
    else:
        force = Quantity("peak_force", r"Peak force $F_\mathrm{max}$ (N)", "peak_force_N", value_of("peak_force_N"))
    sizes = [
        _length_of_zone(units, done, *words)
        for words in (
            ("plastic_zone_depth", "Depth of the outermost yield", r"z_\mathrm{p}", "plastic_zone_depth_m"),
            ("zone_depth_90", "Depth that holds 90 %", "z_{90}", "zone_depth_90_m"),
            ("zone_radius_90", "Radius that holds 90 %", "r_{90}", "zone_radius_90_m"),
        )
    ]
    zone = Quantity(  # of a continuum run
        "plastic_zone_volume",
        r"Plastic zone $V_\mathrm{p}$ (mm³)",
        "plastic_zone_volume_mm3",
        lambda point: 1e9 * _number(point, "plastic_zone_volume_m3"),
        zone=True,
    )
    volume = Quantity(
        "zone_volume_90",
        r"Volume that holds 90 % $V_{90}$ (mm³)",
        "zone_volume_90_mm3",
        lambda point: 1e9 * _number(point, "zone_volume_90_m3"),
        zone=True,
    )
    rebound = Quantity("restitution", r"Coefficient of restitution $e$", "restitution", value_of("restitution"))
    return [
        *([rebound] if all(math.isfinite(rebound.value(point)) for point in done) else []),
        Quantity(
            "dissipated_fraction",
            r"Dissipated fraction $E_\mathrm{d}/E_0$",
            "dissipated_fraction",
            value_of("dissipated_fraction"),
        ),
        *sizes,
        volume,
        *([zone] if any(math.isfinite(_number(point, "plastic_zone_volume_ever_m3")) for point in done) else []),
        Quantity("plastic_spheres", r"Plastic spheres $N_\mathrm{p}$", "n_plastic_spheres", plastic_spheres, zone=True),
        force,
        # of the static contact of two spheres
        Quantity("max_force", r"Force at the largest overlap (N)", "max_force_N", value_of("max_force_N")),
        Quantity(
            "force_deviation",
            "Force less the law (%, rms)",
            "force_deviation_rms_percent",
            value_of("force_deviation_rms_percent"),
        ),
        Quantity("wave_speed", r"Wave speed $c$ (m/s)", "wave_speed_m_s", value_of("wave_speed_m_s")),
    ]


def _length_of_zone(
    units: _Units, done: Sequence[PointResult], name: str, words: str, symbol: str, key: str
) -> Quantity:
    """A length of the plastic zone, in diameters of the spheres where all points have one."""
    if all(math.isfinite(units.length(point)) for point in done):
        return Quantity(
            name,
            f"{words} ${symbol}/D$",
            f"{name}_over_diameter",
            lambda point: _number(point, key) / units.length(point),
            zone=True,
        )
    return Quantity(name, f"{words} ${symbol}$ (mm)", f"{name}_mm", lambda point: 1e3 * _number(point, key), zone=True)


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
