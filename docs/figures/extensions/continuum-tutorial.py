"""Plastic strain of the block below the punch."""

import subprocess

from page_figures import save

subprocess.run(["granwave", "continuum", "half-space", "-o", "block"], check=True)
save("block/figures/plastic_strain.png", "dissipation")
