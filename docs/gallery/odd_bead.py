"""The best position of a different bead in a chain

Nineteen beads of brass and one of aluminium transmit a pulse of force to an elastic bar. The
transmitted energy depends on the position of the aluminium bead: it increases if the bead is near
the loaded end, and decreases if the bead is near the bar.
"""

import matplotlib.pyplot as plt

import granwave as gw

places = [1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 20]


def transmitted(material: str, place: int) -> float:
    """Return the energy in the bar at the end, J."""
    changes = {"replace.1.material": material, "replace.1.index": place, "output.history": 0}
    run = gw.run("intruder", changes, directory="run", force=True)
    return run["energy_bar_J"]


energies = [transmitted("aluminium", place) for place in places]
brass = transmitted("brass", 1)

with gw.style():
    figure, axes = plt.subplots()
    axes.plot(places, energies, "o-", color="C0", markersize=3, label="aluminium among brass")
    axes.axhline(brass, color="C5", linestyle="--", label="brass only")
    axes.set(
        xlabel="bead of aluminium (1: impacted end)",
        ylabel="energy in the bar (J)",
    )
    axes.legend()
    figure.savefig("picture.png", dpi=150)

by_energy = sorted(zip(energies, places, strict=True))
print(f"largest energy in the bar   {by_energy[-1][0]:.3f} J, at position {by_energy[-1][1]}")
print(f"smallest energy in the bar  {by_energy[0][0]:.3f} J, at position {by_energy[0][1]}")
print(f"brass beads only            {brass:.3f} J")
