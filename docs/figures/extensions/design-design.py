"""Course of a search, and the best design."""

from pathlib import Path

from page_figures import ROOT, save, write_files

import granwave as gw

write_files(ROOT / "docs" / "extensions" / "design" / "design.md", Path.cwd())
gw.design("lightest.toml", directory="lightest")
save("lightest/figures/convergence.png", "convergence")
save("lightest/figures/packing.png", "packing")
