"""Units in the names of columns: ``x (mm)``, ``x [mm]``, ``x/mm``, ``x_mm``, ``x in mm``."""

from __future__ import annotations

import re
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Values = TypeVar("Values", float, NDArray[np.float64])

LENGTH = "length"
VELOCITY = "velocity"
MASS = "mass"
DENSITY = "density"
ANGULAR_VELOCITY = "angular velocity"

LENGTH_UNITS = {"m": 0, "dm": -1, "cm": -2, "mm": -3, "um": -6, "nm": -9}
# powers of ten of the SI unit
UNITS: dict[str, dict[str, int]] = {
    LENGTH: LENGTH_UNITS,
    VELOCITY: {f"{unit}/s": power for unit, power in LENGTH_UNITS.items()},
    MASS: {"kg": 0, "g": -3, "mg": -6, "ug": -9},
    DENSITY: {"kg/m^3": 0, "g/cm^3": 3},
    ANGULAR_VELOCITY: {"rad/s": 0},
}
_SPELLINGS = {
    "µ": "u",
    "μ": "u",
    "micron": "um",
    "microns": "um",
    "metre": "m",
    "meter": "m",
    "millimetre": "mm",
    "millimeter": "mm",
    "kg/m3": "kg/m^3",
    "g/cm3": "g/cm^3",
    "g/cc": "g/cm^3",
    "1/s": "rad/s",
}
_CAPITALS = ("mm", "cm", "um", "nm", "mm/s", "cm/s", "kg")
_NO_UNITS = ("-", "--", "1", "/", "none")
_PARTED = re.compile(r"(.+?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\]|\s+in\s+(\S+)|\s*/\s*(\S+))")
_JOINED = re.compile(r"(.+?)_((?:rad|kg|[munc]?m|d?m|[mu]?g)(?:_s|_m3|/s)?)")


def split_unit(head: str) -> tuple[str, str]:
    """Return name and unit of the head of a column; the unit is empty if there is none."""
    if match := _PARTED.fullmatch(head):
        unit = next(part for part in match.groups()[1:] if part is not None)
        return match[1], _spelt(unit)
    if match := _JOINED.fullmatch(head):
        return match[1], _spelt(match[2].replace("_s", "/s").replace("_m3", "/m^3"))
    return head, ""


def unit_of(cell: str) -> str:
    """Return the unit in a cell of its own, such as ``[mm]``; empty if it has none."""
    unit = _spelt(cell.strip().strip("()[]{}\"'"))
    return "" if unit in _NO_UNITS else unit


def in_si(values: Values, power: int) -> Values:
    """Return values in a unit of this power of ten, in the SI unit; decimal digits are kept."""
    return values / 10.0**-power if power < 0 else values * 10.0**power


def _spelt(unit: str) -> str:
    unit = unit.strip()
    for spelling in ("µ", "μ"):
        unit = unit.replace(spelling, _SPELLINGS[spelling])
    spelt = _SPELLINGS.get(unit, unit)
    if unit.isupper() and unit.lower() in _CAPITALS:  # of names in capitals
        return unit.lower()
    return spelt
