"""Varied keys of a scan in its figures: labels, symbols, units, values to plot against."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import is_number
from granwave.analysis.formatting.numbers import tick
from granwave.analysis.formatting.values import (
    AMPLITUDE,
    NONE,
    Naming,
    more_keys,
    shown_unit,
    unique_labels,
    unit_of,
)

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
_OF_PERSONS = ("Young", "Poisson")  # beginnings of labels with a capital within a sentence
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
    def label(self) -> str:
        """Label within a sentence, with the diameter that divides some values."""
        label = self.naming.label
        return label if label.startswith(_OF_PERSONS) else f"{label[:1].lower()}{label[1:]}"

    @property
    def words(self) -> str:
        """Label within a sentence, without a divisor."""
        return self.label.split(" / ")[0]

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
