"""Bilinear chains after a short pulse: leading wave, collisions and the inverse regime, beside thesis 4.2.1."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.chains import bilinear_pulses
from granwave.analysis.measures.chains.bilinear import PRINTED, first_coefficients
from granwave.analysis.measures.chains.bilinear_pulse import INVERSE, ShortPulse, short_pulses
from granwave.analysis.measures.chains.record import OVERTAKEN
from granwave.analysis.studies.chains.runs import from_thesis, uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Bilinear chain after a short pulse"
_TRANSITIONS = {0.7: 9, 0.8: 5, 0.9: 3}  # thesis 4.2.1, "the third, fifth and ninth", of falling beta
_ERROR_OF_MODEL = 0.10  # thesis 4.2.1, of 4.28
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
            beta, formula = f"beta {pulse.beta:g}", PRINTED[0] - PRINTED[3] * pulse.spring.share
            what = f"Residual velocity of bead 1, {beta}"
            yield Row(what, "m/s", None, left, "thesis (4.22)", "", formula * pulse.velocity_unit)
            what = f"Factor of sqrt(1 - beta) in 4.22, {beta}"
            yield Row(what, "", PRINTED[3], pulse.trailing_factor, _WHERE)
    for pulse in pulses:
        yield from _rows_of_decay(pulse)
    for pulse in pulses:
        if pulse.inverse is not None:
            what = f"Power of the peak force with distance, contacts from {INVERSE[0]} on, beta {pulse.beta:g} (4.35)"
            yield Row(what, "", -(1 + pulse.beta) / 2, pulse.inverse.exponent, _WHERE, _POWER, -1.0, digits=2)
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
    yield Picture("bilinear_histories", _HISTORIES.format(middle.beta), bilinear_pulses.histories(middle))
    yield Picture("bilinear_peaks", _PEAKS, bilinear_pulses.peaks(pulses, middle))
    far = [pulse for pulse in pulses if pulse.inverse]
    if far:
        yield Picture("bilinear_far", _FAR, bilinear_pulses.far(far))


def _middle(pulses: Pulses) -> ShortPulse:
    return min(pulses, key=lambda pulse: abs(pulse.beta - 0.8))


def _rows_of_decay(pulse: ShortPulse) -> Iterator[Row]:
    beta, last, model = f"beta {pulse.beta:g}", max(2, pulse.last_of_leading), pulse.model
    number, relative = np.arange(1.0, last + 1), pulse.leading[:last] / pulse.leading[0]
    printed, discrete = (float(np.abs(law(number) / relative - 1).max()) for law in (model.printed, model.discrete))
    yield Row(f"Decay of the leading peak per contact, contacts 1 to 2, {beta}", "", None, pulse.decay, _WHERE,
              f"4.28 with its constants gives {model.decay:.3f}. {_BY_CONTACTS}", -math.log(model.ratio))  # fmt: skip
    yield Row(f"Largest difference of 4.28 from the leading peaks 1 to {last}, {beta}", "", _ERROR_OF_MODEL, printed,
              _WHERE, "'Around 10 %', for beta 0.8 presumably; it starts at the simulated contact 1. Contact by "
              f"contact the difference is {discrete:.1%}.")  # fmt: skip
    if pulse.transition is not None:
        source = next((float(n) for b, n in _TRANSITIONS.items() if math.isclose(b, pulse.beta)), None)
        crossing, remark = None, f"A later wave presses it {pulse.excess:.2g} % harder than the leading one."
        if model.transition:
            remark += f" Theory: where the source's two models cross, {model.transition:.1f}."
            crossing = math.ceil(model.transition)
        if pulse.transition > 1:
            before = pulse.transition - 2
            most = 100 * (float(pulse.largest[before]) / float(pulse.leading[before]) - 1)
            threshold = f"{100 * (OVERTAKEN - 1):.1g} %"
            remark += f" Counted from {threshold} on, as in all studies; contact {before + 1}: {most:.2g} %."
        yield Row(f"Transition to the inverse regime, contact, {beta}", "", source, pulse.transition,
                  f"{_WHERE}, Fig. 4.7", remark, crossing)  # fmt: skip
