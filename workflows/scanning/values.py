"""Values of a key in a scan: a list, or a range between two numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.schema import ValidationError, finite

MOST_POINTS = 100_000
SHAPES = ("log", "linear")


def values_of(value: Any) -> list[Any]:
    """Return the values of a key, from a list or a range.

    Raises
    ------
    ValidationError
        It is neither, or the list is empty.
    """
    expected = "a list of values such as [1, 2, 5], or {log = [1, 100, 9]} or {linear = [0, 10, 11]}"
    if isinstance(value, Mapping):
        if len(value) != 1 or not set(value) <= set(SHAPES):
            raise ValidationError(expected)
        ((shape, limits),) = value.items()
        return _range(shape, limits)
    if not isinstance(value, list):
        raise ValidationError(f"{expected}; a value that holds for all points belongs under [set]")
    if not value:
        raise ValidationError("at least one value")
    return value


def _range(shape: str, limits: Any) -> list[float]:
    expected = f"{{{shape} = [first, last, how many]}}"
    numbers = limits if isinstance(limits, list) else []
    if len(numbers) != 3 or not all(isinstance(n, int | float) and not isinstance(n, bool) for n in numbers):
        raise ValidationError(expected)
    first, last, count = finite(numbers[0], expected), finite(numbers[1], expected), numbers[2]
    if not isinstance(count, int) or not 2 <= count <= MOST_POINTS:
        raise ValidationError(f"{expected} with 2 to {MOST_POINTS} values")
    if shape == "log" and (first <= 0 or last <= 0):
        raise ValidationError(f"{expected} with positive numbers")
    span = last - first if shape == "linear" else last / first
    if not math.isfinite(span) or (shape == "log" and not span):
        raise ValidationError(f"{expected} with numbers that are closer to each other")
    shares = [k / (count - 1) for k in range(1, count - 1)]
    inner = [first + share * span if shape == "linear" else first * span**share for share in shares]
    # 14 digits, so that 0.3 in a range equals 0.3 in a list, and gives the same point
    return [first, *(float(f"{value:.14g}") for value in inner), last]
