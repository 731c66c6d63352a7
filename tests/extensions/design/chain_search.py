"""A search over the materials of a chain of three beads, which several test modules share."""

from __future__ import annotations

from granwave.extensions.design.search.design_file import load_problem

CHAIN = """
name = "chain"
material = "stainless-steel"
[packing]
kind = "chain"
size = 3
diameter = 0.010
[load]
velocity = 2.0
[contact]
law = "hertz"
[run]
end_time = 6e-5
frames = 2
"""
MATERIALS = ["stainless-steel", "ptfe"]
TABLES = {
    "base": "chain.toml",
    "variables": {f"replace.{n}.material": MATERIALS for n in (1, 2, 3)},
    "objective": {"minimise": ["target_peak_force_N"]},
    "search": {"evaluations": 8, "seed": 2},
}


def problem_of(folder, **changes):
    return load_problem({**TABLES, "base": str(folder / "chain.toml"), **changes})
