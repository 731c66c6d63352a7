"""How curves of a comparison look, and the figure of a scaling: in joules and on normalised axes, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.granular_continuum.impacts import Continuum, Granular

COLOURS = ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
MARKERS = "os^DvP*"
FRACTION = "Dissipation / input energy"
GRANULAR_ENERGY = r"Input energy $e_\mathrm{in}/(F_\mathrm{y}\,\alpha_\mathrm{y})$"
CONTINUUM_ENERGY = r"Input energy $e_\mathrm{in} E/(\sigma_\mathrm{y}^2 D^3)$"
_FEWEST_CURVES = 2

Curve = tuple[str, Sequence[Granular] | Sequence[Continuum]]


def draw_scaling(curves: Sequence[Curve], title: str, scale: Literal["linear", "log"]) -> Drawing | None:
    """Dissipated fraction against input energy, in J and normalised; None for a single curve.

    Parameters
    ----------
    curves
        Names and runs, the reference first.
    title
        Of the normalised axis.
    scale
        Of the axes of energy.
    """
    if len(curves) < _FEWEST_CURVES:
        return None
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2, sharey=True)
    columns: dict[str, list] = {"curve": [], "energy_J": [], "energy_normalised": [], "dissipated_fraction": []}
    for n, (name, runs) in enumerate(curves):
        style = reference_and_marks(n)
        energy, normalised = [run.energy for run in runs], [run.energy_normalised for run in runs]
        fraction = [run.fraction for run in runs]
        left.plot(energy, fraction, label=name, **style)
        right.plot(normalised, fraction, **style)
        columns["curve"] += [name] * len(runs)
        columns["energy_J"] += energy
        columns["energy_normalised"] += normalised
        columns["dissipated_fraction"] += fraction
    left.set_xlabel("Input energy (J)")
    right.set_xlabel(title)
    left.set_ylabel(FRACTION)
    left.set_ylim(bottom=0)
    left.legend(fontsize=7, loc="lower right")
    for axes in (left, right):
        axes.set_xscale(scale)
        if scale == "linear":
            axes.set_xlim(left=0)
    return Drawing(figure, columns)


def reference_and_marks(n: int) -> dict[str, Any]:
    """The reference as a line with points, the others as open marks."""
    if n == 0:
        return {"color": COLOURS[0], "marker": ".", "linewidth": 0.8}
    return {
        "color": COLOURS[n % len(COLOURS)],
        "marker": MARKERS[n % len(MARKERS)],
        "markerfacecolor": "none",
        "linestyle": "none",
        "markersize": 5,
    }
