"""LAMMPS's own elasto-plastic law, ``mdr`` of ``pair_style granular``, beside ours: the table of
docs/explanation/contact-law.md.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import granwave as gw

PAGE = Path(__file__).parents[3] / "docs" / "explanation" / "contact-law.md"
RADIUS = 0.005
EFFECTIVE = RADIUS / 2
SPHERES = [{"shape": "sphere", "diameter": 2 * RADIUS, "material": "brass"}] * 2
OURS = "elastoplastic-fe"
LARGEST = 0.048  # overlap over R*
STEPS = 800
SCRIPT = f"""units si
atom_style sphere
atom_modify map array
newton off
boundary f f f
region box block -0.02 0.02 -0.02 0.02 -0.02 0.04
create_box 1 box
create_atoms 1 single 0 0 0
create_atoms 1 single 0 0 {2 * RADIUS * (1 + 1e-9)}
set group all diameter {2 * RADIUS} density 8500
group lower id 1
group upper id 2
comm_modify vel yes
neighbor 1e-3 bin
pair_style granular
pair_coeff * * mdr 115e9 0.3 550e6 0 0.5 0 tangential linear_nohistory 0 0 damping mdr 1
"""


def rows() -> dict[str, list[float]]:
    """Numbers of the table of the page, by the first column."""
    text = PAGE.read_text(encoding="utf-8").partition("## Comparison with LAMMPS's `mdr`")[2]
    table = [line.split("|")[1:-1] for line in text.splitlines() if line.startswith("| ")]
    return {cells[0].strip(): [float(x) for x in re.findall(r"[\d.]+", cells[1] + cells[2])]
            for cells in table[1:] if re.search(r"\d", cells[1])}  # fmt: skip


@pytest.fixture
def pressed(lammps):
    """Overlaps and forces of two spheres that are pressed together and drawn apart again, slowly."""
    run = lammps(SCRIPT)
    speed = LARGEST * EFFECTIVE / STEPS
    run.commands_string("timestep 1\nfix still lower move linear 0 0 0\n")
    curves = []
    for sign in (-1, 1):
        run.command(f"fix go upper move linear 0 0 {sign * speed}")
        run.command("run 0")
        curve = []
        for _ in range(STEPS):
            run.command("run 1 pre no post no")
            places = run.numpy.extract_atom("x")[:2, 2]
            force = abs(run.numpy.extract_atom("f")[0, 2])
            curve.append((2 * RADIUS - np.ptp(places), force))
        run.command("unfix go")
        curves.append(np.array(curve))
    return curves


def test_forces_and_dent(pressed):
    loading, unloading = pressed
    table = rows()
    for share in (0.002, 0.004, 0.008, 0.02, LARGEST):
        overlap = share * EFFECTIVE
        theirs = np.interp(overlap, loading[:, 0], loading[:, 1])
        ours = float(gw.contact_force(OURS, SPHERES, overlap))
        assert table[f"force at {share:g} R\\*, N"] == pytest.approx([theirs, ours], rel=2e-3)
    parted = unloading[unloading[:, 1] < 1e-9]
    peak = LARGEST * EFFECTIVE

    def force(overlap):
        return float(gw.contact_force(OURS, SPHERES, overlap, peak_overlap=peak)) - 1e-6

    dent = brentq(force, 0.5 * peak, peak)
    assert table[f"residual indentation from {LARGEST:g} R\\*, R\\*"] == pytest.approx(
        [parted[0, 0] / EFFECTIVE, dent / EFFECTIVE], abs=1e-4
    )


@pytest.mark.parametrize("speed", [1, 5, 10])
def test_restitution(lammps, speed):
    run = lammps(SCRIPT)
    run.commands_string(
        f"set atom 1 vz {speed}\nfix motion all nve/sphere\ntimestep 1e-8\nrun 12000"
    )
    velocities = run.numpy.extract_atom("v")[:2, 2]
    restitution = abs(np.diff(velocities)[0]) / speed
    mass = 8500 * 4 / 3 * np.pi * RADIUS**3 / 2  # of two equal spheres, reduced
    ours = restitution_of_ours(mass * speed**2 / 2)
    assert rows()[f"restitution at {speed} m/s"] == pytest.approx([restitution, ours], abs=2e-3)


def restitution_of_ours(energy: float) -> float:
    """Return the share of the velocity that a head-on collision of this energy leaves."""

    def loading_work(peak: float) -> float:
        overlaps = np.linspace(0, peak, 4001)
        return float(np.trapezoid(gw.contact_force(OURS, SPHERES, overlaps), overlaps))

    peak = brentq(lambda overlap: loading_work(overlap) - energy, 1e-7, 1e-3)
    return float(np.sqrt(gw.contact_energy(OURS, SPHERES, peak) / energy))
