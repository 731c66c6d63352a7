"""Square packing, elastic impacts.

The packing has 20 × 20 elastic spheres. The impact at 0.29 m/s in the plane, at an edge, is
transmitted by a sphere at rest that touches two spheres; the impact at 0.65 m/s from above, in the
middle, by one that touches four.
"""

import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from packing import COLOURS, MEASURES, source_impacts

import granwave as gw
from granwave.theory import discrete_width, solitary_lengths

# chains with a wave; s, of the maps
WAVES = {"in-plane": 4, "out-of-plane": 8}
SHOWN = (0.15e-3, 0.30e-3)
ENERGIES = {
    "in-plane": {"central chains": 71.5, "edge chains": 24.5},
    "out-of-plane": {"central chains": 44.3, "strikers": 8.0, "impacted spheres": 47.7},
}  # % of the input
SETTLED = 0.02  # fraction of its last length by which a settled pulse may differ
REBOUND = "The source calls this the remaining energy, which is 4.0 % according to its numbers."
ASYMPTOTIC = (
    "The 13 % of the source are the difference of Chatterjee's asymptotic wave from Nesterenko's; "
    "the source calls the decrease in its simulations similar. Theory: the travelling wave of the "
    "discrete chain."
)


def select(runs):
    return source_impacts(runs)


def name(one):
    return f"square-{one.way}"


def title(one):
    return f"Square packing, {one.way} impact"


def text(one):
    return (
        "The packing has 20 × 20 elastic spheres of 19.05 mm. A striker hits a sphere at rest, "
        f"which touches {len(one.struck)} of them, at {one.speed:g} m/s. Energies are the sum of "
        "kinetic and elastic energy divided by the input. For chains, the value is the largest "
        "energy at any time, without the impacted spheres; for strikers and impacted spheres, it "
        "is the energy after their rebound."
    )


def last_length(found):
    """Last sphere of a chain, counted from 0, at which the wall does not affect the length of the
    pulse.
    """
    return np.flatnonzero(np.isfinite(found[MEASURES[3]][:-2]))[-1]


def rows(one):
    way = one.way
    percent = "% of input"
    paths = {"where": "square packing, Wave Propagation Path"}
    ours = {region: 100 * share for region, share in one.settled.items()}
    chains = {
        f"chain from {ids[0]} to {ids[-1]}": ids[1:]
        for group in one.chains.values()
        for ids in group
    }
    shares = gw.measures.energy_by_region(one.run.result, chains)
    carrying = sum(shares[chain].max() > 0.01 for chain in chains)
    # fmt: off
    for region, source in ENERGIES[way].items():
        yield gw.Row(f"Energy in {region}, {way}", percent, source, ours[region], **paths)
    if way == "in-plane":
        yield gw.Row(f"Energy in strikers and impacted spheres, {way}", percent,
                     ours=ours["strikers"] + ours["impacted spheres"], remark=REBOUND, **paths)
    yield gw.Row(f"Chains with a wave, {way}", source=WAVES[way], ours=carrying, **paths)
    yield gw.Row(f"Largest energy in other spheres, {way}", percent,
        ours=100 * one.energies["other spheres"].max(),
                 theory=0.0, remark="The theory value is due to symmetry.", **paths)
    for time in SHOWN:
        speeds = one.velocity["central chains"][np.abs(one.time - time).argmin()]
        crest = speeds[1:].argmax() + 2
        at = f"at {1e3 * time:.2f} ms, {way}"
        maps = {"where": "square packing, Figs 3 and 6"}
        yield gw.Row(f"Fastest sphere of a central chain {at}", ours=crest, **maps)
        yield gw.Row(f"Its speed {at}", "m/s", ours=speeds[crest - 1], **maps)
    for group, found in one.lengths.items():
        of = f"{group}, {way}"
        last = last_length(found)
        pulse = {"where": "square packing, Pulse Length"}
        for n, (measure, theory) in enumerate(solitary_lengths().items()):
            remark = ("The source states a length of about 5, which is Nesterenko's value.") if n < 2 else "Theory: Nesterenko's wave."
            yield gw.Row(f"Pulse length, {measure}, {of}", "diameters", 5.0 if n < 2 else None, found[measure][last],
                         theory=theory, remark=remark, **pulse)
        half = found[MEASURES[3]]
        theory = solitary_lengths()[MEASURES[3]]
        unsettled = np.flatnonzero(np.abs(half[1 : last + 1] / half[last] - 1) > SETTLED)
        yield gw.Row(f"Half-maximum length, relative decrease from Nesterenko's, {of}", "%", 13.0,
            100 * (1 - half[last] / theory),
                     theory=100 * (1 - discrete_width() / theory), remark=ASYMPTOTIC, **pulse)
        yield gw.Row(f"First sphere with a steady pulse, {of}", source=5.0, ours=unsettled[-1] + 3,
            **pulse,
                     remark="The source states sphere five or six. From this sphere on, the "
                            f"length in our run is within {100 * SETTLED:g} % of its last value.")
    # fmt: on


