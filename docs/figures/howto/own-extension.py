"""The figure of the toy extension, which is put onto the path as pip leaves a package."""

import sys
from pathlib import Path

from page_figures import ROOT, save

toy = ROOT / "tests" / "extensions" / "toy"
information = Path("site/toy-1.0.dist-info")
information.mkdir(parents=True)
(information / "METADATA").write_text("Metadata-Version: 2.1\nName: toy\nVersion: 1.0\n")
(information / "entry_points.txt").write_text("[granwave.extensions]\ntoy = toy:extension\n")
sys.path[:0] = [str(toy), "site"]

import granwave as gw  # noqa: E402

run = gw.run(toy / "case.toml", directory="out")
save(run.figure("ranked_forces"), "ranked_forces")
save(run.figure("packing_3d"), "packing_3d")
