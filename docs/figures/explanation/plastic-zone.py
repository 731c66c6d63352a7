"""Energy dissipated by each sphere on the vertical plane through the impact."""

from page_figures import save

import granwave as gw

CHANGES = {"packing.size": [12, 12, 7], "run.end_time": 1e-4}

run = gw.run("fcc-small", CHANGES, directory="small", figures=False)
save(run.figure("dissipation_orthogonal"), "dissipation")
