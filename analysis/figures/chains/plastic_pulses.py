"""Figures of elasto-plastic chains after a pulse: force histories, map, peak forces, speeds and dissipation."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike

from granwave.analysis.figures.chains.labels import FORCE, PEAK_FORCE, PLACE, TIME
from granwave.analysis.figures.series import COLOURS, label, map_of_forces, panels
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.measures.chains import elastoplastic_model as model
from granwave.analysis.measures.chains.elastoplastic_pulse import PlasticWave, Pulses

_STACK = (20, 15, 10, 5)  # contacts of Fig. 2.11, from the top
_SHOWN = 500  # tau of Fig. 2.11
_SHIFT = 20  # contacts by which the elastic chain is moved in the map
_MAP = 90  # contacts of the map
_FAINTEST = 3e-3  # of the largest force: the lower end of the map's colours


def histories(elastic: PlasticWave, plastic: PlasticWave) -> Drawing:
    """Force histories at four contacts of both chains."""
    figure, *stack = panels(4.2, rows=len(_STACK), sharex=True)
    waves = {"elastoplastic": plastic, "elastic": elastic}
    shown = {name: wave.time <= _SHOWN * wave.scales.time for name, wave in waves.items()}
    data: dict[str, ArrayLike] = {}
    data |= {f"{name}_time_normalised": wave.time[shown[name]] / wave.scales.time for name, wave in waves.items()}
    for axes, contact in zip(stack, _STACK, strict=True):
        sides = ((axes, BLUE, "-"), (axes.twinx(), ORANGE, ":"))
        for (side, colour, line), (name, wave) in zip(sides, waves.items(), strict=True):
            force = wave.force[shown[name], contact - 1] / wave.scales.force
            side.plot(data[f"{name}_time_normalised"], force, line, color=colour)
            side.set_ylim(0, 1.25 * float(wave.largest[_STACK[-1] - 1]) / wave.scales.force)
            side.tick_params(colors=colour, axis="y", right=side is not axes)
            data[f"{name}_contact_{contact}_force_normalised"] = force
        axes.text(0.98, 0.8, f"contact {contact}", transform=axes.transAxes, ha="right")
    label(stack[-1], TIME, xlim=(0, _SHOWN))
    figure.supylabel(r"Elasto-plastic $F/E^*R^{*2}$  (elastic, dotted: right)", fontsize=8)
    return Drawing(figure, data)


def force_map(elastic: PlasticWave, plastic: PlasticWave) -> Drawing:
    """Force of the elasto-plastic chain by place and time, and the crest of the elastic one, moved."""
    n = min(_MAP, plastic.force.shape[1])
    last = int(np.searchsorted(plastic.time, plastic.arrivals[min(n, plastic.contacts) - 1]))
    shown = slice(0, last, max(1, last // 600))
    force, time = plastic.force[shown, :n].T / plastic.scales.force, plastic.time[shown] / plastic.scales.time
    place = model.SPACING * np.arange(1, n + 1)
    figure, axes = panels(2.8, width=4.6)
    image = map_of_forces(axes, time, place, np.maximum(force, 1e-30), _FAINTEST)
    beyond = min(n - _SHIFT, elastic.contacts)
    crest = elastic.run.of_contacts("time_peak")[:beyond] / elastic.scales.time
    moved = elastic.place[:beyond] + model.SPACING * _SHIFT
    axes.plot(crest, moved, color=ORANGE, label=f"crest of the elastic wave, moved by {_SHIFT} contacts")
    label(axes, TIME, PLACE, xlim=(0, time[-1]), ylim=(place[0], place[-1]))
    axes.legend(loc="lower right", labelcolor="white", fontsize=7)
    figure.colorbar(image, ax=axes, label=FORCE, extend="min")
    return Drawing(figure, {"elastic_crest_time_normalised": crest, "elastic_crest_place_normalised": moved})


def peaks(pulses: Pulses, *, with_model: bool) -> Drawing:
    """Peak force over impulse: one pulse of every impulse with the source's two laws, and all pulses."""
    figure, left, right = panels(2.9, 2)
    contact = np.arange(1.0, pulses.contacts + 1)
    data: dict[str, ArrayLike] = {"contact": contact}
    for wave in pulses.chosen:
        left.plot(wave.place, wave.normalised, ".", markersize=4, label=_label(wave))
    if with_model:
        data["model"] = model.peak_force(contact)
        early, late = contact[contact <= 12], model.SPACING * contact[contact >= 4]
        exponential = model.START * np.exp(-model.DECAY * (early - 1))
        left.plot(model.SPACING * early, exponential, "k--", label="2.25 by contact")
        left.plot(late, model.INVERSE / late, "k-", label="2.26")
    for n, (group, colour) in enumerate(zip(pulses.groups, COLOURS, strict=False)):
        for wave, line in zip(group, ("-", "--", ":", "-."), strict=False):
            data[f"peak_force_normalised_{wave.name}"] = force = wave.largest / wave.scales.force
            right.plot(wave.place, force * 4.0**-n, line, color=colour, linewidth=0.9, label=wave.name)
    factor = r" (each impulse $\times 1/4$ of the last)" if len(pulses.groups) > 1 else ""
    label(left, PLACE, r"Peak force $F/(E^*R^{*2}\,\bar I)$", log="y", xlim=(0, 160), ylim=(5e-4, 1e-1))
    label(right, PLACE, f"{PEAK_FORCE}, moved", log="y", title=f"All pulses{factor}")
    left.legend(fontsize=7)
    right.legend(fontsize=6, ncols=2)
    return Drawing(figure, data)


