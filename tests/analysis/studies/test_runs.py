"""Runs that belong together, and the runs that a study is offered."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import SimpleNamespace

from granwave.analysis.reports.inputs import Point, Scan, read_inputs
from granwave.analysis.reports.studies import studies_of
from granwave.analysis.studies.runs import all_but
from granwave.workflows import load_case
from tests.helpers.synthetic_report import write_run


def test_twins_differ_in_what_is_named_alone() -> None:
    case = load_case("settled-fcc")
    other = load_case("settled-fcc", {"precompression.pressure": 1e4, "run.end_time": 1e-3})
    faster = load_case("settled-fcc", {"load.velocity": 10.0})
    of_case, of_other, of_faster = (all_but(one, "precompression") for one in (case, other, faster))
    assert of_case == of_other != of_faster
    assert all_but(case, "load.velocity") == all_but(faster, "load.velocity") != all_but(other, "load.velocity")
    assert all_but(case, "precompression", "load.velocity") == all_but(other, "precompression", "load.velocity")


def test_a_report_shows_the_studies_of_its_runs(tmp_path: Path) -> None:
    """Each of the runs that its scans share, and none of which a study takes nothing."""
    for name, text in (("all", ""), ("none", "def select(runs): return []\n")):
        (tmp_path / f"{name}.py").write_text(f"def tables(runs): yield 'Count', {{'Runs': [len(runs)]}}\n{text}")
    every, none = (str(tmp_path / name) for name in ("all.py", "none.py"))
    directories = [write_run(tmp_path / name, figures=False) for name in ("one", "two")]
    inputs = read_inputs(directories, tmp_path / "report.html", [every, none])
    assert studies_of(inputs) == []
    assert [study.name for study in studies_of(inputs, [every, none])] == ["all"]
    points = tuple(Point(SimpleNamespace(labels={}), "", one) for one in inputs.runs)
    scans = (
        Scan("first", None, points, (none,)),
        Scan("second", None, points[:1], (every,)),
        Scan("third", None, points, (every,)),
    )
    (study,) = studies_of(dataclasses.replace(inputs, items=scans))
    assert study.tables[0].rows[0][0].text == "2"
