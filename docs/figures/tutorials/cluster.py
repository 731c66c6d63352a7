"""Dissipation against impact velocity for two materials, on packings of fewer layers."""

import tomllib
from pathlib import Path

from page_figures import save

import granwave as gw

tables = tomllib.loads(Path("speeds.toml").read_text(encoding="utf-8"))
tables["set"] = {"packing.size": [12, 12, 8], "run.end_time": 2e-4}
tables["ranks"] = 1
scan = gw.scan(tables, jobs=2)
save(scan.figure("dissipated_fraction_vs_load_velocity"), "dissipated_fraction")
