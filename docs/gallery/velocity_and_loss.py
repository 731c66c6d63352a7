"""Dissipated fraction of an impact against its velocity

The same packing is hit at 0.1 to 20 m/s. The fraction of energy that yielding contacts dissipate
increases with velocity. The abscissa is the normalised velocity, for which different materials and
diameters can be compared: `velocity_normalised` in `summary.json`.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

velocities = np.geomspace(0.1, 20, 7)
shares = {}
for material in ("brass", "steel"):
    for velocity in velocities:
        changes = {
            "packing.size": [10, 10, 6],
            "run.end_time": 2e-4,
            "load.velocity": velocity,
            "material": material,
        }
        run = gw.run("fcc-small", changes, directory="run", force=True)
        shares.setdefault(material, []).append(
            (run["velocity_normalised"], run["dissipated_fraction"])
        )

with gw.style():
    figure, axes = plt.subplots()
    for (material, points), colour, mark in zip(shares.items(), ("C0", "C1"), "os", strict=True):
        normalised, share = np.array(points).T
        axes.semilogx(normalised, share, color=colour, marker=mark, markersize=3, label=material)
        print(f"{material:6}  dissipated at 0.1 m/s {share[0]:.3f}, at 20 m/s {share[-1]:.3f}")
    axes.set(xlabel="normalised velocity", ylabel="dissipated fraction", ylim=(0, 1))
    axes.legend()
    figure.savefig("picture.png", dpi=150)
