"""Figures of runs, each from the run that figures.toml names."""

import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from page_figures import FOLDER, save

import granwave as gw

DPI = 75

runs = {}
first_changes = {}
table = tomllib.loads((FOLDER / "figures.toml").read_text(encoding="utf-8"))
for entry in table["run"]:
    case = entry["case"]
    changes = entry.get("changes", first_changes.get(case, {}))
    first_changes.setdefault(case, changes)
    key = f"{case} {changes}"
    if key not in runs:
        runs[key] = gw.run(case, changes, directory=f"run{len(runs)}", figures=False)
    for name in entry["figures"]:
        figure = np.ravel(runs[key].figure(name))[0].figure
        picture = Path(f"{name}.png")
        figure.savefig(picture, dpi=DPI, bbox_inches="tight")
        plt.close(figure)
        save(picture, name)
