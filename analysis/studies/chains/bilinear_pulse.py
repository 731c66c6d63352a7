"""Bilinear chains after a short pulse: leading wave, collisions and the inverse regime, beside thesis 4.2.1."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.curves import COLOURS, label, panels
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, Drawing
from granwave.analysis.measures.hertz_chain import ChainScales
from granwave.analysis.studies.chains.bilinear import FORCE, PRINTED, VELOCITY, first_coefficients
from granwave.analysis.studies.chains.scales import of_thesis
from granwave.analysis.studies.chains.short_pulse import INVERSE, ShortPulse, short_pulses
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Bilinear chain after a short pulse"
_TRANSITIONS = {0.7: 9, 0.8: 5, 0.9: 3}  # thesis 4.2.1, "the third, fifth and ninth", of falling beta
_ERROR_OF_MODEL = 0.10  # thesis 4.2.1, of 4.28
_SHOWN = 9.3  # sqrt(k/m) t to which histories are shown: 150 tau for brass of R = 4.76 mm
_WHERE = "thesis 4.2.1"
_LINEAR = "The linear chain itself gives the theory value"
_COEFFICIENTS = (  # (4.19) to (4.21)
    ("v_m m/I, both beads when contact 1 is at its peak (4.19)", f"{_LINEAR}; the print fits 4.22."),
    ("F_p / (sqrt(k/m) I), contact 1 (4.20)", ""),
    ("F_2 / (sqrt(k/m) I), contact 2 at that instant (4.21)", f"{_LINEAR}."),
)
_BY_CONTACTS = (
    "4.28 turns the balance from contact to contact into a differential equation; taken contact by contact, the same "
    "balance gives the theory value. The wave is not self-similar: it decays fastest at first."
)
_POWER = (
    "The source's power comes from an energy balance; beads of one velocity keep the momentum I only if the power is "
    "-1, which is the theory value."
)
_HISTORIES = (
    "Force of contacts 1 to 3 and velocity of beads 1 to 4 after a short pulse, beta = {:g}; beads fly freely once the "
    "wave has left them, then collide (thesis Fig. 4.5)"
)
_PEAKS = (
    "Peak forces of the first contacts, beside the source's two models and the balance taken contact by contact "
    "(thesis Figs. 4.6 and 4.7)"
)
_FAR = "Far down the chain: peak force against distance, and bead velocities at three instants (thesis Fig. 4.8)"
Pulses = Sequence[ShortPulse]


def select(runs: Sequence[FinishedRun]) -> list[list[ShortPulse]]:
    """All values of beta together."""
    pulses = short_pulses(runs)
    return [pulses] if pulses else []


def text(pulses: Pulses) -> str:
    """Describe the runs."""
    betas = ", ".join(f"{pulse.beta:g}" for pulse in pulses)
    return (
        f"An impulse of {_middle(pulses).impulse:.4g} N s on the first bead of a chain under the bilinear law, beta = "
        f"{betas}. The leading peak is the first maximum at a contact; the transition is at the first contact that a "
        "later wave presses harder. Theory is the linear chain in closed form, and for the decay the energy balance of "
        "the source taken contact by contact."
    )


def rows(pulses: Pulses) -> Iterator[Row]:
    """Coefficients, residual velocity, decay and transition, inverse regime."""
    found = zip(_COEFFICIENTS, PRINTED, _middle(pulses).at_first_peak, first_coefficients(), strict=False)
    for (what, remark), printed, ours, theory in found:
        yield Row(what, "", printed, ours, _WHERE, remark, theory)
    for pulse in pulses:
        if math.isfinite(left := pulse.residual(1)):
            expected = (PRINTED[0] - PRINTED[3] * pulse.spring.share) * pulse.velocity_unit
            yield Row(f"Residual velocity of bead 1 (4.22), beta {pulse.beta:g}", "m/s", expected, left, _WHERE)
            yield Row(f"Factor of sqrt(1 - beta) in 4.22, beta {pulse.beta:g}", "", PRINTED[3], pulse.trailing_factor,
                      _WHERE)  # fmt: skip
    for pulse in pulses:
        yield from _rows_of_decay(pulse)
    for pulse in pulses:
        if pulse.inverse is not None:
            what = f"Power of the peak force with distance, contacts from {INVERSE[0]} on, beta {pulse.beta:g} (4.35)"
            yield Row(what, "", -(1 + pulse.beta) / 2, pulse.inverse.exponent, _WHERE, _POWER, -1.0)
    last = pulses[-1]
    scale, where = ChainScales(last.far).velocity, f"{_WHERE}, Fig. 4.8" if of_thesis(last.far) else ""
    for row in last.instants:
        mean, spread, theory = last.uniform(row)
        at = f"{last.far.time[row] * 1e3:.2f} ms, beta {last.beta:g}"
        yield Row(f"Mean velocity behind the front at {at}, in R*/tau", "", None, mean / scale, where,
                  f"Standard deviation {spread:.1%}. Theory: the impulse shared by all beads up to the front.",
                  theory / scale)  # fmt: skip


def pictures(pulses: Pulses) -> Iterator[Picture]:
    """Histories and first contacts of the middle beta, and far contacts of all."""
    middle = _middle(pulses)
    yield Picture("bilinear_histories", _HISTORIES.format(middle.beta), _histories(middle))
    yield Picture("bilinear_peaks", _PEAKS, _peaks(pulses, middle))
    far = [pulse for pulse in pulses if pulse.inverse]
    if far:
        yield Picture("bilinear_far", _FAR, _far(far))


def _middle(pulses: Pulses) -> ShortPulse:
    return min(pulses, key=lambda pulse: abs(pulse.beta - 0.8))


def _rows_of_decay(pulse: ShortPulse) -> Iterator[Row]:
    beta, last, crossing = f"beta {pulse.beta:g}", max(2, pulse.last_of_leading), pulse.model.transition
    number, relative = np.arange(1.0, last + 1), pulse.leading[:last] / pulse.leading[0]
    errors = [float(np.abs(law(number) / relative - 1).max()) for law in (pulse.model.printed, pulse.model.discrete)]
    yield Row(f"Decay of the leading peak per contact, contacts 1 to {last}, {beta} (4.28)", "", pulse.model.decay,
              pulse.decay, _WHERE, _BY_CONTACTS, -math.log(pulse.model.ratio))  # fmt: skip
    yield Row(f"Largest difference of 4.28 from the leading peaks 1 to {last}, {beta}", "", _ERROR_OF_MODEL, errors[0],
              _WHERE, "'Around 10 %', for beta 0.8 presumably; it starts at the simulated contact 1. Contact by "
              f"contact the difference is {errors[1]:.1%}.")  # fmt: skip
    if pulse.transition is not None:
        source = next((float(n) for b, n in _TRANSITIONS.items() if math.isclose(b, pulse.beta)), None)
        theory = f" Theory: where the source's two models cross, {crossing:.1f}." if crossing else ""
        yield Row(f"Transition to the inverse regime, contact, {beta}", "", source, pulse.transition,
                  f"{_WHERE}, Fig. 4.7",
                  f"A later wave presses this contact {pulse.excess:.2g} % harder than the leading one.{theory}",
                  math.ceil(crossing) if crossing else None)  # fmt: skip


def _histories(pulse: ShortPulse) -> Drawing:
    """Forces of contacts 1 to 3 and velocities of beads 1 to 4."""
    run, scales = pulse.near, ChainScales(pulse.near)
    shown = pulse.spring.rate * run.time <= _SHOWN
    time = run.time[shown] / scales.time
    figure, left, right = panels(2.6, 2)
    data: dict[str, ArrayLike] = {"time_normalised": time}
    for axes, values, most, what, quantity, unit in (
        (left, run.force / scales.force, 3, "contact", "force", FORCE),
        (right, run.velocity / scales.velocity, 4, "bead", "velocity", VELOCITY),
    ):
        for n, colour in zip(range(min(most, values.shape[1])), COLOURS, strict=False):
            axes.plot(time, values[shown, n], color=colour, label=f"{what} {n + 1}")
            data[f"{what}_{n + 1}_{quantity}_normalised"] = values[shown, n]
        label(axes, r"Time $t/\tau$", unit, xlim=(0, time[-1]), ylim=(0, None))
        axes.legend()
    return Drawing(figure, data)


def _peaks(pulses: Pulses, middle: ShortPulse) -> Drawing:
    """Peak forces of the first contacts: of one beta with the profile of the wave, and of all with both models."""
    scale = ChainScales(middle.near).force
    figure, left, right = panels(2.9, 2, sharey=True)
    number, fine = np.arange(1.0, middle.contacts + 1), np.linspace(1.0, middle.contacts, 200)
    profile, first = middle.profile(2)[: middle.contacts] / scale, middle.leading[0] / scale
    left.bar(number, profile, width=0.5, color="#d9d9d9", label="wave when contact 2 peaks")
    left.plot(fine, first * middle.model.printed(fine), color=ORANGE, label="4.28")
    left.plot(fine, first * middle.model.discrete(fine), ":", color=GREEN, label="balance by contacts")
    left.plot(number, middle.leading / scale, "o", color=BLUE, markersize=4, label="leading peak")
    data: dict[str, ArrayLike] = {"contact": number, "profile_when_contact_2_peaks": profile}
    for pulse, colour in zip(pulses, COLOURS, strict=False):
        scale, model, beta = ChainScales(pulse.near).force, pulse.model, f"beta_{pulse.beta:g}"
        number, fine = np.arange(1.0, pulse.contacts + 1), np.linspace(1.0, pulse.contacts, 200)
        largest, leading = pulse.largest[: pulse.contacts] / scale, pulse.leading / scale
        first = leading[0]
        right.plot(number[: len(largest)], largest, "o", color=colour, markersize=4, label=rf"$\beta$ = {pulse.beta:g}")
        right.plot(fine, first * model.printed(fine), color=colour, linewidth=0.9)
        right.plot(fine, first * model.secondary(fine), "--", color=colour, linewidth=0.9)
        if pulse.transition is not None:
            right.plot(pulse.transition, 0, "v", color=colour, markersize=7, clip_on=False, zorder=5)
        data |= {
            f"largest_force_{beta}": largest,
            f"leading_peak_{beta}": leading,
            f"model_4_28_{beta}": first * model.printed(number),
            f"balance_by_contacts_{beta}": first * model.discrete(number),
            f"secondary_4_31_{beta}": first * model.secondary(number),
        }
    for axes in (left, right):
        label(axes, "Contact", xlim=(0.4, middle.contacts + 0.6), ylim=(0, 1.15 * first))
        axes.legend()
    label(left, y=r"Peak force $F/E^*R^{*2}$", title=rf"$\beta$ = {middle.beta:g}")
    label(right, title="Lines: 4.28; dashed: collisions; ▾: transition")
    return Drawing(figure, data)


def _far(pulses: Pulses) -> Drawing:
    """Peak force against distance of all, and velocities along the chain of the largest beta at three instants."""
    figure, left, right = panels(2.7, 2)
    data: dict[str, ArrayLike] = {}
    for pulse, colour in zip(pulses, COLOURS, strict=False):
        force = pulse.largest / ChainScales(pulse.far).force
        number, power = np.arange(1.0, len(force) + 1), pulse.inverse.exponent if pulse.inverse else math.nan
        reached = number < 0.95 * pulse.spring.rate * pulse.far.time[-1]
        left.plot(number[reached], force[reached], color=colour, linewidth=0.9,
                  label=rf"$\beta$ = {pulse.beta:g}, power {power:.2f}")  # fmt: skip
        data |= {"contact": number, f"largest_force_beta_{pulse.beta:g}": force}
    guide, anchor = np.array([20.0, 320.0]), float(force[49])
    left.plot(guide, 2 * anchor * (guide / 50) ** -1.0, "--", color="black", linewidth=0.9, label="power -1")
    label(left, "Contact", r"Peak force $F/E^*R^{*2}$", log="xy")
    left.legend()
    last = max(pulses, key=lambda pulse: pulse.beta)
    scale, run = ChainScales(last.far).velocity, last.far
    data["bead"] = bead = np.arange(1, run.velocity.shape[1] + 1)
    for row, colour in zip(last.instants, COLOURS, strict=False):
        velocity = run.velocity[row] / scale
        right.plot(bead, velocity, color=colour, linewidth=0.8, label=f"{run.time[row] * 1e3:.3g} ms")
        right.axhline(last.uniform(row)[2] / scale, color=colour, linestyle=":", linewidth=0.9)
        data[f"velocity_at_{run.time[row]:.4g}_s"] = velocity
    label(right, "Bead", VELOCITY, ylim=(0, 1.6 * right.get_ylim()[1]))
    right.legend(title=rf"$\beta$ = {last.beta:g}; dotted: $I/nm$")
    return Drawing(figure, data)
