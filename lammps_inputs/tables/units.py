"""Units in the names of columns: ``x (mm)``, ``x [mm]``, ``x/mm``, ``x_mm``, ``x in mm``,
``x, mm``, and ``x..mm.`` as R writes it.
"""

from __future__ import annotations

import math
import re
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Values = TypeVar("Values", float, NDArray[np.float64])

LENGTH = "length"
VELOCITY = "velocity"
MASS = "mass"
DENSITY = "density"
VOLUME = "volume"
ANGULAR_VELOCITY = "angular velocity"

LENGTH_UNITS = {"m": 0, "dm": -1, "cm": -2, "mm": -3, "um": -6, "nm": -9}
#: Units of lengths in images, whose size is not in the table.
VOXELS = ("voxel", "voxels", "vox", "vx", "pixel", "pixels", "px", "pix")
# powers of ten of the SI unit
UNITS: dict[str, dict[str, int]] = {
    LENGTH: LENGTH_UNITS,
    VELOCITY: {f"{unit}/s": power for unit, power in LENGTH_UNITS.items()},
    MASS: {"kg": 0, "g": -3, "mg": -6, "ug": -9},
    DENSITY: {"kg/m^3": 0, "g/cm^3": 3},
    VOLUME: {f"{unit}^3": 3 * power for unit, power in LENGTH_UNITS.items()},
    ANGULAR_VELOCITY: {"rad/s": 0},
}
_METRES = ("metre", "metres", "meter", "meters")
_PREFIXES = {"": "m", "deci": "dm", "centi": "cm", "milli": "mm", "micro": "um", "nano": "nm"}
_SPELLINGS = {
    "µ": "u",
    "μ": "u",
    "micron": "um",
    "microns": "um",
    **{f"{prefix}{word}": unit for (prefix, unit), word in product(_PREFIXES.items(), _METRES)},
    "kg/m3": "kg/m^3",
    "g/cm3": "g/cm^3",
    "g/cc": "g/cm^3",
    "1/s": "rad/s",
    **{f"{unit}{cubed}": f"{unit}^3" for unit, cubed in product(LENGTH_UNITS, ("3", "³", "**3"))},
    "ml": "cm^3",
    "mL": "cm^3",
    "ul": "mm^3",
    "uL": "mm^3",
}
_CAPITALS = ("mm", "cm", "um", "nm", "mm/s", "cm/s", "kg")
_NO_UNITS = ("-", "--", "1", "/", "none")
_PLACEHOLDERS = ("unit", "units")  # unit of ImageJ without a scale
_PARTED = re.compile(
    r"(.+?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\]|\s+in\s+(\S+)|\s*/\s*(\S+)"
    r"|,\s*([dcmunµμ]?m(?:/s)?)|\.{1,2}([dcmunµμ]?m)\.)"
)
_DIGITS_OF_SIZE = 14  # digits of a voxel size, which its logarithm keeps
_SIZE_AND_UNIT = re.compile(r"([0-9.]+(?:[eE][-+]?[0-9]+)?)\s*([dcmun]?m)")
_JOINED = re.compile(r"(.+?)_((?:rad|kg|[munc]?m|d?m|[mu]?g)(?:_s|_m3|/s)?|[munc]?m\^?3|dm\^?3)")


def split_unit(head: str) -> tuple[str, str]:
    """Return name and unit of the head of a column; the unit is empty if there is none."""
    if match := _PARTED.fullmatch(head):
        unit = _spelt(next(part for part in match.groups()[1:] if part is not None))
        return match[1], "" if unit in _PLACEHOLDERS else unit
    if match := _JOINED.fullmatch(head):
        return match[1], _spelt(match[2].replace("_s", "/s").replace("_m3", "/m^3"))
    return head, ""


def unit_of(cell: str) -> str:
    """Return the unit in a separate cell, such as ``[mm]``; empty if there is none."""
    unit = _spelt(cell.strip().strip("()[]{}\"'"))
    return "" if unit in _NO_UNITS else unit


def has_size(unit: str) -> bool:
    """Return True if a unit of lengths has a size, such as a voxel: ``0.012 mm``."""
    return unit not in LENGTH_UNITS


def length_power(unit: str) -> float:
    """Return the power of ten of a unit of lengths, such as ``mm``, or ``0.012 mm`` of a voxel.

    Raises
    ------
    ValueError
        It is no unit of lengths, or its size is not above 0.
    """
    if unit in LENGTH_UNITS:
        return LENGTH_UNITS[unit]
    match = _SIZE_AND_UNIT.fullmatch(unit.strip())
    if match is None:
        raise ValueError(f"no unit of lengths: {unit}")
    size = float(match[1])
    if not 0 < size < math.inf:
        raise ValueError(f"no size of a voxel: {unit}")
    return math.log10(size) + LENGTH_UNITS[match[2]]


def in_si(values: Values, power: float) -> Values:
    """Return values in a unit of this power of ten, in the SI unit; decimal digits are kept if the
    power is a whole number.
    """
    if power % 1:
        return values * float(f"{10.0**power:.{_DIGITS_OF_SIZE}g}")
    return values / 10.0**-power if power < 0 else values * 10.0**power


def _spelt(unit: str) -> str:
    unit = unit.strip()
    for spelling in ("µ", "μ"):
        unit = unit.replace(spelling, _SPELLINGS[spelling])
    spelt = _SPELLINGS.get(unit, unit)
    if unit.isupper() and unit.lower() in _CAPITALS:  # for names in capitals
        return unit.lower()
    return spelt
