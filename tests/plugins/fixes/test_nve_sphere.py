"""Fix gran/nve/sphere integrates motion and rotation bitwise as LAMMPS's fix nve/sphere does, and
skips blocks of spheres at rest.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import refuses, script_of
from tests.helpers.bodies.rubbing import BRASS, MU, R, packing, rubbing, same, state

MOTION = ("x", "v", "omega", "f", "torque")
LAMMPS = "fix motion all nve/sphere\n"
OURS = LAMMPS.replace("nve/sphere", "gran/nve/sphere")


def crystal() -> str:
    """Eight layers of spheres at rest, of which the first gets an oblique impact."""
    places = 2 * R * np.indices((4, 4, 8)).T.reshape(-1, 3)
    return rubbing(
        places,
        f"{BRASS} friction {MU}",
        velocities=[(3.0, 1.0, 5.0)],
        spins=[(0, 300, 40)],
        extra="timestep 1e-7\n",
    )


def rattling() -> str:
    """Packing in which all spheres move and rotate."""
    places, velocities, spins = packing()
    return rubbing(
        places, f"{BRASS} friction {MU}", velocities=velocities, spins=spins, extra="timestep 1e-7"
    )


def tops() -> str:
    """Spheres that rotate, some of which also move, without a force."""
    places = [(3 * R * k, 0, 0) for k in range(70)]
    return rubbing(places, velocities=[(0, 0, 1)] * 20, spins=[(1, 2, 3)] * 60)


def rolling() -> str:
    """Spheres under gravity that slide and roll on a floor with friction."""
    floor = f"fix floor all wall/gran/hysteretic zplane {-R} NULL {BRASS} friction {MU}\n"
    places = [(3 * R * k, 0, 0) for k in range(6)]
    weight = "fix weight all gravity 9.81 vector 0 0.3 -1\ntimestep 1e-7\n"
    return rubbing(places, velocities=[(0, 0.5, -0.1)] * 3, extra=floor + weight)


def group() -> str:
    """Impact on a crystal in which the fix integrates only every other sphere."""
    other = "group some id 1:128:2\ngroup others subtract all some\nfix still others nve/noforce\n"
    return crystal().replace("fix motion all", f"{other}fix motion some")


def adaptive() -> str:
    """Impact whose timestep follows the error of the energy balance, which includes rotation."""
    given = "variable given equal 0.02\n"
    return f"{crystal()}{given}timestep 1e-8\nfix step all gran/timestep 16 1e-6 v_given\n"


SCRIPTS = {
    script.__name__: script for script in (crystal, rattling, tops, rolling, group, adaptive)
}


def ours(script: str) -> str:
    """Script with our fix in place of LAMMPS's."""
    assert script.count(" nve/sphere\n") == 1
    return script.replace(" nve/sphere\n", " gran/nve/sphere\n")


@pytest.mark.parametrize("name", SCRIPTS)
def test_the_bits_are_those_of_nve_sphere(lammps, name):
    script = SCRIPTS[name]()
    states = []
    for text in (script, ours(script)):
        lmp = lammps(text)
        lmp.command("run 400 post no")
        states.append(state(lmp, *MOTION))
    same(*states)
    assert np.ptp(states[0]["omega"]) > 0.0


def test_part_of_the_crystal_is_still_at_rest(lammps):
    """The case of the crystal has blocks to skip, and blocks that rotate."""
    lmp = lammps(ours(crystal()))
    lmp.command("run 200 post no")
    motion = state(lmp, "v", "omega")
    turning = motion["omega"].any(axis=1)
    assert not turning[-32:].any()
    assert not motion["v"][-32:].any()
    assert turning[:32].sum() > 3


def test_the_bits_are_the_same_after_a_restart(lammps, tmp_path):
    script = ours(crystal())
    whole = lammps(script)
    whole.commands_string("run 100 post no\nrun 100 post no")
    half = lammps(f"{script}run 100 post no\nwrite_restart {tmp_path}/half\n")
    half.commands_string(
        "clear\nnewton off\natom_modify map yes\n"
        f"read_restart {tmp_path}/half\ncomm_modify vel yes\n{OURS}timestep 1e-7\nrun 100 post no"
    )
    same(state(whole, *MOTION), state(half, *MOTION))


@pytest.mark.xdist_group("two processors")
@pytest.mark.parametrize("name", ["crystal", "rattling"])
def test_the_bits_are_those_of_nve_sphere_on_two_processors(log_of, tmp_path, name):
    columns = "id x y z vx vy vz omegax omegay omegaz tqx tqy tqz"
    end = f"run 400\nwrite_dump all custom out {columns} modify sort id format float %.17g\n"
    dumps = []
    for text in (SCRIPTS[name](), ours(SCRIPTS[name]())):
        log_of(text + end, 2)
        dumps.append((tmp_path / "out").read_text())
    assert dumps[0] == dumps[1]


def test_a_face_cannot_turn(lammps):
    script = script_of([(0, 0, 0), (0, 0, R)], radius=[R, 0.0], style="hertz 1e9 0.3")
    turning = script.replace("fix motion all nve\n", "fix motion all gran/nve/sphere\n")
    refuses(lammps(turning), "run 0", "atom 2 has the radius 0 and cannot rotate")
