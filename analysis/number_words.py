"""Numbers as sentences and tables of studies give them."""

from __future__ import annotations

import math

from granwave.analysis.statistics import Estimate


def number(value: float) -> str:
    """Three digits, and no exponent for what people would write without one."""
    return f"{float(f'{value:.3g}'):g}" if abs(value) < 1e5 else f"{value:.3g}"


def with_interval(value: Estimate, scale: float = 1.0, unit: str = "") -> str:
    """A mean with its interval, both to the digit up to which the interval has two: ``213 ± 18 N``."""
    mean, half = value.mean / scale, value.half_width / scale
    text = number(mean)
    if math.isfinite(half) and half > 0:
        last = math.floor(math.log10(half)) - 1  # power of ten of the digit
        text = f"{_to_digit(mean, last)} ± {_to_digit(half, last)}"
    return f"{text} {unit}".rstrip()


def _to_digit(value: float, last: int) -> str:
    """Rounded to a power of ten; six digits at most."""
    last = max(last, math.floor(math.log10(abs(value))) - 5) if value else last
    return f"{round(value, -last):.{max(0, -last)}f}" if -8 < last < 5 else f"{value:.3g}"
