"""Zero of a function of one variable by Brent's method, without scipy.optimize, whose import takes
long.

R. P. Brent, Algorithms for Minimization Without Derivatives (1973), chapter 4; with the same steps
as `scipy.optimize.brentq`, so that both give the same number.
"""

from __future__ import annotations

import math
from collections.abc import Callable

_MOST_STEPS = 100  # some ten are usual
_RTOL = 8.881784197001252e-16  # four times the precision of a number


def brentq(
    function: Callable[[float], float], low: float, high: float, *, xtol: float, rtol: float = _RTOL
) -> float:
    """Find a zero of a continuous function between two positions where its signs differ.

    Parameters
    ----------
    low, high
        Bounds.
    xtol, rtol
        Absolute and relative tolerance of the position.

    Raises
    ------
    ValueError
        The function has the same sign at both bounds.
    RuntimeError
        It was not found in 100 steps.
    """
    # the position is the best so far
    earlier = float(low)
    place = float(high)
    value_earlier = function(earlier)
    value = function(place)
    if value_earlier == 0:
        return earlier
    if value == 0:
        return place
    if (value_earlier < 0) == (value < 0):
        raise ValueError(
            f"expected different signs, found {value_earlier:g} at {low:g} and {value:g} at {high:g}"
        )
    # a position on the other side of the zero; the last two steps
    across = value_across = before = step = 0.0
    for _ in range(_MOST_STEPS):
        if value_earlier != 0 and value != 0 and (value_earlier < 0) != (value < 0):
            across = earlier
            value_across = value_earlier
            before = step = place - earlier
        if abs(value_across) < abs(value):
            earlier, place, across = place, across, place
            value_earlier, value, value_across = value, value_across, value
        enough = (xtol + rtol * abs(place)) / 2
        half = (across - place) / 2
        if value == 0 or abs(half) < enough:
            return place
        bisected = abs(before) <= enough or abs(value) >= abs(value_earlier)
        if not bisected:
            if earlier == across:
                trial = -value * (place - earlier) / (value - value_earlier)
            else:
                slope = (value_earlier - value) / (earlier - place)
                slope_across = (value_across - value) / (across - place)
                rise = value_across * slope_across - value_earlier * slope
                trial = -value * rise / (slope_across * slope * (value_across - value_earlier))
            bisected = 2 * abs(trial) >= min(abs(before), 3 * abs(half) - enough)
        before, step = (half, half) if bisected else (step, trial)
        earlier = place
        value_earlier = value
        place += step if abs(step) > enough else math.copysign(enough, half)
        value = function(place)
    raise RuntimeError(
        f"found no zero in {_MOST_STEPS} steps; the last position is {place:g}, with the value "
        f"{value:g}"
    )
