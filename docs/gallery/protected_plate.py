"""Height of a packing that protects a plate

A steel plate on a spring lies below a packing that is hit at 5 m/s. The peak reduction is the
largest force on the plate for an impact directly on the plate, divided by the largest force with
the packing. It increases with friction and with the height of the packing.
"""

import matplotlib.pyplot as plt

import granwave as gw

LAYERS = (2, 4, 6, 8)
reductions = {0.0: [], 0.3: []}
for friction, found in reductions.items():
    for layers in LAYERS:
        changes = {"packing.size": [10, 10, layers], "contact.friction": friction}
        run = gw.run("protected-target", changes, directory="run", force=True)
        found.append(run["peak_reduction"])

with gw.style():
    figure, axes = plt.subplots()
    for (friction, found), colour in zip(reductions.items(), ("C0", "C1"), strict=True):
        axes.plot(LAYERS, found, "o-", color=colour, markersize=3, label=f"friction {friction:g}")
        print(
            f"friction {friction:g}: peak reduction", ", ".join(f"{value:.2f}" for value in found)
        )
    axes.set(xlabel="layers of spheres", ylabel="peak reduction", ylim=(0, None))
    axes.legend()
    figure.savefig("picture.png", dpi=150)
