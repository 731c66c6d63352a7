"""Command gran/dents: initial indentations (dents) from a file or from an earlier stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.conftest import script_of
from tests.helpers.bodies.rubbing import BRASS, rubbing
from tests.helpers.bodies.two_spheres import LAW, PAIR, R, restitution, value

MASS = 8500 * 4 / 3 * np.pi * R**3
REPORTS = """compute one all gran/hysteretic/contact 1 2
compute dents all gran/hysteretic/local
compute grains all gran/hysteretic/atom
compute en all gran/hysteretic/energy
thermo_style custom step c_ke c_en c_en[*] c_one[1]
"""
# styles and types of LAMMPS's library
_LOCAL = 2
_ARRAY = 2
_ROWS = 4


def start(lmp, speed=2.0, extra="", **options) -> None:
    """Input script of two touching spheres that are about to collide head-on."""
    velocities = [(0, 0, speed / 2), (0, 0, -speed / 2)]
    lmp.commands_string(script_of(PAIR, velocities=velocities, extra=REPORTS + extra, **options))


def meeting_in(dent: float) -> str:
    """Command that places the second sphere where it just touches the first with a dent between
    them.
    """
    return f"set atom 2 z {2 * R - LAW.residual_overlap(dent):.17g}"


def reading(directory: Path, text: str) -> str:
    """Command that reads these lines of dents from a file."""
    path = directory / "dents.txt"
    path.write_text(text, encoding="utf-8")
    return f"gran/dents read {path}"


def table(lmp) -> np.ndarray:
    """Values of ``compute gran/hysteretic/local``: (n_contacts, 16)."""
    if not lmp.extract_compute(
        "dents", _LOCAL, _ROWS
    ):  # for LAMMPS 29 Aug 2024, which fails at an array without rows
        return np.empty((0, 16))
    return lmp.numpy.extract_compute("dents", _LOCAL, _ARRAY).copy()


@pytest.mark.parametrize("ids", ["1 2", "2 1"])
def test_a_deep_dent_makes_a_collision_elastic(lammps, tmp_path, ids):
    """The first collision, with the dent of a harder one, follows the unloading branch of the dent."""
    dent = 80 * LAW.yield_overlap
    lmp = lammps()
    start(
        lmp,
        speed=0.5,
        extra=reading(tmp_path, f"# id id peak\n\n{ids} {dent:.17g}   # of an earlier run\n"),
    )
    assert value(lmp, "c_en[1]") == 0 and value(lmp, "c_en[5]") == 0
    lmp.commands_string(f"{meeting_in(dent)}\nrun 20000")
    assert restitution(lmp, 0.5) == pytest.approx(1.0, abs=1e-6)
    row = table(lmp)[0]
    assert row[4] == row[15] == dent
    assert value(lmp, "c_en[1]") == value(lmp, "c_en[2]") == row[7] == 0
    assert row[10] == -1 and 0 <= row[8] < row[9]
    # the largest force of the run is that at which the kinetic energy is stored, far below that of
    # the dent
    overlaps = np.linspace(LAW.residual_overlap(dent), dent, 20001)
    stored = LAW.elastic_energy(overlaps, np.full_like(overlaps, dent))
    reached = np.interp(0.25 * MASS * 0.25, stored, overlaps)
    assert (
        row[5]
        == pytest.approx(LAW.force(reached, dent), rel=1e-3)
        == pytest.approx(value(lmp, "c_en[5]"), rel=1e-3)
    )
    assert row[5] < 0.5 * LAW.loading_force(dent)
    assert value(lmp, "c_ke") == pytest.approx(0.25 * MASS * 0.25, rel=1e-6)


def test_what_is_lost_beyond_a_dent(lammps, tmp_path):
    """A collision beyond the initial dent dissipates e(peak) - e(initial), and energy is balanced."""
    dent = 20 * LAW.yield_overlap
    lmp = lammps()
    start(
        lmp,
        speed=4.0,
        extra=f"{reading(tmp_path, f'1 2 {dent:.17g}')}\n{meeting_in(dent)}\nrun 20000",
    )
    row = table(lmp)[0]
    assert row[4] > 1.2 * dent and row[15] == dent
    assert row[7] == pytest.approx(
        LAW.dissipated_energy(row[4]) - LAW.dissipated_energy(dent), rel=1e-12
    )
    assert value(lmp, "c_en[1]") == pytest.approx(row[7], rel=1e-12) and value(lmp, "c_en[2]") == 1
    assert row[5] == pytest.approx(LAW.loading_force(row[4]), rel=1e-12)
    assert 0 <= row[8] < row[10] <= row[9]
    assert value(lmp, "c_ke+c_en+c_en[1]") == pytest.approx(0.25 * MASS * 16, rel=1e-6)
    grains = lmp.numpy.extract_compute("grains", 1, 2)[:2]
    assert grains[:, 3].sum() == pytest.approx(row[7], rel=1e-12) and grains[:, 4].tolist() == [
        1,
        1,
    ]


def test_begin_makes_the_past_of_a_collision(lammps):
    """Command `begin` after a collision: its dent becomes initial, its loss is removed, the next
    collision is elastic.
    """
    lmp = lammps()
    start(lmp)
    lmp.command("run 20000")
    dent = table(lmp)[0, 4]
    speed = value(lmp, "vz[2]-vz[1]")
    assert value(lmp, "c_en[1]") > 0
    lmp.command("gran/dents begin")
    row = table(lmp)[0]
    assert (
        row[4] == row[15] == dent and row[5] == row[7] == 0 and row[8:11].tolist() == [-1, -1, -1]
    )
    assert value(lmp, "c_en[1]") == value(lmp, "c_en[2]") == value(lmp, "c_en[5]") == 0
    lmp.commands_string(f"set atom 1 vz {speed / 2}\nset atom 2 vz {-speed / 2}\nrun 30000")
    assert value(lmp, "vz[2]-vz[1]") == pytest.approx(speed, rel=1e-6)
    row = table(lmp)[0]
    assert row[7] == 0 and row[4] == dent and row[5] > 0 and row[8] > 20000 * 1e-8 and row[10] == -1
    lmp.commands_string(f"set atom 1 vz {speed}\nset atom 2 vz {-speed}\nrun 30000")
    assert value(lmp, "c_en[1]") == pytest.approx(
        LAW.dissipated_energy(table(lmp)[0, 4]) - LAW.dissipated_energy(dent)
    )


@pytest.mark.parametrize("steps", [300, 20000])
def test_begin_forgets_what_was_elastic(lammps, steps):
    """Contacts below the elastic limit keep only their present overlap after `begin`; forgotten
    dents are discarded.
    """
    lmp = lammps()
    start(lmp, speed=0.02)
    lmp.command(f"run {steps}")
    overlap = value(lmp, "c_one[1]")
    peak = value(lmp, "c_one[3]")
    assert 0 < peak < LAW.yield_overlap and (overlap > 0) == (steps == 300)
    lmp.commands_string("gran/dents begin\nrun 0")
    assert value(lmp, "c_one[3]") == (overlap if overlap > 0 else 0.0)
    if overlap > 0:
        assert table(lmp)[0, 15] == 0 and table(lmp)[0, 5] == pytest.approx(
            LAW.loading_force(overlap), rel=1e-12
        )
    else:
        assert len(table(lmp)) == 0


@pytest.mark.parametrize("way", ["sum", "list"])
def test_begin_drops_forgotten_dents(lammps, way):
    lmp = lammps()
    start(lmp, gap=f"2e-5 forgotten {way}")
    lmp.command("run 26000")
    assert len(table(lmp)) == (way == "list") and value(lmp, "c_en[1]") > 0
    lmp.command("gran/dents begin")
    assert len(table(lmp)) == 0 and value(lmp, "c_en[1]") == 0


def test_begin_starts_frictional_losses_anew_and_keeps_the_springs(lammps):
    lmp = lammps()
    extra = "compute one all gran/hysteretic/contact 1 2"
    lmp.commands_string(
        rubbing(
            PAIR, "hertz 115e9 0.3 friction 0.3", velocities=[(1, 0, 1), (0, 0, 0)], extra=extra
        )
    )
    lmp.command("run 1500")
    held = value(lmp, "c_one[6]")
    lost = value(lmp, "c_one[7]")
    assert held > 0 and lost > 0
    lmp.commands_string("gran/dents begin\nrun 0")
    assert value(lmp, "c_one[6]") == held and value(lmp, "c_one[7]") == 0


def test_relaxed_under_pressure_then_begun(lammps):
    """A run from the equilibrium of a chain compressed between walls by FIRE has no motion and no
    dissipation.
    """
    lmp = lammps()
    n = 6
    squeeze = 2e-6
    places = [(0, 0, 2 * R * k) for k in range(n)]
    walls = f"fix ends all wall/gran/hysteretic zplane {-R + squeeze:.17g} {(2 * n - 1) * R - squeeze:.17g} elastoplastic 115e9 0.3 550e6"
    lmp.commands_string(
        script_of(
            places,
            extra=f"{walls}\ncompute dents all gran/hysteretic/local\ncompute en all gran/hysteretic/energy",
        )
    )
    lmp.commands_string(
        "thermo_style custom step pe c_en c_en[*] fnorm\nmin_style fire\nminimize 0 1e-9 20000 100000"
    )
    forces = table(lmp)[:, 3]
    assert len(forces) == n - 1 and forces == pytest.approx(np.full(n - 1, forces.mean()), rel=1e-6)
    stored = value(lmp, "c_en")
    assert stored > 0 and value(lmp, "fnorm") < 1e-6 * forces.mean()
    lmp.commands_string("gran/dents begin\nvelocity all set 0 0 0\nrun 0")
    assert value(lmp, "c_en") == pytest.approx(stored, rel=1e-12) and value(lmp, "c_en[1]") == 0
    lmp.command("run 1000")
    assert value(lmp, "c_ke") < 1e-9 * stored
    rows = table(lmp)
    assert rows[:, 5] == pytest.approx(forces[np.argsort(rows[:, 0])], rel=1e-6)
    assert value(lmp, "c_en[5]") == pytest.approx(forces.mean(), rel=1e-6)


# ---------------------------------------------------------------------- minimization

ALSO = {
    "nothing else": "",
    "new lists at every step": "neigh_modify every 1 delay 0 check no\n",
    "dents in memory": "gran/dents begin\n",
}


def push_of(force: float) -> str:
    return f"fix push top addforce 0 0 {-force}\n"


def pressed(law: str = BRASS, extra: str = "") -> str:
    """Chain of six spheres on a floor, the last of which is pushed down with 50 N."""
    places = [(0, 0, 2 * R * k) for k in range(6)]
    floor = f"fix floor all wall/gran/hysteretic zplane {-R:.17g} NULL {law}\n"
    push = f"group top id 6\n{push_of(50)}"
    dents = "compute dents all gran/hysteretic/local\ncompute en all gran/hysteretic/energy\n"
    output = "thermo_style custom step pe c_en c_en[*] fnorm\nmin_style fire\n"
    return script_of(places, style=law, extra=f"{floor}{push}{dents}{extra}{output}")


def overlap_of(force: float) -> float:
    return brentq(lambda x: LAW.loading_force(x) - force, 0, 0.1 * R, xtol=1e-18)


def wall_column(lmp, number: int) -> float:
    ids = lmp.numpy.extract_atom("id")[:6]
    return lmp.numpy.extract_fix("floor", 1, 2)[:6][ids == 1][0, number]


@pytest.mark.parametrize("style", ["fire", "quickmin"])
@pytest.mark.parametrize("also", ALSO)
def test_a_minimization_leaves_the_dents_of_its_end(lammps, style, also):
    """Far beyond yield every contact has the overlap at which loading gives the force on the chain;
    intermediate positions with larger overlaps leave no dents.
    """
    lmp = lammps(pressed(extra=ALSO[also]) + f"min_style {style}\n")
    least = "minimize 0 1e-9 100000 200000"
    lmp.command(least)
    for _ in range(2):
        rows = table(lmp)
        assert rows[:, 3] == pytest.approx(np.full(5, 50.0), rel=1e-9)
        assert rows[:, 2] == pytest.approx(np.full(5, overlap_of(50.0)), rel=1e-9)
        assert np.array_equal(rows[:, 4], rows[:, 2])
        assert wall_column(lmp, 1) == pytest.approx(50.0, rel=1e-9)
        assert wall_column(lmp, 2) == wall_column(lmp, 0)
        lmp.command(least)
    assert value(lmp, "c_en[2]") == 5


def test_a_minimization_unloads_from_dents_and_comes_back_to_them(lammps):
    """Dents of a larger load are unchanged at equilibrium under a smaller load, and when the larger
    load acts again.
    """
    lmp = lammps(pressed())
    least = "minimize 0 1e-9 100000 200000"
    lmp.command(least)
    peaks = table(lmp)[:, 4]
    lost = value(lmp, "c_en[1]")
    on_wall = wall_column(lmp, 2)
    lmp.commands_string(f"{push_of(20)}{least}")
    rows = table(lmp)
    assert rows[:, 3] == pytest.approx(np.full(5, 20.0), rel=1e-9)
    assert np.array_equal(rows[:, 4], peaks)
    assert (rows[:, 2] < peaks).all()
    assert (rows[:, 2] > overlap_of(20.0)).all()
    assert wall_column(lmp, 2) == on_wall > wall_column(lmp, 0)
    assert value(lmp, "c_en[1]") == lost > 0
    lmp.commands_string(f"{push_of(50)}{least}")
    rows = table(lmp)
    assert rows[:, 4] == pytest.approx(peaks, rel=1e-9)
    assert rows[:, 2] == pytest.approx(peaks, rel=1e-9)
    assert value(lmp, "c_en[1]") == pytest.approx(lost, rel=1e-8)


def test_clear_forgets_dents(lammps):
    """Every contact loads like a new contact, from the present overlap."""
    lmp = lammps(pressed())
    least = "minimize 0 1e-9 100000 200000"
    lmp.commands_string(f"{least}\n{push_of(20)}{least}")
    overlap = table(lmp)[:, 2]
    on_wall = wall_column(lmp, 0)
    assert (table(lmp)[:, 4] > overlap).all()
    lmp.commands_string("gran/dents clear\nrun 0")
    rows = table(lmp)
    assert rows[:, 2] == pytest.approx(overlap, rel=1e-12)
    assert np.array_equal(rows[:, 4], rows[:, 2])
    assert rows[:, 3] == pytest.approx(LAW.loading_force(overlap), rel=1e-9)
    assert (rows[:, 15] == 0).all()
    assert wall_column(lmp, 2) == wall_column(lmp, 0) == pytest.approx(on_wall, rel=1e-12)
