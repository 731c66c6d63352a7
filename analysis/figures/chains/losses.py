"""Figures of composite chains whose contacts lose energy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, label, legend_outside, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.composite_section import Composite
from granwave.analysis.measures.chains.groups import columns


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
