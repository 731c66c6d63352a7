"""A sphere that hits walls in LAMMPS: its radius, its steps, and its state."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.conftest import script_of

R = 0.003
STEP = 2e-8


def thrown(lmp: Any, place: Any, velocity: Any, steps: int, walls: str) -> None:
    """Run a sphere that hits walls, which are the last fixes."""
    text = script_of(
        [place],
        radius=R,
        density=8500.0,
        velocities=[velocity],
        box=[-0.05, 0.05] * 3,
        extra=f"{walls}\ncompute spin all erotate/sphere\nthermo_style custom step c_ke c_spin "
        f"f_wall f_wall[*]\nthermo_modify norm no\ntimestep {STEP}",
    ).replace("fix motion all nve\n", "fix motion all nve/sphere\n")
    lmp.commands_string(f"{text}run {steps}\n")


def state(lmp: Any) -> np.ndarray:
    """Position, velocity and spin of the sphere."""
    return np.concatenate([lmp.numpy.extract_atom(name)[0] for name in ("x", "v", "omega")])
