"""Elastic bars and chains in contact with them: closed forms, the independent chain solver, studies, invalid input."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.measures.chains.bar_pulse import passage
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.study import make_studies
from granwave.lammps_inputs.deck.deck import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.bars import echoes
from granwave.workflows import load_case, run_case
from tests.helpers.chain_twin import Bar, Bead, Chain, rectangle

INTRUDERS = ("intruder-place", "intruder-properties")
SPEED, IMPEDANCE = (200e9 / 8100) ** 0.5, (200e9 * 8100) ** 0.5 * 1.27e-4
SHORT = {"packing.size": 8, "bar.length": 1.2, "bar.elements": 120, "run.end_time": 4e-4, "load.amplitude": 2e3}


def run(directory: Path, name: str, changes: dict[str, Any]) -> ChainRun:
    outcome = run_case(load_case(name, changes), directory, figures=False)
    (found,) = ChainRun.among([(directory.name, directory, outcome.summary)])
    return found


@pytest.fixture(scope="module")
def lone_bars(tmp_path_factory: pytest.TempPathFactory) -> list[ChainRun]:
    """A half-sine in a bar of 1 m, on two meshes."""
    folder = tmp_path_factory.mktemp("bars")
    changes = {"incident_bar.length": 1.0, "load.duration": 4e-5, "run.end_time": 3e-4}
    return [run(folder / str(n), "bar-pulse", changes | {"incident_bar.elements": n}) for n in (100, 200)]


def test_pulse_in_a_bar(lone_bars):
    run = lone_bars[1]
    (bar,) = run.assembly.bars
    found = passage(run, bar)
    assert found.speed == pytest.approx(SPEED, rel=2e-4)
    assert found.measured_impedance == pytest.approx(IMPEDANCE, rel=1e-3)
    assert found.overshoot == pytest.approx(1, abs=5e-3)
    assert found.deviation < 0.08
    assert found.energy == pytest.approx(1, abs=1e-3)
    assert run.summary["energy_input_J"] == pytest.approx(1e4**2 * 4e-5 / 2 / found.impedance, rel=1e-3)
    assert run.summary["energy_balance_error"] < 5e-6


def test_errors_of_a_bar_fall_with_its_elements(lone_bars):
    coarse, fine = (passage(run, run.assembly.bars[0]) for run in lone_bars)
    assert abs(fine.energy - 1) < 0.3 * abs(coarse.energy - 1)  # of second order
    assert 0.5 < fine.deviation / coarse.deviation < 0.75  # 2^(-2/3) = 0.63: the pulse has kinks


def test_study_of_bars(lone_bars):
    (study,) = make_studies({"elastic-bar": lone_bars})
    assert [picture.name for picture in study.pictures] == ["bar_pulse"]  # convergence needs more than two meshes
    assert sum(row.quantity.startswith("Speed") for row in study.rows) == 1
    assert all(np.isfinite(row.ours) for row in study.rows)
    assert all(abs(row.ours / row.theory - 1) < 5e-3 for row in study.rows if row.theory)


@pytest.fixture(scope="module")
def chains(tmp_path_factory: pytest.TempPathFactory) -> list[ChainRun]:
    """Chains of 8 brass beads on a bar, also with one of aluminium at positions 2, 5 and 8."""
    folder = tmp_path_factory.mktemp("intruder")
    changes = SHORT | {"output.history": 0}
    alike = run(folder / "alike", "intruder", changes | {"replace.1.index": 1, "replace.1.material": "brass"})
    return [alike, *(run(folder / str(n), "intruder", changes | {"replace.1.index": n}) for n in (2, 5, 8))]


def test_intruder_against_the_chain_twin(chains):
    run = chains[2]
    aluminium = Bead(modulus=67e9, density=2700.0, strength=150e6)
    beads = [aluminium if n == 5 else Bead() for n in range(1, 9)]
    twin = Chain(beads, "elastoplastic", right=Bar(area=1.27e-4, length=1.2, elements=120))
    record = twin.run(4e-4, 4e-8, load=rectangle(2e3, 1e-4))
    assert run.value("energy_bar_J") == pytest.approx(record.bar_energy[-1, 1], rel=2e-3)
    assert run.summary["wall_peak_force_N"] == pytest.approx(record.peak_force[-1], rel=1e-3)
    assert run.summary["energy_dissipated_J"] == pytest.approx(record.lost[-1], rel=1e-3)


def test_study_of_places(chains):
    (study,) = make_studies({name: chains for name in INTRUDERS})
    rows = {row.quantity: row.ours for row in study.rows}
    assert rows["Transmitted energy, all brass"] > rows["Transmitted energy, aluminium: least, at place 8"]
    assert study.pictures[0].drawing.columns["place_of_aluminium"] == [2, 5, 8]
    assert not make_studies({"split-hopkinson": chains})
    assert not make_studies({"elastic-bar": chains})  # nothing was recorded


def test_study_of_properties(tmp_path):
    """Heavier and softer intruders transmit less; the study determines the differing parameter."""
    changes = SHORT | {"output.history": 0, "replace.1.index": 4, "run.end_time": 6e-4, "bar.length": 1.6}
    steel = {"preset": "steel"}
    kinds = [
        "steel",
        *(steel | {"density": r * 7850} for r in (5, 20)),
        *(steel | {"yield_strength": r * 7e8} for r in (0.1, 0.3)),
    ]
    runs = [run(tmp_path / str(n), "intruder", changes | {"material": "steel", "replace.1.material": kind})
            for n, kind in enumerate(kinds)]  # fmt: skip
    (study,) = make_studies({name: runs for name in INTRUDERS})
    columns = study.pictures[0].drawing.columns
    assert columns["density_ratio"] == pytest.approx([1, 5, 20])
    assert np.all(np.diff(columns["energy_ratio_by_density"]) < 0)
    assert columns["yield_strength_ratio"] == pytest.approx([0.1, 0.3, 1])
    assert columns["energy_ratio_by_yield_strength"][0] < 0.95


def test_split_hopkinson(tmp_path):
    changes = {"packing.size": 4, "replace.1.index": 2, "bar.elements": 200, "incident_bar.elements": 200,
               "run.end_time": 8e-4, "output.history": 400}  # fmt: skip
    found = run(tmp_path, "split-hopkinson", changes)
    (study,) = make_studies({"split-hopkinson": [found]})
    rows = {row.quantity.removesuffix(", split-hopkinson"): row.ours for row in study.rows}
    assert rows["Peak force, incident"] == pytest.approx(30, rel=1e-2)
    assert 0 < rows["Energy, transmitted over incident"] < 0.1 < rows["Energy, reflected over incident"] < 1
    assert [picture.name for picture in study.pictures] == ["split_hopkinson", "split_hopkinson_map"]
    assert found.summary["energy_balance_error"] < 1e-5


def test_two_ranks_change_no_bit(lmp, tmp_path):
    changes = SHORT | {"run.end_time": 1e-4, "output.history": 50, "replace.1.index": 5, "output.dump_format": "text"}
    files = []
    for ranks in (1, 2):
        deck = write_deck(load_case("intruder", changes), tmp_path / str(ranks))
        done = lmp(deck.script, ranks=ranks)
        assert done.returncode == 0, done.stderr
        files.append([(deck.dumps / name).read_bytes() for name in ("history.dump", "spheres.dump", "walls.txt")])
    assert files[0] == files[1]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("bar.area=0", "bar.area: found 0, expected a number above 0"),
        ("bar.elements=4", "bar.elements: found 4 in 2.5 m, expected 27 or more"),
        ("replace.1.index=21", "replace.1.index: found 21, expected an id from 1 to 20"),
        ("load.duration=0", "load.duration: found 0, expected a number above 0"),
        ("boundary.bottom=wall", 'boundary.bottom: found "wall" beside [bar], expected "free"'),
        (
            "replace.1.material={youngs_modulus=67e9, poisson_ratio=0.3, density=2700}",
            "replace.1.material.yield_strength: missing; the elastoplastic law needs it",
        ),
        ("packing={kind='fcc', size=[4, 4, 4], diameter=0.01}", 'bar: found with packing.kind = "fcc"'),
    ],
)
def test_wrong_input_is_one_line(change, expected):
    with pytest.raises(InputError) as refused:
        load_case("intruder", [change])
    (line,) = refused.value.errors
    assert expected in line


def test_a_bar_that_is_too_short_is_told(caplog):
    load_case("intruder", {"bar.length": 2.0})
    assert "an echo of the end of the bar can reach the chain after 0.000805 s" in caplog.text
    caplog.clear()
    for name in ("intruder", "split-hopkinson", "bar-pulse"):
        load_case(name)
    assert not caplog.text


def test_echo_of_a_bar_behind_another():
    times = echoes(assemble(load_case("split-hopkinson")).bars)
    crossing = 2.0 / (200e9 / 8100) ** 0.5
    assert times == pytest.approx({"incident_bar": 3 * crossing, "bar": 3 * crossing})
