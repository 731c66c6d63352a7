"""History of contacts: separation, new lists, ranks, minimisation; sums in place of forgotten records."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import printed
from tests.helpers.rubbing import BRASS, HERTZ, MU, R, oblique, packing, rubbing, same, state
from tests.helpers.two_spheres import value


def test_separation_clears_the_spring_and_not_the_dent(lammps):
    lmp = oblique(
        lammps, 1.0, 2.0, law=f"{BRASS} friction {MU}", steps=20000, extra="compute one all gran/hysteretic/contact 1 2"
    )
    assert value(lmp, "c_one[1]") < 0 and value(lmp, "c_one[6]") == 0 and value(lmp, "c_en[6]") == 0
    dent, loss = value(lmp, "c_one[3]"), value(lmp, "c_one[7]")
    assert dent > 0 and loss == value(lmp, "c_en[7]") > 0
    speeds = state(lmp, "v")["v"]
    lmp.commands_string(
        f"set atom 1 vz {speeds[1, 2] / 2} vx 0\nset atom 2 vz 0 vx 0\nset group all omega 0 0 0\nrun 40000 post no"
    )
    assert value(lmp, "c_one[3]") == dent and value(lmp, "c_en[1]") > 0
    assert value(lmp, "c_en[7]") == pytest.approx(loss, rel=1e-3)  # second collision, head-on


def test_a_forgotten_contact_leaves_its_loss(lammps):
    lmp = oblique(
        lammps,
        1.0,
        2.0,
        law=f"{BRASS} friction {MU}",
        gap="2e-5 forgotten list",
        extra="compute dents all gran/hysteretic/local",
    )
    loss = value(lmp, "c_en[7]")
    lmp.command("run 4000")
    table = lmp.numpy.extract_compute("dents", 2, 2)
    assert table[0, 11] == 0 and table[0, 14] == loss == value(lmp, "c_en[7]")


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
        rubbing(places, types=[1, 1, 2, 2], coefficients=coefficients, velocities=[(1.0, 0, 1.0), (0, 0, 0)] * 2)
    )
    lmp.command("run 8000 post no")
    omega = state(lmp, "omega")["omega"]
    assert np.all(omega[:2, 1] != 0) and not omega[2:].any()
    with pytest.raises(Exception, match="Types 1 and 2 have different laws or options"):
        lammps(rubbing(places, types=[1, 1, 2, 2], coefficients=coefficients[:2]) + "run 1")


PIECES = {
    "sort": "atom_modify sort 1 0.02",
    "rebuild": "neigh_modify every 7 delay 0 check no",
}


@pytest.mark.parametrize("how", PIECES)
def test_springs_outlive_new_lists_and_sorting(lammps, how):
    """Other neighbor settings and another order of spheres change only the order of sums, which are exact."""
    places, speeds, spins = packing(2)
    found = []
    for extra in ("", PIECES[how]):
        lmp = lammps(rubbing(places, f"{BRASS} friction {MU}", velocities=3 * speeds, spins=spins, extra=extra))
        lmp.command("run 3000 post no")
        found.append((state(lmp, "x", "v", "omega"), value(lmp, "c_en[7]")))
    (one, loss), (other, as_much) = found
    same(one, other)
    assert loss == pytest.approx(as_much, rel=1e-12)


def test_two_ranks_give_the_same_bits(log_of, tmp_path):
    places, speeds, spins = packing()
    rows = []
    for ranks in (1, 2):
        text = rubbing(places, f"{BRASS} friction {MU}", velocities=3 * speeds, spins=spins, gap=2e-4)
        text += "compute dents all gran/hysteretic/local\ncompute sums all reduce sum c_dents[13] c_dents[15] inputs local\n"
        text += (
            "thermo_style custom step c_en c_en[*] c_sums[*]\nthermo_modify norm no format float %.15g\nthermo 1000\n"
        )
        text += f"run 4000\nwrite_dump all custom {tmp_path}/{ranks}.dump id x y z vx vy vz omegax omegay omegaz tqx modify sort id format float %.17g"
        rows.append(np.array(printed(log_of(text, ranks), "4000"), float))
    assert (tmp_path / "1.dump").read_text() == (tmp_path / "2.dump").read_text()
    assert rows[0] == pytest.approx(rows[1], rel=1e-12) and rows[0][-1] == pytest.approx(rows[0][7], rel=1e-12)


def test_springs_keep_still_in_a_minimisation(lammps):
    lmp = oblique(lammps, 1.0, steps=1000, extra="compute one all gran/hysteretic/contact 1 2")
    held = value(lmp, "c_one[6]")
    lmp.commands_string("min_style fire\nminimize 0 0 1 10")
    assert value(lmp, "c_one[6]") == held > 0


WAYS = ("sum", "list")
LOSSY = f"{BRASS} friction {MU} loss time 1e-8"


def jumbled(lammps, way: str, steps: int = 20000):
    """Loose spheres between walls that meet and part, most of them several times."""
    places, speeds, spins = packing(2)
    size = 1.6 * np.ptp(places, axis=0).max()
    walls = "".join(
        f"fix {axis} all wall/gran/hysteretic {axis}plane {-0.4 * R:.17g} {size:.17g} hertz 115e9 0.3\n"
        for axis in "xyz"
    )
    extra = f"{walls}compute dents all gran/hysteretic/local\ncompute atoms all gran/hysteretic/atom\ntimestep 5e-8"
    lmp = lammps()
    box = [edge for _ in range(3) for edge in (-2 * R, size + 2 * R)]
    lmp.commands_string(
        rubbing(
            1.1 * places + R,
            LOSSY,
            velocities=30 * speeds,
            spins=spins,
            gap=f"1e-5 forgotten {way}",
            box=box,
            extra=extra,
        )
    )
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
    """The same motion, energies, counts, peaks and times; the restart file of the sums is the smaller one, and holds them."""
    found, size, listed = {}, {}, {}
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
    assert size["list"] > 2 * size["sum"]
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


@pytest.mark.parametrize("move", ["velocity all set 1 1 0\nrun 4", "displace_atoms all move 2e-4 2e-4 0 units box"])
def test_spheres_with_many_records_cross_a_corner(lammps, log_of, tmp_path, monkeypatch, move):
    """They are passed on by a rank that has no records of its own, or moved between runs: all records arrive."""
    monkeypatch.chdir(tmp_path)
    lammps(MANY)
    log = log_of(CROSSING.format(move=move), ranks=4)
    rows = [line.split() for line in log.splitlines() if line.split()[:1] in (["1600"], ["1604"])]
    assert float(rows[0][1]) == pytest.approx(400 * 2e-6, rel=1e-6)
    assert rows[-1][1:] == rows[0][1:]
