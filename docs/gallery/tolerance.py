"""Force at the bottom under tolerances

Perfect spheres pass a sharp pulse on to the wall below. Spheres with a tolerance of 5 um leave gaps, and the pulse
arrives late and low. Friction takes a part of it too.
"""

from granwave.analysis import Result
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, new_figure, style
from granwave.workflows import load_case, run_case

PACKINGS = {
    "perfect spheres": {},
    "friction 0.3": {"contact.friction": 0.3},
    "5 um tolerance": {"packing.diameter_scatter": 5e-6, "packing.seed": 1},
}
common = {"packing.size": [12, 12, 8], "run.end_time": 8e-4}

with style():
    figure = new_figure(2.8)
    axes = figure.subplots()
    for (label, changes), colour in zip(PACKINGS.items(), (BLUE, GREEN, ORANGE), strict=True):
        outcome = run_case(load_case("fcc-small", common | changes), "run", force=True, figures=False)
        with Result("run") as result:
            time, force = result["walls/bottom/time"], result["walls/bottom/force"]
        axes.plot(time * 1e6, abs(force), color=colour, linewidth=0.8, label=label)
        print(f"{label:16}  peak force at the bottom {outcome.summary['wall_peak_force_N']:7.1f} N")
    axes.set(xlabel="time (us)", ylabel="force on the bottom (N)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)
