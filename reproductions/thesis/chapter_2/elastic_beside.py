"""Elasto-plastic and elastic chain under the same pulse.

A pulse of 20 kN within 10 us acts on the first bead of two chains, with the elasto-plastic law and
with Hertz's law.
"""

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from plastic_waves import PLACE, SPACING, PlasticWave, groups, usual

import granwave as gw

CONTACT = 20  # contact at which the elastic wave is evaluated
STACK = (20, 15, 10, 5)  # contacts of Fig. 2.11, from the top
SHOWN = 500  # tau of Fig. 2.11
# contacts of the map; shift of the elastic chain in it
MAP = 90
SHIFT = 20
FORCE = r"Force $F/E^*R^{*2}$"
TIME = r"Time $t/\tau$"


def pair(runs):
    """The elastic chain, and the elasto-plastic chain under the same pulse."""
    return next(PlasticWave(run) for run in runs if run.case.contact.law == "hertz"), usual(
        groups(runs)[0]
    )


def rows(runs):
    wave, _ = pair(runs)
    yield gw.Row(
        f"Elastic chain, {wave.name}: peak force at contact {CONTACT} / (E*R*^2)", where="thesis Fig. 2.11",
        ours=wave.largest[CONTACT - 1] / wave.scales.force, theory=0.719 * (3 / 128) ** 0.6 * wave.reduced**1.2,
        remark="Theory: thesis 4.5 for an impulse. Bead 2 already moves during this pulse.",
    )  # fmt: skip


def pictures(runs):
    elastic, plastic = pair(runs)
    waves = {"elastoplastic": (plastic, "-C0"), "elastic": (elastic, ":C1")}
    figure = Figure((3.5, 4.2), layout="constrained")
    data = {}
    stack = figure.subplots(len(STACK), sharex=True)
    for name, (wave, _) in waves.items():
        time = wave.time / wave.scales.time
        data[f"{name}_time_normalised"] = time[time <= SHOWN]
    for axes, contact in zip(stack, STACK, strict=True):
        for side, (name, (wave, style)) in zip((axes, axes.twinx()), waves.items(), strict=True):
            time = data[f"{name}_time_normalised"]
            force = wave.force[: len(time), contact - 1] / wave.scales.force
            data[f"{name}_contact_{contact}_force_normalised"] = force
            side.plot(time, force, style)
            side.set_ylim(0, 1.25 * wave.largest[STACK[-1] - 1] / wave.scales.force)
            side.tick_params(colors=style[1:], axis="y", right=side is not axes)
        axes.text(0.98, 0.8, f"contact {contact}", transform=axes.transAxes, ha="right")
    stack[-1].set(xlabel=TIME, xlim=(0, SHOWN))
    figure.supylabel(r"Elasto-plastic $F/E^*R^{*2}$  (elastic, dotted: right)", fontsize=8)
    caption = (
        "Force of four contacts against time: elasto-plastic chain, and elastic chain under the "
        "same pulse (dotted, right-hand axis; thesis Fig. 2.11). Where contacts yield, the wave "
        "is slower and smaller, and splits into many"
    )
    yield gw.Picture("elastoplastic_histories", caption, figure, data)

    scales = plastic.scales
    place = SPACING * np.arange(1, MAP + 1)
    last = np.flatnonzero(plastic.force[:, MAP - 1] >= 0.01 * plastic.peak_force[MAP - 1])[0]
    step = slice(0, last, max(1, last // 600))
    force = plastic.force[step, :MAP].T / scales.force
    time = plastic.time[step] / scales.time
    axes = Figure((4.6, 2.8), layout="constrained").subplots()
    norm = LogNorm(3e-3 * force.max(), force.max(), clip=True)
    image = axes.pcolormesh(
        time, place, np.maximum(force, 1e-30), norm=norm, rasterized=True, shading="nearest"
    )
    crest = elastic.of_contacts("time_peak")[: MAP - SHIFT] / scales.time
    moved = elastic.x[: MAP - SHIFT] + SPACING * SHIFT
    axes.plot(crest, moved, "C1", label=f"crest of the elastic wave, moved by {SHIFT} contacts")
    axes.set(xlabel=TIME, ylabel=PLACE, xlim=(0, time[-1]), ylim=(place[0], place[-1]))
    axes.legend(loc="lower right", labelcolor="white", fontsize=7)
    axes.figure.colorbar(image, ax=axes, label=FORCE, extend="min")
    data = {"elastic_crest_time_normalised": crest, "elastic_crest_place_normalised": moved}
    caption = (
        "Force against position and time in the elasto-plastic chain (thesis Fig. 2.12). The "
        "front bends because it slows down; the elastic crest, shown shifted, is straight and "
        "steeper"
    )
    yield gw.Picture("elastoplastic_map", caption, axes.figure, data)
