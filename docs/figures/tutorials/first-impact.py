"""Peak forces, the energy balance and the force at the bottom of the first impact."""

from page_figures import save

import granwave as gw

run = gw.run("impact.toml")
for name in ("packing_3d", "energies", "bottom_force"):
    save(run.figure(name), name)
