"""Figures of confined rows: peak forces, speed and decay, resonances, velocities, and the asymptotic theory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, label, legend_outside, panels
from granwave.analysis.figures.style import GREY, Drawing
from granwave.analysis.measures.signals import Array

Curve = tuple[str, ArrayLike, ArrayLike]  # label, x, y
_FORCE = r"Peak force $F/(E^* R^{*2}) \times 10^4$"


def _columns(curves: Sequence[Curve], x: str, y: str, before: str = "") -> dict[str, ArrayLike]:
    found: dict[str, ArrayLike] = {}
    for words, first, second in curves:
        stem = column_name(f"{before} {words}")
        found |= {f"{stem}_{x}": first, f"{stem}_{y}": second}
    return found


def peak_forces(series: Mapping[str, Sequence[Curve]]) -> Drawing:
    """Peak force against contact, a panel for each ring, a curve for each precompression; forces over E* R*^2."""
    rows = (len(series) + 1) // 2
    figure, *axes = panels(0.5 + 2.1 * rows, min(len(series), 2), rows)
    columns: dict[str, ArrayLike] = {}
    for panel, (title, curves) in zip(axes, series.items(), strict=False):
        for words, contact, force in curves:
            panel.plot(contact, 1e4 * np.asarray(force), label=words)
        label(panel, "Contact", _FORCE, title=title, ylim=(0, None))
        panel.set_ylim(top=1.3 * panel.get_ylim()[1])  # room for the legend
        panel.legend(fontsize="small", ncols=2, loc="upper right")
        columns |= _columns(curves, "contact", "force", title)
    for panel in axes[len(series) :]:
        panel.set_axis_off()
    return Drawing(figure, columns)


def speeds(curves: Sequence[Curve], unit: float) -> Drawing:
    """Speed (m/s) against precompression, for each ring; ``unit``: m/s in the unit of the source, on the right axis."""
    figure, axes = panels(2.7)
    for (words, a, speed), mark in zip(curves, MARKS * 3, strict=False):
        axes.plot(1e3 * np.asarray(a), speed, f"{mark}-", label=words, markersize=4)
    label(axes, r"Precompression $a \times 10^3$", "Speed of the wave (m/s)")
    right = axes.secondary_yaxis("right", functions=(lambda v: v / unit, lambda v: v * unit))
    right.set_ylabel("in the source's unit")
    axes.legend(ncols=2, fontsize="small")
    return Drawing(figure, _columns(curves, "a", "speed_m_s"))


def decays(theory: Curve, runs: Curve, x: str, *, log: str = "", column: str = "x") -> Drawing:
    """Decay per contact against a property of the rows: the equations as a line, runs as points."""
    figure, axes = panels(2.6)
    axes.plot(theory[1], 1e3 * np.asarray(theory[2]), "-", color=GREY, label=theory[0])
    axes.plot(runs[1], 1e3 * np.asarray(runs[2]), "o", label=runs[0], markersize=4)
    label(axes, x, r"Decay per contact $\times 10^3$", log=log)
    axes.legend(fontsize="small")
    return Drawing(figure, _columns([theory, runs], column, "decay"))


def scaled_forces(curves: Sequence[Curve]) -> Drawing:
    """Peak force over v^(6/5) against contact, N (m/s)^-1.2."""
    figure, axes = panels(2.5)
    for (words, contact, force), look in zip(curves, ("-", "-.", "--", ":"), strict=False):
        axes.plot(contact, force, look, label=words)
    label(axes, "Contact", r"$F/v^{6/5}$ (N (m/s)$^{-1.2}$)", ylim=(0, None))
    axes.legend(fontsize="small")
    return Drawing(figure, _columns(curves, "contact", "force"))


def bead_velocities(curves: Sequence[Curve], shifts: Sequence[float]) -> Drawing:
    """Velocity of beads against time, in the source's units; some curves moved to the left."""
    figure, axes = panels(2.6, width=5.0)
    for (words, time, velocity), shift in zip(curves, shifts, strict=True):
        axes.plot(np.asarray(time) - shift, 1e5 * np.asarray(velocity), label=words, linewidth=0.9)
    label(axes, r"Time $\tau$, less the shift", r"Velocity $\times 10^5$", xlim=(-100, None))
    legend_outside(figure, 2)
    return Drawing(figure, _columns(curves, "time", "velocity"))


def travelling_waves(curves: Sequence[tuple[str, Array, Array, Array]]) -> Drawing:
    """Displacement of beads in travelling waves: label, z, the series, the lattice."""
    figure, axes = panels(2.5)
    columns: dict[str, ArrayLike] = {}
    for (words, z, series, lattice), colour in zip(curves, COLOURS, strict=False):
        axes.plot(z, series, "-", color=colour, label=f"series, {words}")
        axes.plot(z[::4], lattice[::4], "o", color=colour, markersize=3, label=f"lattice, {words}")
        stem = column_name(words)
        columns |= {f"{stem}_z": z, f"{stem}_series": series, f"{stem}_lattice": lattice}
    label(axes, "Distance from the crest, beads", "Displacement over A")
    axes.legend(fontsize="small")
    return Drawing(figure, columns)


def small_sphere_velocities(curves: Sequence[tuple[str, Array, Array, Array]]) -> Drawing:
    """First-order velocities of small spheres: label, time, axial, radial."""
    figure, left, right = panels(2.4, 2)
    columns: dict[str, ArrayLike] = {}
    for words, time, axial, radial in curves:
        near = (time > -2) & (time < 10)
        left.plot(time[near], axial[near], label=words, linewidth=0.9)
        right.plot(time[near], radial[near], linewidth=0.9)
        stem = column_name(words)
        columns |= {f"{stem}_time": time[near], f"{stem}_axial": axial[near], f"{stem}_radial": radial[near]}
    label(left, r"Time $\tau$", "Axial, first order")
    label(right, r"Time $\tau$", "Radial, first order")
    legend_outside(figure)
    return Drawing(figure, columns)


def decay_slopes(theory: Curve, runs: Curve) -> Drawing:
    """Decay per contact against the precompression over the wave's amplitude: energy by theory, force of runs."""
    figure, axes = panels(2.5)
    axes.plot(theory[1], theory[2], "-", color=GREY, label=theory[0])
    axes.plot(runs[1], runs[2], "o", label=runs[0], markersize=4)
    label(axes, r"$\hat\delta = 2\,\delta\tan\theta/A$", "Decay per contact", log="y")
    axes.legend(fontsize="small")
    return Drawing(figure, _columns([theory, runs], "delta_hat", "decay"))


def two_pulses(curves: Sequence[Curve]) -> Drawing:
    """Peak force against contact, N: first pulses as full lines, second ones, which follow them, as broken ones."""
    figure, axes = panels(2.8, width=4.4)
    for k, (words, contact, force) in enumerate(curves):
        look = f"{MARKS[k // 2 % len(MARKS)]}{'-' if k % 2 == 0 else '--'}"
        axes.plot(contact, force, look, color=COLOURS[k // 2 % len(COLOURS)], label=words, markersize=3.5)
    label(axes, "Contact", "Peak force (N)", log="y")
    legend_outside(figure, 2, fontsize="small")
    return Drawing(figure, _columns(curves, "contact", "force_N"))
