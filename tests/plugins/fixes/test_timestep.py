"""Fix gran/timestep: a step that follows the error of the energy balance."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import R, value

APART = 2e-5  # m: the first of two spheres flies before it hits
LINE = [(0, 0, 0)] + [(0, 0, 2 * R * k + APART) for k in range(1, 6)]
HERTZ = "hertz 115e9 0.3"
BRASS = "elastoplastic 115e9 0.3 550e6"
TICK = 5e-9
ERROR = """
compute contact all gran/hysteretic/energy
variable error equal c_ke+c_contact+c_contact[1]-v_given
variable share equal v_error/v_given
variable now equal f_step[1]
variable expected equal f_step[2]
variable taken equal f_step[3]
"""


def setup(
    lmp,
    options: str = "32 3e-6 v_given first 4",
    *,
    style: str = BRASS,
    every: int = 32,
    extra: str = "",
    speed=5.0,
):
    """A line of spheres, the first of which hits the others, with an energy record."""
    mass = 8500 * 4 / 3 * np.pi * R**3
    lmp.commands_string(
        script_of(LINE, velocities=[(0, 0, speed)] + [(0, 0, 0)] * (len(LINE) - 1), style=style)
        + f"\ntimestep {TICK}\nvariable given equal {0.5 * mass * speed**2!r}\n{ERROR}"
        + f'fix ledger all ave/time {every} 1 {every} v_share v_now v_expected v_taken file ledger.txt format " %.17g"\n'
        + f"{extra}\nfix step all gran/timestep {options}\nthermo 1000000\n"
    )


def ledger() -> np.ndarray:
    """Rows of step, error of the balance, timestep, expected error, steps."""
    return np.loadtxt("ledger.txt")


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("style", [HERTZ, BRASS])
@pytest.mark.parametrize("tolerance", [1e-4, 3e-6, 1e-7])
def test_the_balance_keeps_the_tolerance(lammps, style, tolerance):
    lmp = lammps()
    first = 2 ** round(np.log2(4 * np.sqrt(tolerance / 3e-6)))
    setup(
        lmp,
        f"64 {tolerance} v_given first {max(1, first)} balance v_error 64",
        style=style,
        every=64,
    )
    lmp.command("run 16000")
    rows = ledger()
    assert np.abs(rows[:, 1]).max() < tolerance
    assert np.abs(rows[:, 1]).max() > tolerance / 30  # and uses it


def test_a_looser_tolerance_takes_fewer_steps(lammps):
    taken = []
    for tolerance in (1e-4, 3e-6, 1e-7):
        lmp = lammps()
        setup(lmp, f"64 {tolerance} v_given first 4", every=64)
        lmp.command("run 16000")
        taken.append(value(lmp, "f_step[3]"))
    assert (
        taken[0] <= taken[1] < taken[2] < 16000
    )  # one sphere has all of the energy for most of the time


@pytest.mark.parametrize("style", [HERTZ, BRASS])
def test_the_error_is_what_the_shadow_energy_tells(lammps, style):
    """Without a measured error, forces and velocities predict it to 10 % of the largest error."""
    lmp = lammps()
    setup(lmp, "8 1e-3 v_given first 8", style=style, every=8)  # a row at each step
    lmp.command("run 12000")
    rows = ledger()
    rows = rows[4:]  # the first step is cut short, as energies are tallied on it
    assert (rows[:, 2] == 8 * TICK).all()
    found = 0.5 * (
        rows[:-2, 1] + rows[1:-1, 1]
    )  # the expected one is that of the middle of the step before
    assert np.abs(found).max() > 3e-7
    assert np.abs(found - rows[2:, 3]).max() < 0.1 * np.abs(found).max()


def test_it_is_short_in_the_collision_and_long_before_and_after(lammps):
    lmp = lammps()
    setup(lmp, "32 3e-6 v_given first 4")
    lmp.command("run 64000")
    rows = ledger()
    hit = int(np.argmax(np.abs(rows[:, 1]) > 1e-9))
    assert (
        rows[:hit, 2].max() == 4 * TICK
    )  # the first has all of the energy, and may hit at any time
    assert rows[hit, 2] == 4 * TICK < rows[-1, 2]


def test_records_fall_on_exact_times(lammps):
    lmp = lammps()
    setup(
        lmp, every=48, extra="dump shots all custom 500 shots.dump id z\n"
    )  # neither is a multiple of the longest step
    lmp.command("run 12345")
    assert lmp.extract_global("ntimestep") == 12345
    assert value(lmp, "time") == pytest.approx(12345 * TICK, rel=1e-14)
    assert (np.diff(ledger()[:, 0]) == 48).all()
    steps = re.findall(r"ITEM: TIMESTEP\n(\d+)", Path("shots.dump").read_text())
    assert [int(step) for step in steps] == list(range(0, 12001, 500))


def test_energies_that_are_tallied_on_the_first_step_of_a_run(lammps):
    lmp = lammps()
    setup(lmp, every=32)
    lmp.command("thermo_style custom step pe c_ke")
    lmp.command("thermo 32")
    lmp.command("run 8000")
    for _ in range(20):
        lmp.command("run 32 pre no")
    assert lmp.extract_global("ntimestep") == 8640


@pytest.mark.parametrize("options", ["32 3e-6 v_given first 4", "32 1e-3 v_given first 8"])
def test_the_impulse_of_a_pulse_stays_exact(lammps, options):
    lmp = lammps()
    setup(
        lmp, options, extra="group hit id 6\nfix push hit gran/load z force half-sine 100 2.003e-5"
    )
    lmp.command("run 16000")
    assert value(lmp, "f_step[5]") > value(lmp, "f_step[4]")
    assert value(lmp, "f_push[2]") == pytest.approx(2 * 100 * 2.003e-5 / np.pi, rel=1e-12)
    given = value(lmp, "f_push[2]+mass(all)/6*5")
    assert value(lmp, "mass(all)*vcm(all,z)") == pytest.approx(given, rel=1e-9)


def test_the_step_is_held_while_a_pulse_is_to_come(lammps):
    lmp = lammps()
    setup(lmp, "32 1e-3 v_given first 2 until 2e-5")
    lmp.command("run 16000")
    rows = ledger()
    assert rows[rows[:, 0] * TICK < 2e-5, 2].max() <= 2 * TICK < rows[:, 2].max()


def test_without_the_fix_the_timestep_is_the_tick_again(lammps):
    lmp = lammps()
    setup(lmp)
    lmp.command("run 8000")
    lmp.command("unfix step")
    assert value(lmp, "dt") == TICK
    lmp.command("unfix ledger")
    lmp.command("run 10")
    assert lmp.extract_global("ntimestep") == 8010


# ---------------------------------------------------------------------- commands that act at certain steps

BALL = "ball\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\nDiameters\n\n1 0.01\n\nMasses\n\n1 0.004\n"
FAR = "region far block -0.04 0.04 -0.04 0.04 0.1 0.12 units box\n"
COMING = f"molecule ball ball.mol\n{FAR}fix new all deposit 10 0 401 8 region far mol ball near 0.011 units box\n"
GOING = "fix thin all evaporate 1003 1 all 5\n"


def spheres(extra: str, fix: str) -> str:
    """Two spheres that collide, in a large box, with a compute that counts spheres."""
    return (
        script_of(LINE[:2], velocities=[(0, 0, 0.5), (0, 0, 0)], box=[-0.05, 0.15] * 3)
        + f"variable number equal count(all)\n{extra}{fix}\nthermo 100000\n"
        + 'fix numbers all print 100 "$(step) ${number}" file numbers.txt screen no\n'
    )


@pytest.mark.parametrize("fix", [COMING, GOING], ids=["deposit", "evaporate"])
def test_spheres_come_and_go_at_their_steps(lammps, fix):
    Path("ball.mol").write_text(BALL)
    numbers = []
    for step in ("", "fix step all gran/timestep 32 1e-4 0.005 first 4\n"):
        script = spheres("region all block INF INF INF INF INF INF\n", fix)
        lmp = lammps(script + step)
        lmp.command("run 6000")
        numbers.append(np.loadtxt("numbers.txt"))
        if step:
            assert value(lmp, "f_step[5]") > value(lmp, "f_step[4]")
    assert np.array_equal(*numbers)
    assert len(numbers[0]) == 61
    assert numbers[0][0, 1] == 2
    assert numbers[0][-1, 1] == (12 if fix == COMING else 0)


def test_spheres_that_come_do_not_count_as_an_error(lammps):
    """A fast sphere that is added has its own shadow energy, which is no error of the balance."""
    Path("ball.mol").write_text(BALL)
    fast = COMING.replace("near", "vz -3 -3 near")
    lmp = lammps(spheres("", fast) + "fix step all gran/timestep 32 1e-4 0.5 first 4\n")
    lmp.command("run 6000")
    assert value(lmp, "v_number") == 12
    assert abs(value(lmp, "f_step[2]")) < 1e-4
    assert value(lmp, "f_step[1]") > 4e-8


@pytest.mark.parametrize("first", [1, 4, 32])
def test_runs_may_have_any_length(lammps, first):
    lmp = lammps()
    setup(lmp, f"32 3e-6 v_given first {first}")
    at = 0
    for command, length in (
        ("run 3", 3),
        ("run 5 pre no", 5),
        ("run 1", 1),
        ("run 101 every 7 NULL", 101),
        ("run 130 upto", 20),
    ):
        lmp.command(command)
        at += length
        assert lmp.extract_global("ntimestep") == at, command
        assert value(lmp, "time") == pytest.approx(at * TICK, rel=1e-12)


def test_intervals_are_kept(lammps):
    """Output of fix print, dumps, restart files, thermodynamic output and diameters are at their
    ticks.
    """
    lmp = lammps()
    mass = 8500 * 4 / 3 * np.pi * R**3
    lmp.commands_string(
        script_of(LINE, velocities=[(0, 0, 5.0)] + [(0, 0, 0)] * 5, style=HERTZ).replace(
            "atom_style sphere", "atom_style sphere 1"
        )
        + f"\ntimestep {TICK}\ngroup last id 6\n"
        + f"variable grown equal {2 * R}*(1-step*1e-9)\n"
        + "fix grows last adapt 96 atom diameter v_grown\n"
        + 'fix words all print 70 "$(step)" file words.txt screen no title ""\n'
        + "variable next equal stride(0,100000,150)\n"
        + "dump places all custom 33 places.txt id z\ndump_modify places delay 30\n"
        + "restart 250 r.*\nthermo 90\nthermo_style custom step v_next\n"
        + f"fix step all gran/timestep 32 1e-4 {0.5 * mass * 25} first 8\n"
    )
    lmp.command("run 1000")
    lmp.command("undump places")
    words = [int(line) for line in Path("words.txt").read_text().split()]
    assert words == list(range(0, 1000, 70))
    dumped = re.findall(r"TIMESTEP\n(\d+)", Path("places.txt").read_text())
    assert [int(step) for step in dumped] == list(range(33, 1000, 33))
    assert sorted(Path.cwd().glob("r.*")) == [Path.cwd() / f"r.{n}" for n in (1000, 250, 500, 750)]
    ids = lmp.numpy.extract_atom("id")[:6]
    radius = lmp.numpy.extract_atom("radius")[:6][ids == 6][0]
    assert radius == pytest.approx(R * (1 - 960e-9), rel=1e-15)


@pytest.mark.parametrize(
    "words",
    [
        "ave/time 1 1 100 c_ke",
        "ave/histo 1 10 100 0 1 10 c_ke",
        "ave/correlate 1 10 100 c_ke",
        "ave/atom 1 10 100 vz",
        "vector 1 c_ke",
        'print 1 "a" file a.txt screen no',
        "move linear 0 0 1",
    ],
)
def test_fixes_that_count_steps_are_refused(lammps, words):
    """If every step is one tick, ticks are steps, and all fixes are allowed."""
    style = words.split()[0]
    script = script_of(LINE[:2]) + f"fix other all {words}\n"
    refused = lammps(script + "fix step all gran/timestep 32 3e-6 1.0\n")
    with pytest.raises(Exception, match=f"fix {style} other (waits for every tick|multiplies)"):
        refused.command("run 100")
    lammps(script + "fix step all gran/timestep 1 3e-6 1.0\n").command("run 100")
