"""Two elasto-plastic laws and finite elements: how far each is off

103 contacts of spheres and flats were pressed together with finite elements: Poisson's ratios 0 to 0.45, moduli of
50 to 1000 times the yield strength, radii of 1 to 1 to 1 to 10 and flats, unlike materials, linear hardening.
The dots are the
deviations of the force of both laws; 13 contacts took no part in the fit of `elastoplastic-fe`. `elastoplastic`, the
default, was made for equal spheres with a Poisson's ratio of 0.30 that do not harden.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw
from granwave.workflows.finite_elements.sphere_contact.law_fit import measured

contacts = measured()
with gw.style():
    figure, panels = plt.subplots(1, 2, figsize=(6.4, 2.8), sharey=True)
    for axes, name in zip(panels, ("elastoplastic", "elastoplastic-fe"), strict=True):
        for held, color, label in ((False, "C0", "fitted contacts"), (True, "C1", "held-out contacts")):
            chosen = [one for one in contacts if one.held == held]
            overlap = np.concatenate([one.overlap / one.start for one in chosen])
            error = np.concatenate([one.loading_errors(one.law(name)) for one in chosen])
            shown = label if name == "elastoplastic-fe" else f"the same {label}"
            axes.plot(overlap, 100 * error, ".", ms=2, color=color, label=shown)
        axes.axhspan(-3, 3, color="0.85", zorder=0)
        axes.set(title=name, xscale="log", ylim=(-80, 80), xlabel="overlap over that at first yield")
    panels[0].set(ylabel="force of the law over finite elements - 1 (%)")
    panels[1].legend()
    figure.savefig("picture.png", dpi=150)

for name in ("elastoplastic", "elastoplastic-fe"):
    error = np.concatenate([one.loading_errors(one.law(name)) for one in contacts])
    print(f"{name}: {100 * (np.abs(error) <= 0.03).mean():.0f} % of the points within 3 %")
