"""Error of the energy balance of a fixed timestep and of the automatic one."""

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

import granwave as gw

KEYS = {"packing.size": [8, 8, 5], "run.end_time": 1e-4}
RUNS = {
    "timestep = 8e-8": {"run.timestep": 8e-8},
    'timestep = "auto"': {},
    "energy_tolerance = 1e-7": {"run.energy_tolerance": 1e-7},
}

with gw.style():
    _, axes = plt.subplots()
    for number, (label, keys) in enumerate(RUNS.items()):
        energies = gw.run("fcc-small", KEYS | keys, directory=f"run-{number}").energies
        sums = energies["kinetic"] + energies["elastic"] + energies["dissipated"]
        error = np.abs(sums - energies["input"]) / energies["input"].max()
        axes.semilogy(1e6 * energies.index, error, label=label)
    axes.axhline(1e-5, color="black", linestyle=":", label="largest accepted error")
    axes.set(xlabel="Time (µs)", ylabel="Error of the balance / input", ylim=(1e-10, None))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    save(axes, "error")
