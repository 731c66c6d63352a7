"""A wave that loses energy in the contacts

A chain of 30 elastic steel spheres of 10 mm is struck at 1 m/s. With a loss time the largest force of a contact to the
power -1/6 grows linearly along the chain; with Tsuji's dashpot the force falls exponentially.
"""

import numpy as np

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, new_figure, style
from granwave.analysis.result.reader import Result
from granwave.workflows import load_case, run_case

LOSSES = {"no loss": {"time": 0.0}, "loss time 0.5 µs": {"time": 5e-7}, "dashpot": {"dashpot": {"restitution": 0.9}}}
peaks = {}
for name, loss in LOSSES.items():
    changes = {"packing.size": 30, "packing.diameter": 0.010, "material": "steel", "load.velocity": 1.0}
    case = load_case("elastic-impact", changes | {"contact.loss": loss, "run.end_time": 6e-4})
    summary = run_case(case, "run", force=True, figures=False).summary
    print(f"{name:18s} lost: {100 * (summary['viscous_fraction'] or 0):5.1f} %")
    with Result("run") as result:
        peaks[name] = result["contacts/peak_force"][:22]

with style():
    figure = new_figure(2.6)
    axes = figure.subplots()
    for (name, force), colour in zip(peaks.items(), (GREY, BLUE, ORANGE), strict=True):
        axes.semilogy(np.arange(1, len(force) + 1), force, "o-", color=colour, markersize=3, label=name)
    axes.set(xlabel="contact", ylabel="largest force (N)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)
