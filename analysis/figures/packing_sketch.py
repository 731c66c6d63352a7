"""Sketch of a packing before it is run: its grains from the side and from above, by material;
cylinders are discs of their diameter.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.series import legend_outside
from granwave.analysis.figures.style import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    WIDTH,
    YELLOW,
    Drawing,
    new_figure,
    save_as,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly

_MILLI = 1e3  # millimetres in a metre
_PALE = "#d9d9d9"
#: Colours of materials, from bright to dark and back, for readers without colours.
_COLOURS = (_PALE, BLUE, YELLOW, GREEN, PURPLE, ORANGE)
_SUFFIXES = (".png", ".pdf")
_EDGE_WIDTH = 0.3  # points
_MARGIN = 0.03  # margin around the grains over the larger width
_NARROW = 0.15  # width of a view / largest extent, below which an axis has two ticks at most
_COLUMNS = 4  # columns of the legend
_LOWEST = 0.5  # height over width of a view, below which the figure is no lower
_TALLEST = 1.6  # height over width of a view, beyond which the figure is no taller
_NARROWER = 0.75  # exponent by which figures of tall packings are narrower

#: Horizontal and vertical axis of a view, direction of view, and title.
_VIEWS = ((0, 2, 1, "from the side"), (0, 1, 2, "from above"))


def write_packing(assembly: Assembly, path: Path) -> Path:
    """Write the sketch of a packing (.png or .pdf; both are written, and the table of its grains).

    Raises
    ------
    InputError
        The path has another suffix, or a file of such a name exists, and granwave did not write it.
    """
    if path.suffix not in _SUFFIXES:
        suffix = path.suffix or "none"
        raise InputError(f"{path}: found the suffix {suffix}, expected {' or '.join(_SUFFIXES)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    save_as(path, _table(assembly), lambda: packing_drawing(assembly))
    return path


def packing_drawing(assembly: Assembly) -> Drawing:
    """Draw the grains of a packing from the side and from above; grains in front hide others."""
    position = assembly.positions()
    diameter = assembly.sphere_diameters()
    names = _materials(assembly)
    low = (position - diameter[:, None] / 2).min(axis=0)
    high = (position + diameter[:, None] / 2).max(axis=0)
    extent = high - low
    margin = _MARGIN * float(extent.max())
    lower = _MILLI * (low - margin)
    upper = _MILLI * (high + margin)
    width, _, height = extent + 2 * margin
    shape = min(max(float(height / width), _LOWEST), _TALLEST)
    figure = new_figure(WIDTH * shape, 2 * WIDTH / max(shape, 1.0) ** _NARROWER)
    views = figure.subplots(1, len(_VIEWS))
    for axes, (across, upward, along, title) in zip(views, _VIEWS, strict=True):
        order = np.argsort(-position[:, along], kind="stable")
        centres = position[order][:, [across, upward]]
        _draw_discs(axes, centres, diameter[order], names[order])
        axes.set_xlim(lower[across], upper[across])
        axes.set_ylim(lower[upward], upper[upward])
        if upward == 2:  # depth points down
            axes.invert_yaxis()
        axes.set_aspect("equal")
        axes.set(xlabel=f"${'xyz'[across]}$ (mm)", ylabel=f"${'xyz'[upward]}$ (mm)", title=title)
        if extent[across] < _NARROW * extent.max():
            axes.xaxis.set_major_locator(MaxNLocator(1))
    _draw_legend(figure, views[0], np.unique(names).tolist())
    return Drawing(figure, _table(assembly))


def _draw_legend(figure: Figure, axes: Axes, names: list[str]) -> None:
    """Draw the legend of materials above the views, if there are several."""
    if len(names) < 2:
        return
    for number, name in enumerate(names):
        colour = _COLOURS[number % len(_COLOURS)]
        look: Any = {"markeredgecolor": "black", "markeredgewidth": _EDGE_WIDTH}
        axes.plot([], [], "o", color=colour, label=name, **look)
    legend_outside(figure, min(len(names), _COLUMNS), fontsize="small")


def _draw_discs(
    axes: Axes, centre: NDArray[np.float64], diameter: NDArray[np.float64], names: NDArray[np.str_]
) -> None:
    """Draw discs (n, 2) in their order, coloured by material."""
    kinds = np.unique(names).tolist()
    colours = [_COLOURS[kinds.index(name) % len(_COLOURS)] for name in names.tolist()]
    discs = EllipseCollection(
        _MILLI * diameter,
        _MILLI * diameter,
        np.zeros(len(diameter)),
        units="xy",
        offsets=_MILLI * centre,
        offset_transform=axes.transData,
        facecolors=colours,
        edgecolors="black",
        linewidths=_EDGE_WIDTH,
    )
    axes.add_collection(discs)


def _materials(assembly: Assembly) -> NDArray[np.str_]:
    """Return the name of the material of each grain: (n,)."""
    bodies = assembly.body[assembly.present]
    names = np.array([str(species.material.name) for species in assembly.species])
    return names[bodies]


def _table(assembly: Assembly) -> dict[str, NDArray[np.generic]]:
    """Return the grains as a table."""
    position = assembly.positions()
    columns: dict[str, NDArray[np.generic]] = dict(
        zip(("x_m", "y_m", "z_m"), position.T, strict=True)
    )
    columns["diameter_m"] = assembly.sphere_diameters()
    columns["material"] = _materials(assembly)
    return columns
