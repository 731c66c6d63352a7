"""Variances of the variables, and course of the search, of the tutorial's design."""

from pathlib import Path

from page_figures import ROOT, save, write_files

import granwave as gw

write_files(ROOT / "docs" / "extensions" / "design" / "tutorial.md", Path.cwd())
gw.design("best.toml", directory="best")
save("best/figures/importance.png", "importance")
save("best/figures/convergence.png", "convergence")
