"""Runs of clumps: impacts compared with closed forms of rigid bodies, energy balances, ranks,
resumed runs.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.run import driver
from granwave.workflows.run.checks import warn_of_rolling

RADIUS = 5e-3
HALF = 6e-3  # of the distance of the two spheres of the dimer
# of the dimer around its middle, over the mass of a sphere: 2 (2/5 R^2 + HALF^2)
INERTIA = 2 * (0.4 * RADIUS**2 + HALF**2)
DIMER = f"0,0,0,0.01,7,0,0,0\n{2 * HALF},0,0,0.01,7,0,0,0\n"
HEADS = "x,y,z,diameter,clump,vx,vy,vz\n"
CLUMPS = f"""{HEADS}0,0,0,0.01,7,0,0,0
0.006,0.001,0.002,0.008,7,0,0,0
0.003,0.005,0.0015,0.006,7,0,0,0
0,0.001,-0.01005,0.01,0,0.3,0,2.0
0.0138,0.003,0.004,0.007,9,-1,0,0.1
0.0198,0.003,0.001,0.007,9,-1,0,0.1
0.016,-0.003,0.0115,0.007,,0,0,0
"""


def clumps_case(rows: str, **tables: Any) -> Case:
    """Case of clumps of steel without a bottom, whose grains have velocities."""
    return case_from_dict(
        {
            "name": "clumps",
            "material": "steel",
            "packing": {"kind": "file", "grains": rows},
            "contact": {"law": "hertz"},
            "load": {"kind": "grains"},
            "boundary": {"bottom": "free"},
            "run": {"end_time": 2e-4, "frames": 3},
        }
        | tables
    )


def ran(case: Case, directory: Path, **options: Any) -> Result:
    assert driver.run_case(case, directory, figures=False, **options).state == "finished"
    return Result(directory)


def errors_of_balance(result: Result) -> np.ndarray:
    """Errors of the energy balance in time / input."""
    energy = sum(result[f"energy/{name}"] for name in ("kinetic", "elastic", "dissipated"))
    return np.abs(energy / result["energy/input"] - 1)


def test_a_dimer_struck_off_centre(tmp_path: Path) -> None:
    """An elastic impact along z on the end of a dimer: impulse J = 2 v / (1/m + 1/M + d^2/I)."""
    case = clumps_case(f"{HEADS}{DIMER}0,0,-0.01001,0.01,0,0,0,1\n")
    with ran(case, tmp_path / "run") as result:
        velocity = result.frame(2, "velocity")
        error = errors_of_balance(result).max()
        rotational = result["energy/rotational"][-1]
        mass = result["spheres/mass"][0]
        assert result["contacts/peak_force"].max() > 0
    impulse = 2 / (1 + 1 / 2 + HALF**2 / INERTIA)  # over the mass of a sphere and its velocity
    spin = HALF * impulse / INERTIA
    # the dimer turns by some milliradians until the end of the run
    turned = spin * 2e-4
    assert velocity[2] == pytest.approx([0, 0, 1 - impulse], abs=1e-5)
    assert velocity[:2].mean(axis=0) == pytest.approx([0, 0, impulse / 2], abs=1e-5)
    assert velocity[0, 2] - velocity[1, 2] == pytest.approx(2 * HALF * spin, abs=turned**2)
    assert rotational == pytest.approx(2 * 0.4 * mass * RADIUS**2 * spin**2 / 2, rel=1e-4)
    assert error < 1e-6


def test_error_of_the_balance_falls_with_the_square_of_the_timestep(tmp_path: Path) -> None:
    case = f"{HEADS}{DIMER}0.001,0.002,-0.00975,0.01,0,0,0,1\n"
    errors = []
    for timestep in (6e-8, 3e-8):
        run = {"end_time": 1e-4, "timestep": timestep, "frames": 2}
        with ran(clumps_case(case, run=run), tmp_path / f"{timestep}") as result:
            errors.append(errors_of_balance(result).max())
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


def test_a_dimer_meets_a_floor(tmp_path: Path) -> None:
    """A tilted dimer that falls on a smooth floor: the elastic impulse is along the normal only."""
    tilt = 0.4
    arm = HALF * np.cos(tilt)
    ends = [(side * arm, side * HALF * np.sin(tilt)) for side in (-1, 1)]
    rows = "".join(f"{x},0,{z},0.01,3,0.5,0,1\n" for x, z in ends)
    lowest = HALF * np.sin(tilt) + RADIUS + 1e-5
    packing = {"kind": "file", "grains": HEADS + rows, "enclosure": {"bottom": lowest}}
    case = clumps_case("", packing=packing, boundary={"bottom": "wall"})
    with ran(case, tmp_path / "run") as result:
        velocity = result.frame(2, "velocity")
        assert errors_of_balance(result).max() < 1e-6
    impulse = 2 / (1 / 2 + arm**2 / INERTIA)
    spin = arm * impulse / INERTIA
    assert velocity.mean(axis=0) == pytest.approx([0.5, 0, 1 - impulse / 2], rel=1e-3, abs=1e-6)
    turned = np.linalg.norm(velocity[1] - velocity[0]) / (2 * HALF)
    assert turned == pytest.approx(spin, rel=1e-3)


SOFT = {"youngs_modulus": 1e8, "poisson_ratio": 0.3, "density": 2500.0, "yield_strength": 1e8}
DROP = 1e-4  # m


def bed_of_trimer(friction: float, contacts: dict[str, str]) -> Case:
    """Case of a flat trimer above the floor, tilted, with a single grain above its hollow."""
    corners = np.exp(2j * np.pi * np.arange(3) / 3) * 1.1 * RADIUS * 2 / np.sqrt(3)
    heights = RADIUS + DROP * np.array([1, 2, 3])
    rows = [
        f"{at.real},{at.imag},{-height},{2 * RADIUS},5"
        for at, height in zip(corners, heights, strict=True)
    ]
    top = -heights.mean() - np.sqrt((2 * RADIUS) ** 2 - abs(corners[0]) ** 2) - DROP
    text = "\n".join(["x,y,z,diameter,clump", *rows, f"0,0,{top},{2 * RADIUS},", ""])
    packing = {"kind": "file", "grains": text, "enclosure": {"bottom": 0.0}, **contacts}
    return clumps_case(
        "",
        material=SOFT,
        packing=packing,
        contact={"law": "hertz", "friction": friction},
        boundary={"bottom": "wall", "sides": "free"},
        precompression={"kind": "gravity"},
        load={"kind": "impact", "index": 4, "velocity": 0.1},
        run={"end_time": 1e-4, "frames": 2},
    )


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_clumps_settle_under_their_weight(friction: float, tmp_path: Path) -> None:
    """A grain rests in the hollow of a trimer: N = m g / (3 cos a) without friction; the floor
    carries the total weight, a third at each grain.
    """
    damped = {"contacts": "relax", "relaxation": "damped"}
    with ran(bed_of_trimer(friction, damped), tmp_path / "run") as result:
        weight = result["spheres/mass"][3] * 9.81
        error = errors_of_balance(result).max()
    dumps = tmp_path / "run" / "dumps"
    pairs = np.loadtxt(dumps / "initial_forces.dump", skiprows=9)
    floor = np.loadtxt(dumps / "initial_forces_bottom.dump", skiprows=9)
    stage = np.loadtxt(dumps / "prestage.txt")
    assert stage[0] < 1e-6
    names = (dumps / "prestage.txt").read_text().split("\n", 1)[0].split()[1:]
    record = dict(zip(names, stage.tolist(), strict=True))
    net = record["residual"] * record["largest_force"]
    if friction:  # the trimer has the largest net force, and is compared with its own weight
        assert net == pytest.approx(3 * record["worst"] * weight, rel=1e-4)
    assert record["unbalanced"] * 4 * weight <= 2 * net * (1 + 1e-4)  # each body counts once
    assert floor[:, 1] == pytest.approx([4 / 3 * weight] * 3, rel=1e-4)
    cosine = np.sqrt(1 - (1.1 / np.sqrt(3)) ** 2)
    if not friction:
        assert pairs[:, 2] == pytest.approx([weight / 3 / cosine] * 3, rel=1e-3)
    assert len(pairs) == 3
    assert error < 1e-5


def test_net_forces_of_clumps_are_compared_with_their_weight(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Forces within a clump, far above the weight of a grain, do not count."""
    case = bed_of_trimer(0.4, {"contacts": "relax", "relaxation": "damped"})
    assembly = assemble(case)
    weight = assembly.sphere_masses()[0] * 9.81
    forces = {number: np.zeros(3) for number in range(1, 5)}
    forces[1] = np.array([50.0 * weight, 0.0, 0.0])
    forces[2] = -forces[1]
    stage = {"unbalanced": 1e-4}
    warn_of_rolling(assembly, stage, forces)
    assert caplog.text == ""
    forces[2] = forces[2] + np.array([0.0, 0.3 * weight, 0.0])
    warn_of_rolling(assembly, stage, forces)
    assert "3 of 4 grains still roll" in caplog.text
    assert "ids 1, 2, 3. Net forces are at most 0.1 of the weight of a clump" in caplog.text


