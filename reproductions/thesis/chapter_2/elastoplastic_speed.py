"""Elasto-plastic chain after a pulse: speed.

The ten chains have the elasto-plastic law and impulses of 0.46, 0.23 and 0.046 in units of E*R*^2
tau. The leading disturbance arrives at a contact with 1 % of the largest force of the contact. Its
speed is taken over ten contacts.
"""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from plastic_waves import HALF, PLACE, SPACING, groups, usual

import granwave as gw
from granwave.measures import power_law

FIRST = 10  # contact of all fits


def rows(runs):
    waves = list(map(usual, groups(runs)))
    last = waves[0].contacts - HALF
    where = {"where": "thesis 2.2.3, Fig. 2.15", "digits": 2}
    # fmt: off
    for wave in waves:
        of_distance, of_force = wave.speed_powers(FIRST, last)
        levels = [f"{wave.speed_powers(FIRST, last, level)[0].exponent:.2f}" for level in (0.01, 0.1, 0.5)]
        near = wave.speed_powers(20, 40)[0].exponent
        low = wave.largest[last - 1] / wave.law.yield_force
        what = f"contacts {FIRST} to {last}, {wave.tag}"
        yield gw.Row(f"Exponent of the leading speed against distance, {what}", source=-0.2, ours=of_distance.exponent,
                     remark="With arrival at 1, 10 and 50 % of the largest force of a contact "
                            f"the power is {', '.join(levels)}. Contacts 20 to 40 give "
                            f"{near:.2f}. The source states neither the level nor the range. "
                            f"The peak force at contact {last} is {low:.2g} F_y.", **where)
        yield gw.Row(f"Exponent of the leading speed against the peak force, {what}", source=0.2, ours=of_force.exponent,
                     **where)
    contact = np.arange(FIRST, last + 1.0)
    speed = [np.exp(np.mean(np.log(np.interp(contact, *wave.speed())))) for wave in waves]
    law = power_law(np.array([wave.reduced for wave in waves]), np.array(speed))
    yield gw.Row(f"Exponent of the leading speed against the impulse, contacts {FIRST} to {last}", source=1 / 6,
                 ours=law.exponent, remark="The two powers of the source contradict each other. "
                                           "With F ~ I/x and a speed that depends only on F, "
                                           "the powers with I and with 1/x are equal; 1/6 and "
                                           "1/5 cannot both hold.", **where)
    # fmt: on


def pictures(runs):
    figure = Figure((3.5, 2.8), layout="constrained")
    axes = figure.subplots()
    data = {}
    for n, group in enumerate(groups(runs)):
        for wave in group:
            number, speed = wave.speed()
            scaled = SPACING * wave.scales.time * speed / wave.reduced ** (1 / 6)
            data |= {f"place_{wave.name}": SPACING * number, f"scaled_speed_{wave.name}": scaled}
            width, label = (1.2, wave.label) if wave is usual(group) else (0.6, None)
            axes.loglog(SPACING * number, scaled, f"C{n}", linewidth=width, label=label)
    guide = SPACING * np.array([8.0, 0.95 * wave.contacts])
    axes.loglog(guide, 0.29 * (guide / guide[0]) ** -0.2, "--k", label="power -1/5")
    axes.set(
        xlabel=PLACE,
        ylabel=r"Leading speed $(v\,\tau/R^*)\,/\,\bar I^{1/6}$",
        xticks=(20, 50, 100, 200),
    )
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.legend(fontsize=7)
    caption = (
        "Speed of the leading disturbance divided by the sixth root of the impulse, against "
        "distance; thin: other pulses of an impulse (thesis Figs 2.14, 2.15). If curves coincide, "
        "the root holds; compare their slope with -1/5"
    )
    yield gw.Picture("elastoplastic_speed", caption, figure, data)
