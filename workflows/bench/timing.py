"""Common parts of the measurements: the deck that is timed, the clock, and texts of medians and ranges."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows.run.lammps_engine import Engine

Report = Callable[[str], None]  # prints a line

STUDY = "fcc-impact"  # reference study
STEPS, WARM = 100, 20  # timed, and run before them
_RATTLE = 0.02  # m/s, largest velocity component; two brass spheres yield above about 0.05 m/s
_RATTLE_STEPS = 200  # until contacts have formed


@dataclass(frozen=True)
class Style:
    """Pair style to be timed.

    Attributes
    ----------
    lines
        Commands of the pair style, with names of constants in braces.
    motion
        Style of the integrating fix.
    beside
        Name of the style that its speed is compared with.
    """

    lines: str
    motion: str
    beside: str


def script(case: Case, data: Path, style: Style) -> str:
    """Return the LAMMPS commands of a struck packing under a pair style."""
    material, diameter = case.material, case.packing.diameter
    modulus = material.youngs_modulus / (2 * (1 - material.poisson_ratio**2))
    coefficients = style.lines.format(
        gap=0.1 * diameter,
        E=material.youngs_modulus,
        nu=material.poisson_ratio,
        yield_strength=material.yield_strength,
        kn=4 / 3 * modulus,
    )
    totals = (
        "compute contact all pair gran/hysteretic\nthermo_style custom step c_contact[2]"
        if "hysteretic" in style.lines
        else ""
    )
    struck = struck_spheres(assemble(case).lattice, 1)[0]
    return f"""units si
atom_style sphere
atom_modify map yes sort 0 0
newton off
comm_modify vel yes
boundary m m m
read_data {data}
neighbor {0.1 * diameter} bin
neigh_modify delay 0 every 10 check yes
{coefficients}
fix motion all {style.motion}
timestep {auto_timestep(case)}
group struck id {struck}
velocity struck set 0.0 0.0 {case.load.velocity} units box
thermo 1000000
{totals}
"""


def rattle(engine: Engine, seed: int) -> None:
    """Give all spheres of this rank random velocities, and run until contacts have formed."""
    speeds = engine.lammps.numpy.extract_atom("v")
    speeds[:] = np.random.default_rng(seed).uniform(-_RATTLE, _RATTLE, speeds.shape)
    engine.commands(f"run {_RATTLE_STEPS} post no")


def seconds(engine: Engine) -> float:
    """Measure the wall time of `STEPS` steps, without set-up and the steps before."""
    engine.commands(f"run {WARM} post no")
    begin = time.perf_counter()
    engine.commands(f"run {STEPS} pre no post no")
    return time.perf_counter() - begin


def spread(values: list[float], unit: float = 1.0) -> str:
    """Return the median and the range as text."""
    low, middle, high = min(values) / unit, statistics.median(values) / unit, max(values) / unit
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"
