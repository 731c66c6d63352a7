"""Axes whose values are spread over decades, and maps that show their values as numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axes._secondary_axes import SecondaryAxis
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.ticker import (
    FixedLocator,
    FuncFormatter,
    LogFormatterSciNotation,
    LogLocator,
    MaxNLocator,
    NullFormatter,
    NullLocator,
    SymmetricalLogLocator,
)
from numpy.typing import NDArray

_IN_MICROSECONDS = "(µs)"  # end of the title of an axis of times
_LONG = 5e3  # µs, later times are shown in ms
_MILLI = 1e-3  # milliseconds in a microsecond
_WIDE = 10.0  # largest / smallest value above which an axis is logarithmic
_MANY = 1e4  # largest / smallest value above which ticks are at powers of ten only ...
_MANY_OF_COLOURS = 1e2  # ... and the same for colour bars
_COLOUR_BAR = "<colorbar>"  # label that matplotlib gives to axes of a colour bar
_NARROW = 30.0  # largest / smallest value below which labels are plain numbers
_LEAST_PLAIN = 1e-3  # smallest plain number
_MOST_PLAIN = 1e4  # largest plain number
_LEAST_DECADE = 3.0  # smallest ratio of the limits of a logarithmic axis, for two ticks
_LEAST_SPAN = 1e-3  # smallest span of an axis relative to its values: labels have four digits
_MOST_NAMED = 8  # columns and lines of a map with names and numbers
_BREAK: dict[str, Any] = {
    "ha": "center", "va": "center", "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.3}
}  # fmt: skip
# labelled multiples of powers of ten, and decades between them; the densest labels first
_WITHIN_DECADES: tuple[tuple[tuple[float, ...], int], ...] = (((1.0, 2.0, 5.0), 1), ((1.0, 3.0), 1))
_POWERS = tuple(((1.0,), every) for every in (1, 2, 3, 5, 10, 20))
_ENOUGH = 3  # number of labels at powers of ten that makes other labels unnecessary
_CHARACTER = 0.6  # width of a character in a label, font sizes
_SUPERSCRIPT = 0.42
_GAP = 0.5  # gap between labels, font sizes
_LINE = 1.15  # height of a line, font sizes
_MOST_TICKS = 30  # largest number of ticks of an axis
_LEAST_TICKS = 2.2  # ratio of the limits of an axis below which it has at most one tick
# largest number of intervals of such an axis: labels are next to each other along x, above each
# other along y
_FEW_TICKS = {"x": 1, "y": 3}
_POINTS = 72.0  # in an inch
_MINUS = "\N{MINUS SIGN}"
_TIMES = "\N{MULTIPLICATION SIGN}"
_SUPERSCRIPTS = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
_RAISED = str.maketrans("-0123456789", _SUPERSCRIPTS)


class PowersOfTen(LogFormatterSciNotation):
    """Labels of a logarithmic axis, such as 10⁻³, as plain text: formulas take many times longer to
    set.

    Major and minor ticks are labelled by one rule: the first choice whose labels fit. Labels
    between powers of ten are plain numbers unless these are very long: 50, 100 and 200.
    """

    plain = False  # numbers such as 0.2 in place of powers
    # labelled multiples of powers of ten; None: the default
    factors: tuple[float, ...] | None = None
    every = 1  # number of decades from one label to the next

    def set_locs(self, locs: Any = None) -> None:
        """Choose labels that fit: plain numbers over about a decade, or between few powers."""
        super().set_locs(locs)
        axis: Any = self.axis
        if axis is None:
            return
        low, high = sorted(axis.get_view_interval())
        base = self._base  # type: ignore[attr-defined]  # it has no public name
        if not 0 < low < high or base != 10:
            return
        few_powers = len(labelled_values(low, high, (1.0,))) < _ENOUGH
        is_short = low >= _LEAST_PLAIN and high <= _MOST_PLAIN
        self.plain = is_short and (few_powers or high <= _NARROW * low)
        self.factors, self.every = self._choose(axis, low, high)

    def _choose(self, axis: Any, low: float, high: float) -> tuple[tuple[float, ...], int]:
        """Return the first choice whose labels fit, the last one if none fits; axes over several
        decades have powers only.
        """
        powers = labelled_values(low, high, (1.0,))
        choices = _POWERS if len(powers) >= _ENOUGH else (*_WITHIN_DECADES, *_POWERS)
        for factors, every in choices:
            if self._have_room(axis, labelled_values(low, high, factors, every), low, high):
                return factors, every
        return choices[-1]

    def _have_room(self, axis: Any, values: Sequence[float], low: float, high: float) -> bool:
        """Return True if labels at these values do not touch each other."""
        size = _font_size(axis)
        along_x = axis.axis_name == "x"
        decade = _length(axis) / math.log10(high / low)
        for first, second in pairwise(values):
            if along_x:
                needed = size * (_width(self._text(first) + self._text(second)) / 2 + _GAP)
            else:
                needed = size * _LINE
            if decade * math.log10(second / first) < needed:
                return False
        return True

    def _text(self, value: float) -> str:
        """Return the label of a positive value, whether it is shown or not."""
        power = math.floor(math.log10(value) + 1e-9)
        factor = round(value / 10.0**power, 6)
        if self.plain:
            return f"{value:g}"
        times = f"{factor:g}{_TIMES}" if factor != 1 else ""
        return f"{times}10{str(power).translate(_RAISED)}"

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a value."""
        if not x:
            return "0"
        if self.factors is None or x < 0:
            if not super().__call__(x, pos):
                return ""
            return self._text(x) if x > 0 else f"{_MINUS}{self._text(-x)}"
        power = math.floor(math.log10(x) + 1e-9)
        factor = round(x / 10.0**power, 6)
        if factor not in self.factors or power % self.every:
            return ""
        return self._text(x)


