"""The contact law of a steel, and the force below packings with and without a tolerance."""

import subprocess

from page_figures import save

import granwave as gw

command = "granwave law --material steel --radius 0.005 -o law.png"
subprocess.run(command.split(), check=True)
save("law.png", "law")

ideal = gw.run("real.toml", {"packing.diameter_scatter": 0.0}, directory="ideal")
real = gw.run("real.toml", directory="real")
save(gw.compare([ideal, real]).figure("bottom_force"), "bottom_force")
