"""Elasto-plastic chains after a pulse: decay, speed and dissipation, beside thesis 2.2 (Figs. 2.11 to 2.16)."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.chains import plastic_pulses
from granwave.analysis.measures.chains import elastoplastic_model as model
from granwave.analysis.measures.chains.elastoplastic_pulse import PlasticWave, Pulses, collect_pulses
from granwave.analysis.measures.chains.hertz_chain import IMPULSE_LIMIT
from granwave.analysis.studies.chains.runs import from_thesis, uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Elasto-plastic chain after a pulse"
_FAR = (15, 100)  # contacts of the fits in the inverse regime
_LEAST_FAR = 45  # the last contact of such a fit at the least
_COLLAPSE = 15  # contacts up to which runs of one impulse are compared: collisions farther on are chaotic
_SPEED = (10, 95)  # contacts of all fits of the speed
_LEAST_SPEED = 15  # contacts of such a fit at the least
_NEAR = (20, 40)  # contacts of a fit that shows how much the power depends on them
_LEVELS = (0.01, 0.1, 0.5)  # of a contact's largest force: what may count as arrival
_LAST = 87  # contact: x/R* = 348, where Fig. 2.16 ends
_ELASTIC = 20  # contact where the elastic wave is taken


def select(runs: Sequence[FinishedRun]) -> list[Pulses]:
    """All impulses together."""
    pulses = collect_pulses(uniform(runs, "elastoplastic"), uniform(runs, "hertz"))
    return [pulses] if pulses else []


def text(pulses: Pulses) -> str:
    """Describe the runs."""
    impulses, n = ", ".join(f"{wave.impulse:.3g}" for wave in pulses.chosen), sum(map(len, pulses.groups))
    return (
        f"{n} {'chains' if n > 1 else 'chain'} under the elasto-plastic law, impulse {impulses} in units of E*R*^2 "
        "tau. Peak forces are the largest ever at a contact; the leading disturbance arrives with 1 % of that, and its "
        "speed is taken over ten contacts. Free beads collide chaotically behind the front: far contacts of like runs "
        "differ by some per cent, fits over many contacts do not."
    )


def rows(pulses: Pulses) -> Iterator[Row]:
    """Decay, speed, collapse and dissipation; of other beads without the source's values, which are of its brass."""
    for part in (_rows_of_decay, _rows_of_speed, _rows_of_collapse, _rows_of_dissipation, _rows_of_elastic):
        for row in part(pulses):
            if _from_source(pulses):
                yield row
            elif row.ours is not None:
                yield dataclasses.replace(row, source=None, where="", remark="")


def pictures(pulses: Pulses) -> Iterator[Picture]:
    """Histories and a map beside the elastic chain, peaks, speeds and dissipation."""
    if pulses.elastic is not None:
        caption = (
            "Force at contacts 5, 10, 15 and 20: elasto-plastic chain, and the elastic one under the same pulse "
            "(dotted, right-hand axis; thesis Fig. 2.11)"
        )
        yield Picture("elastoplastic_histories", caption, plastic_pulses.histories(*pulses.elastic))
        caption = "Force by place and time; the elastic chain's crest starts at contact 20 (thesis Fig. 2.12)"
        yield Picture("elastoplastic_map", caption, plastic_pulses.force_map(*pulses.elastic))
    caption = (
        "Peak force over impulse along the chain, with the source's two regimes, and all pulses of every impulse "
        "(thesis Figs. 2.13 and 2.14)"
    )
    yield Picture("elastoplastic_peaks", caption, plastic_pulses.peaks(pulses, with_model=_from_source(pulses)))
    caption = "Speed of the leading disturbance over the sixth root of the impulse (thesis Figs. 2.14 and 2.15)"
    yield Picture("elastoplastic_speed", caption, plastic_pulses.speeds(pulses))
    caption = "Energy dissipated up to each contact, and the source's model with its own constants (thesis Fig. 2.16)"
    yield Picture(
        "elastoplastic_dissipation", caption, plastic_pulses.dissipation(pulses, with_model=_from_source(pulses))
    )


def _from_source(pulses: Pulses) -> bool:
    """The beads are those of the thesis."""
    return from_thesis(pulses.weakest.run, yielding=True)


def _tag(wave: PlasticWave) -> str:
    return f"I {wave.impulse:.3g} ({wave.name})"


def _rows_of_decay(pulses: Pulses) -> Iterator[Row]:
    weakest, where = pulses.weakest, "thesis 2.25"
    what = f"a: peak force at contact 1 over E*R*^2 I, {_tag(weakest)}"
    yield Row(what, "", model.START, weakest.normalised[0], where)
    for wave in reversed(pulses.chosen):
        slopes = [f"{wave.decay(1, last):.3f} to contact {last}" for last in (5, 7)]
        remark = f"No pure exponential: {', '.join(slopes)}."
        if wave is not weakest:
            remark += " The decay is the faster the larger the impulse; the source fitted the weakest load alone."
        yield Row(f"b: decay of the peak force per contact, contacts 1 to 3, {_tag(wave)}", "", model.DECAY,
                  wave.decay(1, 3), where, remark)  # fmt: skip
    for wave in pulses.chosen:
        if wave.transition is not None:
            yield Row(f"Start of the second regime, contact, {_tag(wave)}", "", model.SWITCH, wave.transition,
                      "thesis 2.2.4", "The source saw 6 to 10 and took 7 for all. Ours: the first contact that a later "
                      "wave presses more.")  # fmt: skip
    for wave in pulses.chosen:
        first, last = _FAR[0], min(_FAR[1], wave.contacts)
        if last < _LEAST_FAR:
            continue
        steps = wave.place[9:last] * wave.normalised[9:last]
        yield Row(f"C: mean of (x/R*) F/(E*R*^2 I), contacts 10 to {last}, {_tag(wave)}", "", model.INVERSE,
                  wave.inverse_constant(10, last), "thesis 2.26",
                  f"Between {steps.min():.2f} and {steps.max():.2f} from contact to contact.")  # fmt: skip
        yield Row(f"Power of the peak force with distance, contacts {first} to {last}, {_tag(wave)}", "", -1.0,
                  wave.force_power(first, last).exponent, "thesis 2.26",
                  "Waves that merge make steps in the curve; near yield the chain turns elastic.",
                  digits=2)  # fmt: skip


