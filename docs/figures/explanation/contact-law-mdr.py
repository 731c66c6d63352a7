"""Peak force against depth in a packing struck by a sphere: LAMMPS's law mdr and ours."""

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

from tests.helpers.programs.struck_packing import LAWS, LAYERS, impact

VELOCITY = 10.0

figure, axes = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
for law, marker in zip(LAWS, ("s", "o"), strict=True):
    result = impact(law, VELOCITY)
    axes.semilogy(np.arange(1, LAYERS), result.peak_forces, marker=marker, label=law)
axes.set(xlabel="layer of the upper sphere", ylabel="peak contact force (N)")
axes.set_xticks(np.arange(1, LAYERS))
axes.grid(which="both", alpha=0.3)
axes.legend()

save(axes, "packing")
