"""Settled packings, scatter of 5 µm.

Impacts at 5 m/s act on FCC packings of 10 × 10 × 6 brass spheres of 10 mm, whose diameters are up
to 5 µm smaller. The spheres are at their lattice sites, with gaps, or are settled without friction
by a static load that remains during the impact. Values are means over seeds with 95 % confidence
intervals. Loaded contacts are contacts of two spheres at the start. Static equilibrium without
friction requires three contacts per sphere, including contacts with walls. The residual is the
largest net force on a sphere divided by the largest static contact force.
"""

import math

from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import differ_significantly, estimate

COLOURS = {
    "identical spheres, as placed": "k",
    "as placed": "C0",
    "settled under gravity": "C1",
    "settled under 10 kPa on top": "C4",
    "settled under 100 kPa on top": "C2",
}


def state(run):
    """Description of the preparation of a packing."""
    stage = run.case.precompression
    if stage is None:
        return "as placed" if run.case.packing.diameter_scatter else "identical spheres, as placed"
    return "settled under " + (
        "gravity" if stage.kind == "gravity" else f"{1e-3 * stage.pressure:g} kPa on top"
    )


def by_state(runs):
    return {name: [run for run in runs if state(run) == name] for name in COLOURS}


def added(run):
    """Dynamic force at the bottom, N, by time, s."""
    time, force = (run.result[f"walls/bottom/{name}"] for name in ("time", "force"))
    return time, force - force[0]


def transmitted(runs):
    return estimate([added(run)[1].max() for run in runs])


def contacts(run):
    """Number of loaded contacts of two spheres at the start, divided by the number of spheres; 0 as
    placed.
    """
    return (
        float(run.result["prestage/contacts"][-1]) / run["n_spheres"]
        if run.case.precompression
        else 0.0
    )


def tables(runs):
    states = by_state(runs).values()
    residual = [
        max((run["precompression_residual"] or math.nan) for run in same) for same in states
    ]
    yield (
        "Settled and as placed",
        {
            "Packing": list(COLOURS),
            "Seeds": [len(same) for same in states],
            "Loaded contacts (per sphere)": [
                estimate(list(map(contacts, same))) for same in states
            ],
            "Residual": [float(f"{one:.2g}") for one in residual],
            "Arrival at the bottom (µs)": [
                estimate([1e6 * run["base_arrival_s"] for run in same]) for same in states
            ],
            "Largest dynamic force there (N)": [transmitted(same) for same in states],
            "Dissipated (% of input)": [
                estimate([100 * run["dissipated_fraction"] for run in same]) for same in states
            ],
        },
    )


def verdict(runs):
    forces = {name: transmitted(same) for name, same in by_state(runs).items()}
    placed = forces["as placed"]
    for name in list(COLOURS)[2:]:
        force = forces[name]
        alike = "" if differ_significantly(force, placed) else "; the difference is not significant"
        yield (
            f"Packing {name}: the dynamic force at the bottom is {force.mean:.0f} ± "
            f"{force.half_width:.0f} N, {force.mean / placed.mean:.3g} times the force below "
            f"the packing that is not settled ({placed.mean:.0f} ± {placed.half_width:.0f} "
            f"N{alike})."
        )


def pictures(runs):
    figure = Figure((3.4, 3.2), layout="constrained")
    data = {}
    axes = figure.subplots()
    for number, (name, same) in enumerate(by_state(runs).items(), start=1):
        for place, run in enumerate(same, start=1):
            time, force = added(run)
            line = ":" if name.startswith("like") else "-"
            axes.plot(
                1e6 * time,
                force,
                line,
                color=COLOURS[name],
                linewidth=1.0,
                label="" if place > 1 else name,
            )
            data |= {f"time_{number}_{place}_s": time, f"force_{number}_{place}_N": force}
    axes.set(xlabel="Time (µs)", ylabel="Dynamic force at the bottom (N)", xlim=(0, None))
    figure.legend(loc="outside lower left", ncols=2, fontsize=7)
    caption = (
        "Dynamic force at the bottom against time, one curve per seed. Settled spheres touch, so "
        "that the wave arrives earlier and varies less between seeds than through the gaps of "
        "spheres as placed. Dotted: identical spheres"
    )
    yield gw.Picture("settled_packing", caption, figure, data)
