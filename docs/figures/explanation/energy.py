"""Energies of an impact on a small packing."""

from page_figures import save

import granwave as gw

CHANGES = {"packing.size": [8, 8, 5], "run.end_time": 2e-4}

run = gw.run("fcc-small", CHANGES, directory="small", figures=False)
save(run.figure("energies"), "energies")
