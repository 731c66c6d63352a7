"""Composite chains: output pulse against the length of the section, and waves in and behind the
section.
"""

import math

import numpy as np
from matplotlib.figure import Figure
from section import FROM_END, SPEEDS, STRESSES, WATCHED, by, sections
from wave_rows import (
    of_energy,
    of_output,
    of_pressure,
    of_reflections,
    of_yielded_pressure,
    waves_and_energy,
)
from waves import Waves

import granwave as gw
from granwave.measures import exponential_decay
from granwave.theory import discrete_speed

PLACE = "composite chain, "
MEASURED = PLACE + "section 4, measured"
FITTED = PLACE + "Fig. 11"
# difference of the source's finite elements from its measurements, brass (%); its striker (m/s)
ERROR = 4.2
STRIKER = 0.626
# m/s, from these elements in a chain of steel, with the striker of the composite chains (table 3)
STEEL_SPEED = 595.0
PULSE = 0.719  # force of the wave of an impulse (thesis 4.5)
# m, between surfaces; slope of the holder; m/s^2
ROLLED = 0.010
SLOPE = math.radians(3)
GRAVITY = 9.81
OF_SPEED = (
    "The elastic chain has no dissipation. The study of the measured speeds lists the possible "
    "reasons for the difference that were tested.",
    "The yield strength is our choice, since the source gives none.",
)
OF_CHANGE = (
    "As the section grows, the distance between the sensors contains less of the fast steel, "
    "which lowers V even without dissipation.",
    "With our choice of the yield strength V falls much more.",
)


def select(runs):
    """Chains by the material of the section, then by the yielding parts, by rising length."""
    groups = by(sections(runs), lambda section: section.light)
    return [by(groups[light], lambda section: section.kind) for light in SPEEDS if light in groups]


def light_of(kinds):
    return next(iter(kinds.values()))[0].light


def name(kinds):
    return f"composite-{light_of(kinds)}"


def title(kinds):
    return f"Composite chain with {light_of(kinds)}"


def text(kinds):
    found = [section for alike in kinds.values() for section in alike]
    lengths = sorted({section.n for section in found})
    return (
        f"There are {len(found)} chains of {found[0].case.packing.size[0]} beads; {lengths[0]} to {lengths[-1]} "
        f"of the beads are of {light_of(kinds)} ({', '.join(kinds)}). A sensor measures the mean "
        "of the two contact forces of its bead. V is the distance of the sensors divided by the "
        "time between their first peaks; lambda is the ratio of these peaks, output to incident."
    )


def watched(found):
    """Chain whose waves are shown."""
    return min(found, key=lambda section: abs(section.n - WATCHED))


def rows(kinds):
    light = light_of(kinds)
    for kind, found in kinds.items():
        yield from of_speed(kind, found, SPEEDS[light])
        yield from of_ratio(kind, found)
    yield gw.Row(
        "Speed of the striker", "m/s", STRIKER, theory=math.sqrt(2 * GRAVITY * math.sin(SLOPE) * ROLLED),
        where=f"{PLACE}section 4", remark="The source value is the speed after a free fall of 20 "
                                          "mm. If the striker is released with its centre 20 mm "
                                          "before the centre of the first bead, it slides only 10 "
                                          "mm down a slope of 3 degrees.",
    )  # fmt: skip
    shown = watched(kinds["elastic"])
    yield from of_reflections(Waves(shown), FROM_END[light])
    for kind, found in kinds.items():
        yield from of_output(Waves(watched(found)), Waves(found[-1]), kind)
        yield from of_energy(Waves(watched(found)), kind)
    yield from of_pressure(shown, STRESSES[light])
    for kind, found in kinds.items():
        if kind != "elastic":
            yield from of_yielded_pressure(watched(found), STRESSES[light], kind)


# fmt: off
def of_speed(kind, found, measured):
    n = [section.n for section in found]
    speed = np.array([section.speed for section in found])
    yields = kind != "elastic"
    for k in sorted({0, len(n) - 1}):
        source = measured.get(n[k])
        yield gw.Row(f"V, N2 = {n[k]}, {kind}", "m/s", source, speed[k], MEASURED if source else FITTED,
                     OF_SPEED[yields] if source else "")
    printed = 100 * (measured[24] / measured[3] - 1) if measured else 0
    yield gw.Row(f"Change of V from N2 = {n[0]} to {n[-1]}, {kind}", "%", ours=100 * (speed[-1] / speed[0] - 1),
                 where=MEASURED if measured else FITTED,
                 remark=(f"The two values of V in the source give {printed:.1f} %. {OF_CHANGE[yields]}") if measured else "")
    if measured:
        errors = [abs(v / measured[one] - 1) for one, v in zip(n, speed, strict=True) if one in measured]
        yield gw.Row(f"Largest error of V against the measurement, {kind}", "%", ERROR,
            100 * max(errors),
                     f"{PLACE}section 4", "The source value is the error of its finite elements "
                                          "for all N2. Our value is the error for the two N2 "
                                          "for which a measured V is printed.")
    if measured and not yields:
        yield from over_steel(found, measured)
    if fit := exponential_decay(np.array(n), speed):
        formula = f"V = {fit.end:.1f} + {fit.span:.1f} exp(-N2/{fit.length:.2f}) m/s, to {fit.residual:.2g} rms."
        yield gw.Row(f"Number of beads within which V approaches its limit by a factor of e, "
                     f"{kind}",
            ours=fit.length, where=FITTED, remark=formula)


