"""Colours of spheres by a quantity: the scale, its bar, and the unit of forces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, to_rgba
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.style import DISSIPATION_MAP, FORCE_MAP
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.result.reader import Result

DISSIPATION_LIMITS = (1e-6, 1e-1)  # range of dissipation over input
_LEAST_DECADES = 3  # default range of a logarithmic scale
_DECADES_OF_FORCE = 4  # largest range of the peak forces, far below F_y: the elastic wave
_LEAST_RATIO = 10.0  # highest / lowest value of a scale of nearly equal values
#: Grains without a value, which differ from both ends of the colour maps in grey prints too.
_BLANK = "white"
_EDGE_OF_BLANK = "#9a9a9a"


@dataclass(frozen=True, eq=False)
class Colouring:
    """Quantity with its colour scale.

    Attributes
    ----------
    values
        Values by sphere: (n_spheres,).
    label
        Label of the colour bar.
    column
        Name of the column in the CSV file.
    map
        Name of the colour map.
    low, high
        Ends of the logarithmic scale.
    title
        Title of the panel, if there are several.
    """

    values: NDArray[np.float64]
    label: str
    column: str
    map: str
    low: float
    high: float
    title: str = ""

    @property
    def norm(self) -> LogNorm:
        """Logarithmic colour scale."""
        return LogNorm(self.low, self.high)


def force_scale(result: Result) -> tuple[float, str, str]:
    """Return the unit of forces in figures, N, the label of the ratio, and its name in CSV files.

    The unit is F_y if contacts can yield, otherwise the largest peak force of the run, whose value
    is in the label.
    """
    if result.has_yield_force:
        return result.law.yield_force, r"$F/F_\mathrm{y}$", "force_over_yield_force"
    largest = float(np.max(result["contacts/peak_force"], initial=0.0)) or 1.0
    label = rf"$F/F_\mathrm{{max}}$, $F_\mathrm{{max}}$ = {quantity_in(largest, 'N')}"
    return largest, label, "force_over_largest_force"


def peak_force_colouring(result: Result) -> Colouring:
    """Return the colouring by the largest contact force of each sphere, on one scale in all figures
    of a run: from the decade of the smallest force, at most four decades.
    """
    scale, label, column = force_scale(result)
    values = result["spheres/peak_force"] / scale
    options = result.figure_options
    high = decades_up_to(float(values.max(initial=0.0)), None)[1]
    low = high / 10**_DECADES_OF_FORCE
    low = max(low, 10 ** math.floor(math.log10(_smallest(values, low))))
    low = min(low, high / _LEAST_RATIO)
    low, high = options.force_limits or (low, high)
    return Colouring(
        values, f"Peak force {label}", f"peak_{column}", options.colour_map or FORCE_MAP, low, high
    )


def _smallest(values: NDArray[np.float64], least: float) -> float:
    """Return the smallest value above 0; ``least`` without any."""
    positive = values[values > 0]
    return float(positive.min()) if len(positive) else least


def dissipation_colouring(result: Result, part: str = "") -> Colouring:
    """Return the colouring by dissipation / energy input.

    ``part``: only the dissipation by ``yielding``, ``friction`` or ``viscous`` losses.
    """
    values = result["spheres/dissipated_energy"]
    if part:
        values = result.yield_energy if part == "yielding" else result[f"spheres/{part}_energy"]
    column = f"{part}_over_input" if part else "dissipated_over_input"
    label = r"Dissipation $e_\mathrm{dis}/e_\mathrm{in}$"
    options = result.figure_options
    low, high = options.dissipation_limits or DISSIPATION_LIMITS
    colours = options.colour_map or DISSIPATION_MAP
    title = "Viscous damping" if part == "viscous" else part.capitalize()
    return Colouring(values / result.energy_input, label, column, colours, low, high, title)


def disc_colours(
    values: NDArray[np.float64], colouring: Colouring
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the colours of discs with values (n,), and the colours of their edges: (n, 4) each."""
    mapped = colormaps[colouring.map]
    colours = mapped(colouring.norm(np.maximum(values, colouring.low)))
    coloured = (values > 0)[:, None]
    return (
        np.where(coloured, colours, to_rgba(_BLANK)),
        np.where(coloured, colours, to_rgba(_EDGE_OF_BLANK)),
    )


def colour_bar(
    figure: Figure,
    axes: list[Axes],
    colouring: Colouring,
    values: NDArray[np.float64],
    location: str = "bottom",
    blank: str = "0",
) -> None:
    """Draw a colour bar next to, above or below the panels, with pointed ends if values exceed the
    scale. Its label explains white grains, if there are any.

    Parameters
    ----------
    values
        Values of the coloured grains; 0 for white ones.
    blank
        Meaning of white.
    """
    below = bool(np.any((values > 0) & (values < colouring.low)))
    above = bool(np.any(values > colouring.high))
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get(
        (below, above), "neither"
    )
    label = colouring.label
    if np.any(values == 0):
        label = f"{label} (white: {blank})"
    mappable = ScalarMappable(colouring.norm, colormaps[colouring.map])
    place: dict[str, Any] = {
        "ax": axes,
        "location": location,
        "fraction": 0.08 if location in ("top", "bottom") else 0.05,
    }
    figure.colorbar(mappable, label=label, extend=extend, aspect=28, pad=0.03, shrink=0.9, **place)


def decades_up_to(largest: float, low: float | None) -> tuple[float, float]:
    """Return the ends of a logarithmic scale up to the largest value, at least one decade, by
    default three.
    """
    high = 10 ** (math.ceil(2 * math.log10(largest)) / 2) if largest > 0 else 1.0
    if low is None or high < 10 * low:
        low = high / 10**_LEAST_DECADES
    return low, high
