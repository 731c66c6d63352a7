"""Spheres that were preloaded and unloaded before the impact.

Contacts have an initial plastic indentation that corresponds to a uniform force; they should stay
elastic up to this force.
"""

from itertools import groupby

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from released import released_energy

import granwave as gw
from granwave.measures import Chain

ELASTIC = 1e-9  # fraction of the input that counts as no dissipation
REACHED = 1e-3  # fraction of the largest force along the chain that marks the arrival of the pulse
CLOSED = {
    "chain": "are open at the impact.",
    "fcc": "are closed by a static load, which remains during the impact.",
}
TITLES = {
    "chain": "Chain of 80 brass spheres of 9.52 mm",
    "fcc": "FCC packing of 8 × 8 × 6 brass spheres of 10 mm",
}


def select(runs):
    """The chain, then the packing."""
    found = ([run for run in runs if run.case.packing.kind == kind] for kind in TITLES)
    return [
        sorted(group, key=lambda run: (level(run), run.case.load.velocity))
        for group in found
        if group
    ]


def level(run):
    """Earlier force on the contacts, N."""
    dents = run.case.contact.initial_overlap
    return dents[0].force if dents else 0.0


def title(runs):
    return f"Preconditioning: {TITLES[runs[0].case.packing.kind]}"


def text(runs):
    gaps = f"The gaps that indentations leave between spheres at their nominal positions {CLOSED[runs[0].case.packing.kind]}"
    return f"{' '.join(__doc__.split(chr(10) * 2)[1].split())} {gaps}{released_energy(runs)}"


def by_level(runs):
    for force, series in groupby(runs, key=level):
        series = list(series)
        values = ([run[key] for run in series] for key in ("peak_force_N", "dissipated_fraction"))
        yield force, *map(np.array, values)


def rows(runs):
    for pressed, force, dissipated in by_level(runs):
        elastic = dissipated < ELASTIC
        for which, chosen, bound in (
            ("Largest force without", elastic, "at most"),
            ("Smallest force with", ~elastic, "at least"),
        ):
            if pressed and chosen.any():
                found = force[chosen].max() if which.startswith("Largest") else force[chosen].min()
                yield gw.Row(
                    f"{which} dissipation / force of the preconditioning, {pressed:g} N",
                        ours=found / pressed,
                    theory=1.0, where="thesis 1.1", bound=True,
                    remark=f"Theory: {bound} 1. The value is from {len(force)} impacts.",
                )  # fmt: skip


def tables(runs):
    found = {
        "Preconditioned to (N)": [level(run) for run in runs],
        "Impact (m/s)": [run.case.load.velocity for run in runs],
        "Largest force (N)": [run["peak_force_N"] for run in runs],
        "Dissipated (% of input)": [100 * run["dissipated_fraction"] for run in runs],
        "Contacts with growing indentation": [run["n_plastic_contacts"] for run in runs],
    }
    if runs[0].case.packing.kind == "fcc":
        bottom = [run.result["walls/bottom/force"] for run in runs]
        found["Largest dynamic force at the bottom (N)"] = [
            (force - force[0]).max() for force in bottom
        ]
    yield "Impacts with and without preconditioning", found


def fastest(runs):
    """Impacts of the largest velocity, by level."""
    velocity = max(run.case.load.velocity for run in runs)
    return [run for run in runs if run.case.load.velocity == velocity]


def verdict(runs):
    fresh, *_, best = fastest(runs)
    lost, kept = (100 * run["dissipated_fraction"] for run in (fresh, best))
    yield (
        f"After an impact at {fresh.case.load.velocity:g} m/s fresh contacts dissipate {lost:.3g} "
        f"%, and contacts preconditioned to {level(best):g} N dissipate {kept:.3g} %.{released_energy((fresh, best))}"
    )


def pictures(runs):
    figure = Figure((3.4, 2.7), layout="constrained")
    data = {}
    axes = figure.subplots()
    for n, (pressed, force, dissipated) in enumerate(by_level(runs)):
        axes.semilogx(
            force,
            100 * dissipated,
            f"o-C{n}",
            markersize=3,
            label=f"{pressed:g} N" if pressed else "fresh",
        )
        if pressed:
            axes.axvline(pressed, color=f"C{n}", linestyle=":", linewidth=0.8)
        data[f"level_{pressed:g}_N_peak_force_N"] = force
        data[f"level_{pressed:g}_N_dissipated_percent"] = 100 * dissipated
    axes.set(xlabel="Largest contact force (N)", ylabel="Dissipated (% of input)", ylim=(-2, 105))
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    figure.legend(title="Preconditioned to", loc="outside lower center", ncols=4, fontsize=7)
    caption = (
        "Dissipated fraction against the largest contact force of an impact, by the "
        "preconditioning force of all contacts (dotted). Marks to the left of their dotted line "
        "should be at zero: contacts stay elastic up to that force"
    )
    yield gw.Picture("_dissipation", caption, figure, data)
    if runs[0].case.packing.kind == "fcc":
        return
    figure = Figure((3.4, 2.5), layout="constrained")
    data = {}
    axes = figure.subplots()
    for run in fastest(runs):
        peaks = Chain(run).of_contacts("peak_force")
        contact = np.arange(1, len(peaks) + 1)
        name = f"{level(run):g} N" if level(run) else "fresh"
        axes.semilogy(contact, np.where(peaks > REACHED * peaks.max(), peaks, np.nan), label=name)
        data |= {"contact": contact, f"level_{level(run):g}_N_peak_force_N": peaks}
    axes.set(xlabel="Contact", ylabel="Largest force (N)", xlim=(0, None))
    figure.legend(title="Preconditioned to", loc="outside lower center", ncols=4, fontsize=7)
    caption = (
        f"Largest force of the contacts along the chain, impact at {run.case.load.velocity:g} m/s. "
        "The force falls while contacts yield, and stays constant once it has fallen to the "
        "preconditioning force; in a fresh chain it continues to fall"
    )
    yield gw.Picture("_pulse", caption, figure, data)
