"""Spheres that are deleted, replaced, lost or removed from a group: their histories and their
contributions to totals.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import printed, refuses, script_of
from tests.helpers.bodies.rubbing import BRASS, rubbing
from tests.helpers.bodies.two_spheres import LAW, MASS, R, value

HERTZ = "hertz 115e9 0.3"
SHALLOW = 1e-5
DEEP = 5e-5
DELETES = "group gone id 2\ndelete_atoms group gone compress no\n"
CREATES = (
    f"create_atoms 1 single 0 0 {2 * R - SHALLOW:.17g} units box\n"
    "set atom 2 diameter 0.01 density 8500\n"
)
# on a rigid wall at -R: force of an overlap
STIFFNESS = 4 / 3 * 115e9 / (1 - 0.3**2) * np.sqrt(R)
# library of LAMMPS: style and type of a per-atom array
PER_ATOM = (1, 2)
# of the values of a wall: losses by yielding, sliding, dashpots and cohesion
LOSSES = (5, 9, 16, 21)


def columns_of(lmp, fix: str) -> np.ndarray:
    """Per-atom array of a fix in the order of the IDs."""
    order = np.argsort(lmp.numpy.extract_atom("id")[: lmp.get_natoms()])
    return lmp.numpy.extract_fix(fix, *PER_ATOM)[order]


def dented(law: str = BRASS, **options) -> str:
    """Two spheres that are pressed together, with a larger overlap than later."""
    return rubbing([(0, 0, 0), (0, 0, 2 * R - DEEP)], law, **options) + "run 0 post no\n"


# ---------------------------------------------------------------------- dents


@pytest.mark.parametrize("between", ["", "run 0 post no\n", "reset_timestep 0\n"])
def test_a_new_sphere_has_no_dent_of_a_deleted_one_with_its_id(lammps, between):
    """The force is the force of a new contact, 103.57 N."""
    lmp = lammps(dented() + DELETES + between + CREATES + "run 0 post no\n")
    assert value(lmp, "fz[2]") == pytest.approx(float(LAW.loading_force(SHALLOW)), rel=1e-9)
    assert value(lmp, "fz[2]") == pytest.approx(103.57, abs=5e-3)


def test_a_sphere_that_stays_keeps_its_dent(lammps):
    """Other spheres are deleted and added: the dent is unchanged."""
    text = dented().replace("run 0 post no\n", "")
    lmp = lammps(f"{text}create_atoms 1 single 0.02 0 0 units box\nset atom 3 diameter 0.01 density 8500\nrun 0 post no\n")  # fmt: skip
    lmp.commands_string(f"group other id 3\ndelete_atoms group other compress no\nset atom 2 z {2 * R - SHALLOW:.17g}\n")  # fmt: skip
    lmp.commands_string("create_atoms 1 single 0.02 0 0 units box\nset atom 3 diameter 0.01 density 8500\nrun 0 post no\n")  # fmt: skip
    assert value(lmp, "fz[2]") == 0


def test_a_new_sphere_has_no_spring_of_a_deleted_one(lammps):
    """Friction and a loss: a tangential force before, and none in a contact that is new."""
    law = f"{HERTZ} friction 0.3 loss time 1e-7"
    lmp = lammps(dented(law, velocities=[(1, 0, 0), (0, 0, 0)]) + "run 20 post no\n")
    assert abs(value(lmp, "fx[1]")) > 1
    lmp.commands_string(f"set atom 1 x 0 y 0 z 0\n{DELETES}{CREATES}run 0 post no\n")
    assert value(lmp, "fx[1]") == 0 and value(lmp, "fz[2]") > 0


@pytest.mark.parametrize("ranks", [1, 2])
def test_births_go_through_restart_files_and_ranks(log_of, ranks):
    """A sphere that was added in a run before the restart, and the sphere that replaces it
    afterwards.
    """
    start = dented() + DELETES + CREATES + "run 1\nwrite_restart r\nclear\n"
    again = (
        "atom_modify map yes\nnewton off\ncomm_modify vel yes\nread_restart r\n"
        "fix motion all nve/sphere\nthermo_style custom step\nrun 0\n"
    )
    end = 'variable force equal fz[2]\nrun 0\nprint "force $(v_force:%.15g)"\n'
    log = log_of(f"{start}processors 1 1 *\n{again}{DELETES}{CREATES}{end}", ranks)
    assert float(printed(log, "force")[0]) == pytest.approx(103.573, abs=1e-3)


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("change", ["group gone id 1\ndelete_atoms group gone compress no\n", "group gone id 1\ndelete_atoms group gone\n", "set atom 1 x 1e-4\n"])  # fmt: skip
def test_states_of_a_restart_file_are_refused_by_other_spheres(lammps, tmp_path, wall, change):
    """LAMMPS assigns IDs by the position in memory, and itself rejects new spheres."""
    fix = f"fix floor all wall/gran/hysteretic zplane {-R:.17g} NULL {HERTZ}\n" if wall else ""
    lammps(dented().replace("run 0", f"{fix}run 0") + f"write_restart {tmp_path}/r")
    reads = f"atom_modify map yes\nnewton off\ncomm_modify vel yes\nread_restart {tmp_path}/r\n"
    text = f"{reads}{change}{fix}fix motion all nve/sphere\nrun 0 post no"
    refuses(
        lammps(),
        text,
        "the state of atom 1 in the restart file would be assigned to atom [12], or to "
        "another position",
    )


# ---------------------------------------------------------------------- walls


@pytest.mark.parametrize("law", [HERTZ, f"{HERTZ} friction 0.3 loss time 1e-7", f"{HERTZ} cohesion jkr 1.0"])  # fmt: skip
def test_a_sphere_that_leaves_a_group_leaves_the_ledger_of_its_wall(lammps, law):
    """Columns, force and energy refer to the remaining spheres; dissipated energies are kept."""
    wall = f"group sub id 1\nfix floor sub wall/gran/hysteretic zplane {-R:.17g} NULL {law}\n"
    wall += "thermo_style custom step f_floor f_floor[*]\ncomm_modify vel yes"
    places = [(0, 0, -1e-6), (0.02, 0, -2e-6)]
    text = script_of(places, extra=wall, velocities=[(0.2, 0, 0), (0, 0, 0)])
    lmp = lammps(f"{text.replace('all nve', 'all nve/sphere')}run 20 post no\n")
    columns = columns_of(lmp, "floor")
    assert columns[0, 1] > 0 and columns[1, 1] == 0
    lost = [value(lmp, f"f_floor[{n}]") for n in LOSSES]
    springs = value(lmp, "f_floor[8]")
    lmp.commands_string("group sub clear\ngroup sub id 2\nrun 0 post no\n")
    columns = columns_of(lmp, "floor")
    assert columns[0, [0, 1, 8]].tolist() == [0, 0, 0]
    assert value(lmp, "f_floor[3]") == -columns[1, 1] == -value(lmp, "fz[2]") != 0
    assert value(lmp, "f_floor[8]") == 0
    after = [value(lmp, f"f_floor[{n}]") for n in LOSSES]
    assert sum(after) == pytest.approx(sum(lost) + springs, rel=1e-12)
    if law == HERTZ:
        assert value(lmp, "f_floor[3]") == pytest.approx(-STIFFNESS * 2e-6**1.5, rel=1e-9)
        assert value(lmp, "f_floor[4]") == pytest.approx(0.4 * STIFFNESS * 2e-6**2.5, rel=1e-9)
    lmp.commands_string("group sub clear\ngroup sub id 1\nrun 0 post no\n")
    assert value(lmp, "f_floor[3]") == -columns_of(lmp, "floor")[0, 1] != 0


def test_cylinders_that_come_during_a_run_touch_the_wall(lammps):
    """A sphere becomes a cylinder during the run: from then on the force is the force of a line
    contact.
    """
    text = script_of([(0, 0, -1e-6), (0.03, 0, 0)], types=[1, 2], coefficients=["pair_coeff * * hertz 115e9 0.3"])  # fmt: skip
    rods = "fix rods all gran/cylinder 2 0.01 0 1 0\ngroup beads id 1\n"
    wall = f"fix floor beads wall/gran/hysteretic zplane {-R:.17g} NULL {HERTZ}\n"
    turns = "variable kind atom 2\nfix turn all set 1 1 group beads type v_kind\n"
    lmp = lammps(f"{text}{rods}{wall}{turns}run 2 post no\n")
    always = lammps(f"{text}{rods}{wall}set atom 1 type 2\nrun 2 post no\n")
    assert value(lmp, "f_floor[3]") == pytest.approx(value(always, "f_floor[3]"), rel=1e-4)
    assert value(lmp, "f_floor[3]") < -100


# ---------------------------------------------------------------------- loads

LEAVES = [-0.03, 0.06, -0.05, 0.05, -0.05, 0.05]


def leaving(load: str, extra: str = "") -> str:
    """Loaded spheres, the second of which leaves the box."""
    fixes = f"{extra}fix push driven gran/load z {load}\nthermo_style custom step c_ke f_push f_push[*]\nthermo_modify lost ignore\ntimestep 1e-7"  # fmt: skip
    text = script_of([(0, 0, 0), (0.02, 0, 0)], velocities=[(0, 0, 0), (3000, 0, 0)], box=LEAVES, extra=fixes)  # fmt: skip
    return text.replace("boundary m m m", "boundary f f f")


def test_the_spheres_that_are_left_share_the_whole_force(lammps):
    lmp = lammps(leaving("force rectangle 2 1", "group driven id 1 2\n") + "run 0 post no\n")
    assert [value(lmp, f"fz[{n}]") for n in (1, 2)] == [1, 1]
    lmp.command("run 1000 post no")
    assert lmp.get_natoms() == 1
    assert value(lmp, "fz[1]") == pytest.approx(2, rel=1e-9)
    assert value(lmp, "f_push[1]") == pytest.approx(2, rel=1e-9)
    work = value(lmp, "f_push")
    kinetic = value(lmp, "c_ke")
    lmp.command("run 1000 post no")
    assert value(lmp, "f_push") - work == pytest.approx(value(lmp, "c_ke") - kinetic, rel=1e-9)


def test_a_load_that_has_lost_all_its_spheres_is_an_error(lammps):
    refuses(lammps(), leaving("force rectangle 2 1", "group driven id 2\n") + "run 1000", "its group driven has lost all its atoms")  # fmt: skip


def test_work_on_spheres_that_leave_the_group_of_a_displacement_stays(lammps):
    """Free spheres: the work is the change of their kinetic energy, whichever of them were loaded
    at the time.
    """
    extra = "group driven id 1 3\ngroup rest id 2\nunfix motion\nfix motion rest nve\nset atom 3 vz 3.0\n"
    third = "create_atoms 1 single -0.02 0 0 units box\nset atom 3 diameter 0.01 density 8500\n"
    text = leaving("displacement harmonic 1e-3 2e3", third + extra)
    lmp = lammps(f"{text}run 300 post no\n")
    kinetic = MASS * value(lmp, "vz[1]") ** 2
    start = 0.5 * MASS * 3.0**2
    assert value(lmp, "f_push") == pytest.approx(kinetic - start, rel=1e-9)
    assert value(lmp, "f_push[2]") == pytest.approx(
        MASS * (2 * value(lmp, "vz[1]") - 3.0), rel=1e-9
    )
    lmp.commands_string("group driven clear\ngroup driven id 1\nrun 0 post no\n")
    assert value(lmp, "f_push") == pytest.approx(kinetic - start, rel=1e-9)
    # stopped, and driven again by the load
    lmp.commands_string("group driven id 3\nvelocity all set 0 0 0\nrun 0 post no\n")
    assert value(lmp, "f_push") == pytest.approx(2 * kinetic - start, rel=1e-9)


def test_work_on_a_sphere_that_is_lost_stays(lammps):
    """Driven out of the box at 12.57 m/s, which cost its kinetic energy."""
    extra = "group driven id 1 2\ngroup rest empty\nunfix motion\nset atom 2 z 0.0499\n"
    text = leaving("displacement harmonic 1e-3 2e3", extra).replace("every 1 check yes", "every 10 check no")  # fmt: skip
    lmp = lammps(f"{text}run 0 post no\n")
    start = value(lmp, "f_push")
    # less the 3000 m/s that it had before
    first = 0.5 * MASS * (2 * (4e-0 * np.pi) ** 2 - 3000.0**2)
    assert start == pytest.approx(first, rel=1e-9)
    lmp.command("run 300 post no")
    assert lmp.get_natoms() == 1
    speed = value(lmp, "vz[1]")
    kept = value(lmp, "f_push") - 0.5 * MASS * (speed**2 - 3000.0**2)
    assert kept == pytest.approx(0.5 * MASS * (4 * np.pi) ** 2, rel=0.02)
