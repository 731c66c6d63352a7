"""Runs of packings with disorder: balance, every lattice, ranks, delays."""

from __future__ import annotations

import dataclasses
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.lammps_output.dumps import read_contacts
from granwave.analysis.lammps_output.time_series import read_energy
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import run_case
from tests.helpers.contacts import assert_same_contacts
from tests.helpers.disordered import LATTICES, case_of

RUN: dict[str, Any] = {
    "packing": {"diameter_scatter": 2e-6, "vacancies": 0.03, "seed": 2},
    "replace": [{"share": 0.1, "material": "steel"}, {"index": 100, "diameter": 0.0099}],
    "run": {"end_time": 1.5e-4, "frames": 3},
}


@dataclasses.dataclass
class Ran:
    """Run and its results."""

    case: Case
    directory: Path
    summary: dict[str, Any]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    case, directory = case_of(size=(8, 8, 5), **RUN), tmp_path_factory.mktemp("disorder") / "run"
    outcome = run_case(case, directory, figures=False)
    assert outcome.state == "finished"
    return Ran(case, directory, outcome.summary)


def test_the_balance_of_a_disordered_packing_closes(ran: Ran) -> None:
    assert ran.summary["n_spheres"] == assemble(ran.case).n_spheres == 310
    assert ran.summary["energy_balance_error"] < 1e-5
    energy = read_energy(ran.directory)
    assert energy["dissipated"][-1] > 0.1 * energy["input"][-1]


@pytest.mark.parametrize(("kind", "sides"), [*product(KINDS, ["free", "wall"]), *product(LATTICES, ["periodic"])])
def test_every_lattice_runs(kind: str, sides: str, tmp_path: Path) -> None:
    """LAMMPS finds all neighbors (otherwise the run stops), and energy is balanced."""
    packing = {"diameter_scatter": 1e-6, "scatter_distribution": "normal"}
    case = case_of(
        kind,
        packing=packing if kind == "chain" else packing | {"vacancies": 0.05},
        replace=[{"share": 0.2, "diameter": 0.0099, "material": "steel"}],
        boundary={"sides": sides},
        run={"end_time": 3e-5, "frames": 2},
    )
    outcome = run_case(case, tmp_path / "run", figures=False)
    assert outcome.state == "finished" and outcome.summary["energy_balance_error"] < 1e-5


def test_one_and_two_ranks_give_the_same_bits(lmp, tmp_path: Path) -> None:
    found = []
    for ranks in (1, 2):
        deck = write_deck(case_of(size=(8, 8, 5), **RUN), tmp_path / str(ranks))
        done = lmp(deck.script, ranks=ranks)
        assert done.returncode == 0, done.stdout + done.stderr
        found.append((read_energy(deck.directory), next(read_contacts(deck.directory))))
    (e1, c1), (e2, c2) = found
    for name in ("kinetic", "elastic", "dissipated"):
        assert e2[name] == pytest.approx(e1[name], rel=1e-10, abs=1e-10 * e1["input"][0])
    assert_same_contacts(c1, c2)


def test_a_tolerance_delays_and_lowers_what_arrives(lmp, tmp_path: Path) -> None:
    """Gaps must close first: at 5 m/s, a gap of 1 um in a pair takes 0.2 us."""
    peaks = []
    for scatter in (0.0, 5e-6):
        case = case_of(size=(8, 8, 5), packing={"diameter_scatter": scatter}, run={"end_time": 1.5e-4, "frames": 3})
        outcome = run_case(case, tmp_path / f"{scatter:g}", figures=False)
        peaks.append(outcome.summary["wall_peak_force_N"])
    assert peaks[1] < 0.9 * peaks[0]
