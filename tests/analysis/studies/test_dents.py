"""What a lasting dent changes: the study of runs that keep dents and forget them, and the law's word on zero force."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.contact_law.restitution import restitution
from granwave.analysis.studies.precompression.dents import restitution_at_zero_force
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import make_studies
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.workflows import load_case, run_case

LOOSE = {"packing.size": 10, "packing.gaps": [[n, 1e-4] for n in range(1, 10)], "run.end_time": 3e-3}
PRESSED = {"packing.kind": "fcc", "packing.size": [4, 4, 3], "contact.initial_overlap": {"force": 3e3}}
CASES = {
    "falling row": {"packing.size": 5, "load.index": [1, 2, 3, 4, 5], "run.end_time": 1e-3},
    "loose row": LOOSE,
    "pressed": PRESSED | {"run.end_time": 5e-4},
    "fresh": PRESSED | {"contact.initial_overlap": 0.0, "run.end_time": 5e-4},
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, bool], FinishedRun]:
    folder, found = tmp_path_factory.mktemp("dents"), {}
    for name, changes in CASES.items():
        for kept in (True, False):
            place: Path = folder / f"{name} {kept}"
            gap = {"boundary.forget_gap": 0.1 if kept else 1e-9, "load.velocity": 5.0}
            case = load_case("sphere-on-wall", changes | gap)
            found[name, kept] = FinishedRun(name, place, case, run_case(case, place, figures=False).summary)
    return found


def change(runs: dict[tuple[str, bool], FinishedRun], name: str, key: str) -> float:
    return runs[name, False].value(key) / runs[name, True].value(key) - 1


def test_one_blow_and_a_falling_row_hardly_ask_for_the_memory(runs):
    for name in ("fresh", "falling row"):
        assert abs(change(runs, name, "energy_dissipated_J")) < 0.01
        assert abs(change(runs, name, "wall_peak_force_N")) < 0.01


def test_loose_and_pressed_packings_do(runs):
    assert change(runs, "loose row", "wall_peak_force_N") < -0.1
    assert change(runs, "loose row", "energy_dissipated_J") > 0.02
    assert runs["pressed", True].value("dissipated_fraction") == 0  # a blow below what pressed it before
    assert runs["pressed", False].value("dissipated_fraction") > 0.01


def test_the_study_has_a_line_for_each_pair(runs):
    (study,) = make_studies({"dents": list(runs.values())})
    table, note = study.tables
    assert len(table.rows) == len(CASES)
    lines = {row[0].text: [cell.text for cell in row] for row in table.rows}
    loose = next(cells for name, cells in lines.items() if "gaps of 0.1 mm" in name)
    assert loose[-1].startswith("-")
    assert "part with 0.561 of it, and would with 0.735" in note.text
    assert "fcc" not in study.verdict[0] and "1 %" in study.verdict[0]


def test_forgetting_at_zero_force_makes_energy():
    """With a dent that is kept it is the law's own restitution; forgotten, the spheres part faster, as if pushed."""
    for speed in (1.0, 5.0):
        case = load_case("two-spheres", {"load.velocity": speed})
        law, mass = sphere_contact(case), case.sphere_mass / 2
        kept, forgotten = restitution_at_zero_force(law, mass, speed)
        assert kept == pytest.approx(np.interp(speed, *restitution(law, mass)), rel=1e-3)
        assert kept + 0.1 < forgotten < 1
