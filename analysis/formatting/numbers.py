"""Formatting of numbers for sentences, tables and axes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TypeGuard

from granwave.analysis.statistics import Estimate
from granwave.lammps_inputs.message_words import counted as counted

# powers of ten outside of which a mean has an exponent
_FEW = -4
_MANY = 6
_MOST = 8  # largest number of digits of a mean
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_VOLUMES = ((1.0, "m³"), (1e-6, "cm³"), (1e-9, "mm³"))
#: Units of columns by SI unit: size, name, and the smallest of the largest values of such a column.
_OF_COLUMNS: dict[str, tuple[tuple[float, str, float], ...]] = {
    "m": ((1.0, "m", 1.0), (1e-3, "mm", 1e-4), (1e-6, "µm", 1e-7), (1e-9, "nm", 0.0)),
    "s": ((1.0, "s", 1.0), (1e-3, "ms", 5e-3), (1e-6, "µs", 1e-7), (1e-9, "ns", 0.0)),
    "m³": ((1.0, "m³", 0.1), (1e-6, "cm³", 1e-7), (1e-9, "mm³", 0.0)),
    "J": ((1.0, "J", 1.0), (1e-3, "mJ", 1e-3), (1e-6, "µJ", 1e-6), (1e-9, "nJ", 0.0)),
    "N": ((1e3, "kN", 1e4), (1.0, "N", 0.1), (1e-3, "mN", 0.0)),
}
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_LONG_TIME = 5e-3  # s, later instants are in ms
_WHOLE = 100.0  # µs above which values are whole
_ALMOST = 0.9995  # fraction of a unit that rounds to the unit with four digits


def number(value: float) -> str:
    """Format a number with three digits, without an exponent for common magnitudes."""
    return plain(f"{float(f'{value:.3g}'):g}" if abs(value) < 1e5 else f"{value:.3g}")


def with_interval(value: Estimate, scale: float = 1.0, unit: str = "") -> str:
    """Format a mean with its interval, both to the second digit of the interval: ``213 ± 18 N``."""
    mean = value.mean / scale
    half = value.half_width / scale
    text = interval(mean, half) if math.isfinite(half) and half > 0 else number(mean)
    return f"{text} {unit}".rstrip()


def interval(mean: float, half_width: float) -> str:
    """Format a mean and its half-width: ``213 ± 18``, or with a common exponent ``(4.623 ±
    0.076)e-4``.

    Parameters
    ----------
    half_width
        Half-width, positive; it has two digits, and the mean has equally many decimals.
    """
    power = max(_power(mean, 12), _power(half_width, 2))
    last = _power(half_width, 2) - 1
    if last < power - _MOST:
        return f"{plain(f'{mean:.{_MOST}g}')} ± {plain(f'{half_width:.1e}')}"
    if _FEW < power < _MANY:
        return f"{_to_digit(mean, last)} ± {_to_digit(half_width, last)}"
    unit = 10.0**power
    decimals = power - last
    return f"({mean / unit:.{decimals}f} ± {half_width / unit:.{decimals}f})e{power}"


def quantity_in(value: float, unit: str) -> str:
    """Format a value with four digits and a prefix of its unit: ``605 nm``, ``1.2 kN``."""
    if not unit or not value:
        return f"{plain(f'{value:.4g}')} {unit}".rstrip()
    scale, prefix = _fitting(value, _PREFIXES)
    return f"{plain(f'{value / scale:.4g}')} {prefix}{unit}"


def range_in(values: Sequence[float], unit: str) -> str:
    """Format the range of values, as `quantity_in` formats them."""
    return " to ".join(
        dict.fromkeys(quantity_in(value, unit) for value in (min(values), max(values)))
    )


def in_any_unit(value: float, unit: str) -> str:
    """Format a value with four digits and its unit, with a suitable prefix.

    Parameters
    ----------
    unit
        As of SI: ``N``, ``m^3``, ``1/m``; empty for a number.
    """
    scale, name = _suitable_unit(value, unit)
    return f"{plain(f'{value / scale:.4g}')} {name}".rstrip()


def interval_in_any_unit(mean: float, half_width: float, unit: str) -> str:
    """Format a mean and its half-width with a prefix of the unit, as `in_any_unit` does: ``213 ± 18
    mm``.
    """
    scale, name = _suitable_unit(mean, unit)
    return f"{interval(mean / scale, half_width / scale)} {name}".rstrip()


def _suitable_unit(value: float, unit: str) -> tuple[float, str]:
    """Return the size and the name of the unit in which a value is read best."""
    unit = unit.replace("^3", "³").replace("^2", "²")
    if unit == "m³" and value:
        return _fitting(value, _VOLUMES)
    if unit.isalpha() and unit != "kg" and value:
        scale, prefix = _fitting(value, _PREFIXES)
        return scale, prefix + unit
    return 1.0, unit


def column_unit(unit: str, values: Iterable[object]) -> tuple[str, float]:
    """Return the unit in which the values of a column are read best, and its size in the SI unit.

    Parameters
    ----------
    unit
        SI unit, such as ``m``, ``m³`` or ``J``; others stay.
    values
        Values in the SI unit; others than finite numbers are skipped.
    """
    sizes = [abs(value) for value in values if _is_finite(value)]
    largest = max(sizes, default=0.0)
    if not largest:
        return unit, 1.0
    for size, name, least in _OF_COLUMNS.get(unit, ()):
        if largest >= _ALMOST * least:
            return name, size
    return unit, 1.0


def _is_finite(value: object) -> TypeGuard[float]:
    """Return True for a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value)


def _fitting(value: float, units: Sequence[tuple[float, str]]) -> tuple[float, str]:
    """Return the largest unit of which a value has one or more, or the smallest: its size and its
    name.
    """
    fitting = [unit for unit in units if abs(value) >= _ALMOST * unit[0]]
    return fitting[0] if fitting else units[-1]


def tick(value: float) -> str:
    """Format a number as short as possible, for an axis."""
    digits, _, power = f"{value:.5e}".partition("e")
    if value == 0 or -4 <= int(power) < 5:
        return f"{value:.6g}"
    return f"{float(digits):g}e{int(power)}"


def plain(text: str) -> str:
    """Shorten the exponent of a formatted number: 1.2e-06 to 1.2e-6."""
    mantissa, e, power = text.partition("e")
    return f"{mantissa}e{int(power)}" if e else text


def superscript(number: int) -> str:
    """Format a whole number as raised digits, the mark of a footnote."""
    return str(number).translate(_RAISED)


def _power(value: float, digits: int) -> int:
    """Return the power of ten of the first digit after rounding to ``digits`` digits."""
    return int(f"{value:.{digits - 1}e}".partition("e")[2]) if value else -400


def _to_digit(value: float, last: int) -> str:
    """Round a value to the power of ten ``last``."""
    return f"{round(value, -last):.{max(0, -last)}f}"


def size_text(size: Sequence[int]) -> str:
    """Format the size of a packing, in spheres along each axis: ``24 x 24 x 12``, with signs of
    multiplication.
    """
    return " \N{MULTIPLICATION SIGN} ".join(map(str, size))


def instant(seconds: float) -> str:
    """Format an instant of a run: ``314 µs``, beyond 5 ms ``12.5 ms``."""
    if seconds > _LONG_TIME:
        return f"{seconds * 1e3:.4g} ms"
    time = seconds * 1e6
    return f"{time:.0f} µs" if time >= _WHOLE else f"{time:.3g} µs"


def duration(seconds: float) -> str:
    """Format a duration in seconds, minutes or hours."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
