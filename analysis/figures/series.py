"""Common elements of figures of studies: single panels, legends above, names of columns."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from granwave.analysis.figures.style import WIDTH, new_figure


def one_panel(height: float, xlabel: str, ylabel: str, width: float = WIDTH, **settings: Any) -> tuple[Figure, Axes]:
    """Make an empty figure with one panel.

    Parameters
    ----------
    height, width
        Size of the figure, inches.
    xlabel, ylabel
        Labels of the axes.
    settings
        Further settings of the axes: ``xscale``, ``ylim``, ...
    """
    figure = new_figure(height, width)
    axes = figure.subplots()
    axes.set(xlabel=xlabel, ylabel=ylabel, **settings)
    return figure, axes


def legend_outside(figure: Figure, ncols: int = 0, *, left: bool = False, **options: Any) -> None:
    """Put the legend of the first panel above all panels.

    Parameters
    ----------
    ncols
        Columns; 0 for one row.
    left
        True to place it at the left, else in the middle.
    options
        Further options of a legend: ``fontsize``, ``title``, ...
    """
    handles, labels = figure.axes[0].get_legend_handles_labels()
    place: Any = f"outside upper {'left' if left else 'center'}"
    figure.legend(handles, labels, loc=place, ncols=ncols or len(labels), **options)


def column_name(words: str) -> str:
    """Convert text to the name of a column or a file: ``FCC, 314 µs`` becomes ``FCC_314_us``."""
    kept = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in words.replace("µ", "u"))
    return "_".join(filter(None, kept.split("_")))
