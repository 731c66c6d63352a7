"""The contact law: loading, unloading and residual indentation

Two brass spheres of 10 mm are pressed together to four overlaps and released. Each unloading curve
ends at an overlap above zero, the residual indentation. When the spheres meet again, the contact
starts from this indentation and follows the same curve upwards.

No simulation is needed: Python calls the same law as the LAMMPS style.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

sphere = {"shape": "sphere", "diameter": 0.010, "material": "brass"}
contact = ("elastoplastic", [sphere, sphere])
unit, yield_force = gw.contact_yield(*contact)

overlap = np.linspace(0, 100 * unit, 400)
loading = gw.contact_force(*contact, overlap)
branches = {n: np.linspace(0, n * unit, 800) for n in (20, 40, 70, 100)}
unloading = {
    n: gw.contact_force(*contact, back, peak_overlap=n * unit) for n, back in branches.items()
}

with gw.style():
    figure, axes = plt.subplots(figsize=(3.4, 2.8))
    axes.plot(overlap * 1e6, loading, color="C5", label="loading")
    for n, force in unloading.items():
        label = "unloading and reloading" if n == 20 else None
        axes.plot(branches[n][force > 0] * 1e6, force[force > 0], color="C0", label=label)
    axes.set(xlabel="overlap (µm)", ylabel="force (N)", xlim=(0, None), ylim=(0, None))
    axes.legend()
    figure.savefig("picture.png", dpi=150)

print(f"first yield at an overlap of {unit * 1e6:.3f} µm and a force of {yield_force:.3f} N")
