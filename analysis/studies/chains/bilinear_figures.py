"""Figures of bilinear chains after a short pulse (thesis Figs. 4.5 to 4.8)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.chains.scales import ChainScales

if TYPE_CHECKING:
    from granwave.analysis.studies.chains.bilinear_short import ShortPulse

FORCE = r"Force $F/E^*R^{*2}$"
VELOCITY = r"Velocity $v\,\tau/R^*$"
TIME = r"Time $t/\tau$"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)
_SHOWN = 9.3  # sqrt(k/m) t to which histories are shown: 150 tau for brass of R = 4.76 mm


def histories_drawing(pulse: ShortPulse) -> Drawing:
    """Forces of contacts 1 to 3 and velocities of beads 1 to 4."""
    run, scales = pulse.near, ChainScales(pulse.near)
    shown = pulse.spring.rate * run.time <= _SHOWN
    time = run.time[shown] / scales.time
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2)
    columns: dict[str, ArrayLike] = {"time_normalised": time}
    for n, colour in zip(range(min(3, run.force.shape[1])), COLOURS, strict=False):
        force = run.force[shown, n] / scales.force
        left.plot(time, force, color=colour, label=f"contact {n + 1}")
        columns[f"contact_{n + 1}_force_normalised"] = force
    for n, colour in zip(range(min(4, run.velocity.shape[1])), COLOURS, strict=False):
        velocity = run.velocity[shown, n] / scales.velocity
        right.plot(time, velocity, color=colour, label=f"bead {n + 1}")
        columns[f"bead_{n + 1}_velocity_normalised"] = velocity
    for axes, label in ((left, FORCE), (right, VELOCITY)):
        axes.set_xlim(0, time[-1])
        axes.set_ylim(bottom=0)
        axes.set_xlabel(TIME)
        axes.set_ylabel(label)
        axes.legend()
    return Drawing(figure, columns)


def peaks_drawing(pulses: Sequence[ShortPulse], middle: ShortPulse) -> Drawing:
    """Peak forces of the first contacts: of one beta with the profile of the wave, and of all with both models."""
    scale = ChainScales(middle.near).force
    figure = new_figure(2.9, 7.0)
    left, right = figure.subplots(1, 2, sharey=True)
    number = np.arange(1.0, middle.contacts + 1)
    fine = np.linspace(1.0, middle.contacts, 200)
    profile = middle.profile(2)[: middle.contacts] / scale
    left.bar(number, profile, width=0.5, color="#d9d9d9", label="wave when contact 2 peaks")
    first = middle.leading[0] / scale
    left.plot(fine, first * middle.model.printed(fine), color=ORANGE, label="4.28")
    left.plot(fine, first * middle.model.discrete(fine), ":", color=GREEN, label="balance by contacts")
    left.plot(number, middle.leading / scale, "o", color=BLUE, markersize=4, label="leading peak")
    left.set_title(rf"$\beta$ = {middle.beta:g}")
    left.set_ylabel(r"Peak force $F/E^*R^{*2}$")
    columns: dict[str, ArrayLike] = {"contact": number, "profile_when_contact_2_peaks": profile}
    for pulse, colour in zip(pulses, COLOURS, strict=False):
        scale = ChainScales(pulse.near).force
        number, fine = np.arange(1.0, pulse.contacts + 1), np.linspace(1.0, pulse.contacts, 200)
        largest, leading, first = (
            pulse.largest[: pulse.contacts] / scale,
            pulse.leading / scale,
            pulse.leading[0] / scale,
        )
        label = rf"$\beta$ = {pulse.beta:g}"
        right.plot(number[: len(largest)], largest, "o", color=colour, markersize=4, label=label)
        right.plot(fine, first * pulse.model.printed(fine), color=colour, linewidth=0.9)
        right.plot(fine, first * pulse.model.secondary(fine), "--", color=colour, linewidth=0.9)
        if pulse.transition is not None:
            right.plot(pulse.transition, 0, "v", color=colour, markersize=7, clip_on=False, zorder=5)
        columns |= {
            f"largest_force_beta_{pulse.beta:g}": largest,
            f"leading_peak_beta_{pulse.beta:g}": leading,
            f"model_4_28_beta_{pulse.beta:g}": first * pulse.model.printed(number),
            f"balance_by_contacts_beta_{pulse.beta:g}": first * pulse.model.discrete(number),
            f"secondary_4_31_beta_{pulse.beta:g}": first * pulse.model.secondary(number),
        }
    for axes in (left, right):
        axes.set_xlim(0.4, middle.contacts + 0.6)
        axes.set_ylim(0, 1.15 * first)
        axes.set_xlabel("Contact")
        axes.legend()
    right.set_title("Lines: 4.28; dashed: collisions; ▾: transition")
    return Drawing(figure, columns)


def far_drawing(pulses: Sequence[ShortPulse]) -> Drawing:
    """Peak force against distance of all, and velocities along the chain of the largest beta at three instants."""
    figure = new_figure(2.7, 7.0)
    left, right = figure.subplots(1, 2)
    columns: dict[str, ArrayLike] = {}
    for pulse, colour in zip(pulses, COLOURS, strict=False):
        if pulse.inverse is None:
            continue
        force = pulse.largest / ChainScales(pulse.far).force
        number = np.arange(1.0, len(force) + 1)
        reached = number < 0.95 * pulse.spring.rate * pulse.far.time[-1]
        left.plot(number[reached], force[reached], color=colour, linewidth=0.9,
                  label=rf"$\beta$ = {pulse.beta:g}, power {pulse.inverse.exponent:.2f}")  # fmt: skip
        columns |= {"contact": number, f"largest_force_beta_{pulse.beta:g}": force}
        anchor = float(force[49])
    guide = np.array([20.0, 320.0])
    left.plot(guide, 2 * anchor * (guide / 50) ** -1.0, "--", color="black", linewidth=0.9, label="power -1")
    left.set_xscale("log")
    left.set_yscale("log")
    left.set_xlabel("Contact")
    left.set_ylabel(r"Peak force $F/E^*R^{*2}$")
    left.legend()
    last = max((pulse for pulse in pulses if pulse.inverse), key=lambda pulse: pulse.beta)
    scale = ChainScales(last.far).velocity
    bead = np.arange(1, last.far.velocity.shape[1] + 1)
    columns["bead"] = bead
    for row, colour in zip(last.instants, COLOURS, strict=False):
        time, velocity = last.far.time[row], last.far.velocity[row] / scale
        right.plot(bead, velocity, color=colour, linewidth=0.8, label=f"{time * 1e3:.3g} ms")
        right.axhline(last.uniform(row)[2] / scale, color=colour, linestyle=":", linewidth=0.9)
        columns[f"velocity_at_{time:.4g}_s"] = velocity
    right.set_ylim(0, 1.6 * right.get_ylim()[1])
    right.set_xlabel("Bead")
    right.set_ylabel(VELOCITY)
    right.legend(title=rf"$\beta$ = {last.beta:g}; dotted: $I/nm$")
    return Drawing(figure, columns)
