"""Composite chains: the output pulse against the section's length, and waves in and behind the section."""

import math

import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure
from section import FROM_END, SPEEDS, STRESSES, WATCHED, by, sections
from waves import NAMES, Waves

import granwave as gw
from granwave.measures import exponential_decay
from granwave.theory import hertz_von_mises_yield_factor

PLACE = "composite chain, "
MEASURED, FITTED = PLACE + "section 4, measured", PLACE + "Fig. 11"
ERROR, STRIKER = 4.2, 0.626  # of the source's elements against its measurements, brass (%); its striker (m/s)
ROLLED, SLOPE, GRAVITY = 0.010, math.radians(3), 9.81  # m, between surfaces; slope of the holder; m/s^2
OF_SPEED = (
    "Nothing dissipates here. A striker of 0.41 m/s would give the measured V: 0.626 m/s is a free fall of 20 mm, not "
    "the source's slope of 3 degrees. Its finite elements, 2 to 3 % slow, are up to 4.2 % above the measured.",
    "The yield strength is our choice: the source gives none.",
)
OF_CHANGE = (
    "the distance of the sensors holds ever less of the fast section, and this alone lowers V, without loss.",
    "the yield strength, which is our choice, does not fit them: V falls far more.",
)


def select(runs):
    """Chains by the material of the section, then by what yields, by rising length."""
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
        f"{len(found)} chains of {found[0].case.packing.size[0]} beads, {lengths[0]} to {lengths[-1]} of them "
        f"{light_of(kinds)} ({', '.join(kinds)}). A sensor reads the mean of its bead's two contact forces. V: "
        "distance of the sensors over the time between the first peaks there; lambda: the ratio of these peaks, output "
        "over incident."
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
        where=f"{PLACE}section 4", remark="The source's is that of a free fall of 20 mm. Released with its centre 20 "
        "mm before that of the first bead it slides 10 mm down a slope of 3 degrees.",
    )  # fmt: skip
    shown = watched(kinds["elastic"])
    yield from of_reflections(Waves(shown), FROM_END[light])
    for kind, found in kinds.items():
        yield from of_output(Waves(watched(found)), Waves(found[-1]), kind)
        yield from of_energy(Waves(watched(found)), kind)
    yield from of_pressure(shown, STRESSES[light])


# fmt: off
def of_speed(kind, found, measured):
    n, speed = [section.n for section in found], np.array([section.speed for section in found])
    yields = kind != "elastic"
    for k in sorted({0, len(n) - 1}):
        source = measured.get(n[k])
        yield gw.Row(f"V, N2 = {n[k]}, {kind}", "m/s", source, speed[k], MEASURED if source else FITTED,
                     OF_SPEED[yields] if source else "")
    printed = 100 * (measured[24] / measured[3] - 1) if measured else 0
    yield gw.Row(f"Change of V from N2 = {n[0]} to {n[-1]}, {kind}", "%", ours=100 * (speed[-1] / speed[0] - 1),
                 where=MEASURED if measured else FITTED,
                 remark=f"From the source's two values of V: {printed:.1f} %; {OF_CHANGE[yields]}" if measured else "")
    if measured:
        errors = [abs(v / measured[one] - 1) for one, v in zip(n, speed, strict=True) if one in measured]
        yield gw.Row(f"Largest error of V against the measured, {kind}", "%", ERROR, 100 * max(errors),
                     f"{PLACE}section 4", "The source's: over all N2, of its finite elements. Ours: over the N2 whose "
                     "measured V it prints.")
    if fit := exponential_decay(np.array(n), speed):
        formula = f"V = {fit.end:.1f} + {fit.span:.1f} exp(-N2/{fit.length:.2f}) m/s, to {fit.residual:.2g} rms."
        yield gw.Row(f"N2 within which V nears its end by 1/e, {kind}", ours=fit.length, where=FITTED, remark=formula)


def of_ratio(kind, found):
    n, ratio = [section.n for section in found], np.array([section.ratio for section in found])
    for k in sorted({0, len(n) - 1}):
        yield gw.Row(f"lambda, N2 = {n[k]}, {kind}", ours=ratio[k], where=FITTED)
    if kind == "elastic":
        yield gw.Row(f"Largest difference of lambda over all N2, {kind}", "%", ours=100 * np.ptp(ratio) / ratio.max(),
                     where=FITTED, remark="Without loss it does not depend on the length: the source's decay is loss.")
    elif fit := exponential_decay(np.array(n), ratio):
        formula = f"lambda = {fit.end:.3f} + {fit.span:.3f} exp(-N2/{fit.length:.2f}), to {fit.residual:.2g} rms."
        yield gw.Row(f"N2 within which lambda nears its end by 1/e, {kind}", ours=fit.length, where=FITTED,
                     remark=formula)


