"""Restitution against velocity, and the decay of a pulse along a chain, for each kind of loss."""

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

import granwave as gw

LOSSES = {
    "none": {"time": 0.0},
    "time": {"time": 3e-7},
    "restitution": {"restitution": 0.95, "velocity": 1.0},
    "dashpot": {"dashpot": {"restitution": 0.97}},
    "prony": {"kind": "prony", "weights": [0.1], "times": [2e-5]},
}
CONTACTS = 26  # the last beads fly off
VELOCITY = np.geomspace(0.02, 10.0, 7)

with gw.style():
    _, axes = plt.subplots()
    for name, loss in LOSSES.items():
        tables = {
            "name": name,
            "case": "two-spheres",
            "set": {"contact": {"law": "hertz", "loss": loss}, "run.end_time": 2e-4},
            "grid": {"load.velocity": VELOCITY.tolist()},
        }
        table = gw.scan(tables, jobs=2).table
        axes.semilogx(table["load.velocity"], table["restitution"], "o-", label=name)
    axes.set(xlabel="Velocity (m/s)", ylabel="Coefficient of restitution", ylim=(0.88, 1.005))
    axes.legend(title="contact.loss", loc="lower left", ncols=2)
    save(axes, "restitution")

    _, axes = plt.subplots()
    for name, loss in LOSSES.items():
        run = gw.run("lossy.toml", {"contact.loss": loss}, directory=f"chain-{name}")
        force = run.contacts.sort_values("i")["peak_force"].to_numpy()
        axes.plot(np.arange(1, CONTACTS + 1), force[:CONTACTS], ".-", label=name)
    axes.set(xlabel="Contact", ylabel="Peak force (N)", ylim=(0, None))
    axes.legend(title="contact.loss")
    save(axes, "decay")
