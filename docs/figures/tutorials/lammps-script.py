"""Energies of a column of spheres that falls on a floor, as a LAMMPS script recorded them."""

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

import granwave as gw

time, kinetic, elastic, dissipated = np.loadtxt("energies.txt", unpack=True)
energies = {"kinetic": kinetic, "elastic": elastic, "dissipated": dissipated}
with gw.style():
    _, axes = plt.subplots()
    for label, energy in energies.items():
        axes.plot(1e6 * time, 1e3 * energy, label=label)
    axes.set(xlabel="Time (µs)", ylabel="Energy (mJ)")
    axes.legend()
    save(axes, "energies")
