"""Force on the bottom and tolerance of the spheres

Perfect spheres transmit a short pulse to the wall below. Spheres with a tolerance of 5 µm have gaps
between them, so that the pulse arrives later and is smaller. Friction reduces it too.
"""

import matplotlib.pyplot as plt

import granwave as gw

PACKINGS = {
    "perfect spheres": {},
    "friction 0.3": {"contact.friction": 0.3},
    "5 µm tolerance": {"packing.diameter_scatter": 5e-6, "packing.seed": 1},
}
common = {"packing.size": [12, 12, 8], "run.end_time": 8e-4}
runs = {
    label: gw.run("fcc-small", common | changes, directory=label, force=True)
    for label, changes in PACKINGS.items()
}

with gw.style():
    figure, axes = plt.subplots(figsize=(3.4, 2.8))
    for (label, run), colour in zip(runs.items(), ("C0", "C2", "C1"), strict=True):
        bottom = run.walls.query("wall == 'bottom'")
        axes.plot(
            bottom["time"] * 1e6, abs(bottom["force"]), color=colour, linewidth=0.8, label=label
        )
        print(f"{label:16}  peak force at the bottom {run['wall_peak_force_N']:7.1f} N")
    axes.set(xlabel="time (µs)", ylabel="force on the bottom (N)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)
