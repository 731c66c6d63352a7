"""Sound speed of a precompressed chain

A chain under a static force carries small pulses as sound. The contact stiffness increases with the
force, so that the sound speed increases too: with the power 1/6 of the force for Hertz's law.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

forces = np.geomspace(0.1, 100, 4)
speeds = []
for force in forces:
    changes = {"precompression.force": force, "packing.size": 60, "output.history": 2000}
    changes |= {"run.end_time": 1.3e-3 / force ** (1 / 6)}
    changes |= {
        "load.velocity": 1e-4 * force ** (5 / 6)
    }  # always small relative to the static compression
    run = gw.run("precompressed-chain", changes, directory="run", force=True)
    rise = (run.chain.contact_force - run.chain.contact_force[0]).values  # N, (n_times, n_contacts)
    first, last = run.chain.time.values[rise[:, [9, 49]].argmax(axis=0)]
    speeds.append(40 * run.case.packing.diameter / (last - first))

with gw.style():
    figure, axes = plt.subplots()
    axes.loglog(forces, speeds, "o", color="C0", label="first maximum of the pulse")
    axes.loglog(
        forces, speeds[-1] * (forces / forces[-1]) ** (1 / 6), color="C5", label="power 1/6"
    )
    axes.set(xlabel="static force (N)", ylabel="speed (m/s)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)

for force, speed in zip(forces, speeds, strict=True):
    print(f"{force:6.1f} N   {speed:.0f} m/s")
print(f"power {np.polyfit(np.log(forces), np.log(speeds), 1)[0]:.3f}")
