"""Warnings of a run in its record, and in reports and comparisons by its name."""

from __future__ import annotations

import json
import logging

import pytest

from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.outline import build_report
from granwave.lammps_inputs.checks.warnings import case_warnings
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import load_case, run_case
from granwave.workflows.run.kept_warnings import keeping_warnings
from tests.helpers.made_up.synthetic_report import notes

pytestmark = pytest.mark.xdist_group("kept warnings")  # its fixture is made once

SMALL = {"packing.size": [4, 4, 3], "run.end_time": 2e-5}
OTHER = {
    "youngs_modulus": 7e10,
    "poisson_ratio": 0.2,
    "density": 2700.0,
    "yield_strength": 1e8,
}
FITTED = "the contact law was fitted for a Poisson's ratio of 0.30, found 0.2"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Runs of a material outside the range of the law, and of one within it."""
    folder = tmp_path_factory.mktemp("warned")
    for name, changes in (("glassy", SMALL | {"material": OTHER}), ("usual", SMALL)):
        run_case(load_case("fcc-small", changes), folder / name, figures=False)
    return folder


def test_the_record_keeps_the_warnings(place):
    (text,) = json.loads((place / "glassy" / "run.json").read_text())["warnings"]
    assert text.startswith(FITTED)
    assert json.loads((place / "usual" / "run.json").read_text())["warnings"] == []


def test_reports_and_comparisons_show_them_once(place):
    """In the report of the run, and in the comparison with which a report of several begins."""
    start = f"Warning of glassy: {FITTED}"
    both = read_inputs([place / "glassy", place / "usual"], place)
    for inputs in (read_inputs([place / "glassy"], place), both):
        shown = [note.text for note in notes(build_report(inputs), "short")]
        assert [text.startswith(start) for text in shown].count(True) == 1
    (note,) = [note for note in compare_runs(both.runs).notes if note.startswith("Warning of")]
    assert note.startswith(start)
    (run, *_) = read_inputs([place / "usual"], place).runs
    assert run.warnings == []


def test_a_chosen_yield_factor_is_meant():
    case = load_case("fcc-small", SMALL | {"material": OTHER, "contact.yield_factor": 1.5})
    assert case_warnings(assemble(case)) == []
    case = load_case("fcc-small", SMALL | {"material": OTHER})
    assert len(case_warnings(assemble(case))) == 1


def test_a_yield_factor_that_is_set_to_its_default_is_meant(tmp_path):
    """The record of the run, and thus its report, has no other warnings than the command."""
    case = load_case("fcc-small", SMALL | {"material": OTHER, "contact.yield_factor": 1.6})
    assert case_warnings(assemble(case)) == []
    assert case == load_case("fcc-small", SMALL | {"material": OTHER})
    run_case(case, tmp_path / "run", figures=False)
    assert json.loads((tmp_path / "run" / "run.json").read_text())["warnings"] == []
    assert "chosen" not in (tmp_path / "run" / "case.toml").read_text()


def test_only_warnings_about_the_case_are_kept():
    """Each once; messages of other levels, and about other cases, are not kept."""
    kept: list[str] = []
    logger = logging.getLogger("granwave.tests")
    with keeping_warnings(["mine", "mine in here"], kept):
        for text in ("mine: a", "mine in here: a", "other: b", "mine: c: d"):
            logger.warning(text)
        logger.info("mine: e")
    logger.warning("mine: f")
    assert kept == ["a", "c: d"]
