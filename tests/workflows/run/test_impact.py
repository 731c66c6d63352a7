"""Impacts on packings of every kind, with disorder too."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from granwave._contact_laws import LAWS
from granwave.analysis.lammps_output.dumps import contacts_at_end
from granwave.analysis.lammps_output.time_series import read_energy
from granwave.lammps_inputs import build_packing, load_case, write_deck
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import library, run_case
from tests.helpers.made_up.small_cases import LATTICES, packing_of
from tests.helpers.twins.twin import Network


def assert_same_contacts(one, other, *, bits: bool = True):
    """Pairs are bitwise identical, because forces are summed independently of the order; momentary
    forces agree to 1e-8 of the largest.
    """
    orders = [np.lexsort((c["j"], c["i"])) for c in (one, other)]
    assert len(orders[0]) == len(orders[1])
    for name in one.columns:
        a = one[name][orders[0]]
        b = other[name][orders[1]]
        if bits:
            assert np.array_equal(a, b), name
        elif not name.startswith("time"):
            assert np.abs(a - b).max() <= 1e-8 * np.abs(a).max(), name


SMALL = ["packing.size=[8,8,5]", "run.end_time=1.2e-4", "run.frames=3"]


def deck(directory: Path, *overrides: str):
    return write_deck(load_case(library.find("fcc-small"), [*SMALL, *overrides]), directory)


def misses(directory: Path) -> float:
    """Largest error of the energy balance / input."""
    e = read_energy(directory)
    return np.abs(e["kinetic"] + e["elastic"] + e["dissipated"] - e["input"]).max() / e["input"][0]


def test_fcc_impact_against_the_network_twin(lmp, tmp_path):
    """The packing as point masses in true geometry has equal dissipation and peaks, contact by
    contact.
    """
    written = deck(tmp_path, "boundary.bottom=free", "run.timestep=5e-8")
    assert lmp(written.script).returncode == 0
    packing = build_packing(written.case)
    twin = Network(packing.positions, packing.contacts - 1, 0.005)
    twin.v[written.struck[0] - 1, 2] = 5.0
    twin.run(5e-8, written.schedule.n_steps)
    found = next(contacts_at_end(tmp_path).frames())
    peak = {
        (int(i), int(j)): p
        for i, j, p in zip(found["i"], found["j"], found["peak_overlap"], strict=True)
    }
    expected = {
        (int(i), int(j)): p
        for (i, j), p in zip(packing.contacts, twin.peak * twin.alpha_y, strict=True)
    }
    largest = max(expected.values())
    assert max(abs(peak.get(pair, 0.0) - expected[pair]) for pair in expected) < 1e-6 * largest
    assert read_energy(tmp_path)["dissipated"][-1] == pytest.approx(twin.dissipated(), rel=1e-6)


def test_three_preferred_directions_are_equal(lmp, tmp_path):
    """Impact along [111] has a three-fold axis: contacts mapped onto each other have equal peaks,
    to 1e-7, until reflections from the sides arrive.
    """
    written = deck(tmp_path, "packing.size=[19,19,8]", "run.end_time=1e-4")
    assert lmp(written.script).returncode == 0
    packing = build_packing(written.case)
    found = next(contacts_at_end(tmp_path).frames())
    centre = packing.positions[written.struck[0] - 1]
    ends = packing.positions[np.stack([found["i"], found["j"]], axis=1).astype(int) - 1] - centre
    middle = ends.mean(axis=1)
    peak = found["peak_force"]
    near = np.linalg.norm(middle, axis=1) < 0.04
    turn = np.array([[-0.5, -np.sqrt(0.75), 0], [np.sqrt(0.75), -0.5, 0], [0, 0, 1]])
    table = {
        tuple(np.rint(m / 1e-4).astype(int)): p
        for m, p in zip(middle[near], peak[near], strict=True)
    }
    checked = 0
    for m, p in zip(middle[near] @ turn.T, peak[near], strict=True):
        key = tuple(np.rint(m / 1e-4).astype(int))
        if key in table and p > 1e-3 * peak.max():
            assert table[key] == pytest.approx(p, rel=1e-7)
            checked += 1
    assert checked > 100


HARD = ("load.velocity=40", "run.timestep=1e-7", "run.end_time=3e-5")


@pytest.mark.parametrize(
    ("ranks", "overrides"),
    [
        (
            2,
            (
                "packing.diameter_scatter=2e-6",
                "packing.vacancies=0.03",
                'replace=[{share=0.1,material="steel"}]',
            ),
        ),
        (2, ("boundary.sides=periodic",)),
        pytest.param(
            2, (*HARD, "load.spheres=7", "boundary.sides=wall"), marks=pytest.mark.validation
        ),
        # slow with more ranks than cores: few steps
        pytest.param(3, (*HARD, "boundary.sides=periodic"), marks=pytest.mark.validation),
        pytest.param(
            4, (*HARD, "load.spheres=7", "boundary.sides=wall"), marks=pytest.mark.validation
        ),
    ],
)
def test_any_number_of_ranks(lmp, tmp_path, ranks, overrides):
    results = []
    for k in (1, ranks):
        written = deck(tmp_path / str(k), *overrides)
        done = lmp(written.script, ranks=k)
        assert done.returncode == 0, done.stdout + done.stderr
        results.append(
            (read_energy(written.directory), next(contacts_at_end(written.directory).frames()))
        )
    (e1, c1), (e2, c2) = results
    for name in ("kinetic", "elastic", "dissipated"):
        assert e2[name] == pytest.approx(e1[name], rel=1e-10, abs=1e-10 * e1["input"][0])
    assert np.array_equal(e1["contacts_yielded"], e2["contacts_yielded"])

    assert_same_contacts(c1, c2)


@pytest.mark.parametrize(
    ("ranks", "balance", "bits"),
    [
        (1, "", True),
        (2, "comm_style tiled\nfix shuffle all balance 150 1.0 rcb\n", True),
        pytest.param(
            3,
            "comm_style tiled\nfix shuffle all balance 150 1.0 rcb\n",
            True,
            marks=pytest.mark.validation,
        ),
        # this method of balancing in LAMMPS itself changes positions by rounding
        pytest.param(
            2,
            "fix shuffle all balance 150 1.0 shift xyz 10 1.0\n",
            False,
            marks=pytest.mark.validation,
        ),
    ],
)
def test_balanced_and_sorted_ranks_change_nothing(lmp, tmp_path, ranks, balance, bits):
    """Spheres that migrate between processors after their contacts have yielded keep their dents."""
    # with steps of one length: steps of several ticks end where the balance is due
    plain = deck(tmp_path / "plain", "load.velocity=20", "run.timestep=2e-8")
    moved = deck(tmp_path / "moved", "load.velocity=20", "run.timestep=2e-8")
    text = moved.script.read_text()
    more = f"{balance}neigh_modify every 50 check no\natom_modify sort 40 0.02\n# --- run ---"
    moved.script.write_text(text.replace("# --- run ---", more))
    assert lmp(plain.script).returncode == 0
    done = lmp(moved.script, ranks=ranks)
    assert done.returncode == 0, done.stdout + done.stderr
    a = read_energy(plain.directory)
    b = read_energy(moved.directory)
    for name in ("kinetic", "elastic", "dissipated"):
        assert b[name] == pytest.approx(a[name], rel=1e-10, abs=1e-10 * a["input"][0])
    assert_same_contacts(
        next(contacts_at_end(plain.directory).frames()),
        next(contacts_at_end(moved.directory).frames()),
        bits=bits,
    )
    log = (moved.directory / "log.lammps").read_text()
    assert int(re.search(r"Neighbor list builds = (\d+)", log).group(1)) > 10


def test_a_quarter_of_the_step_cuts_the_error_tenfold(lmp, tmp_path):
    errors = []
    for dt in (2e-7, 5e-8):
        written = deck(
            tmp_path / f"{dt:g}",
            f"run.timestep={dt}",
            "packing.size=[16,16,8]",
            "run.end_time=2e-4",
        )
        assert lmp(written.script).returncode == 0
        errors.append(misses(written.directory))
    assert errors[0] > 10 * errors[1]


_POWER = {"power": ("contact.constant=2e9", "contact.exponent=1.5")}


@pytest.mark.parametrize("law", [law for law in LAWS if law != "none"])
def test_every_law_balances_in_a_packing(lmp, tmp_path, law):
    changes = ["packing.size=[5,5,4]", f"contact.law={law}", "run.end_time=6e-5"]
    written = deck(tmp_path, *changes, *_POWER.get(law, ()))
    done = lmp(written.script)
    assert done.returncode == 0, done.stdout
    assert misses(tmp_path) < 5e-6


def test_the_balance_of_a_disordered_packing_closes(tmp_path: Path) -> None:
    case = packing_of(
        size=(8, 8, 5), packing={"diameter_scatter": 2e-6, "vacancies": 0.03, "seed": 2},
        replace=[{"share": 0.1, "material": "steel"}, {"index": 100, "diameter": 0.0099}],
        run={"end_time": 1.5e-4, "frames": 3},
    )  # fmt: skip
    outcome = run_case(case, tmp_path, figures=False)
    assert outcome.state == "finished" and outcome.summary["energy_balance_error"] < 1e-5
    assert outcome.summary["n_spheres"] == assemble(case).n_spheres == 310
    energy = read_energy(tmp_path)
    assert energy["dissipated"][-1] > 0.1 * energy["input"][-1]


@pytest.mark.parametrize(
    ("kind", "sides"),
    [*product(KINDS, ["wall"]), *product(LATTICES, ["periodic"]), ("fcc", "free")],
)
def test_every_lattice_runs(kind: str, sides: str, tmp_path: Path) -> None:
    """LAMMPS finds all neighbors (otherwise the run stops), and energy is balanced."""
    packing = {"diameter_scatter": 1e-6, "scatter_distribution": "normal"}
    case = packing_of(
        kind,
        packing=packing if kind == "chain" else packing | {"vacancies": 0.05},
        replace=[{"share": 0.2, "diameter": 0.0099, "material": "steel"}],
        boundary={"sides": sides},
        run={"end_time": 3e-5, "frames": 2},
    )
    outcome = run_case(case, tmp_path / "run", figures=False)
    assert outcome.state == "finished" and outcome.summary["energy_balance_error"] < 1e-5


def test_a_tolerance_delays_and_lowers_what_arrives(lmp, tmp_path: Path) -> None:
    """Gaps must close first: at 5 m/s, a gap of 1 um between two spheres takes 0.2 us."""
    peaks = []
    for scatter in (0.0, 5e-6):
        case = packing_of(
            size=(8, 8, 5),
            packing={"diameter_scatter": scatter},
            run={"end_time": 1.5e-4, "frames": 3},
        )
        outcome = run_case(case, tmp_path / f"{scatter:g}", figures=False)
        peaks.append(outcome.summary["wall_peak_force_N"])
    assert peaks[1] < 0.9 * peaks[0]