def test_overlapping_clumps_with_friction_and_yielding(tmp_path: Path) -> None:
    """Momenta are conserved; the spheres of a clump keep their distances; the energy balance
    closes.
    """
    tables = {"contact": {"friction": 0.3}, "line": [{"name": "all", "index": "all"}]}
    case = clumps_case(CLUMPS, material="brass", **tables)
    with ran(case, tmp_path / "run") as result:
        mass = result["spheres/mass"]
        moved = result["lines/all/displacement"][[0, -1]]
        velocity = result["lines/all/velocity"][[0, -1]]
        spin = result["lines/all/angular_velocity"][[0, -1]]
        place = result["spheres/position"] + moved
        dissipated = result["energy/dissipated"][-1] / result["energy/input"][-1]
        error = errors_of_balance(result).max()
        contacts = zip(result["contacts/i"], result["contacts/j"], strict=True)
        pairs = {tuple(sorted(pair)) for pair in contacts}
    radius = case.packing.grains.diameter / 2
    momentum = mass @ velocity
    turning = mass @ np.cross(place, velocity) + 0.4 * mass * radius**2 @ spin
    assert dissipated > 0.1
    assert error < 3e-6
    assert momentum[1] == pytest.approx(momentum[0], rel=1e-9, abs=1e-12)
    scale = np.linalg.norm(turning[0])
    assert turning[1] == pytest.approx(turning[0], abs=1e-4 * scale)
    for one, other in ((0, 1), (0, 2), (1, 2), (4, 5)):
        apart = np.linalg.norm(place[:, one] - place[:, other], axis=1)
        assert apart[1] == pytest.approx(apart[0], rel=1e-9)
        assert (one + 1, other + 1) not in pairs


