"""Figures handed over to pyplot, to be changed and shown by the user."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes

from granwave.analysis.errors import MissingDataError, did_you_mean
from granwave.analysis.figures.scales import least_span
from granwave.analysis.figures.series import COLOURS
from granwave.analysis.figures.style import WIDTH, Drawing, NotDrawn, style

_HEIGHT = 2.6  # inches, of a figure that pyplot makes
_COLORBAR = "<colorbar>"  # label that matplotlib gives to the axes of colour bars


def draw_axes(draw: Callable[[], Drawing | NotDrawn | None], width: float | None = None) -> Axes | list[Axes] | None:
    """Draw a figure and hand it to pyplot, without saving it.

    Parameters
    ----------
    width
        As in `granwave.analysis.figures.style.style`.

    Returns
    -------
    Axes, list of Axes or None
        Its axes without colour bars, a list if there are several; None if there is nothing to draw.
    """
    from matplotlib import pyplot

    with style(width):
        drawing = draw()
        if drawing is None:
            return None
        if isinstance(drawing, NotDrawn):
            raise MissingDataError(str(drawing))
        least_span(drawing.figure)
        drawing.figure.draw_without_rendering()  # ticks take their style when they are first needed
    pyplot.figure(drawing.figure)
    found = [axes for axes in drawing.figure.axes if axes.get_label() != _COLORBAR]
    return found[0] if len(found) == 1 else found


@contextlib.contextmanager
def own_style() -> Iterator[None]:
    """Apply `granwave.analysis.figures.style.STYLE`, with its colours in turn, to figures that pyplot makes."""
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
    return MissingDataError(f"{owner}: has no figure {name}; {hint}figures are {', '.join(names) or 'none'}")
