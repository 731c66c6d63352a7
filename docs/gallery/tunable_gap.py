"""A band gap tuned by the static load

Alternating steel and aluminium beads have two bands with a gap between them. A static force makes
the contacts stiffer, and both edges move with the power 1/6 of the force. Waves with frequencies in
the gap decay from cell to cell.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

lighter = [{"index": list(range(2, 41, 2)), "material": "aluminium"}]
forces = np.geomspace(1, 100, 5)
edges = []
decay = []
for force in forces:
    changes = {
        "material": "steel",
        "packing.size": 40,
        "replace": lighter,
        "precompression.force": float(force),
    }
    bands = gw.bands("precompressed-chain", changes)
    edges.append([float(bands.edges[0, 1]), float(bands.edges[1, 0]), float(bands.edges[1, 1])])
    decay.append(bands.attrs["attenuation_in_widest_gap"])

below, above, top = np.array(edges).T / 1e3
with gw.style():
    figure, axes = plt.subplots()
    axes.fill_between(forces, 0, below, color="C0", alpha=0.3, lw=0, label="acoustic band")
    axes.fill_between(forces, above, top, color="C1", alpha=0.3, lw=0, label="optical band")
    for edge in (below, above, top):
        axes.plot(forces, edge[-1] * (forces / forces[-1]) ** (1 / 6), color="C5", lw=0.8)
    axes.set(
        xscale="log",
        xlabel="static force (N)",
        ylabel="frequency (kHz)",
        xlim=(1, 100),
        ylim=(0, None),
    )
    axes.legend(loc="upper left")
    figure.savefig("picture.png", dpi=150)

for force, (low, high, _), fall in zip(forces, edges, decay, strict=True):
    print(f"{force:6.1f} N   gap {low:6.0f} to {high:6.0f} Hz   attenuation {fall:.2f} a cell")
