"""Figures of elasto-plastic chains after pulses (thesis Figs. 2.11 to 2.16)."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter
from numpy.typing import ArrayLike

from granwave.analysis.figures.style import BLUE, FORCE_MAP, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.chains.elastoplastic import Pulses, Wave
from granwave.analysis.studies.chains.elastoplastic_model import (
    DECAY,
    INVERSE,
    SPACING,
    START,
    integrated_dissipation,
    model_dissipation,
    model_force,
)

PLACE = r"Distance $x/R^*$"
TIME = r"Time $t/\tau$"
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
_LINES = ("-", "--", ":", "-.")
_STACK = (20, 15, 10, 5)  # contacts of Fig. 2.11, from the top
_SHOWN = 500  # tau of Fig. 2.11
_SHIFT = 20  # contacts by which the elastic chain is moved in the map
_MAP = 90  # contacts of the map
_FAINTEST = 3e-3  # of the largest force: the lower end of the map's colours


def histories(elastic: Wave, plastic: Wave) -> Drawing:
    """Force histories at four contacts of both chains."""
    figure = new_figure(4.2)
    stack = figure.subplots(len(_STACK), 1, sharex=True)
    columns: dict[str, ArrayLike] = {}
    chains = (("elastoplastic", plastic), ("elastic", elastic))
    shown = {name: wave.run.time <= _SHOWN * wave.scales.time for name, wave in chains}
    for name, wave in chains:
        columns[f"{name}_time_normalised"] = wave.run.time[shown[name]] / wave.scales.time
    for axes, contact in zip(stack, _STACK, strict=True):
        right = axes.twinx()
        for (name, wave), place, colour, line in zip(chains, (axes, right), (BLUE, ORANGE), ("-", ":"), strict=True):
            force = wave.run.force[shown[name], contact - 1] / wave.scales.force
            place.plot(columns[f"{name}_time_normalised"], force, line, color=colour, linewidth=1.0)
            columns[f"{name}_contact_{contact}_force_normalised"] = force
        axes.set_ylim(0, 1.25 * float(plastic.largest[_STACK[-1] - 1]) / plastic.scales.force)
        right.set_ylim(0, 1.25 * float(elastic.largest[_STACK[-1] - 1]) / elastic.scales.force)
        axes.text(0.98, 0.8, f"contact {contact}", transform=axes.transAxes, ha="right")
        axes.tick_params(right=False, colors=BLUE, axis="y")
        right.tick_params(colors=ORANGE, axis="y")
    stack[-1].set_xlim(0, _SHOWN)
    stack[-1].set_xlabel(TIME)
    figure.supylabel(r"Elasto-plastic $F/E^*R^{*2}$  (elastic, dotted: right)", fontsize=8)
    return Drawing(figure, columns)


def force_map(elastic: Wave, plastic: Wave) -> Drawing:
    """Force of the elasto-plastic chain by place and time, and the crest of the elastic one, moved."""
    run, scales = plastic.run, plastic.scales
    n = min(_MAP, run.force.shape[1])
    last = np.searchsorted(run.time, plastic.arrivals[: plastic.contacts][min(n, plastic.contacts) - 1])
    rows = slice(0, int(last), max(1, int(last) // 600))
    force = run.force[rows, :n].T / scales.force
    time, place = run.time[rows] / scales.time, SPACING * np.arange(1, n + 1)
    figure = new_figure(2.8, 4.6)
    axes = figure.subplots()
    top = float(force.max())
    image = axes.pcolormesh(time, place, np.maximum(force, 1e-30), cmap=FORCE_MAP, rasterized=True, shading="nearest",
                            norm=LogNorm(_FAINTEST * top, top, clip=True))  # fmt: skip
    beyond = min(n - _SHIFT, elastic.contacts)
    crest = elastic.run.of_contacts("time_peak")[:beyond] / elastic.scales.time
    moved = SPACING * (np.arange(1, beyond + 1) + _SHIFT)
    axes.plot(crest, moved, color=ORANGE, linewidth=1.4, label=f"crest of the elastic wave, moved by {_SHIFT} contacts")
    axes.set_xlim(0, time[-1])
    axes.set_ylim(place[0], place[-1])
    axes.set_xlabel(TIME)
    axes.set_ylabel(PLACE)
    axes.legend(loc="lower right", labelcolor="white", fontsize=7)
    figure.colorbar(image, ax=axes, label=r"Force $F/E^*R^{*2}$", extend="min")
    return Drawing(figure, {"elastic_crest_time_normalised": crest, "elastic_crest_place_normalised": moved})


def peaks(pulses: Pulses) -> Drawing:
    """Peak force over impulse: one pulse of every impulse with the source's two laws, and all pulses."""
    figure = new_figure(2.9, 7.0)
    left, right = figure.subplots(1, 2)
    contact = np.arange(1.0, pulses.contacts + 1)
    columns: dict[str, ArrayLike] = {"contact": contact}
    if pulses.from_source:
        columns["model"] = model_force(contact)
    for wave, colour in zip(pulses.chosen, _COLOURS, strict=False):
        left.plot(SPACING * wave.number, wave.normalised, ".", color=colour, markersize=4, label=_label(wave))
    early, late = contact[contact <= 12], contact[contact >= 4]
    laws = (
        (early, START * np.exp(-DECAY * (early - 1)), "--", "2.25 by contact"),
        (late, INVERSE / (SPACING * late), "-", "2.26"),
    )
    for place, law, line, label in laws if pulses.from_source else ():
        left.plot(SPACING * place, law, line, color="black", linewidth=0.9, label=label)
    left.set_xlim(0, 160)
    for n, (group, colour) in enumerate(zip(pulses.groups, _COLOURS, strict=False)):
        for wave, line in zip(group, _LINES, strict=False):
            force = wave.largest / wave.scales.force
            right.plot(
                SPACING * wave.number, force * 4.0**-n, linestyle=line, color=colour, linewidth=0.9, label=wave.name
            )
            columns[f"peak_force_normalised_{wave.name}"] = force
    factor = r" (each impulse $\times 1/4$ of the last)" if len(pulses.groups) > 1 else ""
    right.set_title(f"All pulses{factor}")
    right.set_ylabel(r"Peak force $F/E^*R^{*2}$, moved")
    left.set_ylabel(r"Peak force $F/(E^*R^{*2}\,\bar I)$")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.set_xlabel(PLACE)
    left.set_ylim(5e-4, 1e-1)
    left.legend(fontsize=7)
    right.legend(fontsize=6, ncols=2)
    return Drawing(figure, columns)


