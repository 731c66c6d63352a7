"""Examples for LAMMPS, `plugins/examples`: each runs with plain ``lmp`` and gives the number on its
page.
"""

from __future__ import annotations

import importlib.util
import re
import shutil
from collections import defaultdict

import numpy as np
import pytest

import granwave as gw
from tests.helpers.manual import PAGES, Log

ROOT = PAGES.parents[1]
SCRIPTS = ROOT / "plugins" / "examples"
SITE = ROOT / "docs" / "lammps"
NAMES = sorted(path.name.removeprefix("in.") for path in SCRIPTS.glob("in.*"))
_specification = importlib.util.spec_from_file_location(
    "lammps_figures", ROOT / "docs" / "_ext" / "lammps_figures.py"
)
figures = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(figures)


def variants(**short: object) -> pytest.MarkDecorator:
    """Run a test with these variables, and, as a validation, with those of the script."""
    options = tuple(str(word) for name, value in short.items() for word in ("-var", name, value))
    return pytest.mark.parametrize(
        "options",
        [
            pytest.param(options, id="short"),
            pytest.param((), id="whole", marks=pytest.mark.validation),
        ],
    )


@pytest.fixture
def example(lmp, tmp_path):
    """Run an example in the folder of the test."""

    def run(name: str, *options: str, ranks: int = 1) -> Log:
        shutil.copytree(SCRIPTS, tmp_path, dirs_exist_ok=True)
        done = lmp(tmp_path / f"in.{name}", *options, ranks=ranks)
        log = tmp_path / "log.lammps"
        assert done.returncode == 0, (
            done.stdout + done.stderr + log.read_text(encoding="utf-8")[-1000:]
        )
        log = Log(log)
        assert "WARNING" not in log.text.replace(
            "WARNING: Restart file used different # of processors", ""
        )
        return log

    return run


def test_every_script_has_its_page_and_figure():
    assert set(NAMES) == set(figures.FIGURES)
    digests = dict(line.split() for line in figures.DIGESTS.read_text().splitlines())
    stale = [name for name in NAMES if digests.get(name) != figures.digest(name)]
    assert not stale, (
        f"figures of earlier scripts: run .venv/bin/python docs/_ext/lammps_figures.py {' '.join(stale)}"
    )
    listed = (SITE / "index.md").read_text(encoding="utf-8")
    for name in NAMES:
        page = (SITE / f"{name}.md").read_text(encoding="utf-8")
        assert (
            f"{{literalinclude}} ../../plugins/examples/in.{name}\n" in page
            and f"{name}.webp" in page
        )
        assert re.search(rf"^{name}$", listed, re.MULTILINE) and f"({name}.md)" in listed
        assert "plugin" not in (SCRIPTS / f"in.{name}").read_text(
            encoding="utf-8"
        )  # loading is not the script's matter


def volume_between(spheres: dict[str, np.ndarray], low: float, high: float) -> float:
    """Volume of the parts of spheres between two heights, m3."""

    def below(height: float) -> np.ndarray:
        t = np.clip((height - spheres["z"]) / spheres["radius"], -1, 1)
        return np.pi * spheres["radius"] ** 3 * (2 / 3 + t - t**3 / 3)

    return float((below(high) - below(low)).sum())


@variants(n=60, wide=0.02, steps=40000)
def test_pour(example, tmp_path, options):
    """Walls carry the weight, the energy balance closes, and the packing is between loose and
    dense.
    """
    log = example("pour", *options)
    assert log.runs[1]["Atoms"][0] == (60 if options else 200)
    assert abs(log.printed("change of the account since all were in, of what was lost")) < 1e-4
    assert log.printed("carried by the walls over weight") == pytest.approx(
        1.0, abs=2e-3 if options else 2e-5
    )
    (end,) = figures.frames(tmp_path / "pour.dump")
    across = 2 * np.abs(end["x"]).max() + 0.01  # walls, to the overlap of spheres with them
    fraction = volume_between(end, 0.005, 0.03) / (0.025 * across**2)
    assert 0.45 < fraction < 0.60  # walls loosen what is 4 or 6 spheres wide; 0.55 to 0.64 without


