"""Figures of waves on precompressed chains and packings: speed and height against static load and impact velocity."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.series import one_panel
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, Drawing, new_figure
from granwave.analysis.measures.precompressed import loaded_line as theory
from granwave.analysis.measures.precompressed.line_waves import Wave
from granwave.analysis.measures.signals import Array, power

_MARKERS = {  # by kind of packing and of load
    ("fcc", "uniaxial"): ("o", BLUE, 7),
    ("hcp", "uniaxial"): ("s", ORANGE, 4),
    ("fcc", "uniform"): ("x", GREEN, 7),
    ("hcp", "uniform"): ("+", PURPLE, 7),
}


def small_pulse_speeds(force: Array, speed: Array, printed: Array) -> Drawing:
    """Speed of small pulses against the static force, N, with the speed c0 that the composite source prints, m/s."""
    figure, axes = one_panel(2.4, "Static force F0 (N)", "Speed of small pulses (m/s)")
    axes.loglog(force, printed, "-", color=GREY, label="c0 (composite 3)")
    label = f"simulation: power {power(force, speed).exponent:.4f}"
    axes.loglog(force, speed, "o", color=BLUE, markersize=4, label=label)
    axes.yaxis.set_minor_formatter(ScalarFormatter())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.legend(loc="upper left")
    return Drawing(figure, {"static_force_N": force, "speed_m_s": speed, "printed_m_s": printed})


def transition_speeds(waves: Sequence[Wave], uncompressed: float) -> Drawing:
    """Speed of the waves of one impact against the static force, with that in an uncompressed chain, m/s."""
    last = waves[-1]
    force, speed = np.array([(wave.static, wave.speed) for wave in waves]).T
    figure, axes = one_panel(2.6, "Static force F0 (N)", "Speed of the wave (m/s)")
    line = np.geomspace(force.min(), force.max(), 50)
    axes.loglog(line, last.c0 * (line / last.static) ** (1 / 6), "-", color=GREY, label="c0")
    axes.axhline(uncompressed, color=ORANGE, linestyle="--", label="uncompressed (composite 4)")
    axes.loglog(force, speed, "o", color=BLUE, markersize=4, label="simulation")
    axes.set_ylim(top=1.5 * speed.max())
    axes.legend(loc="upper left")
    columns = {"static_force_N": force, "speed_m_s": speed}
    columns |= {"force_ratio": [wave.ratio for wave in waves], "c0_m_s": [wave.c0 for wave in waves]}
    return Drawing(figure, columns)


def speeds_and_heights(waves: Sequence[Wave]) -> Drawing:
    """Speed against height of waves on one static force, and height against impact velocity, with their limits."""
    figure = new_figure(2.7, 6.6)
    left, right = figure.subplots(1, 2)
    left.set(xlabel=r"$f_r = F_m/F_0$", ylabel=r"Speed over $c_0$")
    right.set(xlabel=r"Impact velocity over $\omega\alpha_0$", ylabel=r"Crest $F_m/F_0 - 1$")
    x, ratio, speed = np.array([(wave.reduced_velocity, wave.ratio, wave.speed / wave.c0) for wave in waves]).T
    steady = np.array([wave.steady for wave in waves])
    line = np.geomspace(1, 1.5 * ratio.max(), 200)
    left.semilogx(line, theory.solitary_speed(line), "-", color=GREY, label="composite (3)")
    left.semilogx(line, theory.lattice_speed(line), ":", color="black", label="lattice")
    _points(left, ratio, speed, steady)
    fine = np.geomspace(x.min(), x.max(), 50)
    linear = 1.5 * float(theory.crest_force(np.array([waves[0].middle + 1]))[0])
    right.loglog(fine, linear * fine, ":", color=GREEN, label="linear chain")
    right.loglog(fine, theory.uncompressed_height(fine), "--", color=ORANGE, label="uncompressed: power 6/5")
    _points(right, x, ratio - 1, steady)
    columns = {
        "static_force_N": [wave.static for wave in waves],
        "impact_velocity_m_s": [wave.velocity for wave in waves],
        "reduced_velocity": x,
        "force_ratio": ratio,
        "speed_over_c0": speed,
        "solitary_over_c0": theory.solitary_speed(ratio),
        "lattice_over_c0": theory.lattice_speed(ratio),
        "steady": steady.astype(int),
    }
    return Drawing(figure, columns)


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


def _points(axes: Axes, x: Array, y: Array, steady: NDArray[np.bool_]) -> None:
    axes.plot(x[steady], y[steady], "o", color=BLUE, markersize=4, label="simulation")
    if not steady.all():
        (points,) = axes.plot(x[~steady], y[~steady], "o", color=BLUE, markersize=4, label="still spreading")
        points.set_markerfacecolor("white")
    axes.legend(loc="upper left")
