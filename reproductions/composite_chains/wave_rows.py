"""Rows and figure of the waves in and behind the section of a composite chain (source 3.3)."""

import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure
from waves import NAMES

import granwave as gw
from granwave.theory import hertz_von_mises_yield_factor

PLACE = "composite chain, "
EXPLAINED = 1.1  # factor on a printed ratio up to which ours agrees


# fmt: off
def of_reflections(waves, from_end):
    """Times of the waves at the watched contact, and reflected energy (source Fig. 6)."""
    found = waves.reflections
    for key, wave in ((key, found[key]) for key in NAMES if key in found):
        remark = f"The force is {wave.force:.3g} N."
        if key == "BRW" and "FRW" not in found:
            remark += (" No forward reflection above 0.5 % of the largest force follows. The "
                       f"forward wave at {1e3 * waves.second.time:.3g} ms, with "
                       f"{waves.second.force:.3g} N, is the second wave of the incident train, "
                       "which enters without a reflection.")
        if key == "FRW" and not wave.forth:
            remark += " A second wave travels back here at the same time, and the forces add up."
        if key == "end":
            remark = f"The force is {wave.force:.3g} N; the time counts from the impact."
        yield gw.Row(f"{NAMES[key]} {waves.at}", "ms", from_end if key == "end" else None, 1e3 * wave.time,
                     PLACE + ("3.3" if key == "end" else "Fig. 6"), remark)
    yield gw.Row(f"Energy travelling back {waves.at} / energy leaving the section", "",
                 ours=waves.passed(waves.middle)[1] / waves.passed(waves.last)[0], where=f"{PLACE}Fig. 6",
                 remark="Energies are measured until a pulse returns from the end of the chain. "
                        "The source states a much higher value for PTFE than for brass.")


def of_output(waves, longest, kind):
    """Second peak of the output, and the wave of the incident train that causes it (source Fig. 7).
    """
    out = waves.transmitted
    train = longest.train
    if len(out) < 2:
        return
    late = out[1].time - out[0].time
    yield gw.Row(f"Second output peak / first output peak, N2 = {waves.n}, {kind}",
        ours=out[1].force / out[0].force,
                 where=f"{PLACE}Fig. 7", remark=f"The second peak is {1e6 * late:.0f} µs later.")
    if len(train) < 2:
        return
    behind = train[1].time - train[0].time
    remark = (f"The second wave enters {1e6 * behind:.0f} µs later, before anything is reflected: "
              "the incident pulse becomes a train.")
    # the time between them may change while they pass the section
    if abs(late - behind) < 0.25 * behind:
        remark += (" The second output peak is this wave. The source attributes the peak to a "
                   "collision of the incident pulse with the BRW.")
    yield gw.Row(f"Second wave into the section / first wave, N2 = {longest.n}, {kind}",
                 ours=train[1].force / train[0].force, where=f"{PLACE}Fig. 7", remark=remark)


def of_energy(waves, kind):
    """Energy by section, and the largest energy density along the chain (source Fig. 8)."""
    until = waves.before_return
    where = {"where": f"{PLACE}Fig. 8"}
    for share, section in zip(waves.shares.T, ("first steel", "light", "second steel"), strict=True):
        yield gw.Row(f"Energy of the {section} section / input, N2 = {waves.n}, {kind}",
                     ours=np.interp(until, waves.time, share),
                     remark=f"The value is taken at {1e6 * until:.0f} µs, when a pulse returns "
                            "from the end of the chain.", **where)
    density = waves.density
    place = list(waves.chain.array("chain/id")).index
    for part, first, last, remark in (
        ("steel before the section", 3, waves.first - 2,
         "In the source the energy density is constant here. In our run the pulse is still "
         "forming at this position."),
        ("section without its last bead", waves.first, waves.last - 1,
            "In the source only yielding reduces the energy density."),
    ):
        yield gw.Row(f"Change of the largest energy density along the {part}, N2 = {waves.n}, {kind}", "%",
                     ours=100 * (density[place(last)] / density[place(first)] - 1), remark=remark, **where)


def of_pressure(section, source):
    """Largest pressure in the first and the last contact of the section of an elastic chain (source
    3.3).
    """
    first, last = (1e-6 * section.pressure(bead) for bead in (section.first, section.last - 1))
    force = section.peak(section.first) * (source[0] / first) ** 3
    at = f"N2 = {section.n}, elastic"
    where = f"{PLACE}3.3"
    yield gw.Row(f"Largest pressure, first contact of the section, {at}", "MPa", source[0], first, where,
                 "The source value is the largest compressive stress in the contact area, "
                 "without N2 and position. In Hertz's contact the largest compressive stress "
                 f"is the largest pressure; the mean pressure is {2 / 3 * first:.0f} MPa. An "
                 f"elastic contact with the printed stress would carry {force:.2g} N. According "
                 "to the source the contact yields, which limits the pressure (see the rows of "
                 "yielding chains).")
    yield gw.Row(f"Largest pressure, last contact of the section, {at}", "MPa", source[1], last, where,
                 "Without dissipation the pressure does not change along the section; in the "
                 "source it falls.")
    ratio = hertz_von_mises_yield_factor(section.material.poisson_ratio)
    for name, printed, pressure in (("first", source[0], first), ("last", source[1], last)):
        yield gw.Row(f"Largest von Mises stress, {name} contact of the section, {at}",
                     "MPa", printed, pressure / ratio,
                     where, "The source value is interpreted here as the largest von Mises "
                            "stress of its elastic finite elements, below the surface. The "
                            "source calls it compressive and compares it with the yield "
                            "strength.")
    fallen = source[1] / source[0]
    before = 1e-6 * section.pressure(section.first - 1)
    yield gw.Row("Largest pressure, first contact of the section / contact with the steel before "
                 f"it, {at}", "",
                 fallen, first / before, where,
                 "The source value is the ratio of its two stresses, interpreted here as the "
                 "change from the contact with steel to the contacts within the section. This "
                 "interpretation nearly holds for PTFE only.")
    yield gw.Row(f"Last of these pressures / first, {at}", ours=last / first, where=where,
                 remark=f"The two values of the source have the ratio {fallen:.3f}. Any stress "
                        "grows as the cube root of the force, so that the force falls to "
                        f"{fallen**3:.2f} of its first value within the section. This "
                        "decrease requires dissipation.")


