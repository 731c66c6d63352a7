"""Fix gran/load: energy balance of forces and displacements, restart, ranks, manual, messages."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.manual import PAGES, Log
from tests.helpers.pushed import DRIVEN, MASS, PAIR, REPORT, balance, pushed, table
from tests.helpers.two_spheres import value

LOADS = {
    "force": ("group driven id 1\n", "driven|force half-sine 5000 3e-5"),
    "displacement": (DRIVEN, "driven|displacement harmonic 2e-5 8e3"),
}


@pytest.mark.parametrize("kind", LOADS)
def test_energy_balance_with_a_contact_that_yields(lammps, kind):
    extra, load = LOADS[kind]
    lmp = pushed(lammps(), load, PAIR, extra=extra)
    for _ in range(4):
        lmp.command("run 1500")
        assert balance(lmp) == pytest.approx(1, abs=1e-6)
        assert value(lmp, "mass(all)*vcm(all,z)/f_push[2]") == pytest.approx(1, rel=1e-10)
    assert value(lmp, "c_ep[1]") > 0.1 * value(lmp, "f_push")
    if kind == "displacement":
        angle = 2 * np.pi * 8e3 * 6e-5
        assert value(lmp, "z[1]") == pytest.approx(2e-5 * np.sin(angle), rel=1e-10)
        assert value(lmp, "vz[1]") == pytest.approx(2e-5 * 2 * np.pi * 8e3 * np.cos(angle), rel=1e-10)


def test_displacement_by_a_table_stays_at_its_last_value(lammps, tmp_path):
    rows = table(tmp_path / "place.txt", [1e-6, 2.1e-5], [0, 2e-5])
    lmp = pushed(lammps(), f"driven|displacement table {rows}", PAIR, extra=DRIVEN)
    lmp.command("run 1000")
    assert value(lmp, "z[1]") == pytest.approx(9e-6, rel=1e-10) and value(lmp, "vz[1]") == pytest.approx(1, rel=1e-10)
    assert balance(lmp) == pytest.approx(1, abs=1e-6)
    lmp.command("run 4000")
    assert value(lmp, "z[1]") == pytest.approx(2e-5, rel=1e-10) and value(lmp, "vz[1]") == 0
    assert balance(lmp) == pytest.approx(1, abs=1e-5)


def test_velocity_before_the_drive_is_not_its_work(lammps):
    lmp = pushed(lammps(), "driven|displacement harmonic 2e-5 8e3", PAIR, extra=DRIVEN + "set atom 1 vx 2.0 vz 1.0")
    lmp.command("run 3000")
    before = 0.5 * MASS * 5
    assert value(lmp, "c_ke+pe+c_ep[1]-f_push") == pytest.approx(before, rel=1e-6)
    assert value(lmp, "mass(all)*vcm(all,z)-f_push[2]") == pytest.approx(MASS, rel=1e-10)


def test_driven_sphere_crosses_between_processors(lmp, tmp_path):
    found = []
    for ranks in (1, 2):
        script = script_of(PAIR, box=[-0.02, 0.02, -0.02, 0.02, -0.02, 0.02002], extra=DRIVEN)
        script = script.replace("boundary m m m", f"boundary p p p\nprocessors 1 1 {ranks}")  # in contact at z = 1e-5
        script += f"fix push driven gran/load z displacement harmonic 2e-5 8e3{REPORT}neigh_modify check no every 10\nrun 6000\n"
        script += 'print "result $(z[1]:%.17g) $(z[2]:%.17g) $(f_push:%.15g) $(f_push[2]:%.15g) $(f_push[3]:%.15g)"\n'
        (tmp_path / "in.two").write_text(script)
        done = lmp(tmp_path / "in.two", ranks=ranks)
        log = (tmp_path / "log.lammps").read_text()
        assert done.returncode == 0, log[-1000:]
        found.append(log.rpartition("\nresult ")[2].split("\n")[0].split())
    assert found[0][:2] == found[1][:2]
    assert [float(w) for w in found[1]] == pytest.approx([float(w) for w in found[0]], rel=1e-12)


def test_example_of_the_manual(lmp, tmp_path):
    """Example of a bar in the manual page of the pair style; LAMMPS warns of two kinds of masses in hybrid atom styles."""
    page = (PAGES / "pair_gran_hysteretic.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"^```LAMMPS\n(# Example of a bar.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "in.bar").write_text(script)
    done = lmp(tmp_path / "in.bar")
    log = (tmp_path / "log.lammps").read_text()
    assert done.returncode == 0 and log.count("WARNING") == log.count("WARNING: Atom style hybrid defines both"), log
    run = Log(tmp_path / "log.lammps").runs[0]
    assert np.abs(run["v_balance"]).max() < 1e-6
    assert run["c_end[5]"][-1] > 0.5 * run["f_push"][-1]
    assert run["c_barkinetic"][-1] == pytest.approx(run["E_bond"][-1], rel=1e-3)  # a wave that travels one way
