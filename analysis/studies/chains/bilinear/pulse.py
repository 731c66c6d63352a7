"""Bilinear chains after a short pulse: leading wave, collisions and the inverse regime, beside thesis 4.2.1."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, Drawing
from granwave.analysis.measures.chains.bilinear import PRINTED, first_coefficients
from granwave.analysis.measures.chains.bilinear_pulse import INVERSE, ShortPulse, short_pulses
from granwave.analysis.studies.chains.labels import FORCE, PEAK_FORCE, TIME, VELOCITY
from granwave.analysis.studies.chains.runs import from_thesis, uniform
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
    pulses = short_pulses(uniform(runs, "bilinear"))
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
            beta, expected = f"beta {pulse.beta:g}", PRINTED[0] - PRINTED[3] * pulse.spring.share
            what = f"Residual velocity of bead 1 (4.22), {beta}"
            yield Row(what, "m/s", expected * pulse.velocity_unit, left, _WHERE)
            what = f"Factor of sqrt(1 - beta) in 4.22, {beta}"
            yield Row(what, "", PRINTED[3], pulse.trailing_factor, _WHERE)
    for pulse in pulses:
        yield from _rows_of_decay(pulse)
    for pulse in pulses:
        if pulse.inverse is not None:
            what = f"Power of the peak force with distance, contacts from {INVERSE[0]} on, beta {pulse.beta:g} (4.35)"
            yield Row(what, "", -(1 + pulse.beta) / 2, pulse.inverse.exponent, _WHERE, _POWER, -1.0)
    last = pulses[-1]
    where = f"{_WHERE}, Fig. 4.8" if from_thesis(last.far, yielding=True) else ""
    for row in last.instants:
        mean, spread, theory = last.uniform(row)
        scale, at = last.far.scales.velocity, f"{last.far.time[row] * 1e3:.2f} ms, beta {last.beta:g}"
        what = f"Mean velocity behind the front at {at}, in R*/tau"
        remark = f"Standard deviation {spread:.1%}. Theory: the impulse shared by all beads up to the front."
        yield Row(what, "", None, mean / scale, where, remark, theory / scale)


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
    beta, last, model = f"beta {pulse.beta:g}", max(2, pulse.last_of_leading), pulse.model
    number, relative = np.arange(1.0, last + 1), pulse.leading[:last] / pulse.leading[0]
    printed, discrete = (float(np.abs(law(number) / relative - 1).max()) for law in (model.printed, model.discrete))
    yield Row(f"Decay of the leading peak per contact, contacts 1 to {last}, {beta} (4.28)", "", model.decay,
              pulse.decay, _WHERE, _BY_CONTACTS, -math.log(model.ratio))  # fmt: skip
    yield Row(f"Largest difference of 4.28 from the leading peaks 1 to {last}, {beta}", "", _ERROR_OF_MODEL, printed,
              _WHERE, "'Around 10 %', for beta 0.8 presumably; it starts at the simulated contact 1. Contact by "
              f"contact the difference is {discrete:.1%}.")  # fmt: skip
    if pulse.transition is not None:
        source = next((float(n) for b, n in _TRANSITIONS.items() if math.isclose(b, pulse.beta)), None)
        crossing, remark = None, f"A later wave presses this contact {pulse.excess:.2g} % harder than the leading one."
        if model.transition:
            remark += f" Theory: where the source's two models cross, {model.transition:.1f}."
            crossing = math.ceil(model.transition)
        yield Row(f"Transition to the inverse regime, contact, {beta}", "", source, pulse.transition,
                  f"{_WHERE}, Fig. 4.7", remark, crossing)  # fmt: skip


def _histories(pulse: ShortPulse) -> Drawing:
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


def _peaks(pulses: Pulses, middle: ShortPulse) -> Drawing:
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


def _far(pulses: Pulses) -> Drawing:
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