def of_yielded_pressure(section, source, kind):
    """Mean pressure in the first and the last contact of the section of a yielding chain (source
    3.3).
    """
    means = [1e-6 * section.yielded_pressure(bead) for bead in (section.first, section.last - 1)]
    at = f"N2 = {section.n}, {kind}"
    remarks = (
        "The source value is the largest compressive stress in a contact area that yields. Our "
        "mean pressure at the largest overlap is a lower limit of the largest pressure. The yield "
        "strength is our choice.",
        "The force falls along the section by yielding, as in the source.",
    )
    for name, printed, ours, remark in zip(("first", "last"), source, means, remarks, strict=True):
        yield gw.Row(f"Mean pressure, {name} contact of the section, {at}", "MPa", printed, ours, f"{PLACE}3.3", remark)
    fallen = source[1] / source[0]
    remark = "The source value is the ratio of its two stresses, without N2."
    if means[1] / means[0] > EXPLAINED * fallen:
        remark += (" The difference is not explained, since beyond yield the pressure hardly "
                   "depends on the force.")
    yield gw.Row(f"Last of these mean pressures / first, {at}", "", fallen, means[1] / means[0],
        f"{PLACE}3.3",
                 remark)
# fmt: on


def waves_and_energy(waves):
    shown = waves["elastic"]
    chain = waves["elastic"].chain
    k = chain.contact_between(shown.middle)
    time = 1e6 * shown.time
    place = 1e3 * chain.place
    force = shown.section.force(shown.middle)
    largest = np.abs(shown.flow).max()
    figure = Figure((7, 6.8), layout="constrained")
    (left, right), (energy, density) = figure.subplots(2, 2, height_ratios=(1.5, 1))
    norm = SymLogNorm(0.01 * largest, vmin=-largest, vmax=largest)
    places = place[: shown.flow.shape[1]]
    mesh = left.pcolormesh(
        places, time, shown.flow, cmap="RdBu", norm=norm, rasterized=True, shading="nearest"
    )
    for bead in (shown.first - 1, shown.last):
        left.axvline(place[chain.contact_between(bead)], color="k", linewidth=0.6, linestyle="--")
    left.axvline(place[k], color="0.6", linewidth=0.6, linestyle=":")
    left.set(xlabel="Position (mm)", ylabel="Time (µs)")
    figure.colorbar(mesh, ax=left, location="top", label="Force (N), negative in backward waves")
    right.semilogx(np.maximum(force, 1e-9 * force.max()), time)
    for name, wave in shown.reflections.items():
        right.annotate("from the end" if name == "end" else name, (wave.force, 1e6 * wave.time), (6, 0),
                       textcoords="offset points", va="center", fontsize=7)  # fmt: skip
    right.set(
        xlabel=f"Force (N) between beads {shown.middle} and {shown.middle + 1}", ylim=(0, time[-1])
    )
    right.set_xlim(3e-3 * force.max(), 20 * force.max())
    watched = np.array([(wave.time, wave.force, wave.forth) for wave in shown.watched]).T
    data = {"time_s": shown.time, "contact_N": force, "flow_N": shown.flow[:, k]}
    data |= dict(zip(("wave_time_s", "wave_force_N", "wave_forth"), watched, strict=True))
    for line, (kind, one) in zip(("-", "--"), waves.items(), strict=False):
        slug = kind.replace(" ", "_")
        ids = one.chain.array("chain/id")
        data[f"{slug}_time_s"] = one.time
        for n, part in enumerate(("first steel", "light", "second steel")):
            energy.plot(
                1e6 * one.time, one.shares[:, n], f"{line}C{n}", label=part if line == "-" else None
            )
            data[f"{slug}_{part}_over_input".replace(" ", "_")] = one.shares[:, n]
        bead = np.where(
            ids <= one.section.case.packing.size[0], ids, 0
        )  # the striker before bead 1
        density.plot(bead, one.density, f"o{line}", markersize=2.5, label=kind)
        data |= {f"{slug}_bead": bead, f"{slug}_density_J_m3": one.density}
    density.axvspan(shown.first - 0.5, shown.last + 0.5, color="0.9", linewidth=0)
    energy.set(xlabel="Time (µs)", ylabel="Energy / input", xlim=(0, None), ylim=(0, 1.3))
    density.set(
        xlabel="Bead (0: striker; shaded: section)",
        ylabel="Largest energy density (J/m³)",
        ylim=(0, None),
    )
    energy.legend(ncols=3, fontsize=6)
    density.legend()
    return figure, data
