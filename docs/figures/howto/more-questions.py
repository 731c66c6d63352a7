"""Forces on the contacts of a packing, and a measured signal next to the computed one."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from page_figures import save

import granwave as gw

keys = {"packing.size": [8, 8, 5], "run.end_time": 3e-4}
run = gw.run("fcc-small", keys, directory="all-forces")
computed = run.walls.query("wall == 'bottom'")[["time", "force"]].to_numpy().T
measured = pd.read_csv("measured.csv").to_numpy().T
with gw.style():
    _, axes = plt.subplots()
    for label, (time, force) in {"computed": computed, "measured": measured}.items():
        begin = time[np.argmax(force > 0.1 * force.max())]
        axes.plot(1e6 * (time - begin), force, label=label)
    axes.set(xlabel="Time (µs)", ylabel="Force (N)")
    axes.legend()
    save(axes, "comparison")
save(run.figure("peak_force_principal"), "peak_force_principal")
