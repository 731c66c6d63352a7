"""Figure of what a row passes on of a load that oscillates: amplitudes along it, or transmission against frequency."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.analysis.measures.transmission import SteadyMotion, transmission_of
from granwave.analysis.result.reader import Result

_WIDE = 0.05  # smallest over largest ratio below which the axis is logarithmic


def transmission(result: Result) -> Drawing | None:
    """Draw the amplitudes along a chain under a harmonic load, or the transmission of a burst, a sweep or noise."""
    found = transmission_of(result)
    if found is None:
        return None
    figure, axes = panels(2.6)
    if isinstance(found, SteadyMotion):
        bead = np.arange(1, len(found.velocity) + 1)
        size = np.abs(found.velocity)
        axes.semilogy(bead, np.where(size > 0, size, np.nan), ".-", color=BLUE, markersize=3, linewidth=0.8)
        axes.axvspan(found.last + 0.5, len(size) + 0.5, color=GREY, alpha=0.2, linewidth=0)
        label(axes, "Bead, from the driven end", f"Velocity at {found.frequency:.4g} Hz (m/s)")
        axes.set_xlim(0.5, len(size) + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        columns = {"bead": bead, "velocity_amplitude_m_s": size, "phase_rad": np.angle(found.velocity)}
        return Drawing(figure, columns | {"left_by_fit": found.left})
    ratio = np.abs(found.ratio)
    axes.plot(found.frequency * 1e-3, ratio, color=BLUE, linewidth=0.8)
    label(axes, "Frequency (kHz)", f"Velocity of bead {found.last} over that of {found.first}")
    axes.axhline(1.0, color=GREY, linewidth=0.6)
    if ratio.min() < _WIDE * ratio.max():
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, None)
    columns = {"frequency_Hz": found.frequency, "ratio": np.abs(found.ratio), "phase_rad": np.angle(found.ratio)}
    return Drawing(figure, columns)
