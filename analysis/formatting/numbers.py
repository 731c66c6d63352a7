"""Numbers as sentences, tables and axes give them."""

from __future__ import annotations

import math

from granwave.analysis.statistics import Estimate

_FEW, _MANY = -4, 6  # powers of ten from which on a mean has an exponent
_MOST = 8  # digits of a mean


def number(value: float) -> str:
    """Three digits, and no exponent for what people would write without one."""
    return plain(f"{float(f'{value:.3g}'):g}" if abs(value) < 1e5 else f"{value:.3g}")


def with_interval(value: Estimate, scale: float = 1.0, unit: str = "") -> str:
    """A mean with its interval, both to the digit up to which the interval has two: ``213 ± 18 N``."""
    mean, half = value.mean / scale, value.half_width / scale
    text = interval(mean, half) if math.isfinite(half) and half > 0 else number(mean)
    return f"{text} {unit}".rstrip()


def interval(mean: float, half_width: float) -> str:
    """``213 ± 18``; very small and large numbers share an exponent: ``(4.623 ± 0.076)e-4``.

    Parameters
    ----------
    half_width
        Positive; it gets two digits, and the mean as many decimals.
    """
    power = max(_power(mean, 12), _power(half_width, 2))
    last = _power(half_width, 2) - 1
    if last < power - _MOST:
        return f"{plain(f'{mean:.{_MOST}g}')} ± {plain(f'{half_width:.1e}')}"
    if _FEW < power < _MANY:
        return f"{_to_digit(mean, last)} ± {_to_digit(half_width, last)}"
    unit, decimals = 10.0**power, power - last
    return f"({mean / unit:.{decimals}f} ± {half_width / unit:.{decimals}f})e{power}"


def tick(value: float) -> str:
    """A number as short as it can be, for an axis."""
    digits, _, power = f"{value:.5e}".partition("e")
    if value == 0 or -4 <= int(power) < 5:
        return f"{value:.6g}"
    return f"{float(digits):g}e{int(power)}"


def plain(text: str) -> str:
    """1.2e-06 as 1.2e-6."""
    mantissa, e, power = text.partition("e")
    return f"{mantissa}e{int(power)}" if e else text


def _power(value: float, digits: int) -> int:
    """Power of ten, of the first digit once there are so many."""
    return int(f"{value:.{digits - 1}e}".partition("e")[2]) if value else -400


def _to_digit(value: float, last: int) -> str:
    """Rounded to a power of ten."""
    return f"{round(value, -last):.{max(0, -last)}f}"


def duration(seconds: float) -> str:
    """A time span to read, from seconds: seconds, minutes or hours."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