def test_restitution(example, tmp_path):
    log = example("restitution")
    speed, e, theory = np.loadtxt(tmp_path / "restitution.txt").T
    assert len(speed) == 12 and e == pytest.approx(theory, rel=1e-5)
    yields = log.printed("speed of first yield, m/s")
    assert np.all((theory < 1) == (speed > yields)) and theory[-1] < 0.2


def test_chain(example):
    log = example("chain")
    speed = log.printed("speed of the wave, m/s")
    force = log.printed("largest force, N")
    nesterenko = 0.6802 * (2 * 210e9 / (0.01 * 7800**1.5 * 0.91)) ** (1 / 3) * force ** (1 / 6)
    assert speed == pytest.approx(gw.theory.discrete_speed() * nesterenko, rel=1e-3)
    assert log.printed("momentum over that given") == pytest.approx(1.0, abs=1e-12)
    assert np.abs(log.runs[0]["v_balance"]).max() < 1e-6


@variants(cells=3, steps=10000)
def test_block(example, tmp_path, options):
    """The impulse of the floor equals the missing momentum, and the forces have the four-fold
    symmetry of the block.
    """
    log = example("block", *options)
    assert np.abs(log.runs[0]["v_balance"]).max() < 1e-7
    step, _, floor = np.loadtxt(tmp_path / "block.txt").T
    given = log.printed("momentum at first, kg m/s")
    now = log.printed("momentum now, kg m/s")
    assert -floor[1:].sum() * (step[1] - step[0]) * 2e-8 == pytest.approx(
        now - given, rel=1e-4 if options else 1e-10
    )  # it pushes at the end of the short run
    assert now - given > -0.05 * given
    (end,) = figures.frames(tmp_path / "block.dump")
    below = end["type"] == 1
    centre = [float(end[axis][~below][0]) for axis in "xy"]
    orbits = defaultdict(list)
    for x, y, z, force in np.c_[end["x"], end["y"], end["z"], end["c_sphere[2]"]][below]:
        first, second = sorted((round(1e4 * abs(x - centre[0])), round(1e4 * abs(y - centre[1]))))
        orbits[first, second, round(1e4 * z)].append(force)
    assert len(orbits) > 20
    assert max(np.ptp(forces) for forces in orbits.values()) < 1e-6 * end["c_sphere[2]"].max()


@variants(target=6e6, steps=2500)
def test_crystal(example, tmp_path, options):
    """The pressure agrees with twelve contacts per sphere, the force with the law, and the area of
    the loop with the dissipation.
    """
    log = example("crystal", *options)
    _, spacing, volume, pressure, overlap, peak, force, stored, lost = np.loadtxt(
        tmp_path / "crystal.txt"
    ).T
    assert pressure == pytest.approx(2 * np.sqrt(2) * force / spacing**2, rel=1e-9, abs=1e-3)
    ball = {"shape": "sphere", "diameter": 0.01, "material": {"youngs_modulus": 115e9, "poisson_ratio": 0.3, "yield_strength": 550e6, "density": 8500.0}}  # fmt: skip
    law = gw.contact_force(
        "elastoplastic", [ball, ball], np.maximum(overlap, 0), peak_overlap=np.maximum(peak, 0)
    )
    assert force == pytest.approx(law, rel=1e-6, abs=1e-3 * force.max())
    work = -np.cumsum((pressure[1:] + pressure[:-1]) / 2 * np.diff(volume))
    assert work == pytest.approx((stored + lost)[1:], abs=2e-3 * work.max())
    assert (
        abs(log.printed("lost in the second cycle, of the first")) < 1e-9
        and lost[-1] > 0.5 * work[-1]
    )


def test_rolling(example):
    log = example("rolling")
    for resist in ("0", "0.02"):
        words = f"resistance {resist}: "
        speed, formula = (
            log.printed(words + what) for what in ("speed at the end, m/s", "of the formula, m/s")
        )
        assert speed == pytest.approx(formula, rel=1e-3)
        assert abs(log.printed(words + "change of the account, of the energy given")) < 1e-8
    assert log.printed("resistance 0: speed at the end, m/s") == pytest.approx(5 / 7, rel=1e-3)


