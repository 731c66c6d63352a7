"""Plausibility of values in SI units: possible and usual magnitudes, and the unit that was probably meant."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from typing import Any

# Smallest and largest accepted magnitudes by unit; results beyond them would be meaningless. Zero is always accepted
# here; the bounds of a key may exclude it.
POSSIBLE: dict[str, tuple[float, float]] = {
    "m": (1e-18, 1e6),
    "m^2": (1e-36, 1e12),
    "s": (1e-18, 1e9),
    "m/s": (1e-15, 1e8),
    "m/s^2": (1e-12, 1e12),
    "rad/s": (1e-15, 1e12),
    "Hz": (1e-9, 1e18),
    "1/s": (1e-9, 1e18),
    "kg": (1e-24, 1e15),
    "kg/m^3": (1e-6, 1e9),
    "Pa": (1e-6, 1e18),
    "N": (1e-24, 1e18),
    "N/m": (1e-12, 1e24),
    "N s/m": (1e-15, 1e24),
    "diameters": (1e-9, 2.0),
}
_EXPONENTS = {  # powers of ten of the SI unit
    "GPa": 9, "MPa": 6, "kPa": 3, "g/cm^3": 3, "mm": -3, "um": -6, "mm^2": -6, "cm^2": -4, "us": -6, "ms": -3, "ns": -9,
    "mm/s": -3, "mm/s^2": -3, "kN": 3, "mN": -3, "g": -3, "kHz": 3, "MHz": 6,
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Usual:
    """Usual magnitudes of a key.

    Attributes
    ----------
    units
        Units other than SI that users often mean, the most likely first.
    beyond
        Factor above ``high`` up to which there is no warning; for bodies that stand for rigid or heavy ones.
    """

    low: float
    high: float
    units: tuple[str, ...] = ()
    beyond: float = 1.0


LENGTH = Usual(1e-9, 1e2, ("mm", "um"))
DIAMETER = Usual(1e-6, 1.0, ("mm", "um"))  # of spheres: powders to boulders
AREA = Usual(1e-10, 1.0, ("mm^2", "cm^2"))
TIME = Usual(1e-10, 0.5, ("us", "ms"))  # of a run or a pulse
INTERVAL = Usual(1e-13, 0.5, ("ns", "us"))  # of a step or a record
VELOCITY = Usual(1e-6, 1e3, ("mm/s",))
SPIN = Usual(1e-6, 1e6)  # angular velocity, rad/s
FREQUENCY = Usual(0.1, 1e8, ("kHz", "MHz"))
ACCELERATION = Usual(1e-3, 5e3, ("mm/s^2",))
DISPLACEMENT = Usual(1e-12, 0.1, ("um", "mm"))
FORCE = Usual(1e-9, 1e9, ("kN", "mN"))
PRESSURE = Usual(10.0, 1e10, ("MPa", "kPa"))
MASS = Usual(1e-9, 1e6, ("g",))
YOUNGS_MODULUS = Usual(1e6, 1e12, ("GPa", "MPa"), beyond=100.0)  # rubber to diamond
YIELD_STRENGTH = Usual(1e4, 5e10, ("MPa", "GPa"), beyond=1e4)
DENSITY = Usual(10.0, 3e4, ("g/cm^3",), beyond=100.0)  # foam to osmium
FRICTION = Usual(0.0, 2.0)


def impossible(value: Any, unit: str | None) -> str:
    """Return the accepted magnitudes if a value, or a number in it, lies outside them; empty otherwise."""
    low, high = POSSIBLE.get(unit or "", (0.0, float("inf")))
    if all(not number or low <= abs(number) <= high for number in _numbers(value)):
        return ""
    return f"a magnitude from {plain(low)} to {plain(high)} {unit}"


def unusual(value: Any, unit: str | None, usual: Usual) -> str:
    """Return a warning with found and expected magnitude if a number in a value is unusual; empty otherwise."""
    most = usual.high * usual.beyond
    odd = [number for number in _numbers(value) if number and not usual.low <= abs(number) <= most]
    if not odd:
        return ""
    of_unit = f" {unit}" if unit else ""
    text = f"found {plain(odd[0])}{of_unit}, expected some {plain(usual.low)} to {plain(usual.high)}{of_unit}"
    for other in usual.units:
        meant = odd[0] * 10.0 ** _EXPONENTS[other]
        if usual.low <= abs(meant) <= usual.high:
            shown = plain(odd[0])
            return f"{text}; {shown} {other} is {plain(meant) if 'e' in shown else f'{shown}e{_EXPONENTS[other]}'}"
    return text


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _numbers(part)


def plain(number: float) -> str:
    """Write a number as one would type it: 1e6, 0.01."""
    return re.sub(r"e([+-])0*", lambda match: "e-" if match[1] == "-" else "e", f"{number:g}")
