"""LAMMPS's own elasto-plastic law, ``mdr`` of ``pair_style granular``, compared with ours: the
tables of docs/explanation/contact-law.md.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import granwave as gw
from tests.helpers.programs.struck_packing import LAWS, LAYERS, impact

PAGE = Path(__file__).parents[3] / "docs" / "explanation" / "contact-law.md"
RADIUS = 0.005
EFFECTIVE = RADIUS / 2
SPHERES = [{"shape": "sphere", "diameter": 2 * RADIUS, "material": "brass"}] * 2
OURS = "elastoplastic-fe"
LARGEST = 0.048  # overlap / R*
STEPS = 800


def rows() -> dict[str, list[float]]:
    """Numbers of the tables of the page, by the first column."""
    text = PAGE.read_text(encoding="utf-8").partition("## Comparison with LAMMPS's `mdr`")[2]
    table = [line.split("|")[1:-1] for line in text.splitlines() if line.startswith("| ")]
    return {cells[0].strip(): [float(x) for x in re.findall(r"[\d.]+", cells[1] + cells[2])]
            for cells in table[1:] if re.search(r"\d", cells[1])}  # fmt: skip


def two_spheres(law: str, x: float, z: float) -> str:
    """Return the script of two spheres, the second one at (x, 0, z)."""
    return f"""units si
