"""History of contacts: separation, new lists, ranks, minimisation; sums in place of forgotten
records.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.bodies.rubbing import (
    BRASS,
    HERTZ,
    LAMMPS_OWN,
    MU,
    NU,
    E,
    R,
    oblique,
    packing,
    rubbing,
    same,
    state,
)
from tests.helpers.bodies.two_spheres import value


def test_separation_clears_the_spring_and_not_the_dent(lammps):
    lmp = oblique(
        lammps,
        1.0,
        2.0,
        law=f"{BRASS} friction {MU}",
        steps=20000,
        extra="compute one all gran/hysteretic/contact 1 2",
    )
    assert value(lmp, "c_one[1]") < 0 and value(lmp, "c_one[6]") == 0 and value(lmp, "c_en[6]") == 0
    dent = value(lmp, "c_one[3]")
    loss = value(lmp, "c_one[7]")
    assert dent > 0 and loss == value(lmp, "c_en[7]") > 0
    speeds = state(lmp, "v")["v"]
    lmp.commands_string(
        f"set atom 1 vz {speeds[1, 2] / 2} vx 0\nset atom 2 vz 0 vx 0\nset group all omega 0 0 0\nrun 40000 post no"
    )
    assert value(lmp, "c_one[3]") == dent and value(lmp, "c_en[1]") > 0
    assert value(lmp, "c_en[7]") == pytest.approx(loss, rel=1e-3)  # second collision, head-on


@pytest.mark.parametrize("law", [HERTZ, BRASS])
def test_friction_zero_is_no_friction(lammps, law):
    places, speeds, spins = packing(2)
    found = []
    for words in ("", " friction 0"):
        lmp = lammps(rubbing(places, law + words, velocities=speeds, spins=spins))
        lmp.command("run 2000 post no")
        found.append(state(lmp, "x", "v", "f", "omega", "torque"))
        assert value(lmp, "c_en[6]") == value(lmp, "c_en[7]") == 0
    same(*found)
    assert np.array_equal(found[0]["omega"], spins) and not found[0]["torque"].any()


def test_friction_by_pair_of_types(lammps):
    """Only the pairs with a coefficient of friction have tangential forces."""
    lmp = lammps()
    places = [(0, 0, 0), (0, 0, 2 * R), (0.05, 0, 0), (0.05, 0, 2 * R)]
    coefficients = [
        f"pair_coeff 1 1 {HERTZ} friction 0.2",
        f"pair_coeff 2 2 {HERTZ}",
        f"pair_coeff 1 2 {HERTZ} friction 0.1",
    ]
    lmp.commands_string(
        rubbing(
            places,
            types=[1, 1, 2, 2],
            coefficients=coefficients,
            velocities=[(1.0, 0, 1.0), (0, 0, 0)] * 2,
        )
    )
    lmp.command("run 8000 post no")
    omega = state(lmp, "omega")["omega"]
    assert np.all(omega[:2, 1] != 0) and not omega[2:].any()
    with pytest.raises(Exception, match="Types 1 and 2 have different laws or options"):
        lammps(rubbing(places, types=[1, 1, 2, 2], coefficients=coefficients[:2]) + "run 1")


def test_springs_keep_still_in_a_minimisation(lammps):
    lmp = oblique(lammps, 1.0, steps=1000, extra="compute one all gran/hysteretic/contact 1 2")
    held = value(lmp, "c_one[6]")
    lmp.commands_string("min_style fire\nminimize 0 0 1 10")
    assert value(lmp, "c_one[6]") == held > 0


WAYS = ("sum", "list")
LOSSY = f"{BRASS} friction {MU} loss time 1e-8"


def jumbled(lammps, way: str, steps: int = 20000):
    """Loose spheres between walls that touch and separate, most of them several times."""
    places, speeds, spins = packing(2)
    size = 1.6 * np.ptp(places, axis=0).max()
    walls = "".join(
        f"fix {axis} all wall/gran/hysteretic {axis}plane {-0.4 * R:.17g} {size:.17g} hertz 115e9 0.3\n"
        for axis in "xyz"
    )
    extra = f"{walls}compute dents all gran/hysteretic/local\ncompute atoms all gran/hysteretic/atom\ntimestep 5e-8"
    motion = {
        "velocities": 30 * speeds,
        "spins": spins,
        "box": [-2 * R, size + 2 * R] * 3,
        "gap": f"1e-5 forgotten {way}",
    }
    lmp = lammps(rubbing(1.1 * places + R, LOSSY, **motion, extra=extra))
    lmp.command(f"run {steps} post no")
    return lmp


def report(lmp) -> dict[str, np.ndarray]:
    """Totals of all contacts, and the columns of each sphere in the order of IDs."""
    lmp.command("run 0 post no")
    order = np.argsort(lmp.numpy.extract_atom("id")[: lmp.get_natoms()])
    return {
        "totals": np.array([value(lmp, f"c_en[{k}]") for k in range(1, 9)]),
        "spheres": lmp.numpy.extract_compute("atoms", 1, 2)[: lmp.get_natoms()][order].copy(),
    }


def test_sums_are_those_of_the_records(lammps, tmp_path):
    """Motion, energies, counts, peaks and times are equal; the restart file with sums is smaller,
    and contains them.
    """
    found = {}
    size = {}
    listed = {}
    for way in WAYS:
        lmp = jumbled(lammps, way)
        found[way] = report(lmp) | state(lmp, "x", "v", "omega")
        listed[way] = lmp.numpy.extract_compute("dents", 2, 2)[:, 11].copy()
        lmp.command(f"write_restart {tmp_path}/{way}.restart")
        size[way] = (tmp_path / f"{way}.restart").stat().st_size
        again = lammps(
            f"newton off\natom_modify map yes\ncomm_modify vel yes\nread_restart {tmp_path}/{way}.restart\n"
            "compute en all gran/hysteretic/energy\ncompute atoms all gran/hysteretic/atom\n"
            "thermo_style custom step c_en[*]"
        )
        for name, values in report(again).items():
            assert values == pytest.approx(found[way][name], rel=1e-12), name
    assert listed["sum"].all() and np.sum(listed["list"] == 0) > 100
    assert size["list"] > 1.8 * size["sum"]
    for name, values in found["list"].items():
        if name in ("x", "v", "omega"):
            assert np.array_equal(values, found["sum"][name]), name
        else:
            assert found["sum"][name] == pytest.approx(values, rel=1e-11), name
    assert (found["sum"]["totals"][[0, 1, 6, 7]] > 0).all()


def test_restart_files_stay_small(lammps, tmp_path):
    """A file after four times as many steps is no larger than that with all spheres in contact."""
    sizes = []
    for steps in (20000, 60000):
        jumbled(lammps, "sum", steps).command(f"write_restart {tmp_path}/{steps}.restart")
        sizes.append((tmp_path / f"{steps}.restart").stat().st_size)
    assert sizes[1] < 1.1 * sizes[0]


MANY = """units si
atom_style sphere
atom_modify map yes
newton off
comm_modify vel yes
boundary f f f
region box block -0.1 0.1 -0.1 0.1 -0.1 0.1
create_box 1 box
create_atoms 1 single -1e-4 -1e-4 0
create_atoms 1 single -1e-4 -1e-4 0.0101
set group all diameter 0.01 density 8500
pair_style gran/hysteretic 1e-5 forgotten list
pair_coeff * * hertz 1 0.3 friction 0.3 loss time 1e-9
group beating id 2
fix motion beating move wiggle 0 0 1.02e-4 2e-4 units box
timestep 5e-5
run 1600
unfix motion
write_restart many.restart
"""
CROSSING = """newton off
atom_modify map yes
comm_modify vel yes
processors * * 1
read_restart many.restart
neigh_modify delay 0 every 1 check no
fix motion all nve
compute dents all gran/hysteretic/local
compute sums all reduce sum c_dents[5] c_dents[9] inputs local
thermo_style custom step c_sums[*]
thermo_modify norm no format float %.12g
run 0
{move}
run 0
"""


@pytest.mark.validation
@pytest.mark.parametrize(
    "move",
    [
        "velocity all set 1 1 0\nrun 4",
        "displace_atoms all move 2e-4 2e-4 0 units box",
    ],
)
def test_spheres_with_many_records_cross_a_corner(lammps, log_of, tmp_path, monkeypatch, move):
    """All records arrive when a rank without own records passes them on, and when spheres are moved
    between runs.
    """
    monkeypatch.chdir(tmp_path)
    lammps(MANY)
    log = log_of(CROSSING.format(move=move), ranks=4)
    rows = [line.split() for line in log.splitlines() if line.split()[:1] in (["1600"], ["1604"])]
    assert float(rows[0][1]) == pytest.approx(400 * 2e-6, rel=1e-6)
    assert rows[-1][1:] == rows[0][1:]


SOFT = 1e9
MASS = 8500 * 4 / 3 * np.pi * R**3
ACCELERATION = 1e4
WEIGHT = MASS * ACCELERATION
SDS = "rolling sds 2e6 3.0 0.05 twisting sds 4.0 1e-5 2e-5"


def pressed(
    lmp, law: str, velocity: float, spin: tuple[float, float, float], extra: str = ""
) -> float:
    """Sphere pressed onto a plate by a constant force, at rest along it; returns its overlap."""
    stiffness = 4 / 3 * SOFT / (1 - NU**2) * np.sqrt(R)
    overlap = (WEIGHT / stiffness) ** (2 / 3)
    text = script_of(
        [(0, 0, overlap)], velocities=[(velocity, 0, 0)], box=[-0.05, 0.05] * 3,
        extra=f"set atom 1 omega {spin[0]:.17g} {spin[1]:.17g} {spin[2]:.17g}\n"
        f"fix floor all wall/gran/hysteretic zplane NULL {R} hertz {SOFT} {NU} {law}\nfix press all addforce 0 0 {WEIGHT:.17g}\n"
        f"compute turn all erotate/sphere\nthermo_style custom step c_ke c_turn f_floor f_floor[*]\ntimestep 2e-7\n{extra}",
    )  # fmt: skip
    lmp.commands_string(text.replace("fix motion all nve\n", "fix motion all nve/sphere\n"))
    lmp.command("run 0 post no")
    return overlap


def test_a_rolling_sphere_stops(lammps):
    """The sphere rolls the distance 7 v^2 m/(10 mu_r N): torque mu_r R N, inertia 7/5 m R^2 about
    the contact; its energy is dissipated by rolling.
    """
    lmp = lammps()
    speed = 0.5
    mu = 0.1
    pressed(lmp, f"friction 0.5 rolling sds 2e7 0 {mu}", speed, (0, -speed / R, 0))
    before = value(lmp, "c_ke+c_turn")
    lmp.command("run 5500")
    expected = 0.7 * speed**2 * MASS / (mu * WEIGHT)
    assert lmp.numpy.extract_atom("x")[0, 0] == pytest.approx(expected, rel=0.02)
    assert value(lmp, "f_floor[18]") == pytest.approx(before, rel=0.02)
    assert value(lmp, "c_ke+c_turn+f_floor[8]+f_floor[9]+f_floor[17]+f_floor[18]") == pytest.approx(
        before, rel=1e-4
    )
    assert value(lmp, "f_floor[19]+f_floor[20]") == 0.0


@pytest.mark.parametrize("length", [None, 2e-5])
def test_a_twisting_sphere_stops(lammps, length):
    """Its spin ends after the time I w/M, with M = (2/3) mu a N, or a length times N."""
    lmp = lammps()
    spin = 30.0 if length else 1000.0
    mu = 0.3
    words = "twisting marshall" if length is None else f"twisting sds 50.0 0 {length}"
    overlap = pressed(lmp, f"friction {mu} {words}", 0.0, (0, 0, spin))
    lever = length or 2 / 3 * mu * np.sqrt(R * overlap)
    inertia = 0.4 * MASS * R**2
    stop = inertia * spin / (lever * WEIGHT)
    lmp.command(f"run {round(0.5 * stop / 2e-7)}")
    assert lmp.numpy.extract_atom("omega")[0, 2] == pytest.approx(spin / 2, rel=0.01)
    lmp.command(f"run {round(0.6 * stop / 2e-7)}")
    assert abs(lmp.numpy.extract_atom("omega")[0, 2]) < 0.1 * spin
    total = "c_turn+f_floor[19]+f_floor[20]"
    assert value(lmp, total) == pytest.approx(0.5 * inertia * spin**2, rel=1e-6)
    assert value(lmp, "f_floor[20]") == pytest.approx(0.5 * inertia * spin**2, rel=0.02)


@pytest.mark.parametrize("words", ["rolling sds 2e6 0.0 0.05", "twisting sds 4.0 0.0 2e-5", SDS])
def test_as_the_style_of_lammps(lammps, words):
    """Equal constants give equal changes of the spins in an oblique impact of spinning spheres.
    Without the resistances the result differs by 1.6 %.
    """
    spins = [(100.0, 300.0, 400.0), (0.0, -50.0, 20.0)]
    own = LAMMPS_OWN.format(E=E, nu=NU, model="mindlin_rescale", mu=MU)
    changes = []
    for options in (
        ({"own": own}, {"own": own.replace(" damping", f" {words} damping")}),
        ({}, {"law": f"{HERTZ} friction {MU} {words}"}),
    ):
        without, there = (
            state(oblique(lammps, 0.5, spins=spins, **one), "omega")["omega"] for one in options
        )
        changes.append(there - without)
    assert np.abs(changes[1] - changes[0]).max() < 1e-3 * np.abs(changes[0]).max()