def labelled_values(
    low: float, high: float, factors: Sequence[float], every: int = 1
) -> list[float]:
    """Return the values between the ends of an axis that are a factor times a power of ten.

    Parameters
    ----------
    every
        Number of decades from one power to the next.
    """
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    values: list[float] = []
    for power in powers:
        if power % every == 0:
            values += [factor * 10.0**power for factor in factors]
    margin = 1 + 1e-9
    return sorted(value for value in values if low / margin <= value <= high * margin)


def _width(text: str) -> float:
    """Return the width of a label, font sizes."""
    raised = sum(character in _SUPERSCRIPTS for character in text)
    return _CHARACTER * (len(text) - raised) + _SUPERSCRIPT * raised


def _font_size(axis: Any) -> float:
    """Return the size of the labels of an axis, points."""
    parameters: Any = mpl.rcParams
    size = parameters[f"{axis.axis_name}tick.labelsize"]
    return float(FontProperties(size=size).get_size_in_points())


def _length(axis: Any) -> float:
    """Return the length of an axis, points."""
    extent = axis.axes.get_window_extent()
    pixels = extent.width if axis.axis_name == "x" else extent.height
    return float(pixels * _POINTS / axis.axes.figure.dpi)


def plain_powers(figure: Figure) -> None:
    """Replace the default labels of logarithmic axes by the labels of `PowersOfTen`.

    Axes over many decades have ticks at powers only.
    """
    axes_and_children: list[Any] = []
    for axes in figure.axes:
        axes_and_children += [axes, *axes.child_axes]
    axis_list: list[Any] = []
    for axes in axes_and_children:
        if isinstance(axes, SecondaryAxis):
            secondary: Any = axes
            secondary._set_lims()  # otherwise the limits are set only when the axis is drawn
        axis_list += [axes.xaxis, axes.yaxis]
    for axis in axis_list:
        if type(axis.get_major_locator()) is LogLocator:
            _place_ticks(axis)
        for usual, change in (
            (axis.get_major_formatter(), axis.set_major_formatter),
            (axis.get_minor_formatter(), axis.set_minor_formatter),
        ):
            if type(usual) is LogFormatterSciNotation:
                # matplotlib has no public names for base and range of symlog axes
                scale: Any = usual
                change(
                    PowersOfTen(
                        scale._base, scale.labelOnlyBase, scale.minor_thresholds, scale._linthresh
                    )
                )


