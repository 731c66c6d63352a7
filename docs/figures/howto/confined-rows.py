"""Peak force along the beads of a row in a wide and in a narrow tube."""

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

import granwave as gw

NARROW = {"precompression": {"kind": "walls", "tube": 1.425e-5}, "run.end_time": 4.7e-3}

runs = {
    "tube that just touches": gw.run("confined-row"),
    "tube narrowed by 14 µm": gw.run("confined-row", NARROW, directory="narrow"),
}
with gw.style():
    _, axes = plt.subplots()
    for label, run in runs.items():
        force = np.asarray(gw.measures.GrainRow(run).of_contacts("peak_force"))
        axes.plot(np.arange(1, len(force) + 1), force, label=label)
    axes.set(xlabel="Contact of beads", ylabel="Peak force (N)")
    axes.legend()
    save(axes, "peak_force")
