"""Forgotten contacts: sums by sphere in place of records, and records of any number that migrate whole."""

from __future__ import annotations

import numpy as np
import pytest

from tests.helpers.rubbing import BRASS, MU, R, packing, rubbing, state
from tests.helpers.two_spheres import value

WAYS = ("sum", "list")
LAW = f"{BRASS} friction {MU} loss time 1e-8"


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
            LAW,
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
def test_spheres_with_many_records_cross_a_corner(lammps, lmp, tmp_path, monkeypatch, move):
    """They are passed on by a rank that has no records of its own, or moved between runs: all records arrive."""
    monkeypatch.chdir(tmp_path)
    lammps(MANY)
    (tmp_path / "in.crossing").write_text(CROSSING.format(move=move))
    done = lmp(tmp_path / "in.crossing", "-log", "log.crossing", ranks=4)
    log = (tmp_path / "log.crossing").read_text()
    assert done.returncode == 0, done.stderr + log[-1000:]
    rows = [line.split() for line in log.splitlines() if line.split()[:1] in (["1600"], ["1604"])]
    assert float(rows[0][1]) == pytest.approx(400 * 2e-6, rel=1e-6)
    assert rows[-1][1:] == rows[0][1:]
