"""Figure of contacts that lose energy: collisions and the decay of waves."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, label, legend_outside, panels
from granwave.analysis.figures.style import GREY, Drawing

Curve = tuple[NDArray[np.float64], NDArray[np.float64]]


def of_collisions_and_waves(
    collisions: Mapping[str, Curve],
    theory: Mapping[str, Curve],
    waves: Mapping[str, Curve],
    fitted: Mapping[str, Curve],
) -> Drawing:
    """Restitution against velocity, and the largest force along a chain, for each kind of loss.

    Parameters
    ----------
    collisions, theory
        Velocity (m/s) and restitution, of the runs and of formulas, by kind.
    waves, fitted
        Number of the contact, and largest force over that of the first one shown, of the runs and of formulas, by kind.
    """
    figure, left, right = panels(3.0, 2)
    data: dict[str, ArrayLike] = {}
    kinds = list(dict.fromkeys([*collisions, *waves]))
    for kind, colour, marker in zip(kinds, COLOURS, MARKS, strict=False):
        name = column_name(kind)
        for axes, points, lines, x, y in (
            (left, collisions, theory, "velocity_m_s", "restitution"),
            (right, waves, fitted, "contact", "force_over_first"),
        ):
            if kind in points:
                axes.plot(*points[kind], marker, markersize=4, color=colour, label=kind if axes is left else None)
                data |= {f"{name}_{x}": points[kind][0], f"{name}_{y}": points[kind][1]}
            if kind in lines:
                axes.plot(*lines[kind], color=GREY, linewidth=0.9, zorder=0)
                data |= {f"{name}_theory_{x}": lines[kind][0], f"{name}_theory_{y}": lines[kind][1]}
    label(left, "Velocity (m/s)", "Restitution", log="x")
    label(right, "Contact", "Largest force over that of the first", log="y")
    legend_outside(figure, 2, fontsize=7)
    return Drawing(figure, data)
