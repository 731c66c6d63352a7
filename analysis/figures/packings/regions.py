"""Figures of struck square packings: energy by region, length and speed of the pulse along their chains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.series import column_name, legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, WIDTH, Drawing, new_figure
from granwave.analysis.measures.impact.regions import Array, Snapshots, groups, regions
from granwave.analysis.measures.waves.pulses import MEASURES, ChainSpeeds, last_length, speed_of, theory

_LEAST = 1e-3  # of the input: what a region must once have held to be shown
_COLOURS = {
    "central chains": BLUE, "edge chains": SKY, "struck spheres": ORANGE, "strikers": PURPLE,
    "other spheres": "black", "walls": GREY, "dissipated": GREEN,
}  # fmt: skip


def energies_by_region(seen: Snapshots) -> Drawing:
    """Share of the input in each region against time."""
    time = 1e6 * seen.time
    figure, axes = one_panel(2.6, "Time (µs)", "Energy (% of input)", xlim=(0, time[-1]), ylim=(0, 105))
    columns = {"time_s": seen.time}
    for region, share in regions(seen).items():
        columns[f"{region.replace(' ', '_')}_over_input"] = share
        if share.max() > _LEAST:
            axes.plot(time, 100 * share, color=_COLOURS[region], label=region)
    axes.legend(loc="upper right")
    for group, members in groups(seen).items():
        for chain in members:
            word = chain.name.replace(" ", "_").replace("+", "plus_").replace("-", "minus_")
            columns[f"{group.split()[0]}_{word}_over_input"] = seen.energy[:, chain.rows[1:]].sum(axis=1)
    return Drawing(figure, columns)


def energies_by_velocity(speed: Array, shares: Mapping[str, Array]) -> Drawing:
    """Share of the input that each region got, (n_runs,), against the velocity of the striker, m/s."""
    figure, axes = one_panel(2.4, "Velocity of the striker (m/s)", "Energy (% of input)", xscale="log", ylim=(0, 105))
    columns = {"striker_velocity_m_s": speed}
    colours = _COLOURS | {"edge chains": "black"}
    for region, share in shares.items():
        axes.plot(speed, 100 * share, "o-", markersize=3, color=colours[region], label=region)
        columns[f"{region.replace(' ', '_')}_over_input"] = share
    axes.legend(loc="center right")
    return Drawing(figure, columns)


def pulse_lengths(measured: Mapping[str, Mapping[str, Array]]) -> Drawing:
    """Length of the pulse along chains by four measures, with Nesterenko's.

    Parameters
    ----------
    measured
        By group of chains and by measure: (n_spheres,), diameters; see
        `granwave.analysis.measures.waves.pulses.lengths`.
    """
    figure = new_figure(3.4, 1.25 * WIDTH)
    panels = figure.subplots(2, 2, sharex=True)
    columns: dict[str, NDArray] = {}
    for group, found in measured.items():
        shown = np.arange(1, last_length(found) + 1)
        columns[f"{group.split()[0]}_sphere"] = shown + 1
        for axes, measure in zip(panels.ravel(), MEASURES, strict=True):
            values = found[measure][shown]
            axes.plot(shown + 1, values, "o-", color=_COLOURS[group], markersize=3, label=group)
            columns[f"{group.split()[0]}_{measure.replace(' ', '_')}_diameters"] = values
    for axes, measure in zip(panels.ravel(), MEASURES, strict=True):
        low, expected = min(line.get_ydata().min() for line in axes.lines), theory()[measure]
        axes.axhline(expected, color="black", linestyle=":", label="Nesterenko")
        axes.set(title=measure[0].upper() + measure[1:], ylim=(0.95 * low, 1.04 * expected))
    for axes in panels[1]:
        axes.set_xlabel("Sphere of the chain")
    for axes in panels[:, 0]:
        axes.set_ylabel("Length (diameters)")
    legend_outside(figure)
    return Drawing(figure, columns)


def wave_speeds(found: Sequence[ChainSpeeds]) -> Drawing:
    """Speed of the wave against the largest velocity of the particles in chains of several kinds, with the theory."""
    figure, axes = one_panel(2.8, "Largest particle velocity (m/s)", "Wave speed (m/s)")
    columns: dict[str, Array] = {}
    for one, marker, colour in zip(found, "osd", (BLUE, ORANGE, GREY), strict=False):
        label = f"{one.name}: {one.fit.exponent:.4f}"
        axes.loglog(one.velocity, one.speed, marker, color=colour, markersize=4, markerfacecolor="none", label=label)
        axes.loglog(one.velocity, one.fit(one.velocity), color=colour, linewidth=0.8)
        word = column_name(one.name)
        columns |= {f"{word}_peak_velocity_m_s": one.velocity, f"{word}_speed_m_s": one.speed}
    every = np.concatenate([one.velocity for one in found])
    line = np.geomspace(float(every.min()), float(every.max()), 20)
    axes.loglog(line, speed_of(found[-1].material, line), ":", color="black", label="Nesterenko: 1/5")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.5)
    axes.legend(loc="upper left")
    return Drawing(figure, columns)