def pictures(one):
    energy = (
        f"Fraction of the energy in each region against time, {one.way} impact. The fraction is "
        "constant while waves travel along the chains; the fraction of the walls rises when waves "
        "are reflected there"
    )
    speed = (
        f"Speed of every sphere at {len(SHOWN)} instants, {one.way} impact (source Figs 3 and 6). "
        "Waves run along the chains of the impacted spheres; the spheres between them hardly move"
    )
    length = (
        f"Length of the pulse against its position in the chains, by four measures, {one.way} "
        "impact (source Fig. 11). The length becomes constant within a few spheres; it is shorter "
        "than Nesterenko's wave, which holds for a continuum"
    )
    yield gw.Picture("_energies", energy, *energies(one))
    yield gw.Picture("_speeds", speed, *speeds(one))
    yield gw.Picture("_pulses", length, *lengths(one))


def energies(one):
    axes = Figure((4.6, 2.6), layout="constrained").subplots()
    for region, share in one.energies.items():
        if share.max() > 1e-3:
            axes.plot(1e6 * one.time, 100 * share, color=COLOURS[region], label=region)
    axes.set(
        xlabel="Time (µs)",
        ylabel="Energy (% of input)",
        xlim=(0, 1e6 * one.time[-1]),
        ylim=(0, 105),
    )
    axes.figure.legend(loc="outside right upper")
    data = {
        f"{region.replace(' ', '_')}_over_input": share for region, share in one.energies.items()
    }
    return axes.figure, {"time_s": one.time} | data


def speeds(one):
    n = one.size[0] * one.size[1]
    size = 1e3 * one.diameter
    place = 1e3 * one.run.result["spheres/position"][:n, :2]  # mm
    frames = [int(np.abs(one.time - time).argmin()) for time in SHOWN]
    speed = [
        np.linalg.norm(one.run.result.frame(frame, "velocity")[:n], axis=1) for frame in frames
    ]
    figure = Figure((3.5, 2.6), layout="constrained")
    panels = figure.subplots(1, len(SHOWN), sharey=True)
    for axes, time, values in zip(panels, one.time[frames], speed, strict=True):
        own = {
            "units": "xy",
            "offsets": place,
            "offset_transform": axes.transData,
            "cmap": "magma_r",
        }
        discs = axes.add_collection(
            EllipseCollection([size] * n, [size] * n, [0.0] * n, array=values, **own)
        )
        discs.set_clim(0, max(part.max() for part in speed))
        axes.set(
            xlim=(-size / 2, place[:, 0].max() + size / 2),
            ylim=(-size / 2, place[:, 1].max() + size / 2),
        )
        axes.set(aspect="equal", xlabel="x (mm)", title=f"{1e3 * time:.2f} ms")
    panels[0].set_ylabel("y (mm)")
    figure.colorbar(discs, ax=list(panels), label="Speed (m/s)", location="bottom", shrink=0.8)
    data = {
        f"speed_at_{1e6 * one.time[frame]:.0f}_us_m_s": part
        for frame, part in zip(frames, speed, strict=True)
    }
    return figure, {
        "id": np.arange(1, n + 1),
        "x_m": 1e-3 * place[:, 0],
        "y_m": 1e-3 * place[:, 1],
    } | data


def lengths(one):
    figure = Figure((4.4, 3.4), layout="constrained")
    data = {}
    panels = figure.subplots(2, 2, sharex=True)
    for group, found in one.lengths.items():
        chosen = np.arange(1, last_length(found) + 1)
        data[f"{group.split()[0]}_sphere"] = chosen + 1
        for axes, measure in zip(panels.flat, MEASURES, strict=True):
            axes.plot(
                chosen + 1,
                found[measure][chosen],
                "o-",
                color=COLOURS[group],
                markersize=3,
                label=group,
            )
            data[f"{group.split()[0]}_{measure.replace(' ', '_')}_diameters"] = found[measure][
                chosen
            ]
    for axes, (measure, theory) in zip(panels.flat, solitary_lengths().items(), strict=True):
        axes.axhline(theory, color="black", linestyle=":", label="Nesterenko")
        axes.set(title=measure.capitalize(), ylim=(None, 1.04 * theory))
    for axes in panels[1]:
        axes.set_xlabel("Sphere of the chain")
    figure.supylabel("Length (diameters)", fontsize="medium")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure, data