def _rows_of_speed(pulses: Pulses) -> Iterator[Row]:
    where, first = "thesis 2.2.3, Fig. 2.15", _SPEED[0]
    last = min(_SPEED[1], *(wave.last_speed for wave in pulses.chosen))
    if last - first < _LEAST_SPEED:
        return
    for wave in pulses.chosen:
        of_distance, of_force = wave.speed_powers(first, last)
        levels = ", ".join(f"{wave.speed_powers(first, last, level)[0].exponent:.2f}" for level in _LEVELS)
        low = float(wave.largest[last - 1]) / wave.run.law.yield_force
        remark = f"Arrival at 1, 10, 50 % of a contact's largest force: {levels}."
        if last > _NEAR[1]:
            near = wave.speed_powers(*_NEAR)[0].exponent
            remark += f" Contacts {_NEAR[0]} to {_NEAR[1]} alone: {near:.2f}."
        remark += f" The source says neither level nor range. Peak force at contact {last}: {low:.2g} F_y."
        what = f"contacts {first} to {last}, {_tag(wave)}"
        yield Row(f"Power of the leading speed with distance, {what}", "", -0.2, of_distance.exponent, where, remark,
                  digits=2)  # fmt: skip
        yield Row(f"Power of the leading speed with the peak force, {what}", "", 0.2, of_force.exponent, where, "",
                  digits=2)  # fmt: skip
    if (law := pulses.impulse_power(np.arange(first, last + 1.0))) is not None:
        remark = (
            "The source contradicts itself: with F ~ I/x and a speed that depends on F alone the powers with I and "
            "with 1/x are one number, so its 1/6 and 1/5 cannot both hold."
        )
        yield Row(f"Power of the leading speed with the impulse, contacts {first} to {last}", "", 1 / 6, law.exponent,
                  where, remark, digits=2)  # fmt: skip


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
    if not _from_source(pulses):
        return
    for wave in pulses.chosen:
        last = min(_LAST, wave.contacts)
        summed = model.summed_dissipation(last, wave.peak_unit)[-1]
        integral = model.integrated_dissipation(last, wave.peak_unit)[-1]
        ours = float(wave.dissipated[last - 1])
        constant = last * model.QUADRATIC[0] / summed
        remark = (
            "Theory: the source's sum of 2.28. "
            "It calls small impulses accurate and others within 6 %. Its integral in place of the sum gives "
            f"{integral / wave.energy_unit:.4g} "
            f"({ours / integral - 1:+.0%}): it drops half of contact 1, which holds {wave.dissipated[0] / ours:.0%}."
        )
        if constant > 0.1:
            remark += f" The constant d0 alone, at every contact, makes {constant:.0%} of the sum."
        yield Row(f"Dissipated up to contact {last} over F_y alpha_y, {_tag(wave)}", "", None, ours / wave.energy_unit,
                  "thesis Fig. 2.16", remark, summed / wave.energy_unit)  # fmt: skip
    law, where = pulses.weakest.run.law, "thesis 2.28"
    forces = np.array([1e3, 5e3])
    compared = "; ".join(
        f"at {force:g} N {float(model.dissipation_of(force)):.4g} J for {of_law:.4g} J of the law"
        for force, of_law in zip(forces, model.dissipation_at(law, forces), strict=True)
    )
    range_matters = "Depends on the range of the fit"
    converted = "Printed as normalised; taken as {} of brass contacts of R = 4.76 mm, where the law has them."
    units = (
        ("d0", "J", f"{range_matters}. With the printed constants a contact dissipates {compared}."),
        ("d1", "J/N", f"{range_matters}, and even changes sign."),
        ("d2", "J/N^2", "Fitted to the law."),
    )
    for (what, unit, remark), printed, fitted in zip(units, model.QUADRATIC, model.quadratic_of(law), strict=True):
        name = f"{what} of 2.28, fitted to the law up to {model.FITTED_TO:g} N"
        yield Row(name, unit, printed, None, where, f"{converted.format(unit)} {remark}", float(fitted))


def _rows_of_elastic(pulses: Pulses) -> Iterator[Row]:
    if pulses.elastic is not None and pulses.elastic[0].contacts >= _ELASTIC:
        wave = pulses.elastic[0]
        yield Row(f"Elastic chain, {wave.name}: peak force at contact {_ELASTIC} over E*R*^2", "", None,
                  float(wave.largest[_ELASTIC - 1]) / wave.scales.force, "thesis Fig. 2.11",
                  "Theory: thesis 4.5 for an impulse; while this pulse lasts bead 2 moves already.",
                  IMPULSE_LIMIT * wave.impulse**1.2)  # fmt: skip
