"""Scales of axes for values and abscissae: linear or logarithmic, with short labels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

_LEAST_SPAN = 0.2  # of a linear axis, relative to the largest value
_MARGIN = 0.12  # of abscissae, relative to their span
_DECADES = 1.5  # from which on an axis is logarithmic
# largest values of an axis whose labels need no power of ten
_SMALLEST = 1e-3
_LARGEST = 1e5


def scale_values(axes: Axes, which: str, numbers: Sequence[float], ticks: int) -> str:
    """Set the scale of an axis of values, of at least a fifth of the largest value; return the
    power of ten of its labels.

    Parameters
    ----------
    which
        "x" or "y".
    """
    axis = getattr(axes, f"{which}axis")
    set_limits = getattr(axes, f"set_{which}lim")
    if _is_logarithmic(numbers):
        getattr(axes, f"set_{which}scale")("log")
        margin = 10 ** (0.08 * np.log10(max(numbers) / min(numbers)))
        set_limits(min(numbers) / margin, max(numbers) * margin)
        axis.set_major_locator(LogLocator(numticks=ticks))
        axis.set_minor_formatter(NullFormatter())
        return ""
    middle = (max(numbers) + min(numbers)) / 2
    span = max(np.ptp(numbers), _LEAST_SPAN * max(map(abs, numbers))) or 1.0
    set_limits(middle - 0.6 * span, middle + 0.6 * span)
    axis.set_major_locator(MaxNLocator(ticks - 1, steps=[1, 2, 2.5, 5, 10]))
    return _power(axis, numbers)


def scale_abscissae(axes: Axes, numbers: Sequence[float], ticks: int) -> str:
    """Set the scale of the abscissae, with a margin; return the power of ten of its labels."""
    least = min(numbers)
    most = max(numbers)
    if _is_logarithmic(numbers):
        axes.set_xscale("log")
        margin = (most / least) ** _MARGIN
        axes.set_xlim(least / margin, most * margin)
        axes.xaxis.set_major_locator(LogLocator(numticks=ticks))
        axes.xaxis.set_minor_formatter(NullFormatter())
        return ""
    margin = _MARGIN * (most - least)
    axes.set_xlim(least - margin, most + margin)
    axes.xaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
    return _power(axes.xaxis, numbers)


def _power(axis: Any, numbers: Sequence[float]) -> str:
    """Divide the labels of very small and very large numbers by a power of ten; return it."""
    largest = max(map(abs, numbers))
    if not largest or _SMALLEST <= largest < _LARGEST:
        return ""
    exponent = int(np.floor(np.log10(largest)))
    axis.set_major_formatter(FuncFormatter(lambda number, _: _text(number / 10**exponent)))
    return f"$10^{{{exponent}}}$"


def _text(number: float) -> str:
    return f"{number:.4g}".replace("-", "\N{MINUS SIGN}")


def _is_logarithmic(numbers: Sequence[float]) -> bool:
    return min(numbers) > 0 and max(numbers) / min(numbers) > 10**_DECADES
