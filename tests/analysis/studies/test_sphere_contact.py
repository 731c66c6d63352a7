"""The contact law beside finite elements: made-up runs of two spheres with known differences."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.studies.runs import SphereContactRun
from granwave.analysis.studies.study import Study, make_studies
from granwave.lammps_inputs.files import read_toml
from tests.helpers.synthetic_contact import write_contact


def contact(folder: Path, **changes: Any) -> SphereContactRun:
    write_contact(folder, **changes)
    summary = json.loads((folder / "summary.json").read_text())
    return SphereContactRun(folder.name, folder, read_toml(folder / "case.toml"), summary)


def table(study: Study) -> dict[str, dict[str, Any]]:
    """Values of the table of a study, by the name of the spheres and the heading."""
    (one,) = study.tables
    heads = [column.heading for column in one.columns[1:]]
    return {row[0].text: dict(zip(heads, [cell.value for cell in row[1:]], strict=True)) for row in one.rows}


def test_differences_are_finite_elements_over_the_law(tmp_path: Path) -> None:
    runs = contact(tmp_path / "alike"), contact(tmp_path / "unlike", difference=-0.09, partner=9.52e-3)
    (study,) = make_studies({"sphere-contact": runs})
    found = table(study)
    assert list(found) == ["brass, like radii", "brass, radii 2 to 1"]
    alike, unlike = found.values()
    assert (alike["At 3 alpha_y"], alike["Most, 1 to 10 alpha_y"]) == (pytest.approx(0.15), pytest.approx(0.15))
    assert (alike["Least, beyond"], unlike["Least, beyond"]) == (pytest.approx(-0.05), pytest.approx(-0.14))
    assert alike["Smallest unloading exponent"] == 1.33
    assert alike["Energy of yielding in the softer sphere"] is None
    assert len(study.pictures) == 1 and not study.failed


def test_the_softer_sphere_takes_what_its_strain_and_strength_say(tmp_path: Path) -> None:
    run = contact(tmp_path / "unlike", material={"name": "steel", "yield_strength": 1100e6})
    (study,) = make_studies({"sphere-contact": [run]})
    share = table(study)["brass and steel"]["Energy of yielding in the softer sphere"]
    assert share == pytest.approx(0.3 / (0.3 + 2 * 0.1))


def test_other_runs_are_left_out(tmp_path: Path) -> None:
    run = contact(tmp_path / "elastic")
    assert make_studies({"sphere-contact": [SphereContactRun("e", run.directory, run.case, {})]}) == []
