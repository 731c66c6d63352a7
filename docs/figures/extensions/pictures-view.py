"""A packing in space, with a quarter cut away."""

from page_figures import save

import granwave as gw

CHANGES = {"packing.size": [12, 12, 6], "run.end_time": 1e-4}

run = gw.run("fcc-small", CHANGES, directory="turned", figures=False)
save(run.figure("packing_3d"), "packing")
