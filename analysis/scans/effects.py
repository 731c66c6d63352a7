"""Effects of the varied keys on a mean in words: trends with numeric keys, orders of the values of
other keys, and keys without an effect.

A clause holds at all combinations of the other keys, or states at how many of them it holds. Means
differ by `granwave.analysis.scans.trends`.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence

import numpy as np

from granwave.analysis.formatting.numbers import tick
from granwave.analysis.scans.keys import VariedKey
from granwave.analysis.scans.trends import Trend, course_of, significant_steps

_MOST_ORDERED = 6  # largest number of values of a key whose order is stated
_PAIR = 2


@dataclasses.dataclass(frozen=True)
class LineOfMeans:
    """Means along a key at a combination of the other keys, in the order of the key.

    Attributes
    ----------
    names
        Values of the key in words.
    means, half_widths
        Means with the half-widths of their confidence intervals, NaN if unknown.
    """

    names: tuple[str, ...]
    means: tuple[float, ...]
    half_widths: tuple[float, ...]

    @property
    def course(self) -> Trend:
        """Course of the means along the line."""
        return course_of(self.means, self.half_widths)

    def order(self) -> tuple[str, ...]:
        """Return the values of the key by rising mean; empty if neighbours do not differ."""
        ranks = np.argsort(self.means, kind="stable")
        means = np.array(self.means)[ranks]
        widths = np.array(self.half_widths)[ranks]
        steps = significant_steps(means, widths)
        if not all(steps[n, n + 1] > 0 for n in range(len(ranks) - 1)):
            return ()
        return tuple(self.names[rank] for rank in ranks)


def has_no_effect(lines: Sequence[LineOfMeans]) -> bool:
    """Return True if the means do not change along any line."""
    return bool(lines) and all(line.course is Trend.CONSTANT for line in lines)


def trend_of(lines: Sequence[LineOfMeans]) -> tuple[Trend | None, str]:
    """Return the common direction of the lines along a numeric key, of which some may change within
    their intervals, and a clause on these; None without a common direction.
    """
    courses = [line.course for line in lines]
    courses = [course for course in courses if course is not Trend.CONSTANT]
    directions = set(courses) - {Trend.UNCLEAR}
    if directions not in ({Trend.RISES}, {Trend.FALLS}):
        return None, ""
    unclear = courses.count(Trend.UNCLEAR)
    if not unclear:
        return directions.pop(), ""
    return directions.pop(), (
        f" (within the 95 % confidence intervals at {unclear} of {len(courses)} settings of the "
        "other keys)"
    )


def mixed_in_words(key: VariedKey, lines: Sequence[LineOfMeans]) -> str:
    """Return a clause on a numeric key along which the means rise and fall beyond their intervals;
    empty if they do not.
    """
    directions = {line.course for line in lines} - {Trend.CONSTANT, Trend.UNCLEAR}
    if not directions:
        return ""
    if directions == {Trend.MIXED}:
        return f"rises and falls with {key.words}"
    return f"has no common trend with {key.words}"


def order_in_words(
    key: VariedKey, lines: Sequence[LineOfMeans], others: Sequence[VariedKey]
) -> str:
    """Return a clause on the order of the values of a key that has no numbers: ``is 1.1 to 1.3
    times as large for steel as for brass at all 3 values of impact velocity``; empty without a
    clear order, and for a single pair, whose range shows its order.

    Parameters
    ----------
    others
        Other keys with an effect.
    """
    n_values = max((len(line.names) for line in lines), default=0)
    complete = [line for line in lines if len(line.names) == n_values]
    n_settings = len({line.means for line in complete}) if not others else len(complete)
    if n_values < _PAIR or n_values > _MOST_ORDERED or (n_values == _PAIR and n_settings < _PAIR):
        return ""
    orders = Counter(line.order() for line in complete)
    orders.pop((), None)
    if not orders:
        return ""
    order, count = orders.most_common(1)[0]
    label = key.words
    place = _settings_in_words(count, n_settings, others)
    if 2 * count <= n_settings:
        return f"varies with {label} in an order that depends on {_named(others)}"
    if n_values > _PAIR:
        return f"rises in the order {', '.join(order)}{place}"
    low, high = order
    alike = [line for line in complete if line.order() == order]
    return f"is {_ratios(alike)} for {high} {_than(alike)} for {low}{place}"


def _ratios(lines: Sequence[LineOfMeans]) -> str:
    """Return the range of the larger mean divided by the smaller one in words; ``larger`` if the
    means are not positive.
    """
    if any(min(line.means) <= 0 for line in lines):
        return "larger"
    ratios = sorted(max(line.means) / min(line.means) for line in lines)
    least, most = [tick(float(f"{ratio:.3g}")) for ratio in (ratios[0], ratios[-1])]
    return f"{least} times as large" if least == most else f"{least} to {most} times as large"


def _than(lines: Sequence[LineOfMeans]) -> str:
    """Return the word of the comparison that `_ratios` begins."""
    return "than" if any(min(line.means) <= 0 for line in lines) else "as"


def _settings_in_words(count: int, n_settings: int, others: Sequence[VariedKey]) -> str:
    """Return where a clause holds: ``at all 3 values of impact velocity``; empty for one setting.

    Parameters
    ----------
    count
        Number of settings of the other keys at which it holds.
    """
    if n_settings < _PAIR:
        return ""
    how_many = f"{count} of {n_settings}"
    if count == n_settings:
        how_many = "both" if n_settings == _PAIR else f"all {n_settings}"
    if len(others) == 1:
        return f" at {how_many} values of {others[0].words}"
    return f" at {how_many} settings of the other keys"


def _named(keys: Sequence[VariedKey]) -> str:
    """Return keys in words."""
    return keys[0].words if len(keys) == 1 else "the other keys"


def line_of(
    key: VariedKey, rows: Sequence[int], means: Sequence[float], half_widths: Sequence[float]
) -> LineOfMeans:
    """Make the line of these rows of a key, with their means."""
    names = tuple(key.tick(row) for row in rows)
    return LineOfMeans(names, tuple(means), tuple(half_widths))


def along(key: VariedKey, others: Sequence[VariedKey], n_rows: int) -> list[list[int]]:
    """Return the rows along a key, in the order of its numbers or of the scan: a list for each
    combination of the other keys.
    """
    lines: dict[tuple[object, ...], list[int]] = {}
    for row in range(n_rows):
        setting = tuple(other.values[row] for other in others)
        lines.setdefault(setting, []).append(row)
    values = key.values if key.numeric else [key.values.index(value) for value in key.values]
    return [sorted(rows, key=lambda row: float(values[row])) for rows in lines.values()]
