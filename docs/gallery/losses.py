"""Waves in a chain with damping in the contacts

The first sphere of a chain of 30 elastic steel spheres (10 mm) starts at 1 m/s. With a relaxation
time, the power -1/6 of the peak contact force increases linearly along the chain. With Tsuji's
dashpot, the peak force decreases exponentially.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

LOSSES = {
    "no damping": {"time": 0.0},
    "relaxation time 0.5 µs": {"time": 5e-7},
    "dashpot": {"dashpot": {"restitution": 0.9}},
}
peaks = {}
for name, loss in LOSSES.items():
    changes = {
        "packing.size": 30,
        "packing.diameter": 0.010,
        "material": "steel",
        "load.velocity": 1.0,
    }
    changes |= {"contact.loss": loss, "run.end_time": 6e-4}
    run = gw.run("elastic-impact", changes, directory="run", force=True)
    dissipated = 100 * (run["viscous_fraction"] or 0)
    print(f"{name:23s} dissipated by damping: {dissipated:4.1f} %")
    peaks[name] = run.contacts["peak_force"][:22]

with gw.style():
    figure, axes = plt.subplots()
    for (name, force), colour in zip(peaks.items(), ("C5", "C0", "C1"), strict=True):
        axes.semilogy(
            np.arange(1, len(force) + 1), force, "o-", color=colour, markersize=3, label=name
        )
    axes.set(xlabel="contact", ylabel="largest force (N)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)
