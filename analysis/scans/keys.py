"""Varied keys of a scan in its figures (labels, symbols, units, values to plot against), and means
over replicates.

Means are for the start of a report, and the end of a scan.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import is_number, show
from granwave.analysis.formatting.numbers import in_any_unit, interval, interval_in_any_unit, tick
from granwave.analysis.formatting.values import (
    AMPLITUDE,
    NONE,
    Naming,
    grains_called_in,
    more_keys,
    shown_unit,
    unique_labels,
    unit_of,
)
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.measures.zone_size import Mark, mark_of
from granwave.analysis.quantities import quantity, scan_figures
from granwave.analysis.scans.result import REDUCTION, SEED, ScanResult, protects
from granwave.analysis.scans.table import (
    CONFIDENCE,
    COUNT,
    MEAN,
    labels_of,
    physical,
    scan_statistics,
)
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains

_NAMES: Mapping[str, Naming] = {
    "load.velocity": Naming("Impact velocity", r"$v_0$", "m/s"),
    "load.spheres": Naming("Impacted spheres", r"$n_\mathrm{s}$"),
    "load.angle": Naming("Angle of impact", r"$\theta$", "°"),
    "load.duration": Naming("Duration of the load", r"$\tau$", "µs", 1e-6),
    "load.frequency": Naming("Frequency of the load", r"$f$", "kHz", 1e3),
    "packing.diameter": Naming("Sphere diameter", r"$D$", "mm", 1e-3),
    "packing.kind": Naming("Packing"),
    "packing.diameter_scatter": Naming("Diameter scatter", r"$\Delta D$", "µm", 1e-6),
    "packing.vacancies": Naming("Vacancies", unit="%", scale=0.01),
    "packing.tilt": Naming("Tilt of the floor"),
    "material": Naming("Material"),
    "material.youngs_modulus": Naming("Young's modulus", r"$E$", "GPa", 1e9),
    "material.poisson_ratio": Naming("Poisson's ratio", r"$\nu$"),
    "material.density": Naming("Density", r"$\rho$", "kg/m³"),
    "material.yield_strength": Naming("Yield strength", r"$\sigma_\mathrm{y}$", "MPa", 1e6),
    "contact.law": Naming("Contact law"),
    "contact.friction": Naming("Friction coefficient", r"$\mu$"),
    "contact.tangential": Naming("Tangential spring"),
    "contact.rolling": Naming("Coefficient of rolling friction", r"$\mu_r$"),
    "contact.cohesion.energy": Naming("Work of adhesion", "$w$", "J/m²"),
    "contact.loss.time": Naming("Relaxation time", "$A$", "µs", 1e-6),
    "contact.loss.restitution": Naming("Restitution", "$e$"),
    "contact.loss.dashpot": Naming("Dashpot factor", r"$\alpha$"),
    "contact.loss.tangential": Naming("Ratio of tangential damping", "$x$"),
    "contact.loss.dashpot.restitution": Naming("Restitution of the dashpot", "$e$"),
    "contact.initial_overlap": Naming("Initial plastic indentation", unit="µm", scale=1e-6),
    "contact.variant": Naming("Variant"),
    "contact.yield_factor": Naming("Yield factor", r"$C$"),
    "contact.beta": Naming("Residual fraction", r"$\beta$"),
    "precompression.kind": Naming("Precompression"),
    "precompression.pressure": Naming("Static pressure", r"$p_0$", "kPa", 1e3),
    "precompression.force": Naming("Static force", r"$F_0$", "N"),
    "boundary.bottom": Naming("Bottom"),
    "boundary.sides": Naming("Sides"),
    "boundary.forget_gap": Naming("Forgetting gap / diameter"),
    "run.end_time": Naming("End time", unit="µs", scale=1e-6),
    "run.timestep": Naming("Timestep", unit="ns", scale=1e-9),
}
_ENTRIES: Mapping[tuple[str, str], Naming] = {  # keys of entries of lists
    ("striker", "velocity"): Naming("Velocity of the striker", r"$v_0$", "m/s"),
    ("replace", "index"): Naming("Position of replaced spheres"),
}
_AMPLITUDE = Naming("Amplitude of the load", r"$A$")
_OF_MOTION = (("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9))  # units of amplitudes, from the largest on
_SIZES = ("Spheres along x", "Rows along y", "Layers")
_SIZE_SYMBOLS = (r"$n_x$", r"$n_y$", r"$n_z$")
_PLANE_SIZES = (
    "Grains along x",
    "Rows",
)  # counts of a square packing and of crystals in the x-z plane, some with rows of n - 1
_PLANE_SYMBOLS = (r"$n_x$", r"$n_\mathrm{rows}$")


@dataclasses.dataclass(frozen=True)
class VariedKey:
    """Varied key with its values at all points of the scan.

    Attributes
    ----------
    name
        Dotted name.
    values
        Plotted value of each point, in the unit of `naming`; text for values that are not numbers.
    labels
        Labels in the scan, by point.
    unit
        SI unit of the labels, where it depends on the scan.
    """

    name: str
    naming: Naming
    values: tuple[Any, ...]
    labels: tuple[Any, ...]
    unit: str = ""

    @property
    def numeric(self) -> bool:
        """True if all values are numbers."""
        return all(map(is_number, self.values))

    @property
    def title(self) -> str:
        """Title of an axis."""
        unit = f" ({self.naming.unit})" if self.naming.unit else ""
        return " ".join(filter(None, [self.naming.label, self.naming.symbol])) + unit

    @property
    def column(self) -> str:
        """Name of a column in CSV files, which hold the labels in SI units."""
        unit = (
            (self.unit or unit_of(self.name)).replace("^", "").replace("/", "_").replace(" ", "_")
        )
        return f"{self.name}_{unit}" if unit and self.numeric else self.name

    @property
    def slug(self) -> str:
        """Part of file names."""
        return self.name.replace(".", "_")

    def text(self, row: int) -> str:
        """Return the text of the value of a point for a legend."""
        value = self.values[row]
        if not is_number(value):
            return f"{self.naming.label}: {value}" if value == NONE else str(value)
        unit = f" {self.naming.unit}" if self.naming.unit else ""
        return f"{self.naming.symbol or self.naming.label} = {shown(value)}{unit}"

    def tick(self, row: int) -> str:
        """Return the text of the value of a point for an axis."""
        value = self.values[row]
        return shown(value) if is_number(value) else str(value)


def shown(value: float) -> str:
    """Format a number of an axis or a legend with four digits."""
    return tick(float(f"{value:.4g}"))


def key_of(name: str, labels: Sequence[Any], unit: str = "") -> VariedKey:
    """Make the key of this name from its labels, one for each point.

    Parameters
    ----------
    unit
        SI unit of the labels, where it depends on the scan.
    """
    naming = _amplitude(labels, unit) if name == AMPLITUDE else _naming_of(name)
    if name == "packing.size" and (sizes := _sizes(labels)):
        return VariedKey(name, *_size(sizes), tuple(labels))
    if naming is None:
        naming = _of_entry(name) or Naming(name, unit=shown_unit(name))
    if components := _along_one_axis(labels):
        axis, along = components
        return VariedKey(
            name,
            dataclasses.replace(naming, label=f"{naming.label} along {axis}"),
            along,
            tuple(labels),
        )
    texts = unique_labels(labels)
    values = tuple(
        float(f"{label / naming.scale:.12g}") if is_number(label) else text
        for label, text in zip(labels, texts, strict=True)
    )
    return VariedKey(name, naming, values, tuple(labels), unit)


def _naming_of(name: str) -> Naming | None:
    """Return the naming of a key of cases, those of extensions included; None if it has none."""
    return _NAMES.get(name) or more_keys().get(name)


def _amplitude(labels: Sequence[Any], unit: str) -> Naming:
    """Return the naming of the amplitude of a load.

    A displacement has the largest unit in which the largest amplitude is 1 or more.
    """
    if unit != "m":
        return dataclasses.replace(_AMPLITUDE, unit=unit)
    largest = max(filter(is_number, labels), default=0.0)
    fitting = [(name, scale) for name, scale in _OF_MOTION if largest >= scale]
    name, scale = fitting[0] if fitting else _OF_MOTION[-1]
    return dataclasses.replace(_AMPLITUDE, unit=name, scale=scale)


def _of_entry(name: str) -> Naming | None:
    """Return the naming of a key of an entry of a list, such as ``replace.1.material.density``;
    None if unknown.
    """
    table, _, rest = name.partition(".")
    number, _, key = rest.partition(".")
    if not number.isdigit():
        return None
    if (table, key) in _ENTRIES:
        return _ENTRIES[table, key]
    entry = _NAMES.get(key) or _NAMES.get(f"packing.{key}")
    if table != "replace" or entry is None:
        return None
    what = entry.label.removeprefix("Sphere ")
    return dataclasses.replace(entry, label=f"{what[:1].upper()}{what[1:]} of replaced spheres")


def _along_one_axis(labels: Sequence[Any]) -> tuple[str, tuple[float, ...]] | None:
    """Return the common axis of vectors and their components along it; None for other labels."""
    vectors = [_parsed(label) for label in labels]
    if not all(map(_is_vector, vectors)):
        return None
    components = dict(zip("xyz", zip(*vectors, strict=True), strict=False))
    along = [axis for axis, values in components.items() if any(values)]
    if len(along) != 1:
        return None
    (axis,) = along
    return axis, tuple(map(float, components[axis]))


def _is_vector(value: Any) -> bool:
    """Return True for a list of three numbers."""
    return isinstance(value, list) and len(value) == 3 and all(map(is_number, value))


def _parsed(label: Any) -> Any:
    """Return the list that a label shows as text; other labels unchanged."""
    try:
        return json.loads(label) if isinstance(label, str) else label
    except ValueError:
        return label


def _size(sizes: list[tuple[int, ...]]) -> tuple[Naming, tuple[int, ...]]:
    """Return the count that varies, or the number of spheres if several counts vary; for a plane
    crystal the product of its counts.
    """
    lengths = {len(size) for size in sizes}
    in_plane = lengths == {2}
    names = _PLANE_SIZES if in_plane else _SIZES
    symbols = _PLANE_SYMBOLS if in_plane else _SIZE_SYMBOLS
    products = tuple(math.prod(size) for size in sizes)
    if len(lengths) == 1:
        counts = list(zip(*sizes, strict=True))  # counts of each direction
        varying = [n for n, values in enumerate(counts) if len(set(values)) > 1]
        if len(varying) == 1 and len(counts) > 1:
            n = varying[0]
            return Naming(names[n], symbols[n]), counts[n]
    if in_plane:  # rows of n and n - 1 in turn have fewer grains than the product
        return Naming(f"{names[0]} times rows", f"{symbols[0]} {symbols[1]}"), products
    return Naming("Number of spheres", r"$N$"), products


def _sizes(labels: Sequence[Any]) -> list[tuple[int, ...]]:
    """Parse labels as lists of counts; empty if any label is not such a list."""
    sizes = []
    for label in labels:
        parsed = _parsed(label)
        counts = parsed if isinstance(parsed, list) else [parsed]
        if not counts or not all(type(count) is int for count in counts):
            return []
        sizes.append(tuple(counts))
    return sizes


_CLEAR = 0.05  # change of a quantity, relative to its largest value, that is worth a headline
WORTH = 1e-12  # smallest value that is not rounding
_SAME = 1e-6  # relative difference of values that count as equal
_AIMS = (REDUCTION, "restitution", "transmission")  # values for which scans are made
#: Quantities that come first, in this order.
_MAIN = (
    *_AIMS,
    "dissipated_fraction",
    "peak_force_N",
    "peak_force_with_walls_N",
    "max_force_N",
    "wall_peak_force_N",
    "n_plastic_spheres",
)
_OF_ZONE = ("n_plastic_", "plastic_zone_", "zone_")  # names of values of the plastic zone
_TRENDS = ("rises", "falls")
_BETWEEN = "peak_force_N"  # force of contacts between spheres
_WITH_WALLS = "peak_force_with_walls_N"


@dataclasses.dataclass(frozen=True)
class Means:
    """Values of a scan: a row for each combination of its keys without the seed that has finished
    points.

    Attributes
    ----------
    keys
        Varied keys with more than one value, with their values by row; without run times that
        follow from other keys.
    counts
        Number of points of each row.
    values
        Means by name of the quantity, one for each row; None where unknown.
    half_widths
        Half-widths of the 95 % confidence intervals; None without replicates.
    protection
        True if the scan concerns the protection of a target; see
        `granwave.analysis.scans.result.protects`.
    called
        Word for the grains of its runs.
    has_limited_zones
        True if the plastic zone of a point reaches a boundary, which limits its values.
    """

    keys: tuple[VariedKey, ...]
    counts: tuple[int, ...]
    values: Mapping[str, Sequence[float | None]]
    half_widths: Mapping[str, Sequence[float | None]]
    protection: bool = False
    called: str = SPHERES
    has_limited_zones: bool = False

    @property
    def figures(self) -> dict[str, str]:
        """Values that figures show, by the names of figures."""
        return scan_figures(_present(self.values))

    def quantities(self) -> list[tuple[str, str]]:
        """Return the quantities that have figures, as names of figure and value: first those for
        which scans are made and those that vary clearly, then those that vary by less than
        `_CLEAR`, then constant ones.
        """
        quantities = []
        for number, (name, key) in enumerate(self.figures.items()):
            values = [value for value in self.values.get(key, ()) if value is not None]
            if key == REDUCTION and not self.protection:
                continue
            if len(values) == len(self.counts) > 1 and max(map(abs, values)) > WORTH:
                rank = _MAIN.index(key) if key in _MAIN else len(_MAIN) + number
                change = self._change(key)
                is_slight = change <= _CLEAR and key not in _AIMS
                is_limited = self.has_limited_zones and key.startswith(_OF_ZONE)
                quantities.append((change <= _SAME, is_limited, is_slight, rank, name, key))
        return [(name, key) for *_, name, key in sorted(quantities)]

    def varies(self, name: str) -> bool:
        """Return True if the values of a quantity differ by more than rounding."""
        return self._change(name) > _SAME

    def _change(self, name: str) -> float:
        """Return the range of a quantity, divided by its largest magnitude."""
        values = [value for value in self.values[name] if value is not None]
        largest = max(map(abs, values))
        return (max(values) - min(values)) / largest if largest else 0.0

    def sentence(self, main: str) -> str:
        """Return a sentence with the range of a quantity, the points at its ends, and the trends
        with each key.
        """
        low, high = self._ends(main)
        label = quantity(main).label
        most = self.in_words(main, high)
        text = f"{label}: {most} at all points."
        if self.varies(main):
            least = self.in_words(main, low)
            text = f"{label}: from {least} ({self.setting(low)}) to {most} ({self.setting(high)})."
            trends = self._trends(main)
            if trends:
                text += f" It {', '.join(trends)}."
        return in_grains(text, self.called)

    def range_in_words(self, name: str) -> str:
        """Return the range of a quantity and its trends, without the points at the ends."""
        low, high = self._ends(name)
        ends = f"{self.in_words(name, low)} to {self.in_words(name, high)}"
        return in_grains("; ".join([ends, *self._trends(name)]), self.called)

    def _ends(self, name: str) -> tuple[int, int]:
        """Return the rows of the smallest and of the largest value."""
        values = [value or 0.0 for value in self.values[name]]
        return values.index(min(values)), values.index(max(values))

    def _trends(self, main: str) -> list[str]:
        """Return the trends of a quantity with the keys: ``rises with diameter and velocity``."""
        keys_of_trend: dict[str, list[str]] = {word: [] for word in _TRENDS}
        for n, key in enumerate(self.keys):
            trend = self._trend(main, n)
            if trend:
                label = key.naming.label
                keys_of_trend[trend].append(label[:1].lower() + label[1:])
        return [f"{word} with {' and '.join(keys)}" for word, keys in keys_of_trend.items() if keys]

    def _trend(self, main: str, n: int) -> str:
        """Return the trend of a quantity with the n-th key at fixed other keys, ``rises`` or
        ``falls``; empty if it changes its direction.
        """
        if not self.keys[n].numeric:
            return ""
        signs = set()
        for rows in self.lines_along(n):
            values = [self.values[main][row] or 0.0 for row in rows]
            largest = max(map(abs, values), default=0.0)
            changes = [b - a for a, b in itertools.pairwise(values)]
            signs |= {change > 0 for change in changes if abs(change) > _SAME * largest}
        rises, falls = _TRENDS
        if signs == {True}:
            return rises
        return falls if signs == {False} else ""

    def text(self, name: str, row: int) -> str:
        """Return a mean with its interval, if it has one."""
        mean = self.values[name][row]
        half = self.half_widths[name][row]
        return interval(mean, half) if mean is not None and half else show(mean)

    def in_words(self, name: str, row: int) -> str:
        """Return a mean with its unit, and its interval if it has one."""
        mean = self.values[name][row]
        half = self.half_widths[name][row]
        unit = quantity(name).unit
        if mean is None:
            return show(mean)
        return interval_in_any_unit(mean, half, unit) if half else in_any_unit(mean, unit)

    def setting(self, row: int) -> str:
        """Return the values of the keys of a row in words."""
        parts = []
        for key in self.keys:
            unit = f" {key.naming.unit}" if key.naming.unit and key.numeric else ""
            parts.append(
                f"{key.naming.label[:1].lower()}{key.naming.label[1:]} {key.tick(row)}{unit}"
            )
        return ", ".join(parts)

    def lines_along(self, n: int) -> list[list[int]]:
        """Return the rows along the n-th key, in its order: a list for each combination of the
        other keys.
        """
        lines: dict[tuple[object, ...], list[int]] = {}
        others = [key for m, key in enumerate(self.keys) if m != n]
        values = [float(value) for value in self.keys[n].values]
        for row in range(len(self.counts)):
            setting = tuple(key.values[row] for key in others)
            lines.setdefault(setting, []).append(row)
        return [sorted(rows, key=lambda row: values[row]) for rows in lines.values()]


def means_of(scan: ScanResult) -> Means:
    """Average the finished points of a scan over the seeds; without seeds each point is a row."""
    names = [key for key in scan.varied if key != SEED]
    done = [point for point in scan.points if point.status == "done"]
    summaries = [point.summary for point in done]
    if SEED in scan.varied:
        table = scan_statistics(scan)
        counts = table.get(COUNT, [])
        means = {key.removesuffix(MEAN): table[key] for key in table if key.endswith(MEAN)}
        widths = {name: table[name + CONFIDENCE] for name in means}
        labels = {name: table[name] for name in names}
    else:
        counts = [1] * len(done)
        means = _numbers(summaries)
        widths = dict.fromkeys(means, [None] * len(done))
        labels = labels_of(done, names)
    kept = [row for row, count in enumerate(counts) if count]
    keys = [
        key_of(name, column, scan.units.get(name, ""))
        for name, column in physical(_rows_of(labels, kept)).items()
    ]
    return Means(
        tuple(key for key in keys if len(set(key.values)) > 1),
        tuple(counts[row] for row in kept),
        _rows_of(means, kept),
        _rows_of(widths, kept),
        protects(scan.varied, summaries),
        grains_called_in(summaries),
        has_limited_zones=any(
            mark_of(summary) is Mark.CUT or is_unresolved(summary) for summary in summaries
        ),
    )


def with_values(summaries: Iterable[Mapping[str, Any]]) -> set[str]:
    """Return the quantities that these summaries have, for `scan_figures`."""
    return _present(_numbers(list(summaries)))


def _present(columns: Mapping[str, Sequence[float | None]]) -> set[str]:
    """Return the quantities with a value; without the force between spheres if a point has forces
    at walls only.
    """
    present = {name for name, values in columns.items() if set(values) - {None}}
    between = columns.get(_BETWEEN, ())
    of_all = columns.get(_WITH_WALLS, ())
    if any(force == 0 and every for force, every in zip(between, of_all, strict=False)):
        present.discard(_BETWEEN)
    return present


def _numbers(summaries: Sequence[Mapping[str, Any]]) -> dict[str, list[float | None]]:
    """Return the numbers of summaries by quantity; None if there is no number."""
    columns: dict[str, list[float | None]] = {}
    for name in dict.fromkeys(itertools.chain.from_iterable(summaries)):
        values: list[Any] = [summary.get(name) for summary in summaries]
        columns[name] = [float(value) if is_number(value) else None for value in values]
    return columns


def _rows_of(columns: Mapping[str, Sequence[Any]], rows: Sequence[int]) -> dict[str, list[Any]]:
    """Return some rows of each column."""
    picked = {}
    for name, column in columns.items():
        picked[name] = [column[row] for row in rows]
    return picked