atom_style sphere
atom_modify map array
newton off
boundary f f f
region box block -0.02 0.02 -0.02 0.02 -0.02 0.04
create_box 1 box
create_atoms 1 single 0 0 0
create_atoms 1 single {x!r} 0 {z!r}
set group all diameter {2 * RADIUS} density 8500
group lower id 1
group upper id 2
comm_modify vel yes
neighbor 1e-3 bin
{LAWS[law]}
"""


def collision(law: str, x: float, z: float) -> str:
    """Return the script of two spheres that move freely."""
    return two_spheres(law, x, z) + "fix motion all nve/sphere\ntimestep 1e-8\n"


@pytest.fixture
def pressed(lammps):
    """Overlaps and forces of two spheres that are slowly pressed together and separated again."""
    run = lammps(two_spheres("mdr", 0.0, 2 * RADIUS * (1 + 1e-9)))
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
    run = lammps(two_spheres("mdr", 0.0, 2 * RADIUS * (1 + 1e-9)))
    run.commands_string(
        f"set atom 1 vz {speed}\nfix motion all nve/sphere\ntimestep 1e-8\nrun 12000"
    )
    velocities = run.numpy.extract_atom("v")[:2, 2]
    restitution = abs(np.diff(velocities)[0]) / speed
    mass = 8500 * 4 / 3 * np.pi * RADIUS**3 / 2  # of two equal spheres, reduced
    ours = restitution_of_ours(mass * speed**2 / 2)
    assert rows()[f"restitution at {speed} m/s"] == pytest.approx([restitution, ours], abs=2e-3)


def restitution_of_ours(energy: float) -> float:
    """Return the coefficient of restitution of a head-on collision with this energy."""

    def loading_work(peak: float) -> float:
        overlaps = np.linspace(0, peak, 4001)
        return float(np.trapezoid(gw.contact_force(OURS, SPHERES, overlaps), overlaps))

    peak = brentq(lambda overlap: loading_work(overlap) - energy, 1e-7, 1e-3)
    return float(np.sqrt(gw.contact_energy(OURS, SPHERES, peak) / energy))


def test_only_ours_remembers_the_first_collision(lammps):
    table = rows()["restitution of a second collision at 5 m/s"]
    for law, on_the_page in zip(LAWS, table, strict=True):
        run = lammps(collision(law, 0.0, 2 * RADIUS * (1 + 1e-9)))
        restitutions = []
        for _ in range(2):
            run.commands_string("set atom 1 vz 5\nset atom 2 vz 0\nrun 12000")
            places = run.numpy.extract_atom("x")[:2, 2]
            assert np.ptp(places) > 2 * RADIUS
            velocities = run.numpy.extract_atom("v")[:2, 2]
            restitutions.append(np.ptp(velocities) / 5)
        assert restitutions[1] == pytest.approx(on_the_page, abs=2e-3)
        remembers = restitutions[1] > restitutions[0] + 0.1
        assert remembers == (law == OURS)


def overlap_rounded_to_zero() -> tuple[float, float]:
    """Return a position (x, z) whose squared distance from the origin is below the square of the
    diameter, while the distance itself is rounded to the diameter.
    """
    diameter = RADIUS + RADIUS
    for x in np.arange(1, 1000) * 1e-6:
        z = np.sqrt(diameter**2 - x**2)
        for height in (z, np.nextafter(z, 0)):
            square = x * x + height * height
            if square < diameter**2 and np.sqrt(square) == diameter:
                return float(x), float(height)
    raise AssertionError("no such position")


def test_mdr_stops_where_the_overlap_is_rounded_to_zero(lammps):
    x, z = overlap_rounded_to_zero()
    with pytest.raises(Exception, match="F_MDR is NaN, non-adhesive case"):
        lammps(collision("mdr", x, z)).command("run 1")
    run = lammps(collision(OURS, x, z))
    run.command("run 1")
    assert np.all(run.numpy.extract_atom("f")[:2] == 0)


def touching(run) -> np.ndarray:
    """Return, for each pair of spheres, whether they overlap."""
    count = run.get_natoms()
    places = np.empty((count, 3))
    places[run.numpy.extract_atom("id")[:count] - 1] = run.numpy.extract_atom("x")[:count]
    first, second = np.triu_indices(count, 1)
    return np.sum((places[first] - places[second]) ** 2, axis=1) < (2 * RADIUS) ** 2


def test_mdr_does_not_stop_in_a_packing_that_rattles(lammps):
    """Contacts open and close, and none is affected by an overlap that is rounded to zero."""
    cell = float(np.sqrt(2) * 2 * RADIUS * (1 + 1e-9))
    run = lammps(f"""units si
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
boundary f f f
lattice fcc {cell!r}
region box block -0.5 3.5 -0.5 3.5 -0.5 3.5
create_box 1 box
region grains block -0.01 2.99 -0.01 2.99 -0.01 2.99
create_atoms 1 region grains
set group all diameter {2 * RADIUS} density 8500
neighbor 1e-3 bin
{LAWS["mdr"]}
fix motion all nve/sphere
timestep 2e-8
run 0
""")
    velocities = np.random.default_rng(2).normal(scale=5.0, size=(108, 3))
    run.numpy.extract_atom("v")[:108] = velocities
    before = touching(run)
    changes = 0
    for _ in range(100):
        run.command("run 10 pre no post no")
        now = touching(run)
        changes += int(np.sum(now != before))
        before = now
    assert changes > 150


@pytest.mark.validation
def test_struck_packing():
    table = rows()
    theirs, ours = (impact(law, 10.0) for law in LAWS)
    for layer in (1, 2, 4, 6):
        forces = [result.peak_forces[layer - 1] for result in (theirs, ours)]
        assert table[f"peak force below layer {layer}, N"] == pytest.approx(forces, rel=5e-3)
    restitutions = [theirs.restitution, ours.restitution]
    assert table["restitution of the impactor"] == pytest.approx(restitutions, abs=2e-3)
    assert table["kinetic energy lost"] == pytest.approx([theirs.lost, ours.lost], abs=2e-3)
    # the energy lost with our law is stored or dissipated
    assert ours.stored + ours.dissipated == pytest.approx(ours.lost, abs=1e-5)
    # every layer except the last, which is held, carries less with our law than with mdr
    assert np.all(ours.peak_forces < theirs.peak_forces)
    assert len(ours.peak_forces) == LAYERS - 1


def test_a_packing_that_just_touches_stops_mdr():
    with pytest.raises(Exception, match="F_MDR is NaN"):
        impact("mdr", 10.0, gap=0.0)
