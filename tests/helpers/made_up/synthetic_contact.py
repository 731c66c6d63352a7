"""Runs of two finite-element spheres with known differences from the contact law."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import tomli_w

BRASS = {"name": "brass", "yield_strength": 550e6}
# m: overlap at first yield, R*
YIELD = 1e-6
RADIUS = 2.4e-3


def write_contact(
    folder: Path,
    difference: float = 0.0,
    partner: float | None = None,
    force: float = 1.0,
    material: dict[str, Any] | None = None,
) -> Path:
    """Write a run whose finite-element force is 15 % above the law up to 10 alpha_y, 5 % below it
    beyond, plus a given difference.
    """
    folder.mkdir()
    overlap = np.geomspace(0.3 * YIELD, 0.2 * RADIUS, 2000)
    law = 5e9 * overlap**1.2
    over = np.where(overlap <= 10.001 * YIELD, 0.15, -0.05) + difference
    with h5py.File(folder / "result.h5", "w") as file:
        file["loading/overlap"] = overlap
        file["loading/law_force"] = law
        file["loading/force"] = force * law * (1 + over)
        for n, pressure in enumerate((1.0, 1.6, 1.5)):
            file[f"pressure/{n}/pressure"] = [pressure * 16 / 15 * 550e6] * 3 + [0.0] * 5
        file["loading/contact_radius"] = np.sqrt(2 * RADIUS * overlap)
        file["fields/position"] = [[0, 0], [1, 0], [1, 1], [0, 1], [1, 2], [0, 2]]
        file["fields/elements"] = [[0, 1, 2, 3], [3, 2, 4, 5]]
        file["fields/body"] = [0, 1]
        file["fields/plastic_strain"] = [0.3, 0.1]
    case: dict[str, Any] = {"material": BRASS, "sphere": {"radius": 4.76e-3}}
    if partner or material:
        case["partner"] = {"radius": partner or 4.76e-3, "material": material or BRASS}
    exponents = {"unloading_exponent_min": 1.33, "unloading_exponent_max": 1.44}
    summary = {
        "name": folder.name,
        "yield_overlap_m": YIELD,
        "effective_radius_m": RADIUS,
        **exponents,
    }
    (folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    (folder / "case.toml").write_text(tomli_w.dumps(case), encoding="utf-8")
    return folder
