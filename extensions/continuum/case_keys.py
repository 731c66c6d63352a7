"""Labels and units of the keys of cases of finite elements, in tables and figures of scans.

A test compares these units with the units of the cases.
"""

from __future__ import annotations

from granwave.analysis.formatting.values import Naming

CASE_KEYS = {
    "block.diameter": Naming("block.diameter", unit="m", si="m"),
    "block.height": Naming("block.height", unit="m", si="m"),
    "punch.velocity": Naming("Velocity of the punch", r"$v_0$", "m/s", si="m/s"),
    "punch.mass": Naming("Mass of the punch", r"$m$", "kg", si="kg"),
    "punch.diameter": Naming("Diameter of the punch", r"$D$", "mm", 1e-3, "m"),
    "punch.taper": Naming("Taper of the punch", unit="mm", scale=1e-3, si="m"),
    "run.elements": Naming("Elements"),
    "run.edge_size": Naming("Elements at the edge", unit="mm", scale=1e-3, si="m"),
    "run.frame_interval": Naming("run.frame_interval", unit="s", si="s"),
}
