"""Peak forces in a plane crystal, and the speed of the grains of its middle line."""

from page_figures import save

import granwave as gw

run = gw.run("crystal.toml")
for name in ("peak_force_principal", "line_speeds"):
    save(run.figure(name), name)
