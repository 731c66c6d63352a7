"""The study of elasto-plastic chains after pulses: rows beside thesis 2.2."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.studies.chains import elastoplastic_figures as draw
from granwave.analysis.studies.chains.elastoplastic import Pulses, Wave, collect_pulses
from granwave.analysis.studies.chains.elastoplastic_model import (
    DECAY,
    FITTED_TO,
    INVERSE,
    QUADRATIC,
    START,
    SWITCH,
    dissipation_at,
    elastic_peak,
    integrated_dissipation,
    model_dissipation,
    quadratic_of,
)
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.study import Picture, Row, Study

_FAR = (15, 100)  # contacts of the fits in the inverse regime
_LEAST_FAR = 45  # the last contact of such a fit at the least
_COLLAPSE = 15  # contacts up to which runs of one impulse are compared: collisions farther on are chaotic
_MIDDLE = 40  # contact: x/R* = 160, the last of the fits of the speed near the struck end
_LAST = 87  # contact: x/R* = 348, where Fig. 2.16 ends
_ELASTIC = 20  # contact where the elastic wave is taken


def elastoplastic_pulses(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Elasto-plastic chains after pulses, all impulses together."""
    pulses = collect_pulses(runs)
    if pulses is None:
        return
    impulses = ", ".join(f"{wave.impulse:.3g}" for wave in pulses.chosen)
    n = sum(map(len, pulses.groups))
    yield Study(
        "elastoplastic-pulse",
        "Elasto-plastic chain after a pulse",
        f"{n} {'chains' if n > 1 else 'chain'} under the elasto-plastic law, impulse {impulses} in units of E*R*^2 "
        "tau. Peak forces are the largest ever at a contact; the leading disturbance arrives with 1 % of that, and its "
        "speed is taken over ten contacts. Free beads collide chaotically behind the front: far contacts of like runs "
        "differ by some per cent, fits over many contacts do not.",
        tuple(row if pulses.from_source else _alone(row) for row in _rows(pulses)),
        tuple(_pictures(pulses)),
    )


def _rows(pulses: Pulses) -> Iterator[Row]:
    yield from _rows_of_decay(pulses)
    yield from _rows_of_speed(pulses)
    yield from _rows_of_collapse(pulses)
    yield from _rows_of_dissipation(pulses)
    if pulses.elastic is not None:
        elastic, _ = pulses.elastic
        if elastic.contacts >= _ELASTIC:
            yield Row(
                f"Elastic chain, {elastic.name}: peak force at contact {_ELASTIC} over E*R*^2",
                "",
                None,
                float(elastic.largest[_ELASTIC - 1]) / elastic.scales.force,
                "thesis Fig. 2.11",
                "Theory: thesis 4.5 for an impulse; while this pulse lasts bead 2 moves already.",
                elastic_peak(elastic.impulse),
            )


def _alone(row: Row) -> Row:
    """Of other beads: the source's constants are those of its brass."""
    return dataclasses.replace(row, source=None, where="", remark="")


def _tag(wave: Wave) -> str:
    return f"I {wave.impulse:.3g} ({wave.name})"


def _rows_of_decay(pulses: Pulses) -> Iterator[Row]:
    weakest, where = pulses.weakest, "thesis 2.25"
    yield Row(f"a: peak force at contact 1 over E*R*^2 I, {_tag(weakest)}", "", START, weakest.normalised[0], where)
    for wave in reversed(pulses.chosen):
        slopes = [f"{wave.decay(1, last):.3f} to contact {last}" for last in (5, 7)]
        remark = f"No pure exponential: {', '.join(slopes)}."
        if wave is not weakest:
            remark += " The decay is the faster the larger the impulse; the source fitted the weakest load alone."
        yield Row(f"b: decay of the peak force per contact, contacts 1 to 3, {_tag(wave)}", "", DECAY,
                  wave.decay(1, 3), where, remark)  # fmt: skip
    for wave in pulses.chosen:
        if wave.transition is not None:
            remark = (
                "The source saw 6 to 10 and took 7 for all. Ours: the first contact that a later wave presses more."
            )
            yield Row(f"Start of the second regime, contact, {_tag(wave)}", "", SWITCH, wave.transition,
                      "thesis 2.2.4", remark)  # fmt: skip
    for wave in pulses.chosen:
        first, last = _FAR[0], min(_FAR[1], wave.contacts)
        if last < _LEAST_FAR:
            continue
        fit = wave.force_power(first, last)
        yield Row(f"C: mean of (x/R*) F/(E*R*^2 I), contacts 10 to {last}, {_tag(wave)}", "", INVERSE,
                  wave.inverse_constant(10, last), "thesis 2.26", _steps(wave, last))  # fmt: skip
        yield Row(f"Power of the peak force with distance, contacts {first} to {last}, {_tag(wave)}", "", -1.0,
                  fit.exponent, "thesis 2.26",
                  "Waves that merge make steps in the curve; near yield the chain turns elastic.")  # fmt: skip


def _steps(wave: Wave, last: int) -> str:
    values = 4 * wave.number[9:last] * wave.normalised[9:last]
    return f"Between {values.min():.2f} and {values.max():.2f} from contact to contact."


