"""Keys of a scan along the axes of its figures, and keys that distinguish curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from granwave.analysis.scans.keys import VariedKey
from granwave.analysis.scans.table import (
    TIMES,
    determines,
)

FEWEST = 2  # smallest number of points in a figure
FEWEST_LEVELS = 3  # smallest number of values of a key along an axis, where a key has so many
_LONGEST_NAME = 12  # characters of a category that a legend names with a number


def _n_levels(key: VariedKey) -> int:
    """Return the number of values that a key takes."""
    return len(set(key.values))


def choices_of_axes(keys: Mapping[str, VariedKey], free: Sequence[str]) -> list[list[str]]:
    """Return the keys along horizontal axes, the best choice first; the first that shows a change
    is drawn.

    Numeric keys of three values or more, then the category with most values, then numeric keys of
    two values, with the category if it is equivalent to one of them.
    """
    numeric = _abscissae(keys, free)
    long = [name for name in numeric if _n_levels(keys[name]) >= FEWEST_LEVELS]
    short = [name for name in numeric if name not in long]
    categories = [name for name in free if not keys[name].numeric]
    if not categories:
        return [long, short]
    category = max(categories, key=lambda name: _n_levels(keys[name]))
    same = [name for name in numeric if determines(keys[name].labels, keys[category].labels)]
    if same or not numeric:
        return [[name for name in long if name not in same], [*same, category], short]
    if _n_levels(keys[category]) >= FEWEST_LEVELS:
        return [long, [category], short]
    return [long, short, [category]]


def _abscissae(keys: Mapping[str, VariedKey], free: Sequence[str]) -> list[str]:
    """Return the independent numeric keys, and keys that are equivalent to one of them, except run
    times.
    """
    chosen = []
    for name, key in keys.items():
        alike = [other for other in free if determines(key.labels, keys[other].labels)]
        along = bool(alike) and not name.startswith(TIMES)
        if key.numeric and _n_levels(key) > 1 and (name in free or along):
            chosen.append(name)
    return chosen


def keys_of_curves(keys: dict[str, VariedKey], free: Sequence[str], x: str) -> list[VariedKey]:
    """Return the keys that distinguish curves over ``x``: the keys that ``x`` does not determine.

    A key with fewer values than ``x`` also distinguishes curves, although ``x`` determines it.
    Categories that are equivalent to such a key are named with it.
    """
    abscissae = keys[x].labels
    chosen = [
        keys[name] for name in free if name != x and not determines(abscissae, keys[name].labels)
    ]
    for key in keys.values():
        has_fewer = determines(abscissae, key.labels) and not determines(key.labels, abscissae)
        if has_fewer and len(set(key.labels)) > 1:
            settings = list(zip(*(other.labels for other in chosen), strict=True))
            if not settings or not determines(settings, key.labels):
                chosen.append(key)
    for key in keys.values():
        if key not in chosen and any(_names_the_same(key, other) for other in chosen):
            chosen.append(key)
    return chosen


def _names_the_same(key: VariedKey, other: VariedKey) -> bool:
    """Return True for a category of short names, each of which belongs to one number of another
    key.
    """
    if key.numeric or not other.numeric or _n_levels(key) < FEWEST:
        return False
    is_short = max(len(str(value)) for value in key.values) <= _LONGEST_NAME
    same = determines(key.labels, other.labels) and determines(other.labels, key.labels)
    return is_short and same