def speeds(pulses: Pulses) -> Drawing:
    """Leading speed over the sixth root of the impulse against distance, on logarithmic axes."""
    figure = new_figure(2.8)
    axes = figure.subplots()
    columns: dict[str, ArrayLike] = {}
    for group, chosen, colour in zip(pulses.groups, pulses.chosen, _COLOURS, strict=False):
        for wave in group:
            number, speed = wave.speed
            scaled = speed / wave.impulse ** (1 / 6)
            axes.plot(SPACING * number, scaled, color=colour, linewidth=1.2 if wave is chosen else 0.6,
                      alpha=1 if wave is chosen else 0.6, label=_label(wave) if wave is chosen else None)  # fmt: skip
            columns |= {f"place_{wave.name}": SPACING * number, f"scaled_speed_{wave.name}": scaled}
    guide = SPACING * np.array([8.0, 0.95 * pulses.contacts])
    axes.plot(guide, 0.29 * (guide / guide[0]) ** -0.2, "--", color="black", linewidth=0.9, label="power -1/5")
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis, ticks in ((axes.xaxis, (20, 50, 100, 200, 400)), (axes.yaxis, (0.15, 0.2, 0.25, 0.3, 0.35))):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_locator(NullLocator())
    axes.set_xlabel(PLACE)
    axes.set_ylabel(r"Leading speed $(v\,\tau/R^*)\,/\,\bar I^{1/6}$")
    axes.legend(fontsize=7)
    return Drawing(figure, columns)


def dissipation(pulses: Pulses) -> Drawing:
    """Dissipation up to each contact, with the model where its constants belong to the beads."""
    figure = new_figure(2.8)
    axes = figure.subplots()
    columns: dict[str, ArrayLike] = {}
    for wave, colour in zip(pulses.chosen, _COLOURS, strict=False):
        lost = wave.dissipated / wave.energy_unit
        axes.plot(SPACING * wave.number, lost, color=colour, label=_label(wave))
        columns |= {f"place_{wave.name}": SPACING * wave.number, f"dissipated_over_yield_{wave.name}": lost}
        if pulses.from_source:
            for name, line, model in (("sum", "--", model_dissipation), ("integral", ":", integrated_dissipation)):
                values = model(wave.contacts, wave.peak_unit) / wave.energy_unit
                label = f"model, {name}" if wave is pulses.chosen[0] else None
                axes.plot(SPACING * wave.number, values, line, color=colour, linewidth=0.9, label=label)
                columns[f"model_{name}_{wave.name}"] = values
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(PLACE)
    axes.set_ylabel(r"Dissipated $E/F_\mathrm{y}\alpha_\mathrm{y}$")
    axes.legend(fontsize=7)
    return Drawing(figure, columns)


def _label(wave: Wave) -> str:
    return rf"$\bar I$ = {wave.impulse:.3g}"