def test_a_clump_across_a_periodic_boundary(tmp_path: Path) -> None:
    """A dimer whose spheres are at opposite sides of the box responds like a dimer in the
    middle.
    """
    boundary = {"bottom": "free", "sides": "periodic"}
    ends = []
    for shift in (0.02, 0.0):
        xs = [(x + shift) % 0.05 for x in (-HALF, HALF, -HALF)]
        rows = f"{HEADS}{xs[0]},0,0,0.01,7,0,0,0\n{xs[1]},0,0,0.01,7,0,0,0\n"
        rows += f"{xs[2]},0,-0.0101,0.01,0,0,0,1\n"
        packing = {"kind": "file", "grains": rows, "period": [0.05, 0.05]}
        with ran(clumps_case("", packing=packing, boundary=boundary), tmp_path / f"{shift}") as one:
            ends.append(one.frame(2, "velocity"))
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-12)
    assert ends[0][2, 2] < 0


def short_case() -> Case:
    run = {"end_time": 2e-5, "timestep": 4e-8, "frames": 2}
    return clumps_case(CLUMPS, material="brass", contact={"friction": 0.3}, run=run)


def test_a_resumed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that was stopped and resumed equals an uninterrupted run, to rounding."""
    with ran(short_case(), tmp_path / "whole") as result:
        whole = result.frame(1, "velocity")
    looks = iter(range(100))
    with monkeypatch.context() as patched:
        patched.setattr(driver.StopRequest, "wanted", lambda _: next(looks) == 1)
        patched.setattr(driver, "_PIECE", 1e-3)
        outcome = driver.run_case(short_case(), tmp_path / "cut", figures=False)
        assert outcome.state == "interrupted"
    n_steps = json.loads((tmp_path / "cut" / "run.json").read_text())["n_steps"]
    assert 0 < n_steps < 500
    with ran(short_case(), tmp_path / "cut", resume=True) as result:
        assert result.frame(1, "velocity") == pytest.approx(whole, rel=1e-9, abs=1e-9)


@pytest.mark.validation
def test_two_ranks(granwave: Any, tmp_path: Path) -> None:
    """Two ranks give the results of one, to rounding."""
    (tmp_path / "case.toml").write_text(short_case().to_toml())
    ends = []
    for ranks in (1, 2):
        out = tmp_path / str(ranks)
        words = ("run", tmp_path / "case.toml", "-o", out, "--no-figures", "--np", ranks)
        done = granwave(*words)
        assert done.returncode == 0, done.stderr
        with Result(out) as result:
            ends.append(result.frame(1, "velocity"))
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("relaxation", ["damped", "minimiser"])
@pytest.mark.parametrize("clump", [True, False])
def test_grains_that_touch_walls_alone(clump: bool, relaxation: str, tmp_path: Path) -> None:
    """Three separate grains on the floor, two of them a clump or single: the floor carries each
    grain.
    """
    if clump and relaxation == "minimiser":
        pytest.skip("clumps come to balance by damped motion alone")
    member = 1 if clump else ""
    distance = 1.5 if clump else 3
    places = {0.0: member, distance * RADIUS: member, 9 * RADIUS: ""}
    rows = [f"{x},0,{-0.9999 * RADIUS},{2 * RADIUS},{of}" for x, of in places.items()]
    packing = {
        "kind": "file",
        "grains": "\n".join(["x,y,z,diameter,clump", *rows, ""]),
        "enclosure": {"bottom": 0.0},
        "contacts": "relax",
        "relaxation": relaxation,
    }
    case = clumps_case(
        "",
        material=SOFT,
        packing=packing,
        contact={"law": "hertz", "friction": 0.3 if relaxation == "damped" else 0.0},
        boundary={"bottom": "wall", "sides": "free"},
        precompression={"kind": "gravity"},
        load={"kind": "impact", "index": 3, "velocity": 0.01},
        run={"end_time": 1e-4, "frames": 2},
    )
    with ran(case, tmp_path / "run") as result:
        weight = result["spheres/mass"][2] * 9.81
        error = errors_of_balance(result).max()
    dumps = tmp_path / "run" / "dumps"
    floor = np.loadtxt(dumps / "initial_forces_bottom.dump", skiprows=9)
    names, values = (dumps / "prestage.txt").read_text().splitlines()
    stage = dict(zip(names.removeprefix("# ").split(), map(float, values.split()), strict=True))
    assert floor[:, 1] == pytest.approx([weight] * 3, rel=1e-5)
    assert stage["largest_force"] == pytest.approx(weight, rel=1e-5)
    assert stage["residual"] < 1e-6
    assert error < 1e-5