def of_reflections(waves, from_end):
    """Times of the waves at the watched contact, and energy that turns back (source Fig. 6)."""
    found = waves.reflections
    for key, wave in ((key, found[key]) for key in NAMES if key in found):
        remark = f"{wave.force:.3g} N."
        if key == "BRW" and "FRW" not in found:
            remark += " No forth reflection above 0.5 % of the largest force follows it"
            remark += "".join(f"; the wave forth at {1e3 * second.time:.3g} ms, {second.force:.3g} N, is the second of "
                              "the incident train, which enters without any reflection" for second in waves.further[:1])
            remark += "."
        if key == "FRW" and not wave.forth:
            remark += " It meets a second wave back here, and their forces add up."
        if key == "end":
            remark = f"{wave.force:.3g} N; time from the impact on."
        yield gw.Row(f"{NAMES[key]} {waves.at}", "ms", from_end if key == "end" else None, 1e3 * wave.time,
                     PLACE + ("3.3" if key == "end" else "Fig. 6"), remark)
    yield gw.Row(f"Energy back {waves.at} over energy out of the section", "",
                 ours=waves.passed(waves.middle)[1] / waves.passed(waves.last)[0], where=f"{PLACE}Fig. 6",
                 remark="Until a pulse is back from the chain's end. Source: much higher for PTFE than for brass.")


def of_output(waves, longest, kind):
    """Second peak of the output, and the wave of the incident train that makes it (source Fig. 7)."""
    out, train = waves.transmitted, longest.train
    if len(out) < 2:
        return
    late = out[1].time - out[0].time
    yield gw.Row(f"Second output peak over the first, N2 = {waves.n}, {kind}", ours=out[1].force / out[0].force,
                 where=f"{PLACE}Fig. 7", remark=f"{1e6 * late:.0f} µs later.")
    if len(train) < 2:
        return
    behind = train[1].time - train[0].time
    remark = f"{1e6 * behind:.0f} µs later, before anything is reflected: the incident pulse becomes a train."
    if abs(late - behind) < 0.25 * behind:  # the time between them may change on their way through the section
        remark += " The second output peak is this wave; for the source it comes of a collision of the incident " \
            "pulse with the BRW."
    yield gw.Row(f"Second wave into the section over the first, N2 = {longest.n}, {kind}",
                 ours=train[1].force / train[0].force, where=f"{PLACE}Fig. 7", remark=remark)


def of_energy(waves, kind):
    """Energy by section, and the largest energy density along the chain (source Fig. 8)."""
    until, where = waves.before_return, {"where": f"{PLACE}Fig. 8"}
    for share, section in zip(waves.shares.T, ("first steel", "light", "second steel"), strict=True):
        yield gw.Row(f"Energy of the {section} section over the input, N2 = {waves.n}, {kind}",
                     ours=np.interp(until, waves.time, share),
                     remark=f"At {1e6 * until:.0f} µs, when a pulse is back from the chain's end.", **where)
    density, place = waves.density, list(waves.chain.array("chain/id")).index
    for part, first, last, remark in (
        ("steel before the section", 3, waves.first - 2,
         "The source: constant. The pulse still finds its shape here."),
        ("section, its last bead left out", waves.first, waves.last - 1, "The source: falls, by yielding alone."),
    ):
        yield gw.Row(f"Change of the largest energy density along the {part}, N2 = {waves.n}, {kind}", "%",
                     ours=100 * (density[place(last)] / density[place(first)] - 1), remark=remark, **where)


def of_pressure(section, source):
    """Largest pressure in the first and the last contact of the section of an elastic chain (source 3.3)."""
    first, last = (1e-6 * section.pressure(bead) for bead in (section.first, section.last - 1))
    mises = first / hertz_von_mises_yield_factor(section.material.poisson_ratio)
    force = section.peak(section.first) * (source[0] / first) ** 3
    at, where = f"N2 = {section.n}, elastic", f"{PLACE}3.3"
    yield gw.Row(f"Largest pressure, first contact of the section, {at}", "MPa", source[0], first, where,
                 "The source: largest compressive stress in the contact area, without N2 and place. In Hertz's contact "
                 f"that is the largest pressure; the mean one is {2 / 3 * first:.0f}, the largest von Mises stress "
                 f"{mises:.0f} MPa. The source's would be a force of {force:.2g} N.")
    yield gw.Row(f"Largest pressure, last contact of the section, {at}", "MPa", source[1], last, where,
                 "Without loss it stays as it was; the source's has fallen along the section.")
    fallen = source[1] / source[0]
    yield gw.Row(f"Last of these pressures over the first, {at}", ours=last / first, where=where,
                 remark=f"The source's two values: {fallen:.3f}. Any stress goes with the cube root of the force, "
                 f"which then falls to {fallen**3:.2f} of the first within the section: only loss can do that.")
# fmt: on


