"""Figures of waves on precompressed chains and packings: speed and height against static load and impact velocity."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from granwave.analysis.figures.series import one_panel
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, Drawing
from granwave.analysis.measures.signals import Array

_MARKERS = {  # by kind of packing and of load
    ("fcc", "uniaxial"): ("o", BLUE, 7),
    ("hcp", "uniaxial"): ("s", ORANGE, 4),
    ("fcc", "uniform"): ("x", GREEN, 7),
    ("hcp", "uniform"): ("+", PURPLE, 7),
}


def small_wave_speeds(series: Iterable[tuple[tuple[str, str], Array, Array, Array]]) -> Drawing:
    """Speed of small waves in packings against pressure.

    Parameters
    ----------
    series
        Kinds of packing and load; pressure, Pa, speed and that by theory, m/s, (n_runs,) each.
    """
    figure, axes = one_panel(2.6, "Pressure (Pa)", "Speed of small waves (m/s)")
    columns: dict[str, Array] = {}
    for where, pressure, speed, theirs in series:
        axes.loglog(pressure, theirs, "-", color=GREY)
        marker, colour, size = _MARKERS[where]
        look: dict[str, Any] = {"color": colour, "markersize": size, "markerfacecolor": "none"}
        axes.loglog(pressure, speed, marker, label=", ".join(where), **look)
        word = "_".join(where)
        columns |= {f"{word}_pressure_Pa": pressure, f"{word}_speed_m_s": speed, f"{word}_theory_m_s": theirs}
    axes.plot([], [], "-", color=GREY, label="theory")
    axes.legend(loc="upper left")
    return Drawing(figure, columns)
