"""Axes whose values are spread over decades, and maps that show their values as numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import (
    FixedLocator,
    LogFormatterSciNotation,
    LogLocator,
    NullFormatter,
    NullLocator,
    SymmetricalLogLocator,
)
from numpy.typing import NDArray

_WIDE = 10.0  # largest over smallest value from which on an axis is logarithmic
# largest over smallest value from which ticks are at powers of ten only
_MANY = 1e4
_MANY_OF_COLOURS = 1e2
_COLOUR_BAR = "<colorbar>"  # label that matplotlib gives to axes of a colour bar
# largest over smallest value up to which labels are plain numbers, if these are short
_NARROW = 30.0
_LEAST_PLAIN = 1e-3
_MOST_PLAIN = 1e4
# limits of a logarithmic axis over its value: ticks at two of 1, 2 and 5 at least
_LEAST_DECADE = 3.0
_LEAST_SPAN = 1e-3  # of an axis, over its values: labels of ticks have four digits
_MOST_NAMED = 8  # columns and lines of a map that are named, and whose cells have numbers
_BREAK: dict[str, Any] = {
    "ha": "center", "va": "center", "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.3}
}  # fmt: skip
_ROUND = (1.0, 2.0, 4.0)  # those of them that matplotlib labels anyway
_MINUS = "\N{MINUS SIGN}"
_TIMES = "\N{MULTIPLICATION SIGN}"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class PowersOfTen(LogFormatterSciNotation):
    """Labels of a logarithmic axis, such as 10⁻³, as plain text: formulas take many times longer to
    set.
    """

    plain = False  # numbers such as 0.2 in place of powers
    few = False  # of the values within a decade

    def set_locs(self, locs: Any = None) -> None:
        """Choose the labels: plain numbers within a decade or so; on axes across, no more than
        there is room for.
        """
        super().set_locs(locs)
        axis: Any = self.axis
        low, high = (
            (abs(one) for one in axis.get_view_interval()) if axis is not None else (0.0, 0.0)
        )
        if not 0 < low < high:
            return
        self.plain = high <= _NARROW * low and low >= _LEAST_PLAIN and high <= _MOST_PLAIN
        powers = 10.0 ** np.arange(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        round_ones = [one for one in np.outer(powers, _ROUND).ravel() if low <= one <= high]
        self.few = axis.axis_name == "x" and len(round_ones) > 1

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a value."""
        if not super().__call__(x, pos) or not x:
            return "" if x else "0"
        power = math.floor(math.log10(abs(x)) + 1e-9)
        factor = round(abs(x) / 10.0**power, 6)
        if x > 0 and self.few and factor not in _ROUND:
            return ""
        if x > 0 and self.plain:
            return f"{x:g}"
        sign = _MINUS if x < 0 else ""
        times = f"{factor:g}{_TIMES}" if factor != 1 else ""
        return f"{sign}{times}10{str(power).translate(_RAISED)}"


def plain_powers(figure: Figure) -> None:
    """Give logarithmic axes that have the usual labels those of `PowersOfTen`; of many decades
    ticks at powers only.
    """
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        many = _MANY_OF_COLOURS if axis.axes.get_label() == _COLOUR_BAR else _MANY
        if axis.get_scale() == "log" and high >= many * low:
            axis.set_minor_locator(NullLocator())
        for usual, change in (
            (axis.get_major_formatter(), axis.set_major_formatter),
            (axis.get_minor_formatter(), axis.set_minor_formatter),
        ):
            if type(usual) is LogFormatterSciNotation:
                scale: Any = usual  # base and the range of symlog axes have no public names
                change(
                    PowersOfTen(
                        scale._base, scale.labelOnlyBase, scale.minor_thresholds, scale._linthresh
                    )
                )


def least_span(figure: Figure) -> None:
    """Widen axes on which all values are equal or nearly so: their ticks would show one and the
    same number.
    """
    for axes in (one for one in figure.axes if one.get_label() != _COLOUR_BAR):
        if axes.get_autoscalex_on() and (
            limits := _around(axes.dataLim.intervalx, axes.get_xscale())
        ):
            axes.set_xlim(limits)
        if axes.get_autoscaley_on() and (
            limits := _around(axes.dataLim.intervaly, axes.get_yscale())
        ):
            axes.set_ylim(limits)


def _around(values: NDArray[np.float64], scale: str) -> tuple[float, float] | None:
    """Return limits of an axis around the ends of its values; None if these are apart."""
    low, high = values.tolist()
    if not 0 <= high - low < _LEAST_SPAN * max(abs(low), abs(high)):
        return None
    middle = 0.5 * (low + high)
    share = _LEAST_DECADE if scale == "log" else 1.05
    return (middle / share, middle * share) if middle > 0 else (middle * share, middle / share)


def ticks_at(axis: Axis, places: Iterable[float]) -> None:
    """Put plain numbers at these places of a logarithmic axis, and nowhere else."""
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
    """Put ticks at all places; scales become logarithmic where values are spread over decades, and
    0 is kept.

    Returns
    -------
    str
        Words for the title of the axis of places, if it is not linear; empty otherwise. Its line is
        then broken between 0 and the first place.
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
    """Return words for the title of an axis of cells of one width, if its values are not equally
    spaced.
    """
    steps = np.diff(places)
    return "" if np.allclose(steps, steps[:1]) else ", not to scale"
