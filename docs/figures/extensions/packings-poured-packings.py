"""A poured bed hit by a sphere, and the statistics of the bed."""

import subprocess

from page_figures import save

import granwave as gw

run = gw.run("poured-small", directory="hit", figures=False)
save(run.figure("packing_3d"), "bed")
subprocess.run(["granwave", "bed", "poured-small", "-o", "grains.png"], check=True)
save("grains.png", "statistics")
