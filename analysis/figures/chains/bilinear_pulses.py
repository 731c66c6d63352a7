"""Figures of bilinear chains after a short pulse: first contacts, peak forces, and far down the chain."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.chains.labels import FORCE, PEAK_FORCE, TIME, VELOCITY
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, Drawing
from granwave.analysis.measures.chains.bilinear_pulse import ShortPulse

_SHOWN = 9.3  # sqrt(k/m) t to which histories are shown: 150 tau for brass of R = 4.76 mm


def histories(pulse: ShortPulse) -> Drawing:
    """Forces of contacts 1 to 3 and velocities of beads 1 to 4."""
    run, scales = pulse.near, pulse.near.scales
    shown = pulse.spring.rate * run.time <= _SHOWN
    time = run.time[shown] / scales.time
    figure, left, right = panels(2.6, 2)
    data: dict[str, ArrayLike] = {"time_normalised": time}
    for axes, values, what, quantity, unit in (
        (left, run.force[shown, :3] / scales.force, "contact", "force", FORCE),
        (right, run.velocity[shown, :4] / scales.velocity, "bead", "velocity", VELOCITY),
    ):
        for n, one in enumerate(values.T, start=1):
            axes.plot(time, one, label=f"{what} {n}")
            data[f"{what}_{n}_{quantity}_normalised"] = one
        label(axes, TIME, unit, xlim=(0, time[-1]), ylim=(0, None))
        axes.legend()
    return Drawing(figure, data)


def peaks(pulses: Sequence[ShortPulse], middle: ShortPulse) -> Drawing:
    """Peak forces of the first contacts: of one beta with the profile of the wave, and of all with both models."""
    figure, left, right = panels(2.9, 2, sharey=True)
    scale, number = middle.near.scales.force, np.arange(1.0, middle.contacts + 1)
    profile, leading = middle.profile(2)[: middle.contacts] / scale, middle.leading / scale
    fine = np.linspace(1.0, middle.contacts, 200)
    left.bar(number, profile, width=0.5, color="#d9d9d9", label="wave when contact 2 peaks")
    left.plot(fine, leading[0] * middle.model.printed(fine), color=ORANGE, label="4.28")
    left.plot(fine, leading[0] * middle.model.discrete(fine), ":", color=GREEN, label="balance by contacts")
    left.plot(number, leading, "o", color=BLUE, markersize=4, label="leading peak")
    data: dict[str, ArrayLike] = {"contact": number, "profile_when_contact_2_peaks": profile}
    for pulse in pulses:
        scale, model, beta = pulse.near.scales.force, pulse.model, f"beta_{pulse.beta:g}"
        number, fine = np.arange(1.0, pulse.contacts + 1), np.linspace(1.0, pulse.contacts, 200)
        largest, leading = pulse.largest[: pulse.contacts] / scale, pulse.leading / scale
        (marks,) = right.plot(number[: len(largest)], largest, "o", markersize=4, label=rf"$\beta$ = {pulse.beta:g}")
        colour = marks.get_color()
        right.plot(fine, leading[0] * model.printed(fine), color=colour)
        right.plot(fine, leading[0] * model.secondary(fine), "--", color=colour)
        if pulse.transition is not None:
            right.plot(pulse.transition, 0, "v", color=colour, clip_on=False, zorder=5)
        data |= {
            f"largest_force_{beta}": largest,
            f"leading_peak_{beta}": leading,
            f"model_4_28_{beta}": leading[0] * model.printed(number),
            f"balance_by_contacts_{beta}": leading[0] * model.discrete(number),
            f"secondary_4_31_{beta}": leading[0] * model.secondary(number),
        }
    for axes in (left, right):
        label(axes, "Contact", xlim=(0.4, middle.contacts + 0.6), ylim=(0, 1.15 * leading[0]))
        axes.legend()
    label(left, y=PEAK_FORCE, title=rf"$\beta$ = {middle.beta:g}")
    label(right, title="Lines: 4.28; dashed: collisions; ▾: transition")
    return Drawing(figure, data)


def far(pulses: Sequence[ShortPulse]) -> Drawing:
    """Peak force against distance of all, and velocities along the chain of the largest beta at three instants."""
    figure, left, right = panels(2.7, 2)
    data: dict[str, ArrayLike] = {}
    for pulse in pulses:
        force = pulse.largest / pulse.far.scales.force
        number, power = np.arange(1.0, len(force) + 1), pulse.inverse.exponent if pulse.inverse else math.nan
        reached = number < 0.95 * pulse.spring.rate * pulse.far.time[-1]
        left.plot(number[reached], force[reached], label=rf"$\beta$ = {pulse.beta:g}, power {power:.2f}")
        data |= {"contact": number, f"largest_force_beta_{pulse.beta:g}": force}
    guide, anchor = np.array([20.0, 320.0]), float(force[49])
    left.plot(guide, 2 * anchor * (guide / 50) ** -1.0, "--", color="black", label="power -1")
    label(left, "Contact", PEAK_FORCE, log="xy")
    left.legend()
    last = pulses[-1]
    run, scale = last.far, last.far.scales.velocity
    data["bead"] = bead = np.arange(1, run.velocity.shape[1] + 1)
    for row in last.instants:
        data[f"velocity_at_{run.time[row]:.4g}_s"] = velocity = run.velocity[row] / scale
        (line,) = right.plot(bead, velocity, label=f"{run.time[row] * 1e3:.3g} ms")
        right.axhline(last.uniform(row)[2] / scale, color=line.get_color(), linestyle=":")
    label(right, "Bead", VELOCITY, ylim=(0, 1.6 * right.get_ylim()[1]))
    right.legend(title=rf"$\beta$ = {last.beta:g}; dotted: $I/nm$")
    return Drawing(figure, data)