def pictures(kinds):
    light = light_of(kinds)
    caption = f"{light}: pulse at the second sensor (source Figs. 7, 10), and its speed and height (source Fig. 11)"
    yield gw.Picture(f"composite_{light.replace('-', '_')}_length", caption, *against_length(kinds, SPEEDS[light]))
    shown = watched(kinds["elastic"])
    caption = (
        f"{light}, {shown.n} beads: waves in the chain, and at one contact of the section (source Fig. 6); energy by "
        "section (dips: in the contact with the end), and its largest density along the chain (source Fig. 8)"
    )
    waves = {kind: Waves(watched(found)) for kind, found in kinds.items()}
    yield gw.Picture(f"composite_{light.replace('-', '_')}_waves", caption, *waves_and_energy(waves))


def against_length(kinds, measured):
    figure, data = Figure((7, 5.2), layout="constrained"), {}
    panels = figure.subplots(2, 2)
    panels[0, 1].sharey(panels[0, 0])
    for axes, marker, (kind, found) in zip(panels[0], "os", kinds.items(), strict=False):
        slug, shortest = kind.replace(" ", "_"), found[0]
        for section in (*found[:-2:3], found[-1]):
            axes.plot(1e6 * section.time, section.output, label=f"$N_2$ = {section.n}")
            data |= {f"{slug}_{section.n}_time_s": section.time, f"{slug}_{section.n}_output_N": section.output}
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
    panels[1, 0].set(xlabel="Beads in the section $N_2$", ylabel="Speed $V$ (m/s)")
    panels[1, 1].set(
        xlabel="Beads in the section $N_2$", ylabel=r"$\lambda$, output over incident peak", ylim=(0, None)
    )
    panels[1, 0].legend()
    panels[0, len(kinds) - 1].legend()
    return figure, data


def waves_and_energy(waves):
    shown, chain = waves["elastic"], waves["elastic"].chain
    k, time, place = chain.contact_between(shown.middle), 1e6 * shown.time, 1e3 * chain.place
    force, largest = shown.section.force(shown.middle), np.abs(shown.flow).max()
    figure = Figure((7, 6.8), layout="constrained")
    (left, right), (energy, density) = figure.subplots(2, 2, height_ratios=(1.5, 1))
    norm = SymLogNorm(0.01 * largest, vmin=-largest, vmax=largest)
    places = place[: shown.flow.shape[1]]
    mesh = left.pcolormesh(places, time, shown.flow, cmap="RdBu", norm=norm, rasterized=True, shading="nearest")
    for bead in (shown.first - 1, shown.last):
        left.axvline(place[chain.contact_between(bead)], color="k", linewidth=0.6, linestyle="--")
    left.axvline(place[k], color="0.6", linewidth=0.6, linestyle=":")
    left.set(xlabel="Place (mm)", ylabel="Time (µs)")
    figure.colorbar(mesh, ax=left, location="top", label="Force (N), negative while the beads move back")
    right.semilogx(np.maximum(force, 1e-9 * force.max()), time)
    for name, wave in shown.reflections.items():
        right.annotate("from the end" if name == "end" else name, (wave.force, 1e6 * wave.time), (6, 0),
                       textcoords="offset points", va="center", fontsize=7)  # fmt: skip
    right.set(xlabel=f"Force (N) between beads {shown.middle} and {shown.middle + 1}", ylim=(0, time[-1]))
    right.set_xlim(3e-3 * force.max(), 20 * force.max())
    watched = np.array([(wave.time, wave.force, wave.forth) for wave in shown.watched]).T
    data = {"time_s": shown.time, "contact_N": force, "flow_N": shown.flow[:, k]}
    data |= dict(zip(("wave_time_s", "wave_force_N", "wave_forth"), watched, strict=True))
    for line, (kind, one) in zip(("-", "--"), waves.items(), strict=False):
        slug, ids = kind.replace(" ", "_"), one.chain.array("chain/id")
        data[f"{slug}_time_s"] = one.time
        for n, part in enumerate(("first steel", "light", "second steel")):
            energy.plot(1e6 * one.time, one.shares[:, n], f"{line}C{n}", label=part if line == "-" else None)
            data[f"{slug}_{part}_over_input".replace(" ", "_")] = one.shares[:, n]
        bead = np.where(ids <= one.section.case.packing.size[0], ids, 0)  # the striker before bead 1
        density.plot(bead, one.density, f"o{line}", markersize=2.5, label=kind)
        data |= {f"{slug}_bead": bead, f"{slug}_density_J_m3": one.density}
    density.axvspan(shown.first - 0.5, shown.last + 0.5, color="0.9", linewidth=0)
    energy.set(xlabel="Time (µs)", ylabel="Energy over the input", xlim=(0, None), ylim=(0, 1.3))
    density.set(xlabel="Bead (0: striker; shaded: section)", ylabel="Largest energy density (J/m³)", ylim=(0, None))
    energy.legend(ncols=3, fontsize=6)
    density.legend()
    return figure, data
