"""Measures of signals: first peaks, arrivals, widths, and laws fitted to points."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_FEWEST_FITTED = 4  # points of an exponential law


def first_peak(time: ArrayLike, signal: ArrayLike, *, floor: float = 0.01) -> tuple[float, float]:
    """Time and height of the first maximum of a signal above ``floor`` of its largest, by a
    parabola through samples.

    Parameters
    ----------
    time, signal
        (n_times,).

    Returns
    -------
    tuple
        (NaN, NaN) of a signal that never rises.
    """
    time = np.asarray(time, dtype=np.float64)
    signal = np.asarray(signal, dtype=np.float64)
    largest = float(signal.max(initial=0.0))
    if not largest > 0:
        return np.nan, np.nan
    places = maxima(signal, floor * largest)
    k = int(places[0]) if len(places) else int(signal.argmax())
    if not 0 < k < len(signal) - 1:
        return float(time[k]), float(signal[k])
    return _vertex(time[k - 1 : k + 2], signal[k - 1 : k + 2])


def maxima(signal: ArrayLike, floor: float = 0.0) -> NDArray[np.intp]:
    """Positions of the local maxima of a signal (n_times,) above a floor."""
    signal = np.asarray(signal, dtype=np.float64)
    inner = (signal[1:-1] >= signal[:-2]) & (signal[1:-1] > signal[2:]) & (signal[1:-1] > floor)
    return np.flatnonzero(inner) + 1


def at_time(time: float, times: ArrayLike, rows: ArrayLike) -> Array:
    """A record (n_times, n) at one time, interpolated linearly: (n,)."""
    times = np.asarray(times, dtype=np.float64)
    rows = np.asarray(rows, dtype=np.float64)
    k = min(int(np.searchsorted(times, time)), len(times) - 1)
    part = (time - times[k - 1]) / (times[k] - times[k - 1])
    return np.asarray(rows[k - 1] + part * (rows[k] - rows[k - 1]))


def arrival(time: ArrayLike, signal: ArrayLike, level: float) -> float:
    """Time at which a signal first passes a level, between samples by a straight line, s; NaN:
    never.
    """
    time = np.asarray(time, dtype=np.float64)
    signal = np.asarray(signal, dtype=np.float64)
    above = np.flatnonzero(signal >= level)
    if not len(above):
        return np.nan
    k = int(above[0])
    if k == 0:
        return float(time[0])
    part = (level - signal[k - 1]) / (signal[k] - signal[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def arrivals(time: ArrayLike, signals: ArrayLike, levels: ArrayLike) -> Array:
    """Arrivals, as of `arrival`, of several signals (n_times, n) at levels (n,): (n,), s."""
    columns = np.asarray(signals, dtype=np.float64).T
    limits = np.asarray(levels, dtype=np.float64)
    return np.array(
        [arrival(time, column, level) for column, level in zip(columns, limits, strict=True)]
    )


def width(x: ArrayLike, signal: ArrayLike, share: float = 0.5) -> float:
    """Full width of the largest peak of a signal at a fraction of its height, in units of x; NaN
    if it is cut off.
    """
    x = np.asarray(x, dtype=np.float64)
    signal = np.asarray(signal, dtype=np.float64)
    k = int(signal.argmax())
    level = share * float(signal.max())
    left = np.flatnonzero(signal[:k] < level)
    right = np.flatnonzero(signal[k:] < level)
    if not len(left) or not len(right):
        return np.nan
    a = int(left[-1])
    b = k + int(right[0])
    start = x[a] + (level - signal[a]) / (signal[a + 1] - signal[a]) * (x[a + 1] - x[a])
    end = x[b - 1] + (level - signal[b - 1]) / (signal[b] - signal[b - 1]) * (x[b] - x[b - 1])
    return float(end - start)


def decay_rate(x: ArrayLike, y: ArrayLike) -> float:
    """Rate of an exponential decay: minus the slope of the straight line through ln(y); NaN unless
    all y are positive.

    Parameters
    ----------
    x, y
        Position, and the decaying quantity: (n_points,).
    """
    x = np.asarray(x)
    y = np.asarray(y)
    return -float(np.polyfit(x, np.log(y), 1)[0]) if len(y) > 1 and (y > 0).all() else np.nan


@dataclasses.dataclass(frozen=True)
class Power:
    """A law y = factor x^exponent, fitted to logarithms.

    Attributes
    ----------
    margin
        Half the 95 % confidence interval of the exponent; NaN from two points.
    """

    factor: float
    exponent: float
    margin: float

    def __call__(self, x: Array) -> Array:
        """Values of the law."""
        return self.factor * x**self.exponent

    @property
    def interval(self) -> str:
        """Confidence interval of the exponent as a sentence; empty if there is none."""
        return f"95 % confidence interval: ± {self.margin:.1g}." if np.isfinite(self.margin) else ""


def power(x: ArrayLike, y: ArrayLike) -> Power:
    """The power law through the positive points (n_points,).

    Raises
    ------
    ValueError
        There are fewer than two, or all have the same x.
    """
    x = np.asarray(x, dtype=np.float64)
    y = np.asarray(y, dtype=np.float64)
    chosen = (x > 0) & (y > 0) & np.isfinite(x) & np.isfinite(y)
    if np.count_nonzero(chosen) < 2:
        raise ValueError(
            f"found {np.count_nonzero(chosen)} points, expected two or more for a power law"
        )
    if np.ptp(x[chosen]) == 0.0:
        raise ValueError(
            f"found x = {x[chosen][0]:g} at all points, expected two or more different values "
            "for a power law"
        )
    from scipy import stats  # imported on demand: slow to load

    fit = stats.linregress(np.log(x[chosen]), np.log(y[chosen]))
    n = int(np.count_nonzero(chosen))
    margin = float(stats.t.ppf(0.975, n - 2) * fit.stderr) if n > 2 else np.nan
    return Power(float(np.exp(fit.intercept)), float(fit.slope), margin)


@dataclasses.dataclass(frozen=True)
class ExponentialDecay:
    """``y = end + span exp(-x/length)``, fitted by least squares.

    Attributes
    ----------
    residual
        Root mean square.
    """

    end: float
    span: float
    length: float
    residual: float

    def __call__(self, x: Array) -> Array:
        """Values of the law."""
        return _exponential(x, self.end, self.span, self.length)


def decay(x: ArrayLike, y: ArrayLike) -> ExponentialDecay | None:
    """The exponential law through points (n_points,); None if there are too few, or if no such law
    is found.
    """
    x = np.asarray(x, dtype=np.float64)
    y = np.asarray(y, dtype=np.float64)
    if len(x) < _FEWEST_FITTED:
        return None
    from scipy.optimize import curve_fit  # imported on demand: slow to load

    start = (float(y[-1]), float(y[0] - y[-1]) * np.e, float(x[-1] - x[0]) / 3)
    try:
        (end, span, length), _ = curve_fit(_exponential, x, y, p0=start, maxfev=5000)
    except RuntimeError:
        return None
    residual = float(np.sqrt(np.mean((_exponential(x, end, span, length) - y) ** 2)))
    return ExponentialDecay(float(end), float(span), float(length), residual)


def _exponential(x: Array, end: float, span: float, length: float) -> Array:
    return end + span * np.exp(-x / length)


def _vertex(time: Array, signal: Array) -> tuple[float, float]:
    """Vertex of the parabola through three points."""
    a, b, c = np.polyfit(time - time[1], signal, 2)
    if not a < 0:
        return float(time[1]), float(signal[1])
    return float(time[1] - b / (2 * a)), float(c - b * b / (4 * a))
