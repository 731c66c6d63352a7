"""Restitution of a sphere on a wall, from runs and from the law

A brass sphere of 10 mm hits a rigid wall. The line is the coefficient of restitution calculated
directly from the contact law; the symbols are runs.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

velocities = np.geomspace(0.05, 20, 6)
runs = [
    gw.run("sphere-on-wall", {"load.velocity": v}, directory="run", force=True) for v in velocities
]

contact = ("elastoplastic", [{"shape": "sphere", "diameter": 0.010, "material": "brass"}, "plane"])
overlap = np.geomspace(1e-9, 3e-4, 4000)  # m
force = gw.contact_force(*contact, overlap)
work = np.cumsum(
    np.diff(overlap, prepend=0) * (force + np.append(0, force[:-1])) / 2
)  # J, of loading
velocity = np.sqrt(2 * work / runs[0].case.sphere_mass)
coefficient = np.sqrt(gw.contact_energy(*contact, overlap) / work)

with gw.style():
    figure, axes = plt.subplots()
    found = [run["restitution"] for run in runs]
    shown = (velocity > 0.01) & (velocity < 30)
    axes.semilogx(velocity[shown], coefficient[shown], color="C0", label="contact law")
    axes.semilogx(velocities, found, "o", color="C1", markersize=4, label="runs")
    axes.set(xlabel="impact velocity (m/s)", ylabel="coefficient of restitution", ylim=(0, 1.02))
    axes.legend()
    figure.savefig("picture.png", dpi=150)

for velocity, value in zip(velocities, found, strict=True):
    print(f"{velocity:6.2f} m/s   {value:.4f}")
