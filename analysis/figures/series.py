"""Parts that figures share: panels and their labels, curves against time, legends above, names of
columns.

Figures are registered with pyplot, so that the user can change and show them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from contextvars import ContextVar
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import MissingDataError, did_you_mean
from granwave.analysis.figures.scales import least_span
from granwave.analysis.figures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    WIDTH,
    Drawing,
    NotDrawn,
    new_figure,
    style,
)
from granwave.analysis.figures.user_axes import (
    UserFigure,
    drawing_into,
    fit_to_axes,
    laid_out,
    leave_layout,
    match_font,
    match_text,
    plots_of,
    user_figure,
)
from granwave.analysis.formatting.numbers import quantity_in

_MICRO = 1e6  # in a second
_MOST_POINTS = 20_000  # most points of a curve; the CSV file has all

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
MARKS = "os^Dv"
#: Line styles in turn, which distinguish curves in grey prints.
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))
_ENERGIES = ((1.0, "J"), (1e3, "mJ"), (1e6, "µJ"), (1e9, "nJ"))
_VELOCITIES = ((1.0, "m/s"), (1e3, "mm/s"), (1e6, "µm/s"))
_TWO_DECADES = 100.0  # highest / lowest value below which ticks between decades have labels
_WIDE_PEAKS = 30.0  # largest / smallest peak of the curves of a logarithmic axis
_UNREADABLE = 4.0  # largest / smallest peak from which on each curve is divided by its peak
_ERRORS_SHOWN = 1e4  # largest over smallest error on the axis of the energies
_LEAST_PEAK = 1e-4  # fraction of the largest peak: curves that the wave reached
_BELOW_PEAKS = 4.0  # smallest peak / start of that axis
_ABOVE_PEAKS = 1.5  # end of that axis / largest peak
_LEAST_VELOCITY = 0.01  # in m/s: tenths are common there


def energy_unit(largest: float) -> tuple[float, str]:
    """Return the unit of energies up to ``largest`` (J): the number of units in a joule, and its
    name.
    """
    return next((unit for unit in _ENERGIES if largest * unit[0] >= 1), _ENERGIES[-1])


def velocity_unit(largest: float) -> tuple[float, str]:
    """Return the unit of velocities up to ``largest`` (m/s): the number of units in 1 m/s, and its
    name.
    """
    return next(
        (unit for unit in _VELOCITIES if largest * unit[0] >= _LEAST_VELOCITY), _VELOCITIES[-1]
    )


def against_time(
    axes: Axes, time: NDArray[np.float64], values: NDArray[np.float64], line: Any = "-", **look: Any
) -> None:
    """Draw a record against time, and label the axis of time.

    Long records are drawn by the lowest and the highest value of every bin, which give the same
    curve.
    """
    if len(values) > _MOST_POINTS:
        n_bins = _MOST_POINTS // 2
        size = len(values) // n_bins
        bins = values[: n_bins * size].reshape(n_bins, size)
        starts = np.arange(n_bins) * size
        rows = np.unique(
            [*(starts + bins.argmin(axis=1)), *(starts + bins.argmax(axis=1)), len(values) - 1]
        )
        time = time[rows]
        values = values[rows]
    axes.plot(time * _MICRO, values, linestyle=line, **look)
    time_axis(axes, time)


def time_axis(axes: Axes, time: NDArray[np.float64]) -> None:
    """Label the axis of times, s, of the lowest panel if several share it."""
    place = axes.get_subplotspec()
    if user_figure() is not None or place is None or place.is_last_row():
        axes.set_xlabel("Time (µs)")
    axes.set_xlim(0, float(time[-1]) * _MICRO or 1.0)


def end_of_axis(shown: float, last: float) -> str:
    """Return a sentence on an axis of times that ends before the run; empty if it shows all.

    Parameters
    ----------
    shown, last
        Ends of the axis and of the run, s.
    """
    if shown >= last:
        return ""
    ends = [quantity_in(float(f"{end:.3g}"), "s") for end in (shown, last)]
    return f"The axis ends at {ends[0]} of {ends[1]}."


def one_panel(height: float, xlabel: str, ylabel: str, **settings: Any) -> tuple[Figure, Axes]:
    """Make a figure, of a height in inches, with one panel and its labels; ``settings``: of
    ``Axes.set``.
    """
    figure, axes = panels(height)
    axes.set(xlabel=xlabel, ylabel=ylabel, **settings)
    return figure, axes


def panels(
    height: float, columns: int = 1, rows: int = 1, *, width: float = 0.0, **options: Any
) -> tuple[Any, ...]:
    """A new figure and its axes, row by row; curves take the `COLOURS` in turn.

    Parameters
    ----------
    height, width
        Inches; by default the width of a column of a journal, or of two for panels side by side.
    options
        Arguments of ``Figure.subplots``.
    """
    figure = new_figure(height, width or WIDTH * min(columns, 2))
    grid = figure.subplots(rows, columns, squeeze=False, **options).ravel()
    for axes in grid:
        axes.set_prop_cycle(color=COLOURS)
    return figure, *grid


def label(axes: Axes, x: str = "", y: str = "", *, log: str = "", **settings: Any) -> None:
    """Label axes, and set their other properties.

    Parameters
    ----------
    log
        Names of logarithmic axes: ``x``, ``y`` or ``xy``.
    settings
        Arguments of ``Axes.set``, such as ``xlim`` and ``title``.
    """
    axes.set(**{f"{name}scale": "log" for name in log})
    axes.set(xlabel=x or axes.get_xlabel(), ylabel=y or axes.get_ylabel(), **settings)


def label_log_axis(axes: Axes, ratio: float) -> None:
    """Label the ticks of a logarithmic vertical axis: 1, 2 and 5 of each decade over less than two
    decades, otherwise the decades.

    Parameters
    ----------
    ratio
        Largest value / smallest value.
    """
    if ratio < _TWO_DECADES:
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def limits_of_error(residual: NDArray[np.float64]) -> dict[str, Any]:
    """Return the limits of the axis of errors, which single small errors do not widen."""
    largest = float(residual.max(initial=0.0))
    if not 0 < largest < math.inf:  # a logarithmic axis shows only positive, finite errors
        return {}
    shown = residual[residual > largest / _ERRORS_SHOWN]
    return {"ylim": (float(shown.min()) / 2, 2 * largest)}


def scale_by_peaks(axes: Axes, peaks: ArrayLike) -> None:
    """Give the vertical axis a logarithmic scale if the peaks of its curves differ so much that the
    lowest curves would be on the axis of times.

    Parameters
    ----------
    peaks
        Largest values of the curves, in the unit of the axis: (n_curves,).
    """
    values = np.asarray(peaks, dtype=np.float64)
    values = values[values > _LEAST_PEAK * values.max(initial=0.0)]
    if not len(values) or values.max() < _WIDE_PEAKS * values.min():
        return
    axes.set_yscale("log")
    axes.set_ylim(values.min() / _BELOW_PEAKS, values.max() * _ABOVE_PEAKS)
    label_log_axis(axes, _BELOW_PEAKS * values.max() / values.min())


_overlaid: ContextVar[bool] = ContextVar("curves of another run are drawn over", default=False)


@contextlib.contextmanager
def drawn_over() -> Iterator[None]:
    """Draw figures over which curves of another run are drawn: curves have one common unit."""
    token = _overlaid.set(True)
    try:
        yield
    finally:
        _overlaid.reset(token)


def is_overlaid() -> bool:
    """Return True while figures are drawn over which curves of another run are drawn."""
    return _overlaid.get()


def are_relative(peaks: ArrayLike) -> bool:
    """Return True for curves whose peaks differ so much that the lowest could not be read on a
    common axis: each is divided by its own peak. Curves that the wave has not reached do not count.

    Curves over which those of another run are drawn are never divided, see `scale_by_peaks`.

    Parameters
    ----------
    peaks
        Largest values of the curves: (n_curves,).
    """
    values = np.asarray(peaks, dtype=np.float64)
    values = values[values > _LEAST_PEAK * values.max(initial=0.0)]
    is_wide = len(values) > 0 and values.max() > _UNREADABLE * values.min()
    return bool(is_wide) and not is_overlaid()


def legend_outside(figure: Figure, ncols: int, **options: Any) -> None:
    """Put the legend of the first panel above all panels; ``options``: of a legend, such as
    ``title``.
    """
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(),
        loc="outside upper center",
        ncols=ncols,
        **options,
    )


def with_error(value: float, error: float) -> str:
    """Return a number with its error, which has two digits: ``70.4 ± 2.8``."""
    digits = 0
    if error > 0:
        digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}".replace("-", "\N{MINUS SIGN}")


def column_name(words: str) -> str:
    """Convert text to the name of a column or a file: ``FCC, 314 µs`` becomes ``FCC_314_us``."""
    kept = "".join(
        letter if letter.isalnum() and letter.isascii() else "_"
        for letter in words.replace("µ", "u")
    )
    return "_".join(filter(None, kept.split("_")))


_HEIGHT = 2.6  # height of a figure that pyplot makes, inches


def draw_axes(
    draw: Callable[[], Drawing | NotDrawn | None],
    width: float | None = None,
    into: Sequence[Axes] = (),
) -> Axes | list[Axes] | None:
    """Draw a figure and hand it to pyplot, without saving it.

    Parameters
    ----------
    width
        As in `granwave.analysis.figures.style.style`.
    into
        Axes of the user, one for each panel, used instead of a new figure.

    Returns
    -------
    Axes, list of Axes or None
        Its axes without colour bars, a list if there are several; None if there is nothing to draw.
    """
    from matplotlib import pyplot

    with laid_out(into):
        with style(width), drawing_into(into) if into else nullcontext():
            drawing = draw()
            if drawing is None:
                return None
            if isinstance(drawing, NotDrawn):
                raise MissingDataError(str(drawing))
            least_span(drawing.figure)
            if into:
                cast(UserFigure, drawing.figure).align()
                leave_layout(drawing.figure)
            # ticks take their style when they are first needed
            drawing.figure.draw_without_rendering()
        if into:
            match_text(drawing.figure, into)
            fit_to_axes(cast(UserFigure, drawing.figure))
            match_font(drawing.figure, into)  # legends that were drawn anew
    if not into:
        pyplot.figure(drawing.figure)
    plots = plots_of(drawing.figure)
    return plots[0] if len(plots) == 1 else plots


@contextlib.contextmanager
def own_style() -> Iterator[None]:
    """Apply `granwave.analysis.figures.style.STYLE`, with its colours in turn, to figures that
    pyplot makes.
    """
    usual: dict[Any, Any] = {
        "axes.prop_cycle": cycler(color=COLOURS),
        "figure.constrained_layout.use": True,
        "figure.figsize": (WIDTH, _HEIGHT),
    }
    with style(), mpl.rc_context(usual):
        yield


def no_figure(owner: str, name: str, names: Iterable[str]) -> MissingDataError:
    """Return the error that there is no figure of a name."""
    names = list(names)
    near = did_you_mean(str(name), names)
    hint = f"{near} " if near else ""
    return MissingDataError(
        f"{owner}: has no figure {name}; {hint}figures are {', '.join(names) or 'none'}"
    )