def over_steel(found, measured):
    """V over the speed of the wave in a chain of steel; a common modulus, density or striker does
    not affect it.
    """
    scales = found[0].chain.scales
    force = PULSE * scales.impulse_force(found[0].chain.mass * STRIKER)
    steel = discrete_speed() * scales.nesterenko(force)
    slow = steel / STEEL_SPEED
    for section in (one for one in found if one.n in measured):
        most = (1 + ERROR / 100) * measured[section.n] / STEEL_SPEED
        left = section.speed / ((1 + ERROR / 100) * measured[section.n] * slow) - 1
        yield gw.Row(f"V / speed in a chain of steel, N2 = {section.n}, elastic, at most", "", most,
                     section.speed / steel, f"{PLACE}section 4, Table 3", bound=True, digits=4,
                     remark=f"The bound is the V of the finite elements of the source, at most {ERROR:g} "
                            f"% above the measurement, divided by their {STEEL_SPEED:g} m/s in "
                            f"steel. The discrete wave in steel has {steel:.0f} m/s, so that these "
                            f"elements are {100 * (slow - 1):.1f} % too slow. Our V is {100 * (section.speed / measured[section.n] - 1):.1f} "
                            f"% above the measurement; {100 * left:.1f} % or more of this is not "
                            "explained.")


def of_ratio(kind, found):
    n = [section.n for section in found]
    ratio = np.array([section.ratio for section in found])
    for k in sorted({0, len(n) - 1}):
        yield gw.Row(f"lambda, N2 = {n[k]}, {kind}", ours=ratio[k], where=FITTED)
    if kind == "elastic":
        yield gw.Row(f"Largest difference of lambda over all N2, {kind}", "%", ours=100 * np.ptp(ratio) / ratio.max(),
                     where=FITTED, remark="Without dissipation lambda does not depend on the "
                                          "length, so that the decay in the source is "
                                          "dissipation.")
    elif fit := exponential_decay(np.array(n), ratio):
        formula = f"lambda = {fit.end:.3f} + {fit.span:.3f} exp(-N2/{fit.length:.2f}), to {fit.residual:.2g} rms."
        yield gw.Row(f"Number of beads within which lambda approaches its limit by a factor of e, "
                     f"{kind}",
            ours=fit.length, where=FITTED,
                     remark=formula)
# fmt: on


def pictures(kinds):
    light = light_of(kinds)
    caption = (
        f"{light}: force at the second sensor by length of the section (source Figs 7, 10); speed "
        "and height of this pulse, with exponential fits (source Fig. 11). A longer section also "
        "slows elastic pulses; the further decrease is due to yielding"
    )
    yield gw.Picture(
        f"composite_{light.replace('-', '_')}_length",
        caption,
        *against_length(kinds, SPEEDS[light]),
    )
    shown = watched(kinds["elastic"])
    caption = (
        f"{light}, {shown.n} beads: force against position and time (slanted lines: waves), "
        "and at one contact, with the "
    )
    caption += "source's names (Fig. 6). Below: energy by section (dashed: yielding), and its largest density (Fig. 8)"
    waves = {kind: Waves(watched(found)) for kind, found in kinds.items()}
    yield gw.Picture(
        f"composite_{light.replace('-', '_')}_waves", caption, *waves_and_energy(waves)
    )


def against_length(kinds, measured):
    figure = Figure((7, 5.2), layout="constrained")
    data = {}
    panels = figure.subplots(2, 2)
    panels[0, 1].sharey(panels[0, 0])
    for axes, marker, (kind, found) in zip(panels[0], "os", kinds.items(), strict=False):
        slug = kind.replace(" ", "_")
        shortest = found[0]
        for section in (*found[:-2:3], found[-1]):
            axes.plot(1e6 * section.time, section.output, label=f"$N_2$ = {section.n}")
            data |= {
                f"{slug}_{section.n}_time_s": section.time,
                f"{slug}_{section.n}_output_N": section.output,
            }
        until = shortest.time < shortest.arrived
        axes.plot(1e6 * shortest.time[until], shortest.incident[until], "k", label="incident")
        data |= {f"{slug}_incident_time_s": shortest.time, f"{slug}_incident_N": shortest.incident}
        axes.set(xlabel="Time (µs)", ylabel="Sensor force (N)", title=kind, ylim=(0, None))
        axes.set_xlim(0, 1.25e6 * found[-1].arrived)
        n = np.array([section.n for section in found])
        data[f"{slug}_n"] = n
        for below, what in zip(panels[1], ("speed", "ratio"), strict=True):
            values = np.array([getattr(section, what) for section in found])
            data[f"{slug}_speed_m_s" if what == "speed" else f"{slug}_ratio"] = values
            (marks,) = below.plot(n, values, marker, markersize=4, label=kind)
            if fit := exponential_decay(n, values):
                fine = np.linspace(n[0], n[-1], 200)
                below.plot(fine, fit(fine), color=marks.get_color())
    if measured:
        panels[1, 0].plot(list(measured), list(measured.values()), "k*", label="source, measured")
    panels[1, 0].set(ylabel="Speed $V$ (m/s)")
    panels[1, 1].set(ylabel=r"$\lambda$, output / incident peak", ylim=(0, None))
    for axes in panels[1]:
        axes.set_xlabel("Beads in the section $N_2$")
    panels[1, 0].legend()
    panels[0, len(kinds) - 1].legend()
    return figure, data
