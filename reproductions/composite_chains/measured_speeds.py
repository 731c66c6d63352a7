"""Measured speeds of composite chains: possible reasons for the difference.

Elastic composite chains are compared with the two measured speeds for several moduli of the brass,
with Hertz's law and with the contact law of the source's finite elements, under the weight of the
beads, and for other definitions of the arrival. The source suspects the properties of its
materials. Its finite elements have a different contact law: Fig. 5 prints the exponent 1.554, and
table 3 the force, both for spheres of 4.76 mm. The modulus of the brass is chosen to give the
measured speed with the longest section, and the result for the shortest section is compared with
the measurement.
"""

import numpy as np
from matplotlib.figure import Figure
from section import SPEEDS, by, sections

import granwave as gw
from granwave.measures import Chain, first_peak

PLACE = "composite chain, "
WHERE = f"{PLACE}section 4, measured"
GIGA = 1e9
MEASURED = SPEEDS["brass-composite"]
ERROR = 4.2  # most that the source's finite elements differ from its measurements, %
# its finite elements in a chain of steel (table 3): force, N; speed, m/s; its contacts from 0
FORCE = 27.22
SPEED = 595.0
EARLY = 4
LATE = 9
EXPONENT = 1.554
FRONT = 0.1  # of the first peak, where a front is taken to arrive
LAWS = {"hertz": "Hertz's law", "power": "law of the source's elements"}


def sections_by_law(runs):
    """Chains of brass without weight, by contact law and number of beads in the section."""
    light = [run for run in runs if run.case.replace and run.case.precompression is None]
    return by(sections(light), lambda section: (section.case.contact.law, section.n))


def speeds_of(runs):
    """Moduli of the brass, GPa, and the speeds V for each modulus, m/s, by contact law and number
    of beads in the section.
    """
    speeds = {}
    for key, group in sections_by_law(runs).items():
        points = sorted((one.material.youngs_modulus / GIGA, one.speed) for one in group)
        speeds[key] = np.array(points).T
    return speeds


def steel_wave(run):
    """Peak force, N, and speed, m/s, of the wave in the chain of steel."""
    chain = Chain(run)
    (early, _), (late, force) = (chain.first_peak(contact) for contact in (EARLY, LATE))
    return force, (LATE - EARLY) * chain.scales.diameter / (late - early)


def front_speed(section):
    """Speed V from the times at which the forces reach a fraction of their first peaks, m/s."""
    arrivals = []
    for force in (section.incident, section.output):
        height = FRONT * first_peak(section.time, force)[1]
        after = int(np.argmax(force >= height))
        steps = slice(after - 1, after + 1)
        arrivals.append(np.interp(height, force[steps], section.time[steps]))
    return section.speed * (section.arrived - section.start) / (arrivals[1] - arrivals[0])


def rows(runs):
    for run in runs:
        if not run.case.replace:
            yield of_steel(run)
    speeds = speeds_of(runs)
    for law in LAWS:
        if curves := {n: curve for (name, n), curve in speeds.items() if name == law}:
            yield from of_law(law, curves, speeds)
    for (law, n), group in sections_by_law(runs).items():
        if law == "hertz":
            printed = max(group, key=lambda section: section.material.youngs_modulus)
            yield of_front(n, printed)
    loaded = [run for run in runs if run.case.replace and run.case.precompression is not None]
    for section in sections(loaded):
        yield of_weight(section)


# fmt: off
def of_steel(run):
    force, speed = steel_wave(run)
    return gw.Row(
        "Wave speed in steel, law of the source's elements", "m/s", SPEED, speed,
        f"{PLACE}Fig. 5, Table 3",
        digits=4,
        remark=f"The law is a power of the approach with the printed exponent {EXPONENT:g}. Its "
               f"constant is chosen to give the printed force, {FORCE:g} N (here {force:.2f} N). "
               "Hertz's law gives 27.5 N and 613 m/s.",
    )


def above_measured(curve, n):
    """Excess of the speed at the printed modulus, %."""
    return 100 * (curve[1][-1] / MEASURED[n] - 1)


def of_law(law, curves, speeds):
    for n, (moduli, values) in curves.items():
        remark = f"The finite elements of the source are at most {ERROR:g} % above the measurement."
        if law == "hertz" and ("power", n) in speeds:
            left = above_measured(speeds["power", n], n)
            remark += (f" With the contact law of these finite elements and {n} light beads "
                       f"(N2 = {n}), our chain is {left:.1f} % above the measurement, at least "
                       f"{left - ERROR:.1f} % more than the finite elements.")
        if law == "power":
            remark += (" Their contact law was determined for spheres of 4.76 mm. In spheres of "
                       "10 mm their elements are finer relative to the contact, and the law may "
                       "be closer to Hertz's law.")
        yield gw.Row(f"V, N2 = {n}, brass of {moduli[-1]:g} GPa, {LAWS[law]}", "m/s",
                     MEASURED[n], values[-1], WHERE, digits=4, remark=remark)
    shortest = min(curves)
    longest = max(curves)
    moduli, values = curves[longest]
    modulus = np.interp(MEASURED[longest], values, moduli)
    yield gw.Row(
        f"V, N2 = {shortest}, with the modulus of brass that gives V of N2 = {longest}, "
        f"{LAWS[law]}", "m/s",
        MEASURED[shortest], np.interp(modulus, *curves[shortest]), WHERE, digits=4,
        remark=f"The modulus is {modulus:.1f} GPa; the source prints {moduli[-1]:g} GPa and "
               "suspects a mismatch of material properties.",
    )


def of_front(n, section):
    return gw.Row(
        f"V, N2 = {n}, by arrivals at {100 * FRONT:g} % of the peaks", "m/s", MEASURED[n],
        front_speed(section), WHERE, digits=4,
        remark=f"With arrivals at the peaks, as in the source, V is {section.speed:.1f} m/s.",
    )


def of_weight(section):
    return gw.Row(
        f"V, N2 = {section.n}, beads on a slope of 3 degrees under their weight", "m/s",
        MEASURED[section.n], section.speed, WHERE, digits=4,
        remark="The static force makes waves faster.",
    )
# fmt: on


def pictures(runs):
    speeds = speeds_of(runs)
    if not speeds:
        return
    figure = Figure((3.5, 2.8), layout="constrained")
    axes = figure.subplots()
    data = {}
    for (law, n), (moduli, values) in speeds.items():
        colour = f"C{sorted(MEASURED).index(n)}"
        line = "-" if law == "hertz" else "--"
        axes.plot(moduli, values, f"o{line}", color=colour, markersize=4, label=f"{n}, {LAWS[law]}")
        data |= {f"{law}_{n}_modulus_GPa": moduli, f"{law}_{n}_speed_m_s": values}
    for colour, n in enumerate(sorted(MEASURED)):
        axes.axhline(MEASURED[n], color=f"C{colour}", linestyle=":")
    axes.set(xlabel="Modulus of the brass (GPa)", ylabel="Speed $V$ (m/s)")
    axes.legend(fontsize=6)
    caption = (
        "Speed V against the modulus of the brass, with 3 and 24 beads of brass, for Hertz's law "
        "and for the law of the source's finite elements; dotted: measured"
    )
    yield gw.Picture("composite_measured_speeds", caption, figure, data)
