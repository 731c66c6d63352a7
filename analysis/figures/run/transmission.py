"""Figures of what a row passes on of a load that oscillates: along it, against frequency, and against amplitude."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, Drawing, legend_above
from granwave.analysis.measures.driven import MULTIPLES, SteadyMotion, amplitude_sweep_of, transmission_of
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
        if found.last < len(size):
            axes.axvspan(found.last + 0.5, len(size) + 0.5, color=GREY, alpha=0.2, linewidth=0)
            place = (found.last + 0.5 + (len(size) - found.last) / 2, 0.04)
            axes.text(*place, "absorbing", transform=axes.get_xaxis_transform(), ha="center", color=GREY)
        label(axes, "Bead, from the loaded end", f"Velocity at {found.frequency:.4g} Hz (m/s)")
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


def amplitude_sweep(result: Result) -> Drawing | None:
    """Draw the velocity of the last bead against the amplitude of the load, rising and falling."""
    found = amplitude_sweep_of(result)
    if found is None:
        return None
    scale, unit = (1.0, "N") if result.case.load.kind == "force" else (1e6, "µm")
    names = ("load's frequency", "twice", "three times", "half of it")
    figure, axes = panels(2.9)
    columns = {"load": found.load, "rising": found.rising.astype(int)}
    for number, (name, colour) in enumerate(zip(names, (BLUE, ORANGE, GREEN, PURPLE), strict=True)):
        for chosen, line in ((found.rising, "-"), (~found.rising, "--")):
            size = found.last[number][chosen]
            label_of = name if line == "-" else None
            axes.plot(found.load[chosen] * scale, size, line, color=colour, linewidth=0.9, label=label_of)
        columns[f"last_at_{MULTIPLES[number]:g}_f_m_s"] = found.last[number]
        columns[f"first_at_{MULTIPLES[number]:g}_f_m_s"] = found.first[number]
    label(axes, f"Amplitude of the load ({unit}), dashed: falling", "Velocity of the last bead (m/s)")
    axes.set_xlim(0, None)
    axes.set_yscale("log")
    legend_above(axes, 2)
    return Drawing(figure, columns)
