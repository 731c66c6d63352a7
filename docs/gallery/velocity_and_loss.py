"""Dissipated share of an impact against its velocity

The same packing is hit at 0.1 to 20 m/s. The faster the impact, the larger the share of its energy that yielding
contacts take. The abscissa is the velocity in units in which materials and diameters can be compared:
`velocity_normalised` in `summary.json`.
"""

import numpy as np

from granwave.analysis.figures.style import BLUE, ORANGE, new_figure, style
from granwave.workflows import load_case, run_case

velocities = np.geomspace(0.1, 20, 7)
shares = {}
for material in ("brass", "steel"):
    for velocity in velocities:
        changes = {"packing.size": [10, 10, 6], "run.end_time": 2e-4, "load.velocity": velocity, "material": material}
        outcome = run_case(load_case("fcc-small", changes), "run", force=True, figures=False)
        summary = outcome.summary
        shares.setdefault(material, []).append((summary["velocity_normalised"], summary["dissipated_fraction"]))

with style():
    figure = new_figure(2.6)
    axes = figure.subplots()
    for (material, points), colour, mark in zip(shares.items(), (BLUE, ORANGE), "os", strict=True):
        normalised, share = np.array(points).T
        axes.semilogx(normalised, share, color=colour, marker=mark, markersize=3, label=material)
        print(f"{material:6}  share lost at 0.1 m/s {share[0]:.3f}, at 20 m/s {share[-1]:.3f}")
    axes.set(xlabel="normalised velocity", ylabel="share of the energy dissipated", ylim=(0, 1))
    axes.legend()
    figure.savefig("picture.png", dpi=150)
