"""Figures of preconditioned packings: dissipation, and forces along a chain, by the force that contacts once bore."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.series import legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.measures.signals import Array

_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_REACHED = 1e-3  # of the largest force along the chain: the pulse has come to a contact


def dissipation_by_level(levels: Sequence[tuple[float, Array, Array]]) -> Drawing:
    """Dissipation against the largest contact force.

    Parameters
    ----------
    levels
        Force that contacts were pressed to, N, 0: none; largest force, N, and per cent dissipated, (n_impacts,) each.
    """
    figure, axes = one_panel(2.7, "Largest contact force (N)", "Dissipated (% of input)")
    columns: dict[str, Array] = {}
    for place, (level, force, percent) in enumerate(levels):
        colour, label = _look(place, level)
        axes.semilogx(force, percent, "o-", color=colour, markersize=3, label=label)
        if level:
            axes.axvline(level, color=colour, linestyle=":", linewidth=0.8)
        columns |= {f"level_{level:g}_N_peak_force_N": force, f"level_{level:g}_N_dissipated_percent": percent}
    axes.set_ylim(-2, max(105.0, *(1.05 * percent.max() for _, _, percent in levels)))
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    legend_outside(figure, title="Preconditioned to")
    return Drawing(figure, columns)


def forces_by_level(levels: Sequence[tuple[float, Array]]) -> Drawing:
    """Largest forces of the contacts along a chain, (n_contacts,), N, by the force that they were pressed to, N."""
    figure, axes = one_panel(2.5, "Contact", "Largest force (N)")
    columns: dict[str, NDArray] = {}
    for place, (level, peaks) in enumerate(levels):
        contact = np.arange(1, len(peaks) + 1)
        colour, label = _look(place, level)
        axes.semilogy(contact, np.where(peaks > _REACHED * peaks.max(), peaks, np.nan), color=colour, label=label)
        columns |= {"contact": contact, f"level_{level:g}_N_peak_force_N": peaks}
    axes.set_xlim(left=0)
    legend_outside(figure, title="Preconditioned to")
    return Drawing(figure, columns)


def _look(place: int, level: float) -> tuple[str, str]:
    """Colour and label of a level."""
    return (_COLOURS[place % len(_COLOURS)], f"{level:g} N") if level else (GREY, "fresh")