def long_times_in_ms(figure: Figure) -> None:
    """Show axes of times that reach beyond 5 ms in ms; their data stay in µs."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            title = axis.get_label_text()
            if not title.endswith(_IN_MICROSECONDS) or max(axis.get_view_interval()) <= _LONG:
                continue
            axis.set_label_text(title.removesuffix(_IN_MICROSECONDS) + "(ms)")
            axis.set_major_formatter(FuncFormatter(_in_milliseconds))
            axis.set_minor_formatter(NullFormatter())


def _in_milliseconds(time: float, _position: int | None = None) -> str:
    """Return the label, in ms, of a time in µs."""
    return f"{time * _MILLI:.6g}".replace("-", _MINUS)


def _place_ticks(axis: Axis) -> None:
    """Place the ticks of a logarithmic axis: at round numbers within a third of a decade, at powers
    of ten only over many decades.
    """
    low, high = sorted(axis.get_view_interval())
    if high < _LEAST_TICKS * low:
        named: Any = axis  # matplotlib's types do not know the name
        axis.set_major_locator(MaxNLocator(_FEW_TICKS[named.axis_name], min_n_ticks=1))
        axis.set_major_formatter("{x:.4g}")
        axis.set_minor_locator(NullLocator())
        return
    many = _MANY_OF_COLOURS if axis.axes.get_label() == _COLOUR_BAR else _MANY
    if high >= many * low:
        axis.set_minor_locator(NullLocator())
    locator: Any = axis.get_major_locator()
    locator.set_params(numticks=_MOST_TICKS)  # the default is a few, of any decades


def least_span(figure: Figure) -> None:
    """Widen axes with nearly equal values, whose ticks would all show the same number."""
    for axes in figure.axes:
        if axes.get_label() == _COLOUR_BAR:
            continue
        x_limits = _around(axes.dataLim.intervalx, axes.get_xscale())
        if axes.get_autoscalex_on() and x_limits:
            axes.set_xlim(x_limits)
        y_limits = _around(axes.dataLim.intervaly, axes.get_yscale())
        if axes.get_autoscaley_on() and y_limits:
            axes.set_ylim(y_limits)


def _around(values: NDArray[np.float64], scale: str) -> tuple[float, float] | None:
    """Return limits of an axis around nearly equal values; None if the values differ clearly."""
    low, high = values.tolist()
    if not 0 <= high - low < _LEAST_SPAN * max(abs(low), abs(high)):
        return None
    middle = 0.5 * (low + high)
    share = _LEAST_DECADE if scale == "log" else 1.05
    return (middle / share, middle * share) if middle > 0 else (middle * share, middle / share)


def ticks_at(axis: Axis, places: Iterable[float]) -> None:
    """Put plain numbers at these positions of a logarithmic axis, and nowhere else."""
    axis.set_major_locator(FixedLocator(list(places)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())


def numbered_map(
    axes: Axes,
    values: NDArray[np.float64],
    ends: tuple[float, float],
    title: str,
    names: Sequence[Sequence[str]],
    form: str = ".3g",
    most: int = _MOST_NAMED,
) -> None:
    """Draw values (n_y, n_x) by colour, and as numbers if they are few, in cells of equal size,
    with a colour bar.

    Parameters
    ----------
    ends
        Lower and upper end of the colours.
    title
        Title of the colour bar.
    names
        Of the columns and of the lines.
    form
        Format of the numbers.
    most
        Largest number of columns that are named.
    """
    low, top = ends
    mesh = axes.imshow(values, cmap="viridis", vmin=low, vmax=top, origin="lower", aspect="auto")
    for (line, place), value in np.ndenumerate(
        values if max(values.shape) <= _MOST_NAMED else np.empty((0, 0))
    ):
        if np.isfinite(value):
            colour = "black" if value - low > 0.6 * (top - low) else "white"
            axes.text(
                place, line, f"{value:{form}}", ha="center", va="center", fontsize=6.5, color=colour
            )
    for axis, words, room in zip(
        (axes.xaxis, axes.yaxis), names, (min(most, _MOST_NAMED), _MOST_NAMED), strict=True
    ):
        step = -(-len(words) // max(1, room))
        axis.set_ticks(range(0, len(words), step), words[::step])
    axes.tick_params(which="both", length=0)
    assert axes.figure is not None
    axes.figure.colorbar(mesh, ax=axes, pad=0.02).set_label(title)


def spread_scales(axes: Axes, places: Iterable[float]) -> str:
    """Put ticks at all positions; scales become logarithmic if values are spread over decades, and
    0 is kept.

    Returns
    -------
    str
        Words for the title of the axis of positions, if it is not linear; empty otherwise. Its line
        is then broken between 0 and the first position.
    """
    places = sorted(set(places))
    positive = [place for place in places if place > 0]
    spread = len(positive) > 1 and positive[-1] >= _WIDE * positive[0]
    if spread:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.5)
    ticks_at(axes.xaxis, places)
    if spread:
        axes.xaxis.set_minor_locator(
            SymmetricalLogLocator(linthresh=positive[0], base=10, subs=range(1, 10))
        )
    if spread and len(positive) < len(places):
        axes.text(
            0.5 * positive[0], 0, "//", transform=axes.get_xaxis_transform(), fontsize=7, **_BREAK
        )
    low, high = axes.get_ylim()
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in axes.lines])
    if values.min() > 0 and values.max() > _WIDE / 2 * values.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
    elif low < 0.5 * high:
        axes.set_ylim(0)
    return ", logarithmic" if spread else ""


def not_to_scale(places: Sequence[float]) -> str:
    """Return a note for the title of an axis of equal cells, if its values are not equally
    spaced.
    """
    steps = np.diff(places)
    return "" if np.allclose(steps, steps[:1]) else ", not to scale"
