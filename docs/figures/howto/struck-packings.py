"""Peak forces in a square packing, and the force in a load cell."""

from page_figures import save

import granwave as gw

run = gw.run("square-in-plane")
save(run.figure("peak_force_principal"), "peak_force")
save(gw.run("cell.toml").figure("target"), "load_cell")
