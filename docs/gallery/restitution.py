"""Restitution of a sphere on a wall, from runs and from the law

A brass sphere of 10 mm hits a rigid wall. The line is the coefficient of restitution that follows from the contact law
alone; the marks are runs.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

velocities = np.geomspace(0.05, 20, 6)
found = []
for velocity in velocities:
    run = gw.run("sphere-on-wall", {"load.velocity": velocity}, directory="run", force=True)
    found.append(run["restitution"])
    print(f"{velocity:6.2f} m/s   {found[-1]:.4f}")

sphere = {"shape": "sphere", "diameter": run.case.packing.diameter, "material": "brass"}
contact = ("elastoplastic", [sphere, "plane"])
overlap = np.geomspace(1e-9, 3e-4, 4000)  # m
force = gw.contact_force(*contact, overlap)
work = np.cumsum(np.diff(overlap, prepend=0) * (force + np.append(0, force[:-1])) / 2)  # J, of loading
velocity = np.sqrt(2 * work / run.case.sphere_mass)
coefficient = np.sqrt(gw.contact_energy(*contact, overlap) / work)
shown = (velocity > 0.01) & (velocity < 30)
velocity, coefficient = velocity[shown], coefficient[shown]

with gw.style():
    figure, axes = plt.subplots()
    axes.semilogx(velocity, coefficient, color="C0", label="contact law")
    axes.semilogx(velocities, found, "o", color="C1", markersize=4, label="runs")
    axes.set(xlabel="impact velocity (m/s)", ylabel="coefficient of restitution", ylim=(0, 1.02))
    axes.legend()
    figure.savefig("picture.png", dpi=150)
