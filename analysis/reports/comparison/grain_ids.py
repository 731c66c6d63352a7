"""Ids of grains in words: ranges, constant spacings, numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

_MOST_RANGES = 4  # most ranges of ids in a row of a table
_MOST_SHORT = 3  # most ranges of ids in a label
_ENDINGS = {1: "st", 2: "nd", 3: "rd"}  # endings of ordinal numbers


def short_ids(ids: Iterable[int]) -> str:
    """Return ids in a label: ``at 1, 3 to 5``, ``every 2nd``, ``at 12 positions``."""
    numbers = sorted(ids)
    if step := _step(numbers):
        return f"every {_ordinal(step)}"
    texts = _range_texts(numbers)
    if len(texts) > _MOST_SHORT:
        return f"at {len(numbers)} positions"
    return f"at {', '.join(texts)}"


def ids_in_words(ids: Iterable[int]) -> str:
    """Return ids as ranges: ``grains 1, 3 to 5``; for long lists the first ids, and the number of
    all.
    """
    numbers = sorted(ids)
    if len(numbers) == 1:
        return f"grain {numbers[0]}"
    if step := _step(numbers):
        return f"grains {numbers[0]}, {numbers[1]}, … {numbers[-1]} (every {_ordinal(step)})"
    texts = _range_texts(numbers)
    if len(texts) > _MOST_RANGES:
        return f"{len(numbers)} grains ({', '.join(texts[:_MOST_RANGES])}, …)"
    return f"grains {', '.join(texts)}"


def _range_texts(numbers: Sequence[int]) -> list[str]:
    """Return rising ids as single ids and ranges in words."""
    ranges: list[list[int]] = []
    for number in numbers:
        if ranges and number == ranges[-1][-1] + 1:
            ranges[-1] = [ranges[-1][0], number]
        else:
            ranges.append([number])
    return [f"{part[0]} to {part[-1]}" if len(part) > 1 else f"{part[0]}" for part in ranges]


def _ordinal(number: int) -> str:
    """Return a number as ``2nd``, ``13th``."""
    if number % 100 in (11, 12, 13):
        return f"{number}th"
    return f"{number}{_ENDINGS.get(number % 10, 'th')}"


def _step(numbers: Sequence[int]) -> int:
    """Return the constant spacing (above 1) of at least four numbers; 0 if it is not constant."""
    steps = set(np.diff(numbers).tolist())
    if len(numbers) > _MOST_RANGES and len(steps) == 1 and steps != {1}:
        return int(steps.pop())
    return 0
