"""The best order of beads in a chain

Six beads of steel or PTFE in a chain are hit at 2 m/s. Which order transmits the smallest force to
the wall? A search finds it among all 64 orders in 24 runs: soft beads at both ends and hard beads
between them. Each interface reflects a part of the pulse.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

row = {"material": "stainless-steel", "packing.size": 6, "load.velocity": 2.0, "run.end_time": 4e-4}
row |= {"boundary.bottom": "wall"}
beads = {f"replace.{n}.material": ["stainless-steel", "ptfe"] for n in range(1, 7)}
search = {
    "objective": {"minimise": ["target_peak_force_N"]},
    "search": {"evaluations": 24, "guards": False},
}
found = gw.design(
    {"base": "elastic-impact", "set": row, "variables": beads, **search},
    directory="row",
    force=True,
)

with gw.style():
    figure, axes = plt.subplots()
    force = found.table["target_peak_force_N"]
    axes.plot(found.table["number"], force, ".", label="each order")
    axes.step(
        found.table["number"], np.minimum.accumulate(force), where="post", label="best so far"
    )
    axes.set(xlabel="number of the run", ylabel="peak force on the wall (N)", yscale="log")
    axes.legend()
    figure.savefig("picture.png", dpi=150)

order = ", ".join(
    "PTFE" if value == "ptfe" else "steel" for value in found.best["variables"].values()
)
print(
    f"{order}: {found.best['objective']['target_peak_force_N']:.3g} N; largest force of all runs: {force.max():.4g} N"
)
