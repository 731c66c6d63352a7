"""Split-Hopkinson bar.

A chain of 14 beads lies between two bars. The incident pulse is a force on the free end of the
first bar, and the incident energy is the work of this force. Reflected and transmitted energy are
the energies in the bars at the end of the run, before an echo from their ends reaches the chain.
The pulses in both bars are compared with the closed forms of a slender bar.
"""

import numpy as np
from bar_pulse import Passage, closed_forms
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

import granwave as gw

ASSUMED = (
    "The source prints neither the incident signal nor a value. The pulse is our choice, and "
    "this number is not a test."
)
REFLECTED = "According to the source most of the energy is reflected."
SECTIONS = {"incident_bar": 0.5, "bar": 0.25}  # shown; lengths from the end where the pulse enters


def rows(runs):
    (run,) = runs
    incident = Passage(run, "incident_bar")
    transmitted = Passage(run, "bar")
    force = run["wall_peak_force_N"]
    entered = run["energy_input_J"]
    # fmt: off
    for what, unit, ours, remark in (
        ("Peak force, incident", "kN", 1e-3 * incident.peak, ""),
        ("Peak force, transmitted", "kN", 1e-3 * force, ASSUMED),
        ("Force, transmitted / incident", "", force / incident.peak, ASSUMED),
        ("Energy, transmitted / incident", "", run["energy_bar_J"] / entered, ASSUMED),
        ("Energy, reflected / incident", "", run["energy_incident_bar_J"] / entered, REFLECTED),
        ("Energy, dissipated / incident", "", run["energy_dissipated_J"] / entered, ""),
    ):
        yield gw.Row(f"{what}, split-hopkinson", unit, ours=ours, where="thesis 3.2.2, Fig. 3.5", remark=remark)
    # fmt: on
    yield from closed_forms(incident, "split-hopkinson, table incident bar")
    *_, energy = closed_forms(
        transmitted, "split-hopkinson, bar"
    )  # the pulse has not passed both sections
    yield energy


def pictures(runs):
    result = runs[0].result
    case = runs[0].case
    time = result["chain/time"]
    figure = Figure((3.4, 3.6), layout="constrained")
    data = {"time_s": time}
    for axes, (name, share) in zip(figure.subplots(2, sharex=True), SECTIONS.items(), strict=True):
        force = result[f"bars/{name}/force"][:, int(share * getattr(case, name).elements)]
        axes.plot(1e6 * time, 1e-3 * force)
        axes.axhline(0, color="black", linewidth=0.5)
        axes.set(ylabel=f"{name.replace('_', ' ').capitalize()}\nsection force (kN)")
        data[f"{name}_N"] = force
    axes.set(xlabel="Time (µs)", xlim=(0, 1e6 * time[-1]))
    caption = (
        "Force at a section of each bar against time. The first bar shows the incident pulse, "
        "followed by the reflection of the chain with the opposite sign. The second bar, with its "
        "own scale, shows the transmitted pulse, which is later and longer"
    )
    yield gw.Picture("split_hopkinson", caption, figure, data)

    parts = {"chain": (result["chain/contact_position"], result["chain/contact_force"])}
    for name in SECTIONS:
        nodes = result[f"bars/{name}/position"]
        parts[name] = 0.5 * (nodes[1:] + nodes[:-1]), np.abs(result[f"bars/{name}/force"])
    largest = max(force.max() for _, force in parts.values())
    figure = Figure((6.6, 3.2), layout="constrained")
    data = {"time_s": time}
    row = figure.subplots(1, 3, sharey=True, width_ratios=(0.7, 1.0, 0.7))
    for axes, name in zip(row, ("incident_bar", "chain", "bar"), strict=True):
        place, force = parts[name]
        shown = np.where(force > 1e-3 * largest, force, np.nan)
        colours = {
            "norm": LogNorm(1e-3 * largest, largest),
            "rasterized": True,
            "shading": "nearest",
        }
        image = axes.pcolormesh(1e3 * place, 1e6 * time, shown, **colours)
        axes.set(xlabel="Position (mm)", title=name.replace("_", " "))
        some = np.linspace(0, len(place) - 1, 14).astype(int)
        data |= {f"{name}_at_{1e3 * place[n]:.4g}_mm_N": force[:, n] for n in some}
    row[0].set(ylabel="Time (µs)")
    figure.colorbar(image, ax=axes, label="Force (N)")
    caption = (
        "Magnitude of the force against position and time, bars and chain (thesis Fig. 3.6; "
        "scales of position differ). Stripes in the bars are pulses, which are reflected at the "
        "chain; little is transmitted"
    )
    yield gw.Picture("split_hopkinson_map", caption, figure, data)
