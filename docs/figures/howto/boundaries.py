"""Force on the bottom of one small packing, by the kind of bottom."""

import matplotlib.pyplot as plt
from page_figures import save

import granwave as gw

CASE = {"packing.size": [8, 8, 5], "run.end_time": 2e-4, "boundary.sides": "free"}
BOTTOMS = {
    "rigid wall": "wall",
    "steel wall": {"material": "steel"},
    "plate on springs": {"plate": {"mass": 0.01, "stiffness": 1e6}, "material": "steel"},
    "half-space": {"half_space": {"radius": 0.02}, "material": "steel"},
    "damper": {"damper": {"damping": 500.0}},
}

axes = plt.figure(figsize=(7.0, 3.4), layout="constrained").subplots()
for label, bottom in BOTTOMS.items():
    run = gw.run(
        "fcc-small",
        {**CASE, "boundary.bottom": bottom},
        directory=label.replace(" ", "-"),
        figures=False,
    )
    wall = run.walls[run.walls["wall"] == "bottom"]
    axes.plot(1e6 * wall["time"], wall["force"], label=label)
axes.set_xlabel("Time (µs)")
axes.set_ylabel("Force on the bottom (N)")
axes.legend()
save(axes, "bottom_force")