@variants(n=100, steps=40000)
def test_contacts(example, tmp_path, options):
    """Listed forces, wall forces and weight balance on every sphere."""
    log = example("contacts", *options)
    spheres, contacts = (
        figures.frames(tmp_path / f"{name}.dump")[0] for name in ("spheres", "contacts")
    )
    place = np.c_[spheres["x"], spheres["y"]]
    i, j = (contacts[f"c_contact[{n}]"].astype(int) - 1 for n in (1, 2))
    normal = (place[i] - place[j]) / np.linalg.norm(place[i] - place[j], axis=1)[:, None]
    force = (
        contacts["c_contact[4]"][:, None] * normal
        + np.c_[contacts["c_contact[18]"], contacts["c_contact[19]"]]
    )
    total = np.zeros_like(place)
    np.add.at(total, i, force)
    np.add.at(total, j, -force)
    free = (spheres["f_floor[2]"] == 0) & (spheres["f_sides[2]"] == 0)
    weight = 9.81 * spheres["mass"]
    total[:, 1] -= weight
    tolerance = 0.02 if options else 1e-3
    assert free.sum() > 0.5 * len(free)
    assert np.abs(total[free]).max() < tolerance * weight.max()
    # the floor pushes straight up, but for friction
    on_floor = (spheres["f_floor[2]"] > 0) & (spheres["f_sides[2]"] == 0)
    assert total[on_floor, 1] == pytest.approx(
        -spheres["f_floor[2]"][on_floor], abs=tolerance * weight.max()
    )
    assert log.printed("carried by floor and sides over weight") == pytest.approx(
        1.0, abs=tolerance / 10
    )


@variants(steps=9000)
def test_restart(example, tmp_path, options):
    """A run that was interrupted, on two ranks and then one, is bitwise identical to an
    uninterrupted run.
    """
    log = example("restart", "-var", "part", "whole", *options)
    account = np.concatenate([run["v_account"] for run in log.runs])
    assert account == pytest.approx(account[0], rel=1e-6)
    assert log.runs[-1]["c_now[1]"][-1] > (0.01 if options else 0.2) * account[0]
    example("restart", "-var", "part", "first", *options, ranks=2)
    example("restart", "-var", "part", "second", *options)
    assert (tmp_path / "second.dump").read_bytes() == (tmp_path / "whole.dump").read_bytes()


def test_clumps(example, tmp_path):
    """Momentum and energy are conserved, except for the energy that LAMMPS's own style stores while
    two clumps touch.
    """
    log = example("clumps")
    assert log.printed("momentum over that of the clumps") == pytest.approx(1.0, abs=1e-12)
    balance = log.runs[0]["v_balance"]
    assert abs(balance[-1]) < 1e-6 and np.abs(balance).max() < 0.2
    energies = np.loadtxt(tmp_path / "clumps.txt")[:, 1:].sum(axis=1)
    given = energies[0]
    assert np.all(energies < (1 + 1e-6) * given) and energies.min() < 0.99 * given


def test_timestep(example):
    log = example("timestep")
    steps, error, lost = (
        {way: log.printed(f"{way}: {words}") for way in ("fixed", "adaptive")}
        for words in ("steps", "error of the balance", "lost by yielding, J")
    )
    assert steps["adaptive"] < steps["fixed"] / 8
    assert abs(error["fixed"]) < 1e-8 and abs(error["adaptive"]) < 1e-6
    assert np.abs(log.runs[1]["v_balance"]).max() < 1e-6
    assert lost["adaptive"] == pytest.approx(lost["fixed"], rel=1e-5)


@variants(layers=2, steps=16000)
def test_chute(example, options):
    """The energy of the fall equals kinetic plus dissipated energy; in steady flow the floor
    carries weight and shear.
    """
    log = example("chute", *options)
    account = np.concatenate([run["v_account"] for run in log.runs])
    lost = log.runs[-1]["v_lost"][-1]
    assert account == pytest.approx(account[0], abs=(0.01 if options else 0.002) * lost)
    tolerance = 0.15 if options else 0.02
    assert log.printed("normal force over weight") == pytest.approx(1.0, abs=tolerance)
    if not options:
        assert log.printed(
            r"shear over normal force on the floor, of tan\(angle\)"
        ) == pytest.approx(1.0, abs=0.03)
