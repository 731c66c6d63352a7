"""Figures of chains under an oscillating load: amplitudes, transmission, sweep of the amplitude."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from granwave.analysis.figures.series import (
    COLOURS,
    label,
    panels,
)
from granwave.analysis.figures.style import (
    BLUE,
    GREY,
    Drawing,
    legend_above,
)
from granwave.analysis.measures.driven import (
    MULTIPLES,
    SteadyMotion,
    amplitude_sweep_of,
    transmission_of,
)
from granwave.analysis.result.reader import Result

_WIDE = 0.05  # smallest / largest amplitude below which the axis is logarithmic


def transmission(result: Result) -> Drawing | None:
    """Draw the amplitudes along a chain under a harmonic load, or the transmission of a burst, a
    sweep or noise.
    """
    response = transmission_of(result)
    if response is None:
        return None
    figure, axes = panels(2.6)
    if isinstance(response, SteadyMotion):
        bead = np.arange(1, len(response.velocity) + 1)
        size = np.abs(response.velocity)
        axes.semilogy(
            bead, np.where(size > 0, size, np.nan), ".-", color=BLUE, markersize=3, linewidth=0.8
        )
        if response.last < len(size):
            axes.axvspan(response.last + 0.5, len(size) + 0.5, color=GREY, alpha=0.2, linewidth=0)
            place = (response.last + 0.5 + (len(size) - response.last) / 2, 0.04)
            axes.text(
                *place, "absorbing", transform=axes.get_xaxis_transform(), ha="center", color=GREY
            )
        label(axes, "Bead, from the loaded end", f"Velocity at {response.frequency:.4g} Hz (m/s)")
        axes.set_xlim(0.5, len(size) + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        columns = {
            "bead": bead,
            "velocity_amplitude_m_s": size,
            "phase_rad": np.angle(response.velocity),
        }
        return Drawing(figure, columns | {"left_by_fit": response.left})
    ratio = np.abs(response.ratio)
    axes.plot(response.frequency * 1e-3, ratio, color=BLUE, linewidth=0.8)
    label(
        axes,
        "Frequency (kHz)",
        f"Velocity ratio, bead {response.last} / bead {response.first}",
    )
    axes.axhline(1.0, color=GREY, linewidth=0.6)
    axes.set(**({"yscale": "log"} if ratio.min() < _WIDE * ratio.max() else {"ylim": (0, None)}))
    columns = {
        "frequency_Hz": response.frequency,
        "ratio": np.abs(response.ratio),
        "phase_rad": np.angle(response.ratio),
    }
    return Drawing(figure, columns)


def amplitude_sweep(result: Result) -> Drawing | None:
    """Draw the velocity of the last bead against the amplitude of the load, rising and falling."""
    sweep = amplitude_sweep_of(result)
    if sweep is None:
        return None
    scale, unit = result.case.load.shown_amplitude
    names = ("load's frequency", "twice", "three times", "half of it")
    figure, axes = panels(2.9)
    columns = {"load": sweep.load, "rising": sweep.rising.astype(int)}
    for number, name in enumerate(names):
        look: Any = {"color": COLOURS[number], "linewidth": 0.9}
        for chosen, line, called in ((sweep.rising, "-", name), (~sweep.rising, "--", None)):
            axes.plot(
                sweep.load[chosen] * scale, sweep.last[number][chosen], line, label=called, **look
            )
        columns[f"last_at_{MULTIPLES[number]:g}_f_m_s"] = sweep.last[number]
        columns[f"first_at_{MULTIPLES[number]:g}_f_m_s"] = sweep.first[number]
    label(
        axes,
        f"Load amplitude ({unit}; dashed: falling)",
        "Velocity of the last bead (m/s)",
        log="y",
    )
    axes.set_xlim(0, None)
    legend_above(axes, 2)
    return Drawing(figure, columns)
