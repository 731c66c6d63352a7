"""Plastic zones of a few elements: their uncertainty, and the texts that name it."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest

from granwave.analysis.measures.incomplete_values import DISSIPATED_FRACTION
from granwave.analysis.reports.comparison.compared_value import ComparedValue
from granwave.analysis.reports.comparison.values import differing_values
from granwave.extensions.continuum.punch import ContinuumCase, mesh
from granwave.extensions.continuum.punch.resolution import (
    ELEMENTS,
    ERROR,
    FEWEST,
    RESOLVED,
    VISCOUS,
    doubts,
    resolution,
    zone_elements,
)
from granwave.extensions.continuum.punch.run import BlockRun, run_continuum
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.main import main
from granwave.workflows.library import find

LIGHT = {
    "name": "light",
    "material": "brass",
    "punch": {"mass": 0.00445, "velocity": 12.0},
    "run": {"elements": 4000},
}


def summary_of(elements, mass, velocity):
    tables = {
        "name": "case",
        "material": "brass",
        "punch": {"mass": mass, "velocity": velocity},
        "run": {"elements": elements},
    }
    run = BlockRun(ContinuumCase.from_dict(tables))
    run.integrate()
    return run.summarise(1.0)


def shifted_mesh(shift):
    """Function that makes the mesh of a block with its edge shifted by a fraction of an element."""
    usual = mesh.block_mesh

    def make(radius, height, edge, elements, **options):
        lines = usual(radius, height, edge, elements, **options).r
        outside = np.searchsorted(lines, edge)
        width = lines[outside] - lines[outside - 1]
        return usual(radius, height, edge + shift * width, elements, **options)

    return make


@pytest.mark.parametrize(
    ("elements", "mass", "velocity"),
    [(4000, 0.1, 4.0), (4000, 0.1, 6.0), (2000, 0.00445, 20.0), (4000, 0.1, 12.0)],
)
def test_uncertainty_covers_the_position_of_the_nodes(monkeypatch, elements, mass, velocity):
    """A shift of the nodes by a fraction of an element changes the dissipated fraction by less than
    the uncertainties of both.
    """
    found = []
    for shift in (-0.375, -0.125, 0.125, 0.375):
        with monkeypatch.context() as patch:
            patch.setattr(mesh, "block_mesh", shifted_mesh(shift))
            found.append(summary_of(elements, mass, velocity))
    for one, other in itertools.combinations(found, 2):
        assert abs(one[DISSIPATED_FRACTION] - other[DISSIPATED_FRACTION]) < math.hypot(
            one[ERROR], other[ERROR]
        )


def test_elements_are_counted_by_energy_density():
    work = np.array([0.0, 1.0, 5.0, 4.0, 0.5])
    volume = np.array([1.0, 1.0, 10.0, 1.0, 10.0])
    assert zone_elements(work, volume) == 3  # 4, 1 and 5 of 10.5
    assert zone_elements(np.zeros(3), np.ones(3)) == 0


def test_uncertainty_of_a_fraction():
    found = resolution(0.01, 4, 0.0)
    assert found == {ERROR: pytest.approx(0.005), ELEMENTS: 4, RESOLVED: False}
    assert resolution(0.2, FEWEST, 1e-4)[RESOLVED]
    assert resolution(0.0, 0, 3e-4) == {ERROR: 3e-4, ELEMENTS: 0, RESOLVED: None}


def test_run_warns_of_an_unresolved_zone_and_of_viscosity(tmp_path, caplog):
    summary = run_continuum(ContinuumCase.from_dict(LIGHT), tmp_path / "light", figures=False)
    assert summary[ELEMENTS] < FEWEST and summary[RESOLVED] is False
    assert summary[VISCOUS] == pytest.approx(
        summary["energy_viscous_J"] / summary["energy_input_J"], rel=1e-12
    )
    zone, viscosity = doubts(summary)
    assert zone.startswith("the plastic zone is not resolved: ") and " ± " in zone
    assert f"dissipates {100 * summary[VISCOUS]:.2g} % of the input" in viscosity
    for text in (zone, viscosity):
        assert text in caplog.text


def test_resolved_zone_gives_no_warning():
    summary = summary_of(4000, 0.1, 12.0)
    assert summary[RESOLVED] is True
    assert doubts(summary) == []


def test_report_names_both(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_continuum(ContinuumCase.from_dict(LIGHT), tmp_path / "light", figures=False)
    assert main(["report", "light", "-o", "page.md"]) == 0
    page = (tmp_path / "page.md").read_text()
    summary = json.loads((tmp_path / "light" / "summary.json").read_text())
    (lead,) = [line for line in page.splitlines() if "of the input energy" in line]
    assert " ± " in lead
    assert "90 % of the plastic dissipation is within" not in page
    assert "the plastic zone is not resolved" in page
    assert f"artificial viscosity dissipates {100 * summary[VISCOUS]:.2g} %" in page


@pytest.fixture(scope="module")
def packing_and_blocks(tmp_path_factory):
    """A small packing until its dissipation has ended, and blocks with an unresolved and a resolved
    zone.
    """
    place = tmp_path_factory.mktemp("both")
    grains = load_case(find("fcc-small"), ["packing.size=[8,8,4]", "run.end_time=1e-3"])
    run_case(grains, place / "grains")
    run_continuum(ContinuumCase.from_dict(LIGHT), place / "light", figures=False)
    heavy = LIGHT | {"name": "heavy", "punch": {"mass": 0.1, "velocity": 12.0}}
    run_continuum(ContinuumCase.from_dict(heavy), place / "heavy", figures=False)
    return place


def rows_of(page, run):
    """Cells of the rows of a page in Markdown that begin with a run."""
    lines = [line for line in page.splitlines() if line.startswith(f"| {run} | ")]
    return [line.strip("| ").split(" | ") for line in lines]


@pytest.mark.validation
def test_study_omits_sizes_of_an_unresolved_zone(packing_and_blocks, monkeypatch):
    monkeypatch.chdir(packing_and_blocks)
    assert main(["report", "grains", "light", "heavy", "-o", "page.md"]) == 0
    page = (packing_and_blocks / "page.md").read_text()
    per_mass = [row for row in rows_of(page, "light") if row[1].startswith("continuum")]
    assert any(row[-4:] == ["not resolved"] * 4 and " ± " in row[3] for row in per_mass)
    resolved = [row for row in rows_of(page, "heavy") if row[1].startswith("continuum")]
    assert resolved and not any("not resolved" in row for row in resolved)
    assert "Plastic zones of a few elements are not resolved" in page


def test_comparison_has_no_ratio_of_an_unresolved_zone(packing_and_blocks, monkeypatch, capfd):
    monkeypatch.chdir(packing_and_blocks)
    assert main(["compare", "grains", "light"]) == 0
    text = capfd.readouterr().out
    first = next(part for part in text.split("\n\n") if "dissipated fraction" in part)
    assert " ± " in first and "ratio" not in first
    (row,) = [line for line in text.splitlines() if line.endswith(" dissipated_fraction")]
    assert " ± " in row and "not resolved" in row
    text = " ".join(text.split())
    assert "The plastic zone of light is not resolved" in text
    assert "artificial viscosity dissipates" in text
    assert main(["compare", "grains", "heavy"]) == 0
    text = capfd.readouterr().out
    first = next(part for part in text.split("\n\n") if "dissipated fraction" in part)
    assert "not resolved" not in text and "a ratio of" in " ".join(first.split())


def test_fractions_within_their_uncertainties_do_not_differ():
    value = ComparedValue("dissipated_fraction", (0.003, 0.005), "", "", errors=(0.002, 0.002))
    assert value.is_within_errors and differing_values([value]) == []
    apart = ComparedValue("dissipated_fraction", (0.003, 0.9), "", "", errors=(0.002, None))
    assert differing_values([apart]) == [apart]
    assert apart.text(0.003) == "0.30 ± 0.20 %" and apart.text(0.9) == "90 %"


def test_value_without_known_uncertainty_is_not_complete():
    sizes = ComparedValue("zone_depth_90_m", (1e-3, 2e-3), "", "m", is_unresolved=True)
    assert not sizes.is_complete and sizes.ratio is None
    assert sizes.without_ratio == "not resolved"
