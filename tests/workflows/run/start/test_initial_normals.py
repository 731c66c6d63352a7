"""Contact forces that keep their initial directions: a second solver, ranks, stops, rejected
input.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_case
from granwave.workflows.run.driver import run_case
from tests.conftest import refuses, script_of
from tests.helpers.made_up.small_cases import case_of

TABLE = Path(__file__).parents[4] / "reproductions/thesis/chapter_5/second_solver.csv"
FIXED = {
    "contact.normals": "initial",
    "packing.size": [12, 12, 8],
    "boundary.bottom": "free",
    "run.end_time": 2e-4,
}
START = "fix initial all property/atom d2_initial 3 ghost yes\n"
PLACES = START + "".join(
    f"variable p{axis} atom {axis}\nset group all d2_initial[{column}] v_p{axis}\n"
    for column, axis in enumerate("xyz", start=1)
)
FORGOTTEN = "pair_style gran/hysteretic 0.001"


@pytest.mark.parametrize("velocity", [40, 5])
def test_second_solver(velocity: float, tmp_path: Path) -> None:
    """Compare with the network that keeps the initial directions; true directions change the
    dissipated fraction by 1.4e-3 at 40 m/s.
    """
    with TABLE.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["packing"] == "small"]
    (row,) = (
        row
        for row in rows
        if float(row["velocity_m_s"]) == velocity and row["normals"] == "of the start"
    )
    case = load_case("fcc-small", FIXED | {"load.velocity": velocity})
    summary = run_case(case, tmp_path / "run", figures=False).summary
    assert summary["energy_balance_error"] < 1e-5
    assert summary["dissipated_fraction"] == pytest.approx(
        float(row["dissipated_fraction"]), abs=5e-6
    )
    assert summary["n_plastic_contacts"] == int(row["yielded_contacts"])


def test_a_chain_has_the_same_directions_anyway(tmp_path: Path) -> None:
    peaks = []
    for normals in ("initial", "current"):
        case = case_of(10, load={"velocity": 1.0}, contact={"law": "hertz", "normals": normals})
        run_case(case, tmp_path / normals, figures=False)
        with Result(tmp_path / normals) as result:
            peaks.append(result.along_chain("peak_force"))
    np.testing.assert_allclose(*peaks, rtol=1e-9)


@pytest.mark.validation
def test_ranks(granwave, tmp_path: Path) -> None:
    """The same bits on two ranks; after a stop: tests/workflows/cli/test_resume.py."""
    sets = [
        "--set", "contact.normals=initial", "--set", "packing.size=[4,4,4]",
        "--set", "load.velocity=30", "--set", "run.end_time=6e-5",
    ]  # fmt: skip
    for name, more in (("one", []), ("two", ["--np", "2"])):
        done = granwave("run", "fcc-small", *sets, "--no-figures", "-o", name, *more, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    with Result(tmp_path / "one") as one, Result(tmp_path / "two") as two:
        np.testing.assert_array_equal(one["contacts/peak_force"], two["contacts/peak_force"])
        np.testing.assert_array_equal(
            one["contacts/dissipated_energy"], two["contacts/dissipated_energy"]
        )


@pytest.mark.parametrize(("sets", "words"), [
    ({"contact.friction": 0.1}, "with friction"),
    ({"boundary.sides": "periodic"}, "with periodic sides"),
    ({"contact.cohesion": {"kind": "dmt", "energy": 0.1}}, "with cohesion"),
])  # fmt: skip
def test_what_turns_or_comes_back_is_refused(sets: dict, words: str) -> None:
    with pytest.raises(InputError, match=f'contact.normals: found "initial" {words}'):
        load_case("fcc-small", {"contact.normals": "initial"} | sets)


def test_cylinders_are_refused() -> None:
    with pytest.raises(InputError, match='found "initial" with cylinders'):
        load_case("filter-row-touching", {"contact.normals": "initial"})


def two_spheres(setup: str, normals: str = " normals initial", **more) -> str:
    """Script of two spheres that collide off-centre and slide past each other."""
    velocities = [(0, 0, 1.0), (0.5, 0, -1.0)]
    script = script_of([(0, 0, 0), (0, 0, 0.01)], velocities=velocities, **more)
    return script.replace(FORGOTTEN, f"{setup}{FORGOTTEN}{normals}")


def test_forces_keep_their_direction(lammps) -> None:
    """In LAMMPS: no force perpendicular to the initial line of centers, and energy is conserved."""
    across = []
    for setup, normals in ((PLACES, " normals initial"), ("", "")):
        lmp = lammps(two_spheres(setup, normals, style="hertz 1e9 0.3"))
        lmp.commands_string("variable e equal c_ke+pe\nvariable vx equal vx[1]\nrun 0")
        before = lmp.extract_variable("e")
        lmp.commands_string("run 1500")
        assert lmp.extract_variable("e") == pytest.approx(before, rel=1e-5)
        across.append(lmp.extract_variable("vx"))
    assert across[0] == 0.0
    assert abs(across[1]) > 1e-6


@pytest.mark.parametrize(("setup", "more", "words"), [
    ("", {}, "requires the initial positions"),
    (START.replace("ghost yes", "ghost no"), {}, "requires the initial positions"),
    (START.replace("d2_initial 3", "d_initial"), {}, "requires the initial positions"),
    (
        PLACES, {"style": "hertz 1e9 0.3 friction 0.1", "extra": "comm_modify vel yes"},
        "does not support friction and cohesion",
    ),
    (f"{PLACES}fix round all gran/cylinder 1 0.1 0 1 0\n", {}, "requires spheres"),
])  # fmt: skip
def test_what_lammps_refuses(lammps, setup: str, more: dict, words: str) -> None:
    refuses(lammps(two_spheres(setup, **more)), "run 0", words)


@pytest.mark.parametrize(
    "words", ["normals", "normals start", "forgotten initial", "normal initial"]
)
def test_words_of_the_pair_style(lammps, words: str) -> None:
    refuses(lammps(), two_spheres(PLACES, f" {words}"), "'normals current' or 'normals initial'")


def test_deck_names_the_places(granwave, tmp_path: Path) -> None:
    done = granwave(
        "write", "fcc-small", "--set", "contact.normals=initial", "-o", "deck", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "deck" / "in.granwave").read_text()
    assert "forgotten list normals initial" in text
    assert "property/atom d2_initial 3 ghost yes" in text
