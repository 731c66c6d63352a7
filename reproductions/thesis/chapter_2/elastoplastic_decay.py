"""Elasto-plastic chain after a pulse: decay.

The ten chains have the elasto-plastic law and impulses of 0.46, 0.23 and 0.046 in units of E*R*^2
tau. Peak forces are the largest forces of a contact at any time. Behind the front free beads
collide chaotically: distant contacts of similar runs differ by a few per cent, but fits over many
contacts do not.
"""

import numpy as np
from matplotlib.figure import Figure
from plastic_waves import (
    DECAY,
    INVERSE,
    PLACE,
    SPACING,
    START,
    SWITCH,
    SWITCHES,
    common_decay,
    groups,
    peak_force,
    usual,
)

import granwave as gw

FAR = 15  # first contact of the fits in the inverse regime
# largest contact at which runs with equal impulse are compared: collisions farther on are chaotic
COLLAPSE = 15
FITTED = 20  # last contact of the source's fit for the weakest load
MERGER = 21  # contact at which the first trailing wave of that load meets the leading one


def rows(runs):
    found = groups(runs)
    waves = list(map(usual, found))
    weakest = waves[-1]
    yield gw.Row(
        f"a: peak force at contact 1 / (E*R*^2 I), {weakest.tag}",
        source=START,
        ours=weakest.normalised[0],
        where="thesis 2.25",
    )
    yield gw.Row(
        f"Contact at which a trailing wave meets the leading one, {weakest.tag}",
        source=MERGER,
        ours=weakest.merger,
        where="thesis 2.2.3",
        remark="Our value is the contact where the leading peak stops falling.",
    )
    start, decay = common_decay(waves, SWITCH)
    for name, source, ours in (("a", START, start), ("b", DECAY, decay)):
        yield gw.Row(
            f"{name} of one law 2.25 for the leading waves of {len(waves)} impulses, contacts 1 to {SWITCH}",
            source=source,
            ours=ours,
            where="thesis 2.25, Fig. 2.13",
            digits=3,
            remark="The decay is fitted by least squares of the logarithm of the force. The "
            "source draws one curve for three impulses, and states that it was fitted to the "
            "smallest impulse; the smallest impulse alone has other constants.",
        )
    yield gw.Row(
        f"b: decay of the leading wave per contact, contacts 1 to {FITTED}, {weakest.tag}",
        source=DECAY,
        ours=weakest.decay(1, FITTED),
        where="thesis 2.25",
        digits=3,
        remark="According to the source its law was fitted to this wave. Our decay is not "
        f"exponential: it falls from {weakest.decay(1, 2):.3f} at contact 1 to {weakest.decay(FITTED - 1, FITTED):.3f} "
        f"at contact {FITTED}.",
    )
    for wave in reversed(waves):
        yield gw.Row(
            f"b: decay of the leading wave per contact, contacts 1 to {SWITCH}, {wave.tag}",
            source=DECAY,
            ours=wave.decay(1, SWITCH),
            where="thesis 2.25",
            digits=3,
            remark="The source uses one decay for all impulses over these contacts. Our decay is "
            "faster for larger impulses.",
        )
    for wave in waves:
        yield gw.Row(
            f"Start of the second regime, contact, {wave.tag}, at most",
            source=SWITCHES[1],
            ours=wave.merger,
            where="thesis 2.2.3, 2.2.4",
            bound=True,
            remark="In the source the second regime starts where a trailing wave merges with the "
            f"leading wave: from {SWITCHES[0]} to {SWITCHES[1]}, about {SWITCH}, or {MERGER} for "
            "the smallest impulse in another place. Our value is the contact where the leading "
            "peak stops falling.",
        )
        yield gw.Row(
            f"First contact with a larger force in a later wave, {wave.tag}",
            ours=wave.transition,
            where="thesis 2.2.4",
            remark=f"The later force is {wave.pressed_more(wave.transition):.1%} larger.",
        )
        steps = wave.x[9:] * wave.normalised[9:]
        last = wave.contacts
        yield gw.Row(
            f"C: mean of (x/R*) F/(E*R*^2 I), contacts 10 to {last}, {wave.tag}",
            source=INVERSE,
            ours=wave.inverse_constant(),
            where="thesis 2.26",
            remark=(
                f"The value for single contacts is between {steps.min():.2f} and {steps.max():.2f}."
            ),
        )
        yield gw.Row(
            f"Exponent of the peak force against distance, contacts {FAR} to {last}, {wave.tag}",
            source=-1.0,
            ours=wave.force_power(FAR, last).exponent,
            where="thesis 2.26",
            digits=2,
            remark="Merging waves make steps in the curve; near yield the chain becomes elastic.",
        )
    for group, chosen in zip(found, waves, strict=True):
        for wave in group:
            if wave is chosen:
                continue
            ratio = np.abs(wave.largest[:COLLAPSE] / chosen.largest[:COLLAPSE] - 1)
            far = wave.inverse_constant() / chosen.inverse_constant() - 1
            remark = (
                f"For contacts 5 to {COLLAPSE} the difference is {ratio[4:].max():.1%}, and "
                f"for the mean of n F from contact 10 on {far:+.1%}."
            )
            if wave.duration > 50:
                remark += f" The pulse lasts {wave.duration:.0f} tau and is not short."
            name = f"Largest difference in peak force, contacts 1 to {COLLAPSE}, {wave.tag} against {chosen.name}"
            yield gw.Row(name, ours=ratio.max(), where="thesis Fig. 2.14", remark=remark)


def pictures(runs):
    found = groups(runs)
    contact = usual(found[0]).number
    figure = Figure((7, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    data = {"contact": contact, "model": peak_force(contact)}
    for n, group in enumerate(found):
        wave = usual(group)
        left.plot(wave.x, wave.normalised, ".", markersize=4, label=wave.label)
        for wave, line in zip(group, ("-", "--", ":", "-."), strict=False):
            data[f"peak_force_normalised_{wave.name}"] = force = wave.largest / wave.scales.force
            right.semilogy(wave.x, force * 4.0**-n, f"{line}C{n}", linewidth=0.9, label=wave.name)
    early = contact[contact <= 12]
    late = SPACING * contact[3:]
    left.semilogy(
        SPACING * early, START * np.exp(-DECAY * (early - 1)), "--k", label="2.25 by contact"
    )
    left.semilogy(late, INVERSE / late, "k", label="2.26")
    left.set(
        xlabel=PLACE, ylabel=r"Peak force $F/(E^*R^{*2}\,\bar I)$", xlim=(0, 160), ylim=(5e-4, 1e-1)
    )
    title = r"All pulses (each impulse $\times 1/4$ of the last)"
    right.set(xlabel=PLACE, ylabel=r"Peak force $F/E^*R^{*2}$, moved", title=title)
    left.legend(fontsize=7)
    right.legend(fontsize=6, ncols=2)
    caption = "Peak force / impulse along the chain: all impulses follow the source's two laws, 2.25 and then 2.26 "
    caption += (
        "(thesis Fig. 2.13). Right: pulses of one impulse differ only near the load (Fig. 2.14)"
    )
    yield gw.Picture("elastoplastic_peaks", caption, figure, data)
