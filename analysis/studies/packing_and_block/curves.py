"""Look of the curves of a comparison, and the figure of a scaling: in joules and on normalised axes, side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Literal

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.studies.packing_and_block.impacts import Curve

COLOURS = ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
MARKERS = "os^DvP*"
FRACTION = "Dissipation / input energy"
GRANULAR_ENERGY = r"Input energy $e_\mathrm{in}/(F_\mathrm{y}\,\alpha_\mathrm{y})$"
CONTINUUM_ENERGY = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$"


def draw_scaling(curves: Sequence[Curve], title: str, scale: Literal["linear", "log"]) -> Drawing:
    """Dissipated fraction against input energy, in J and normalised.

    Parameters
    ----------
    curves
        Names and runs, the reference first.
    title
        Of the normalised axis.
    scale
        Of the axes of energy.
    """
    figure, left, right = panels(2.6, 2, sharey=True)
    columns: dict[str, list] = {"curve": [], "energy_J": [], "energy_normalised": [], "dissipated_fraction": []}
    for n, (name, runs) in enumerate(curves):
        style = reference_and_marks(n)
        energy, normalised = [run.energy for run in runs], [run.energy_normalised for run in runs]
        fraction = [run.fraction for run in runs]
        left.plot(energy, fraction, label=name, **style)
        right.plot(normalised, fraction, **style)
        add(columns, [name] * len(runs), energy, normalised, fraction)
    label(left, "Input energy (J)", FRACTION, ylim=(0, max(1.0, 1.05 * max(columns["dissipated_fraction"]))))
    label(right, title)
    figure.legend(loc="outside upper center", ncols=2, fontsize=7, columnspacing=1.0)
    for axes in (left, right):
        axes.set_xscale(scale)
        if scale == "linear":
            axes.set_xlim(left=0)
    return Drawing(figure, columns)


def add(columns: dict[str, list], *values: Iterable[Any]) -> None:
    """Append a curve's values to the columns of a figure, in their order."""
    for column, more in zip(columns.values(), values, strict=True):
        column.extend(more)


def reference_and_marks(n: int) -> dict[str, Any]:
    """The reference as a line with points, the others as open marks."""
    if n == 0:
        return {"color": COLOURS[0], "marker": ".", "linewidth": 0.8}
    return {**colour_and_marker(n), "markerfacecolor": "none", "linestyle": "none", "markersize": 5}


def colour_and_marker(n: int) -> dict[str, Any]:
    """Colour and marker of the n-th curve."""
    return {"color": COLOURS[n % len(COLOURS)], "marker": MARKERS[n % len(MARKERS)]}
