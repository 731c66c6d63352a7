"""Repeated impacts on a packing.

Each run starts with the spheres at their initial positions and with the indentations of the
previous run. The order follows from the runs: contact.initial_overlap of a second impact is the
result of the first one.

    granwave report first second --study reproductions/precompression/hits.py
"""

from pathlib import Path

from matplotlib.figure import Figure
from released import released_energy

import granwave as gw


def select(runs):
    """The runs in the order of the impacts, in one group."""
    after = {before(run): run for run in runs}
    series = [after.pop(None)]
    while (following := after.get(series[-1].directory.resolve())) is not None:
        series.append(following)
    return [series]


def before(run):
    """Directory of the run that caused the indentations; None for a first impact."""
    left = run.case.contact.initial_overlap
    if not isinstance(left, str):
        return None
    path = Path(left).resolve()
    return path.parent if path.suffix == ".h5" else path


def title(series):
    return f"{len(series)} impacts on a packing"


def columns(series):
    force = [run.result["walls/bottom/force"] for run in series]
    return {
        "Impact number": list(range(1, len(series) + 1)),
        "Impact (m/s)": [run.case.load.velocity for run in series],
        "Dissipated (% of input)": [100 * run["dissipated_fraction"] for run in series],
        "Contacts with growing indentation": [run["n_plastic_contacts"] for run in series],
        "Largest contact force (N)": [run["peak_force_N"] for run in series],
        "Largest dynamic force at the bottom (N)": [(one - one[0]).max() for one in force],
        "Arrival there (µs)": [1e6 * run["base_arrival_s"] for run in series],
    }


def tables(series):
    yield "Values by impact", columns(series)


def verdict(series):
    lost, force = (
        columns(series)[key]
        for key in ("Dissipated (% of input)", "Largest dynamic force at the bottom (N)")
    )
    yield (
        f"After {len(series)} impacts the packing dissipates {lost[-1]:.3g} % of the last ({lost[0]:.3g} "
        f"% of the first) and transmits {force[-1]:.4g} N ({force[0]:.4g} N).{released_energy((series[0], series[-1]))}"
    )


def pictures(series):
    found = columns(series)
    figure = Figure((5.6, 2.3), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.bar(found["Impact number"], found["Dissipated (% of input)"], color="C2", width=0.6)
    right.bar(found["Impact number"], found["Largest dynamic force at the bottom (N)"], width=0.6)
    left.set(xlabel="Impact", ylabel="Dissipated (% of input)", xticks=found["Impact number"])
    right.set(xlabel="Impact", ylabel="Force at the bottom (N)", xticks=found["Impact number"])
    caption = (
        "Dissipated fraction and largest dynamic force at the bottom, by number of the impact. "
        "After the first impact contacts are elastic up to their earlier force: less energy is "
        "dissipated, and more force is transmitted"
    )
    yield gw.Picture("", caption, figure, found)
