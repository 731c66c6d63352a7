"""Density of states, participation and transmission of finite packings."""

from __future__ import annotations

from typing import Any

import numpy as np

from granwave.analysis.figures.series import COLOURS, one_panel
from granwave.analysis.figures.style import BLUE, Drawing, legend_above
from granwave.analysis.spectra.bands import Gap, Modes
from granwave.analysis.spectra.transmission import Transmission

_KILO = 1e-3


def density_of_states(modes: Modes) -> Drawing:
    """Draw the density of states."""
    figure, axes = one_panel(2.2, "Frequency (kHz)", "Density of states (1/kHz)", xlim=(0, None))
    axes.fill_between(_KILO * modes.density_frequency, modes.density / _KILO, color=BLUE, alpha=0.3, lw=0)
    axes.plot(_KILO * modes.density_frequency, modes.density / _KILO, color=BLUE)
    axes.set_xlim(0, _KILO * float(modes.density_frequency[-1]))
    axes.set_ylim(0, None)
    return Drawing(figure, {"frequency_Hz": modes.density_frequency, "density_per_Hz": modes.density})


def participation(modes: Modes) -> Drawing:
    """Draw the participation ratios of the modes."""
    figure, axes = one_panel(2.2, "Frequency (kHz)", "Participation ratio", ylim=(0, 1.05))
    axes.plot(_KILO * modes.frequency, modes.participation, "o", ms=2, color=BLUE)
    axes.set_xlim(0, None)
    return Drawing(figure, {"frequency_Hz": modes.frequency, "participation_ratio": modes.participation})


def transmission_curve(found: Transmission, gaps: tuple[Gap, ...] = ()) -> Drawing:
    """Draw the ratios of amplitudes against frequency, with gaps of the bands shaded where they are known."""
    figure, axes = one_panel(2.4, "Frequency (kHz)", "Amplitude over that of the drive", yscale="log")
    for gap in gaps:
        high = min(gap.high, float(found.frequency[-1]))
        if high > gap.low:
            axes.axvspan(_KILO * gap.low, _KILO * high, color="0.9", lw=0, zorder=0)
    for sensor, one, colour in zip(found.sensors, found.amplitude.T, COLOURS * len(found.sensors), strict=False):
        axes.plot(_KILO * found.frequency, np.maximum(one, 1e-300), color=colour, label=f"grain {sensor}")
    axes.set_xlim(_KILO * float(found.frequency[0]), max(_KILO * float(found.frequency[-1]), 1e-9))
    largest = float(found.amplitude.max())
    axes.set_ylim(max(float(found.amplitude.min()) / 2, 1e-12 * largest), 2 * largest)
    legend_above(axes, min(len(found.sensors), 4))
    columns: dict[str, Any] = {"frequency_Hz": found.frequency}
    for n, sensor in enumerate(found.sensors):
        columns |= {f"amplitude_{sensor}": found.amplitude[:, n], f"phase_{sensor}_rad": found.phase[:, n]}
    return Drawing(figure, columns)
