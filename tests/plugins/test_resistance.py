"""Resistance to rolling and twisting: closed forms, LAMMPS's own style, energy, processors."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.rubbing import HERTZ, LAMMPS_OWN, MU, NU, TOTAL, E, R, oblique, packing, rubbing, state
from tests.helpers.two_spheres import value

SOFT, MASS, ACCELERATION = 1e9, 8500 * 4 / 3 * np.pi * R**3, 1e4
WEIGHT = MASS * ACCELERATION
SDS = "rolling sds 2e6 3.0 0.05 twisting sds 4.0 1e-5 2e-5"
ALL = f"{HERTZ} friction {MU} rolling sds mindlin 1.0 0.05 twisting marshall"
WHOLE = TOTAL + "+c_en[9]+c_en[10]+c_en[11]+c_en[12]"


def pressed(lmp, law: str, velocity: float, spin: tuple[float, float, float], extra: str = "") -> float:
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
    """It rolls 7 v^2 m/(10 mu_r N): torque mu_r R N, inertia 7/5 m R^2 about the contact; its energy is that of rolling."""
    lmp, speed, mu = lammps(), 0.5, 0.1
    pressed(lmp, f"friction 0.5 rolling sds 2e7 0 {mu}", speed, (0, -speed / R, 0))
    before = value(lmp, "c_ke+c_turn")
    lmp.command("run 5500")
    expected = 0.7 * speed**2 * MASS / (mu * WEIGHT)
    assert lmp.numpy.extract_atom("x")[0, 0] == pytest.approx(expected, rel=0.02)
    assert value(lmp, "f_floor[18]") == pytest.approx(before, rel=0.02)
    assert value(lmp, "c_ke+c_turn+f_floor[8]+f_floor[9]+f_floor[17]+f_floor[18]") == pytest.approx(before, rel=1e-4)
    assert value(lmp, "f_floor[19]+f_floor[20]") == 0.0


@pytest.mark.parametrize("length", [None, 2e-5])
def test_a_twisting_sphere_stops(lammps, length):
    """Its spin ends after I w/M: M = (2/3) mu a N, or a length times N."""
    lmp, spin, mu = lammps(), 30.0 if length else 1000.0, 0.3
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
    """Same constants, same change of the spins, in an oblique impact of spinning spheres. Sliding alone differs by 1.6 %."""
    spins = [(100.0, 300.0, 400.0), (0.0, -50.0, 20.0)]
    own = LAMMPS_OWN.format(E=E, nu=NU, model="mindlin_rescale", mu=MU)
    changes = []
    for options in (
        ({"own": own}, {"own": own.replace(" damping", f" {words} damping")}),
        ({}, {"law": f"{HERTZ} friction {MU} {words}"}),
    ):
        without, there = (state(oblique(lammps, 0.5, spins=spins, **one), "omega")["omega"] for one in options)
        changes.append(there - without)
    assert np.abs(changes[1] - changes[0]).max() < 1e-3 * np.abs(changes[0]).max()


@pytest.mark.parametrize("law", [ALL, f"{HERTZ} rolling sds mindlin 0.0 0.1", f"{HERTZ} friction {MU} {SDS}",
                                 ALL.replace(HERTZ, f"elastoplastic {E} {NU} 550e6")])  # fmt: skip
def test_balance_and_passivity_in_a_packing(lammps, law):
    """Random motions: kinetic, stored and lost energy keep their sum, and each loss grows."""
    places, speeds, spins = packing(2)
    lmp = lammps(rubbing(places, law, velocities=speeds, spins=spins))
    lmp.command("run 0 post no")
    start = value(lmp, WHOLE)
    lost = np.zeros(3)
    for _ in range(6):
        lmp.command("run 500 post no")
        now = np.array([value(lmp, f"c_en[{n}]") for n in (7, 10, 12)])
        assert np.all(now >= lost - 1e-9 * start)
        lost = now
    assert value(lmp, WHOLE) == pytest.approx(start, rel=2e-5)
    assert lost[1] > 1e-6 * start
    assert ("twisting" in law) == (lost[2] > 0)


def test_processors(lmp, tmp_path):
    """The same bits on one and on three processors."""
    places, speeds, spins = packing(2)
    text = rubbing(places, ALL, velocities=speeds, spins=spins)
    end = "dump end all custom 1000 out id x y z omegax omegay omegaz\ndump_modify end sort id format float %.17g\nrun 1000\n"
    found = []
    for ranks in (1, 3):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        (folder / "in").write_text(text + end)
        done = lmp(folder / "in", ranks=ranks)
        assert done.returncode == 0, (folder / "log.lammps").read_text()[-500:]
        found.append((folder / "out").read_text())
    assert found[0] == found[1]