def speeds(pulses: Pulses) -> Drawing:
    """Leading speed over the sixth root of the impulse against distance, on logarithmic axes."""
    figure, axes = panels(2.8)
    data: dict[str, ArrayLike] = {}
    for group, colour in zip(pulses.groups, COLOURS, strict=False):
        for wave in group:
            place, speed = wave.speed_normalised
            data[f"place_{wave.name}"], data[f"scaled_speed_{wave.name}"] = place, speed / wave.impulse ** (1 / 6)
            strong = wave in pulses.chosen
            axes.plot(place, speed / wave.impulse ** (1 / 6), color=colour, linewidth=1.2 if strong else 0.6,
                      label=_label(wave) if strong else None)  # fmt: skip
    guide = model.SPACING * np.array([8.0, 0.95 * pulses.contacts])
    axes.plot(guide, 0.29 * (guide / guide[0]) ** -0.2, "k--", label="power -1/5")
    label(axes, PLACE, r"Leading speed $(v\,\tau/R^*)\,/\,\bar I^{1/6}$", log="xy", xticks=(20, 50, 100, 200))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.legend(fontsize=7)
    return Drawing(figure, data)


def dissipation(pulses: Pulses, *, with_model: bool) -> Drawing:
    """Dissipation up to each contact, with the model where its constants belong to the beads."""
    figure, axes = panels(2.8)
    data: dict[str, ArrayLike] = {}
    models = (("sum", "--", model.summed_dissipation), ("integral", ":", model.integrated_dissipation))
    for wave, colour in zip(pulses.chosen, COLOURS, strict=False):
        data[f"place_{wave.name}"] = wave.place
        data[f"dissipated_over_yield_{wave.name}"] = lost = wave.dissipated / wave.energy_unit
        axes.plot(wave.place, lost, color=colour, label=_label(wave))
        for name, line, curve in models if with_model else ():
            data[f"model_{name}_{wave.name}"] = values = curve(wave.contacts, wave.peak_unit) / wave.energy_unit
            entry = f"model, {name}" if wave is pulses.chosen[0] else None
            axes.plot(wave.place, values, line, color=colour, label=entry)
    label(axes, PLACE, r"Dissipated $E/F_\mathrm{y}\alpha_\mathrm{y}$", xlim=(0, None), ylim=(0, None))
    axes.legend(fontsize=7)
    return Drawing(figure, data)


def _label(wave: PlasticWave) -> str:
    return rf"$\bar I$ = {wave.impulse:.3g}"
