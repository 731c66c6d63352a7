"""Repeated impacts on a packing

The contacts keep the plastic indentations of the first impact, so that the packing has hardened:
the second impact dissipates less energy, and a larger force reaches the bottom. Each run reads the
indentations from the directory of the previous run.

For comparison, another packing discards the indentations during an impact whenever the undeformed
spheres separate, and has all indentations again at the start of the next impact.
"""

import matplotlib.pyplot as plt

import granwave as gw

GAPS = {"kept": 0.1, "forgotten": 1e-9}  # diameters: an indentation is forgotten beyond this gap
hits = {dents: [] for dents in GAPS}
for dents, gap in GAPS.items():
    for hit in range(1, 6):
        changes = {"packing.size": [10, 10, 6], "run.end_time": 4e-4, "boundary.forget_gap": gap}
        if hit > 1:
            changes["contact.initial_overlap"] = f"{dents}-{hit - 1}"
        hits[dents].append(gw.run("fcc-small", changes, directory=f"{dents}-{hit}", force=True))

with gw.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(5.6, 2.4))
    for (dents, runs), line, colour in zip(hits.items(), ("o-", "^--"), ("C0", "C1"), strict=True):
        shares, forces = (
            [run[name] for run in runs] for name in ("dissipated_fraction", "wall_peak_force_N")
        )
        left.plot(
            range(1, 6), shares, line, color=colour, markersize=4, label=f"indentations {dents}"
        )
        right.plot(range(1, 6), forces, line, color=colour, markersize=4)
        for hit, (share, force) in enumerate(zip(shares, forces, strict=True), start=1):
            print(
                f"indentations {dents}, impact {hit}: {share:.3f} of the energy dissipated, {force:.0f} N at the bottom"
            )
    left.set(xlabel="impact", ylabel="dissipated fraction", ylim=(0, 1))
    left.legend(loc="lower left")
    right.set(xlabel="impact", ylabel="peak force at the bottom (N)", ylim=(0, None))
    figure.savefig("picture.png", dpi=150)