def _rows_of_speed(pulses: Pulses) -> Iterator[Row]:
    where = "thesis 2.2.3, Fig. 2.15"
    for wave in pulses.chosen:
        farthest = min(_FAR[1], wave.contacts)
        for last in (_MIDDLE, farthest) if farthest >= _LEAST_FAR else ():
            distance, force = wave.speed_powers(10, last)
            low = float(wave.largest[last - 1]) / wave.run.law.yield_force
            remark = f"Peak force at contact {last}: {low:.2g} F_y. " + (
                "Nearer to yield the elastic power 1/6 of the force comes back, which makes -1/6 of the distance."
                if last > _MIDDLE
                else "It depends by some 0.02 on what counts as arrival, which the source does not say."
            )
            yield Row(f"Power of the leading speed with distance, contacts 10 to {last}, {_tag(wave)}", "", -0.2,
                      distance.exponent, where, remark)  # fmt: skip
            yield Row(f"Power of the leading speed with the peak force, contacts 10 to {last}, {_tag(wave)}", "", 0.2,
                      force.exponent, where, remark)  # fmt: skip
    contact = np.arange(20.0, min(_FAR[1], pulses.contacts) - 5)
    fit = pulses.impulse_power(contact) if len(contact) > 10 else None
    if fit is not None:
        yield Row("Power of the leading speed with the impulse, at equal places from contact 20 on", "", 1 / 6,
                  fit.exponent, where, "Depends on the range by some 0.01.")  # fmt: skip


def _rows_of_collapse(pulses: Pulses) -> Iterator[Row]:
    for group, chosen in zip(pulses.groups, pulses.chosen, strict=True):
        for wave in group:
            if wave is chosen:
                continue
            ratio = wave.largest[:_COLLAPSE] / chosen.largest[:_COLLAPSE] - 1
            far = wave.inverse_constant(10, pulses.contacts) / chosen.inverse_constant(10, pulses.contacts) - 1
            near = np.abs(ratio[4:]).max()
            remark = f"Contacts 5 to {_COLLAPSE}: {near:.1%}; mean of n F from contact 10 on: {far:+.1%}."
            if wave.duration > 50:
                remark += f" A pulse of {wave.duration:.0f} tau is not short."
            name = f"Largest difference in peak force, contacts 1 to {_COLLAPSE}, {_tag(wave)} against {chosen.name}"
            yield Row(name, "", None, float(np.abs(ratio).max()), "thesis Fig. 2.14", remark)


def _rows_of_dissipation(pulses: Pulses) -> Iterator[Row]:
    for wave in pulses.chosen if pulses.from_source else ():
        last = min(_LAST, wave.contacts)
        summed, integral = (f(last, wave.peak_unit)[-1] for f in (model_dissipation, integrated_dissipation))
        ours = float(wave.dissipated[last - 1])
        constant = last * QUADRATIC[0] / summed
        remark = (
            f"The source claims 6 % at most. Its integral in place of the sum gives {integral / wave.energy_unit:.4g} "
            f"({ours / integral - 1:+.0%}): it drops half of contact 1, which holds {wave.dissipated[0] / ours:.0%}."
        )
        if constant > 0.1:
            remark += f" The constant d0 alone, at every contact, makes {constant:.0%} of the sum."
        yield Row(f"Dissipated up to contact {last} over F_y alpha_y, {_tag(wave)}; source: sum of 2.28", "",
                  summed / wave.energy_unit, ours / wave.energy_unit, "thesis Fig. 2.16", remark)  # fmt: skip
    if not pulses.from_source:
        return
    law = pulses.weakest.run.law
    remarks = ("Depends on the range of the fit.",
               "Depends on the range of the fit, and even changes sign.", "")  # fmt: skip
    names = ((f"{d} of 2.28, fitted to the law up to {FITTED_TO:g} N", unit)
             for d, unit in (("d0", "J"), ("d1", "J/N"), ("d2", "J/N^2")))  # fmt: skip
    for name, printed, ours, remark in zip(names, QUADRATIC, quadratic_of(law), remarks, strict=True):
        yield Row(*name, printed, float(ours), "thesis 2.28", remark)
    for force in (1e3, 5e3):
        printed = float(np.polynomial.polynomial.polyval(force, QUADRATIC))
        ours = float(dissipation_at(law, np.array([force]))[0])
        remark = "The print overestimates small forces: 2.28 is a fit." if force < 2e3 else ""
        yield Row(f"Dissipated by a contact of {force:g} N; source: 2.28 with its constants", "J", printed, ours,
                  "thesis 2.28", remark)  # fmt: skip


def _pictures(pulses: Pulses) -> Iterator[Picture]:
    if pulses.elastic is not None:
        yield Picture(
            "elastoplastic_histories",
            "Force at contacts 5, 10, 15 and 20: elasto-plastic chain, and the elastic one under the same pulse "
            "(dotted, right-hand axis; thesis Fig. 2.11)",
            draw.histories(*pulses.elastic),
        )
        yield Picture(
            "elastoplastic_map",
            "Force by place and time; the elastic chain's crest starts at contact 20 (thesis Fig. 2.12)",
            draw.force_map(*pulses.elastic),
        )
    yield Picture(
        "elastoplastic_peaks",
        "Peak force over impulse along the chain, with the source's two regimes, and all pulses of every impulse "
        "(thesis Figs. 2.13 and 2.14)",
        draw.peaks(pulses),
    )
    yield Picture(
        "elastoplastic_speed",
        "Speed of the leading disturbance over the sixth root of the impulse (thesis Figs. 2.14 and 2.15)",
        draw.speeds(pulses),
    )
    yield Picture(
        "elastoplastic_dissipation",
        "Energy dissipated up to each contact, and the source's model with its own constants (thesis Fig. 2.16)",
        draw.dissipation(pulses),
    )
