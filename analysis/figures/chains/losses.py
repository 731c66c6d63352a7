"""Figures of chains whose contacts lose energy: composite chains, collisions and the decay of waves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, label, legend_outside, panels
from granwave.analysis.figures.style import GREY, Drawing
from granwave.analysis.measures.chains.composite_section import Composite
from granwave.analysis.measures.chains.groups import columns

Curve = tuple[NDArray[np.float64], NDArray[np.float64]]


def of_composites(
    series: Mapping[str, Mapping[float, Sequence[Composite]]], measured: Sequence[Mapping[int, float]]
) -> Drawing:
    """V and lambda against the section's length, for each material of the section and each restitution.

    Parameters
    ----------
    series
        Chains by material and restitution, in the order of their length.
    measured
        The source's V by length, of each material, m/s.
    """
    figure, left, right = panels(3.0, 2)
    data: dict[str, ArrayLike] = {}
    for (light, chains), colour, speeds in zip(series.items(), COLOURS, measured, strict=False):
        for (value, alike), marker in zip(chains.items(), MARKS, strict=False):
            n, speed, ratio = columns(alike, "n", "speed", "ratio")
            name = column_name(f"{light} restitution {value:g}")
            data |= {f"{name}_n": n.astype(float), f"{name}_speed_m_s": speed, f"{name}_ratio": ratio}
            for axes, values in ((left, speed), (right, ratio)):
                axes.plot(n, values, marker + "-", markersize=4, color=colour, label=f"{light}, restitution {value:g}")
        if speeds:
            left.plot(list(speeds), list(speeds.values()), "x", color=colour, label=f"{light}, measured (source)")
    label(left, r"Beads in the section $N_2$", r"Speed $V$ (m/s)")
    label(right, r"Beads in the section $N_2$", r"$\lambda$")
    legend_outside(figure, 2, fontsize=7)
    return Drawing(figure, data)


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
