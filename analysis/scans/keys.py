"""Varied keys of a scan in its figures (labels, symbols, units, values to plot against), and means
over replicates.

Means are for the start of a report, and the end of a scan.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import is_number, show
from granwave.analysis.formatting.numbers import interval, tick
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
from granwave.analysis.quantities import quantity, scan_figures
from granwave.analysis.scans.result import REDUCTION, SEED, ScanResult, protects
from granwave.analysis.scans.table import CONFIDENCE, COUNT, MEAN, physical, scan_statistics
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains

_NAMES: Mapping[str, Naming] = {
    "load.velocity": Naming("Impact velocity", r"$v_0$", "m/s"),
    "load.spheres": Naming("Struck spheres", r"$n_\mathrm{s}$"),
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
    "contact.tangential": Naming("Spring of friction"),
    "contact.rolling": Naming("Coefficient of rolling friction", r"$\mu_r$"),
    "contact.cohesion.energy": Naming("Work of adhesion", "$w$", "J/m²"),
    "contact.loss.time": Naming("Loss time", "$A$", "µs", 1e-6),
    "contact.loss.restitution": Naming("Restitution", "$e$"),
    "contact.loss.dashpot": Naming("Factor of the dashpot", r"$\alpha$"),
    "contact.loss.dashpot.restitution": Naming("Restitution of the dashpot", "$e$"),
    "contact.initial_overlap": Naming("Dent before the run", unit="µm", scale=1e-6),
    "contact.variant": Naming("Variant"),
    "contact.yield_factor": Naming("Yield factor", r"$C$"),
    "contact.beta": Naming("Residual share", r"$\beta$"),
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
    ("replace", "index"): Naming("Place of replaced spheres"),
}
_AMPLITUDE = Naming("Amplitude of the load", r"$A$")
_OF_MOTION = (("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9))  # units of amplitudes, from the largest on
_SIZES = ("Spheres along x", "Rows along y", "Layers")
_SIZE_SYMBOLS = (r"$n_x$", r"$n_y$", r"$n_z$")
_PLANE_SIZES = (
    "Grains along x",
    "Rows",
)  # of a square packing and of crystals in the x-z plane, some rows of n - 1
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
        """Return the value of one point for a legend."""
        value = self.values[row]
        if not is_number(value):
            return f"{self.naming.label}: {value}" if value == NONE else str(value)
        unit = f" {self.naming.unit}" if self.naming.unit else ""
        return f"{self.naming.symbol or self.naming.label} = {shown(value)}{unit}"

    def tick(self, row: int) -> str:
        """Return the value of one point for an axis."""
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
    """Return the naming of the load's amplitude: of a motion in the largest unit in which the
    largest is 1 or more.
    """
    if unit != "m":
        return dataclasses.replace(_AMPLITUDE, unit=unit)
    largest = max((label for label in labels if is_number(label)), default=0.0)
    shown_in = next(
        ((name, scale) for name, scale in _OF_MOTION if largest >= scale), _OF_MOTION[-1]
    )
    return dataclasses.replace(_AMPLITUDE, unit=shown_in[0], scale=shown_in[1])


def _of_entry(name: str) -> Naming | None:
    """Return the naming of a key of an entry of a list, such as ``replace.1.material.density``;
    None if unknown.
    """
    table, _, rest = name.partition(".")
    number, _, key = rest.partition(".")
    found = _ENTRIES.get((table, key)) or (
        _naming_of(key) or _naming_of(f"packing.{key}") if table == "replace" else None
    )
    if not number.isdigit() or found is None:
        return None
    if (table, key) in _ENTRIES:
        return found
    what = found.label.removeprefix("Sphere ")
    return dataclasses.replace(found, label=f"{what[:1].upper()}{what[1:]} of replaced spheres")


def _along_one_axis(labels: Sequence[Any]) -> tuple[str, tuple[float, ...]] | None:
    """Return the axis and the components of vectors that are all along it; None of anything else."""
    vectors = [
        vector for vector in map(_parsed, labels) if isinstance(vector, list) and len(vector) == 3
    ]
    if len(vectors) < len(labels) or not all(
        is_number(part) for vector in vectors for part in vector
    ):
        return None
    axes = {axis for vector in vectors for axis in range(3) if vector[axis]}
    if len(axes) != 1:
        return None
    (axis,) = axes
    return "xyz"[axis], tuple(float(vector[axis]) for vector in vectors)


def _parsed(label: Any) -> Any:
    """Return the list that a label is the text of; other labels as they are."""
    try:
        return json.loads(label) if isinstance(label, str) else label
    except ValueError:
        return label


def _size(sizes: list[tuple[int, ...]]) -> tuple[Naming, tuple[int, ...]]:
    """Return the count that varies, or the number of spheres if several counts do; in a plane, the
    counts' product.
    """
    lengths = {len(size) for size in sizes}
    names, symbols = (_PLANE_SIZES, _PLANE_SYMBOLS) if lengths == {2} else (_SIZES, _SIZE_SYMBOLS)
    varying = (
        [n for n in range(max(lengths)) if len({size[n] for size in sizes}) > 1]
        if len(lengths) == 1
        else []
    )
    if len(varying) == 1 and max(lengths) > 1:
        n = varying[0]
        return Naming(names[n], symbols[n]), tuple(size[n] for size in sizes)
    if lengths == {2}:  # rows of n and n - 1 in turn have fewer grains than that
        return Naming(f"{names[0]} times rows", f"{symbols[0]} {symbols[1]}"), tuple(
            math.prod(size) for size in sizes
        )
    return Naming("Spheres in all", r"$N$"), tuple(math.prod(size) for size in sizes)


def _sizes(labels: Sequence[Any]) -> list[tuple[int, ...]]:
    """Parse labels as lists of counts; empty if any label is not such a list."""
    found = [counts if isinstance(counts, list) else [counts] for counts in map(_parsed, labels)]
    whole = all(isinstance(n, int) and not isinstance(n, bool) for counts in found for n in counts)
    return [tuple(counts) for counts in found] if whole and all(found) else []


WORTH = 1e-12  # smallest value that is not rounding
_SAME = 1e-6  # relative difference of values that count as equal
_MAIN = (  # in this order
    REDUCTION, "restitution", "transmission", "dissipated_fraction", "peak_force_N", "n_plastic_spheres",
)  # fmt: skip
_TRENDS = ("rises", "falls")


@dataclasses.dataclass(frozen=True)
class Means:
    """Values of a scan: a row for each combination of its keys without the seed that has finished
    points.

    Attributes
    ----------
    keys
        Varied keys that take more than one value, with their values by row; without run times that
        follow from others.
    counts
        Number of points of each row.
    values
        Means by name of the quantity, one a row; None where there is none.
    half_widths
        Half-widths of the 95 % confidence intervals; None without replicates.
    protection
        True if the scan asks what reaches a target; `granwave.analysis.scans.result.protects`.
    called
        What the grains of its runs are called.
    """

    keys: tuple[VariedKey, ...]
    counts: tuple[int, ...]
    values: Mapping[str, Sequence[float | None]]
    half_widths: Mapping[str, Sequence[float | None]]
    protection: bool = False
    called: str = SPHERES

    @property
    def figures(self) -> dict[str, str]:
        """Values that figures show, by the names of figures."""
        there = {key for key, values in self.values.items() if set(values) - {None}}
        return scan_figures(there)

    def quantities(self) -> list[tuple[str, str]]:
        """Return the quantities that have figures, by names of figure and value: varying quantities
        first.
        """
        found = []
        for number, (name, key) in enumerate(self.figures.items()):
            values = [value for value in self.values.get(key, ()) if value is not None]
            if key == REDUCTION and not self.protection:
                continue
            if len(values) == len(self.counts) > 1 and max(map(abs, values)) > WORTH:
                rank = _MAIN.index(key) if key in _MAIN else len(_MAIN) + number
                found.append((not self.varies(key), rank, name, key))
        return [(name, key) for *_, name, key in sorted(found)]

    def varies(self, name: str) -> bool:
        """Return True if a quantity takes more than one value, rounding apart."""
        values = [value for value in self.values[name] if value is not None]
        return max(values) - min(values) > _SAME * max(map(abs, values))

    def sentence(self, main: str) -> str:
        """Say between which values a quantity lies, where, and how it depends on each key."""
        values = self.values[main]
        low, high = (
            choose(range(len(values)), key=lambda row: values[row] or 0.0) for choose in (min, max)
        )
        label = quantity(main).label
        unit = quantity(main).unit.replace("^", "")
        unit = f" {unit}" if unit else ""
        least, most = (self.text(main, row) + unit for row in (low, high))
        text = f"{label}: {most} at all points."
        if self.varies(main):
            text = f"{label}: from {least} ({self.setting(low)}) to {most} ({self.setting(high)})."
            said = []
            for word in _TRENDS:
                names = [
                    key.naming.label
                    for n, key in enumerate(self.keys)
                    if self._trend(main, n) == word
                ]
                said += (
                    [f"{word} with {' and '.join(name[:1].lower() + name[1:] for name in names)}"]
                    if names
                    else []
                )
            text += f" It {', '.join(said)}." if said else ""
        return in_grains(text, self.called)

    def _trend(self, main: str, n: int) -> str:
        """Return the trend of a quantity with the n-th key, all others equal; empty if it changes
        in both directions.
        """
        if not self.keys[n].numeric:
            return ""
        signs = set()
        for rows in self.lines_along(n):
            values = [self.values[main][row] or 0.0 for row in rows]
            largest = max(map(abs, values), default=0.0)
            changes = [b - a for a, b in itertools.pairwise(values)]
            signs |= {change > 0 for change in changes if abs(change) > _SAME * largest}
        return {frozenset({True}): "rises", frozenset({False}): "falls"}.get(frozenset(signs), "")

    def text(self, name: str, row: int) -> str:
        """Return a mean with its interval, where it has one."""
        mean = self.values[name][row]
        half = self.half_widths[name][row]
        return interval(mean, half) if mean is not None and half else show(mean)

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
        for row in range(len(self.counts)):
            lines.setdefault(
                tuple(key.values[row] for m, key in enumerate(self.keys) if m != n), []
            ).append(row)
        return [
            sorted(rows, key=lambda row: float(self.keys[n].values[row])) for rows in lines.values()
        ]


def means_of(scan: ScanResult) -> Means:
    """Average the finished points of a scan over the seeds; without seeds each point is a row."""
    names = [key for key in scan.varied if key != SEED]
    if SEED in scan.varied:
        table = scan_statistics(scan)
        counts = table.get(COUNT, [])
        columns = {
            key.removesuffix(MEAN): column for key, column in table.items() if key.endswith(MEAN)
        }
        widths = {key: table[key + CONFIDENCE] for key in columns}
        labels = {name: table[name] for name in names}
    else:
        done = [point for point in scan.points if point.status == "done"]
        counts = [1] * len(done)
        found = dict.fromkeys(key for point in done for key in point.summary)
        values: dict[str, list[Any]] = {
            key: [point.summary.get(key) for point in done] for key in found
        }
        columns = {
            key: [float(one) if is_number(one) else None for one in column]
            for key, column in values.items()
        }
        widths = {key: [None] * len(done) for key in found}
        labels = {name: [point.labels.get(name) for point in done] for name in names}
    kept = [row for row, count in enumerate(counts) if count]
    summaries = [point.summary for point in scan.points if point.status == "done"]
    there = physical({name: [labels[name][row] for row in kept] for name in names})
    keys = [key_of(name, column, scan.units.get(name, "")) for name, column in there.items()]
    return Means(
        tuple(key for key in keys if len(set(key.values)) > 1),
        tuple(counts[row] for row in kept),
        {key: [column[row] for row in kept] for key, column in columns.items()},
        {key: [column[row] for row in kept] for key, column in widths.items()},
        protects(scan.varied, summaries),
        grains_called_in(summaries),
    )
