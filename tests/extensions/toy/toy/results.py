"""Participation of the contacts in an impact, and the figure that shows it."""

import numpy as np

from granwave.analysis.figures.run_figures import RunFigure
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.quantities import Quantity
from granwave.analysis.result.reader import Result


def summary_values(result):
    """Return the values of a run for summary.json, by name; None where one does not apply."""
    force = result["contacts/peak_force"]
    if not force.any():
        return {"force_participation": None}
    return {"force_participation": float(force.sum() ** 2 / (len(force) * (force**2).sum()))}


QUANTITIES = (
    Quantity(
        "force_participation",
        "Participation of contacts",
        "1 if all contacts carry the same peak force, small if few carry all of it.",
    ),
)


def ranked_forces(result):
    """Draw the peak forces of the contacts in descending order; None if there are none."""
    force = np.sort(result["contacts/peak_force"])[::-1]
    if not force.any():
        return None
    rank = np.arange(1, len(force) + 1)
    figure, axes = panels(2.4)
    axes.plot(rank, force)
    label(axes, "Contacts in descending order", "Peak force (N)")
    return Drawing(figure, {"rank": rank, "peak_force_N": force})


RANKED_FORCES = RunFigure(
    "Peak forces of contacts in descending order",
    ranked_forces,
    "The flatter the curve, the more contacts share the load.",
)


def participation(options):
    """Execute ``granwave participation``; return the exit status."""
    with Result(options.directory) as result:
        print(summary_values(result)["force_participation"])
    return 0
