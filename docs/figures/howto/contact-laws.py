"""Force against overlap of five contact laws: loading, and unloading from the same overlap."""

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

import granwave as gw

BODY = {"shape": "sphere", "diameter": 0.010, "material": "brass"}
PEAK = 40e-6  # m

axes = plt.figure(figsize=(7.0, 3.4), layout="constrained").subplots()
overlap = np.linspace(0.0, PEAK, 400)
for law in ("hertz", "elastoplastic", "elastoplastic-fe", "thornton", "bilinear"):
    loading = gw.contact_force(law, [BODY, BODY], overlap)
    unloading = gw.contact_force(law, [BODY, BODY], overlap, peak_overlap=PEAK)
    line = axes.plot(1e6 * overlap, loading, label=law)[0]
    axes.plot(1e6 * overlap, unloading, "--", color=line.get_color())
axes.set_xlabel("Overlap (µm)")
axes.set_ylabel("Force (N)")
axes.legend()
save(axes, "laws")
