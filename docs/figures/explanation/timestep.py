"""Timestep of an impact on a small packing, and the error of its energy balance."""

from page_figures import save

import granwave as gw

CHANGES = {"packing.size": [8, 8, 5], "run.end_time": 2e-4}

run = gw.run("fcc-small", CHANGES, directory="small", figures=False)
save(run.figure("timestep"), "timestep")
