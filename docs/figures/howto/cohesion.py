"""Force against overlap without cohesion and with both kinds of it."""

import subprocess

import matplotlib.pyplot as plt
import pandas as pd
from page_figures import save

import granwave as gw

KINDS = {"none": [], "dmt": ["--cohesion", "dmt", "0.1"], "jkr": ["--cohesion", "jkr", "0.1"]}
LAW = "granwave law --law hertz --material steel --radius 5e-5 --max-overlap 0.25"

with gw.style():
    _, axes = plt.subplots()
    for kind, options in KINDS.items():
        subprocess.run([*LAW.split(), *options, "-o", f"{kind}.csv"], check=True)
        table = pd.read_csv(f"{kind}.csv")
        colour = f"C{list(KINDS).index(kind)}"
        for branch, line in (("loading", "--"), ("unloading_4", "-")):
            part = table[table["branch"] == branch]
            label = kind if branch == "loading" else None
            overlap = 1e9 * part["overlap_m"]
            axes.plot(overlap, 1e6 * part["force_N"], line, color=colour, label=label)
    axes.set(xlabel="Overlap (nm)", ylabel="Force (µN)")
    axes.legend(title="cohesion")
    save(axes, "laws")
