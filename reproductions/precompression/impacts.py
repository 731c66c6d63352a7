"""An impact at 5 m/s on packings under uniform pressure, with yielding and with elastic contacts.

FCC packings of 16 × 16 × 8 brass spheres of 10 mm have free sides and are under constant, uniform
static pressure. Yielding by the static load is not counted.
"""

import numpy as np
from matplotlib.figure import Figure
from released import released_energy

import granwave as gw
from granwave.theory import precompressed_line

WORDS = {"elastoplastic": "elasto-plastic contacts", "hertz": "elastic contacts"}


def select(runs):
    """The yielding packing and the elastic packing, by rising pressure."""
    found = ([run for run in runs if run.case.contact.law == law] for law in WORDS)
    return [sorted(group, key=pressure) for group in found if group]


def pressure(run):
    return run.case.precompression.pressure if run.case.precompression else 0.0


def added(run):
    """Largest dynamic force at the bottom, N."""
    force = run.result["walls/bottom/force"]
    return (force - force[0]).max()


def title(runs):
    return f"Impact on a packing under uniform pressure, 5 m/s: {WORDS[runs[0].case.contact.law]}"


def columns(runs):
    """The impact at each pressure; values of yielding only if contacts yield."""
    static = [
        precompressed_line(run.case).force if run.case.precompression else 0.0 for run in runs
    ]
    found = {
        "Static pressure (Pa)": [pressure(run) for run in runs],
        "Static force of a contact (N)": static,
        "Largest dynamic force at the bottom (N)": [added(run) for run in runs],
        "Arrival there (µs)": [1e6 * run["base_arrival_s"] for run in runs],
        "Largest contact force, with static force (N)": [run["peak_force_N"] for run in runs],
    }
    if runs[0].case.contact.law != "hertz":
        found["Dissipated by the impact (% of input)"] = [
            100 * run["dissipated_fraction"] for run in runs
        ]
        found["Contacts that yielded"] = [run["n_plastic_contacts"] for run in runs]
    return found


def tables(runs):
    yield "The impact against static pressure", columns(runs)


def verdict(runs):
    first = runs[0]
    last = runs[-1]
    sentence = (
        f"Under a uniform pressure of {pressure(last):.3g} Pa the dynamic force at the "
        f"bottom is {added(last):.4g} N "
    )
    sentence += f"({added(first):.4g} N without a static load)"
    if last["dissipated_fraction"]:
        dissipated = (100 * run["dissipated_fraction"] for run in (last, first))
        sentence += ", and the impact dissipates {:.3g} % ({:.3g} %)".format(*dissipated)
    yield f"{sentence}.{released_energy((first, last))}"


def pictures(runs):
    found = columns(runs)
    labels = {"Largest dynamic force at the bottom (N)": "Dynamic force at the bottom (N)"}
    labels["Dissipated by the impact (% of input)"] = "Dissipated (% of input)"
    shown = [name for name in labels if name in found]
    x = np.array(found["Static pressure (Pa)"])
    figure = Figure((3.3 * len(shown), 2.5), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True):
        values = np.array(found[name])
        axes.semilogx(x[1:], values[1:], "o-", markersize=4)
        axes.axhline(values[0], color="0.5", linestyle="--", label="without static load")
        axes.set(xlabel="Static pressure (Pa)", ylabel=labels[name], ylim=(0, 1.25 * values.max()))
        axes.set_xlim(x[1] / 2, 2 * x[-1])
        axes.legend()
    caption = (
        f"{' and '.join(labels[name].partition(' (')[0].lower() for name in shown).capitalize()} "
        "against static pressure; dashed: the same impact without static load. The static load "
        "matters where the marks leave the dashed line"
    )
    yield gw.Picture("", caption, figure, found)
