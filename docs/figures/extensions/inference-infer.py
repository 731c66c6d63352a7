"""Inferred forces, and their error against the noise of the measurement."""

import subprocess
from pathlib import Path

from page_figures import ROOT, save, write_files

import granwave as gw

write_files(ROOT / "docs" / "extensions" / "inference" / "infer.md", Path.cwd())
gw.run("cubic.toml", directory="cubic", figures=False)
command = ["granwave", "infer", "cubic", "--noise", "0.02,0.05,0.1", "--repeat", "5", "-o", "noisy"]
subprocess.run(command, check=True)
save("noisy/figures/noise.png", "noise")
save("noisy/figures/force_network.png", "force_network")
