"""Sound in a precompressed chain

A chain under a static force carries small pulses as sound. Contacts are stiffer the harder they are pressed, so that
the speed grows with the force: to the power 1/6 for Hertz's law.
"""

import numpy as np

from granwave.analysis import Result
from granwave.analysis.figures.style import BLUE, GREY, new_figure, style
from granwave.workflows import load_case, run_case

forces = np.geomspace(0.1, 100, 4)
speeds = []
for force in forces:
    changes = {
        "precompression.force": force,
        "load.velocity": 1e-4 * force ** (5 / 6),  # equally small beside the static compression
        "packing.size": 60,
        "run.end_time": 1.3e-3 / force ** (1 / 6),
        "output.history": 2000,
    }
    case = load_case("precompressed-chain", changes)
    run_case(case, "run", force=True, figures=False)
    with Result("run") as result:
        time, contact_force = result["chain/time"], result["chain/contact_force"]
    rise = contact_force - contact_force[0]
    first, last = (time[rise[:, contact].argmax()] for contact in (9, 49))
    speeds.append(40 * case.packing.diameter / (last - first))
    print(f"{force:6.1f} N   {speeds[-1]:.0f} m/s")

power = np.polyfit(np.log(forces), np.log(speeds), 1)[0]
print(f"power {power:.3f}")

with style():
    figure = new_figure(2.6)
    axes = figure.subplots()
    axes.loglog(forces, speeds, "o", color=BLUE, label="first maximum of the pulse")
    axes.loglog(forces, speeds[-1] * (forces / forces[-1]) ** (1 / 6), color=GREY, label="power 1/6")
    axes.set(xlabel="static force (N)", ylabel="speed (m/s)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)
