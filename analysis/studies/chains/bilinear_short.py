"""Bilinear chains after a short pulse, measured and beside thesis 4.2.1 (Figs. 4.5 to 4.8)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.signals import Power, first_peak, power
from granwave.analysis.studies.chains.bilinear import (
    PRINTED,
    LeadingWave,
    Spring,
    first_coefficients,
    leading_wave,
    spring_of,
)
from granwave.analysis.studies.chains.bilinear_figures import far_drawing, histories_drawing, peaks_drawing
from granwave.analysis.studies.chains.runs import ChainRun, uniform
from granwave.analysis.studies.chains.scales import ChainScales, impulse_of, is_pulse, of_thesis
from granwave.analysis.studies.study import Picture, Row, Study

Array = NDArray[np.float64]

_SHORT = 0.25  # of 1/sqrt(k/m): the longest pulse that is an impulse alone
_CONTACTS = 12  # of the leading wave that are followed
_FINE = 0.25  # of 1/sqrt(k/m): the coarsest record that shows the leading wave
_SHORTEST = 8.0  # 1/sqrt(k/m): the shortest record, in which contacts 1 to 3 have peaked
_OVERTAKEN = 1.0005  # of the leading peak: a later one that is higher
_INVERSE = (30, 300)  # contacts of the fit in the inverse regime
_FEWEST = 100  # contacts that make such a fit worth while
_FRONTS = (119.1, 238.2, 357.4)  # sqrt(k/m) t of Fig. 4.8: 1.5, 3 and 4.5 ms
_BEHIND = 0.9  # of the way to the front over which velocities are averaged
_TRANSITIONS = {0.7: 9, 0.8: 5, 0.9: 3}  # thesis 4.2.1, "the third, fifth and ninth", of falling beta
_ERROR_OF_MODEL = 0.10  # thesis 4.2.1, of 4.28
_WHERE = "thesis 4.2.1"


@dataclasses.dataclass(frozen=True, eq=False)
class ShortPulse:
    """Chains of one beta after a short pulse: one recorded in short steps, one followed far."""

    near: ChainRun
    far: ChainRun

    @cached_property
    def spring(self) -> Spring:
        """Contact and bead."""
        return spring_of(self.near)

    @property
    def beta(self) -> float:
        """Of the law."""
        return self.spring.beta

    @property
    def impulse(self) -> float:
        """N s."""
        return impulse_of(self.near)

    @property
    def velocity_unit(self) -> float:
        """I/m, m/s."""
        return self.impulse / self.spring.mass

    @property
    def force_unit(self) -> float:
        """sqrt(k/m) I, N."""
        return self.impulse * self.spring.rate

    @cached_property
    def model(self) -> LeadingWave:
        """Of thesis 4.23 to 4.31."""
        return leading_wave(self.beta)

    @cached_property
    def _leading(self) -> tuple[Array, Array]:
        found = [first_peak(self.near.time, self.near.force[:, n]) for n in range(self.contacts)]
        time, force = np.array(found).T
        # the parabola overshoots where unloading is much steeper than loading; peaks of every step bound it
        return time, np.minimum(force, self.near.of_contacts("peak_force")[: self.contacts])

    @property
    def contacts(self) -> int:
        """That the leading wave is followed over."""
        reached = self.spring.rate * self.near.time[-1] - 3  # three contacts long
        return max(2, min(_CONTACTS, int(reached), self.near.force.shape[1]))

    @property
    def leading(self) -> Array:
        """First peak at each contact: (n_followed,), N."""
        return self._leading[1]

    @cached_property
    def largest(self) -> Array:
        """Largest force ever at each contact: (n_contacts,), N."""
        return self.far.of_contacts("peak_force")

    @property
    def transition(self) -> int | None:
        """First contact that a later wave presses harder than the leading one did; None: beyond those followed."""
        n = min(self.contacts, len(self.largest))
        over = np.flatnonzero(self.largest[:n] > _OVERTAKEN * self.leading[:n])
        return int(over[0]) + 1 if len(over) else None

    @property
    def excess(self) -> float:
        """Of the later wave over the leading one at the `transition`, per cent."""
        n = (self.transition or 1) - 1
        return float(100 * (self.largest[n] / self.leading[n] - 1))

    @property
    def last_of_leading(self) -> int:
        """The last contact whose largest force is that of the leading wave."""
        return (self.transition or self.contacts + 1) - 1

    @property
    def decay(self) -> float:
        """Per contact, of the logarithm of the leading peak, from contact 1 to `last_of_leading`, two at least."""
        last = max(2, self.last_of_leading)
        return float(math.log(self.leading[0] / self.leading[last - 1]) / (last - 1))

    def profile(self, contact: int) -> Array:
        """Forces of all contacts when one (from 1) is at its leading peak: (n_contacts,), N."""
        return _at(self.peak_time(contact), self.near.time, self.near.force)

    def peak_time(self, contact: int) -> float:
        """When the beads of a contact (from 1) are first equally fast after touching, s."""
        closing = self.near.velocity[:, contact - 1] - self.near.velocity[:, contact]
        k = int(np.flatnonzero((closing <= 0) & (self.near.force[:, contact - 1] > 0))[0])
        return float(np.interp(0.0, -closing[k - 1 : k + 1], self.near.time[k - 1 : k + 1]))

    @property
    def at_first_peak(self) -> tuple[float, float, float]:
        """v_m, F_p and F_2, in units of I/m and sqrt(k/m) I, when the first contact is at its peak."""
        moving = float(_at(self.peak_time(1), self.near.time, self.near.velocity)[0])
        second = float(self.profile(1)[1])
        return moving / self.velocity_unit, float(self.leading[0]) / self.force_unit, second / self.force_unit

    def residual(self, bead: int) -> float:
        """Velocity of a bead (from 1) in free flight once the leading wave has left it, m/s; NaN: none."""
        if bead > self.contacts:
            return math.nan
        force = self.near.force[:, max(0, bead - 2) : bead]
        free = (self.near.time > self._leading[0][bead - 1]) & (force.max(axis=1) == 0)
        places = np.flatnonzero(free)
        return float(self.near.velocity[places[0], bead - 1]) if len(places) else math.nan

    @property
    def trailing_factor(self) -> float:
        """Of sqrt(1 - beta) in thesis 4.22, with its v_m = 0.482 I/m."""
        return (PRINTED[0] - self.residual(1) / self.velocity_unit) / self.spring.share

    @cached_property
    def inverse(self) -> Power | None:
        """Power of the largest force with the distance far down the chain; None: the chain is short for it."""
        last = min(_INVERSE[1], int(0.85 * self.spring.rate * self.far.time[-1]), len(self.largest) - 20)
        if last - _INVERSE[0] < _FEWEST:
            return None
        number = np.arange(_INVERSE[0], last + 1)
        return power(number.astype(float), self.largest[_INVERSE[0] - 1 : last])

    @property
    def instants(self) -> list[int]:
        """Rows of the far record at the times of Fig. 4.8, as far as it goes."""
        phase = self.spring.rate * self.far.time
        shown = [front for front in _FRONTS if front <= min(phase[-1], self.far.velocity.shape[1] - 10)]
        return [int(np.argmin(np.abs(phase - front))) for front in shown]

    def uniform(self, row: int) -> tuple[float, float, float]:
        """Mean velocity behind the front (m/s), its standard deviation over that, and I/m over the beads that move."""
        v = self.far.velocity[row]
        front = int(np.flatnonzero(v > 0.5 * v[: len(v) // 10 + 2].mean())[-1]) + 1
        behind = v[: max(2, int(_BEHIND * front))]
        return float(behind.mean()), float(behind.std() / behind.mean()), self.velocity_unit / front


def short_pulses(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """The study of bilinear chains after a short pulse, all values of beta together."""
    pulses = _pulses(runs)
    if not pulses:
        return
    middle = min(pulses, key=lambda pulse: abs(pulse.beta - 0.8))
    betas = ", ".join(f"{pulse.beta:g}" for pulse in pulses)
    yield Study(
        "bilinear-pulse",
        "Bilinear chain after a short pulse",
        f"An impulse of {middle.impulse:.4g} N s on the first bead of a chain under the bilinear law, beta = {betas}. "
        "The leading peak is the first maximum at a contact; the transition is at the first contact that a later wave "
        "presses harder. Theory is the linear chain in closed form, and for the decay the energy balance of the source "
        "taken contact by contact.",
        tuple(_rows(pulses, middle)),
        tuple(_pictures(pulses, middle)),
    )


def _at(time: float, times: Array, rows: Array) -> Array:
    """A record (n_times, n) at one time, between its rows by straight lines."""
    k = min(int(np.searchsorted(times, time)), len(times) - 1)
    part = (time - times[k - 1]) / (times[k] - times[k - 1])
    return np.asarray(rows[k - 1] + part * (rows[k] - rows[k - 1]))


def _pulses(runs: Sequence[ChainRun]) -> list[ShortPulse]:
    found: dict[float, list[ChainRun]] = {}
    for run in uniform(runs, "bilinear"):
        if is_pulse(run) and run.force.shape[1] > 2 and run.load.lasts * spring_of(run).rate < _SHORT:
            found.setdefault(run.case.contact.beta, []).append(run)
    pulses = []
    for _, group in sorted(found.items()):
        near = min(group, key=lambda run: float(run.time[1] - run.time[0]))
        # runs of another material or impulse are no part of the same study
        group = [run for run in group if math.isclose(impulse_of(run), impulse_of(near), rel_tol=1e-6)
                 and math.isclose(run.mass, near.mass, rel_tol=1e-6)]  # fmt: skip
        far = max(group, key=lambda run: min(run.force.shape[1], spring_of(run).rate * run.time[-1]))
        rate = spring_of(near).rate
        if (near.time[1] - near.time[0]) * rate < _FINE and near.time[-1] * rate > _SHORTEST:
            pulses.append(ShortPulse(near, far))
    return pulses


def _rows(pulses: Sequence[ShortPulse], middle: ShortPulse) -> Iterator[Row]:
    names = ("v_m m/I, both beads when contact 1 is at its peak (4.19)", "F_p / (sqrt(k/m) I), contact 1 (4.20)",
             "F_2 / (sqrt(k/m) I), contact 2 at that instant (4.21)")  # fmt: skip
    remarks = ("The linear chain itself gives the theory value; the print fits 4.22.", "",
               "The linear chain itself gives the theory value.")  # fmt: skip
    for name, printed, ours, theory, remark in zip(
        names, PRINTED, middle.at_first_peak, first_coefficients(), remarks, strict=False
    ):
        yield Row(name, "", printed, ours, _WHERE, remark, theory)
    for pulse in pulses:
        beta = f"beta {pulse.beta:g}"
        expected = (PRINTED[0] - PRINTED[3] * pulse.spring.share) * pulse.velocity_unit
        if math.isnan(pulse.residual(1)):
            continue
        yield Row(f"Residual velocity of bead 1 (4.22), {beta}", "m/s", expected, pulse.residual(1), _WHERE)
        yield Row(f"Factor of sqrt(1 - beta) in 4.22, {beta}", "", PRINTED[3], pulse.trailing_factor, _WHERE)
    for pulse in pulses:
        yield from _rows_of_decay(pulse)
    for pulse in pulses:
        yield from _rows_far(pulse)
    yield from _rows_of_velocity(pulses[-1])


def _rows_of_decay(pulse: ShortPulse) -> Iterator[Row]:
    beta, last, crossing = f"beta {pulse.beta:g}", max(2, pulse.last_of_leading), pulse.model.transition
    number = np.arange(1.0, last + 1)
    relative = pulse.leading[:last] / pulse.leading[0]
    yield Row(
        f"Decay of the leading peak per contact, contacts 1 to {last}, {beta} (4.28)",
        "",
        pulse.model.decay,
        pulse.decay,
        _WHERE,
        "4.28 turns the balance from contact to contact into a differential equation; taken contact by contact, the "
        "same balance gives the theory value. The wave is not self-similar: it decays fastest at first.",
        -math.log(pulse.model.ratio),
    )
    yield Row(
        f"Largest difference of 4.28 from the leading peaks 1 to {last}, {beta}",
        "",
        _ERROR_OF_MODEL,
        float(np.abs(pulse.model.printed(number) / relative - 1).max()),
        _WHERE,
        "'Around 10 %', for beta 0.8 presumably; it starts at the simulated contact 1. "
        f"Contact by contact the difference is {np.abs(pulse.model.discrete(number) / relative - 1).max():.1%}.",
    )
    if pulse.transition is not None:
        yield Row(
            f"Transition to the inverse regime, contact, {beta}",
            "",
            next((float(n) for b, n in _TRANSITIONS.items() if math.isclose(b, pulse.beta)), None),
            pulse.transition,
            f"{_WHERE}, Fig. 4.7",
            f"A later wave presses this contact {pulse.excess:.2g} % harder than the leading one."
            + (f" Theory: where the source's two models cross, {crossing:.1f}." if crossing else ""),
            math.ceil(crossing) if crossing else None,
        )


def _rows_far(pulse: ShortPulse) -> Iterator[Row]:
    beta = f"beta {pulse.beta:g}"
    if pulse.inverse is not None:
        yield Row(
            f"Power of the peak force with distance, contacts from {_INVERSE[0]} on, {beta} (4.35)",
            "",
            -(1 + pulse.beta) / 2,
            pulse.inverse.exponent,
            _WHERE,
            "The source's power comes from an energy balance; beads of one velocity keep the momentum I only if "
            "the power is -1, which is the theory value.",
            -1.0,
        )


def _rows_of_velocity(pulse: ShortPulse) -> Iterator[Row]:
    for row in pulse.instants:
        mean, spread, theory = pulse.uniform(row)
        scale = ChainScales(pulse.far).velocity
        yield Row(
            f"Mean velocity behind the front at {pulse.far.time[row] * 1e3:.2f} ms, beta {pulse.beta:g}, in R*/tau",
            "",
            None,
            mean / scale,
            f"{_WHERE}, Fig. 4.8" if of_thesis(pulse.far) else "",
            f"Standard deviation {spread:.1%}. Theory: the impulse shared by all beads up to the front.",
            theory / scale,
        )


def _pictures(pulses: Sequence[ShortPulse], middle: ShortPulse) -> Iterator[Picture]:
    yield Picture(
        "bilinear_histories",
        f"Force of contacts 1 to 3 and velocity of beads 1 to 4 after a short pulse, beta = {middle.beta:g}; beads fly "
        "freely once the wave has left them, then collide (thesis Fig. 4.5)",
        histories_drawing(middle),
    )
    yield Picture(
        "bilinear_peaks",
        "Peak forces of the first contacts, beside the source's two models and the balance taken contact by contact "
        "(thesis Figs. 4.6 and 4.7)",
        peaks_drawing(pulses, middle),
    )
    if any(pulse.inverse for pulse in pulses):
        yield Picture(
            "bilinear_far",
            "Far down the chain: peak force against distance, and bead velocities at three instants (thesis Fig. 4.8)",
            far_drawing(pulses),
        )
