"""How figures look, and how they are saved: PNG and PDF with the data beside them as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

WIDTH = 3.4  # inches: one column of a journal
RESOLUTION = 300  # dots per inch
SUFFIXES = (".png", ".pdf", ".csv")

# Okabe and Ito's colours, which stay apart for colour-blind readers
BLUE, ORANGE, GREEN, PURPLE, SKY, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#767676"
YELLOW = "#F0C000"  # for areas; as a line it is too pale
FORCE_MAP = "viridis"
DISSIPATION_MAP = "inferno"
DENT_MAP = "cividis"
BLANK = "#dcdcdc"  # spheres without a value

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "mathtext.fontset": "dejavusans",
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "savefig.dpi": RESOLUTION,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
}

Columns = Mapping[str, ArrayLike]


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure and the numbers it shows.

    Attributes
    ----------
    figure
        The figure.
    columns
        Its data: arrays by name, the unit at the end of the name; shorter ones are padded with nothing.
    """

    figure: Figure
    columns: Columns


@contextmanager
def style() -> Iterator[None]:
    """Within it figures look as `STYLE` says; other programs' settings are left alone."""
    with mpl.rc_context(STYLE):
        yield


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """An empty figure that fits its parts together, sizes in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def legend_above(axes: Axes, ncols: int, **options: Any) -> None:
    """A legend that lies on no curve."""
    place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "columnspacing": 1.0}
    axes.legend(ncols=ncols, **(place | options))


def save(drawing: Drawing, path: Path, *, pdf: bool = True) -> None:
    """Save a drawing as path.png, path.pdf and path.csv.

    Parameters
    ----------
    path
        Without a suffix; its directory must exist.
    pdf
        False: without a PDF, which takes two thirds of the time; an older one is removed.
    """
    if not pdf:
        path.with_suffix(".pdf").unlink(missing_ok=True)
    drawing.figure.savefig(path.with_suffix(".png"))
    if pdf:
        drawing.figure.set_layout_engine("none")  # the parts have their places now
        drawing.figure.savefig(path.with_suffix(".pdf"), metadata={"CreationDate": None})
    write_csv(drawing.columns, path.with_suffix(".csv"))


def remove(path: Path) -> None:
    """Remove what `save` leaves."""
    for suffix in SUFFIXES:
        path.with_suffix(suffix).unlink(missing_ok=True)


def write_csv(columns: Columns, path: Path) -> None:
    """Write columns as CSV with a header; columns may differ in length."""
    texts = [_texts(values) for values in columns.values()]
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip_longest(*texts, fillvalue=""))


def _texts(values: ArrayLike) -> list[str]:
    array = np.asarray(values)
    if array.dtype.kind == "f":
        return ["" if value != value else f"{value:.10g}" for value in array.tolist()]
    return [str(value) for value in array.tolist()]
