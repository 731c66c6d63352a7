"""Square packing with yielding.

The same impacts with the elasto-plastic law, which are not in the source."""

import numpy as np
from matplotlib.figure import Figure
from packing import COLOURS, Packing

import granwave as gw

# spheres of a central chain
FIRST = 2
SECOND = 6
COLOURS = COLOURS | {"edge chains": "black"}


def select(runs):
    """Select the runs by way of impact, in rising order of the striker's velocity."""
    packings = sorted(
        (Packing(run) for run in runs if run.case.contact.law == "elastoplastic"),
        key=lambda one: one.speed,
    )
    series = [[one for one in packings if one.way == way] for way in ("in-plane", "out-of-plane")]
    return [one for one in series if one]


def name(series):
    return f"square-yielding-{series[0].way}"


def title(series):
    return f"Square packing with yielding, {series[0].way} impact"


def text(series):
    material = series[0].case.material
    return (
        f"The same impacts are run with the elasto-plastic law and a yield strength of {1e-6 * material.yield_strength:g} "
        f"MPa ({material.name}: {material.source}); the source has no such runs. Harder spheres "
        "dissipate less. Values of the chains are their largest energies at any time."
    )


def rows(series):
    for one in series:
        at = f"{one.speed:g} m/s, {one.way}"
        largest = one.velocity["central chains"].max(axis=0)
        # fmt: off
        for what, region in (("Dissipated", "dissipated"), ("Largest energy in central chains", "central chains")):
            yield gw.Row(f"{what} at {at}", "% of input", ours=100 * one.settled[region], where="no reference")
        yield gw.Row(f"Peak velocity at sphere {SECOND} / at sphere {FIRST}, {at}", where="no reference",
                     ours=largest[SECOND - 1] / largest[FIRST - 1])
        # fmt: on


def pictures(series):
    axes = Figure((3.5, 2.4), layout="constrained").subplots()
    speed = np.array([one.speed for one in series])
    data = {"striker_velocity_m_s": speed}
    for region in ("dissipated", *series[0].chains, "impacted spheres", "strikers"):
        share = np.array([one.settled[region] for one in series])
        axes.semilogx(speed, 100 * share, "o-", markersize=3, color=COLOURS[region], label=region)
        data[f"{region.replace(' ', '_')}_over_input"] = share
    axes.set(xlabel="Velocity of the striker (m/s)", ylabel="Energy (% of input)", ylim=(0, 105))
    axes.legend(loc="center right")
    caption = (
        "Fraction of the energy that is dissipated, or remains in each region, against the "
        f"velocity of the striker, {series[0].way} impact on spheres that yield. A faster impact "
        "dissipates a larger fraction, and the chains carry less"
    )
    yield gw.Picture("", caption, axes.figure, data)
