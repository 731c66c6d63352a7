"""The tables of results: made of the stored rows, and some of these run anew."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import granwave as gw
from granwave.analysis.studies.registry import COMPARISON, STUDIES
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import make_studies
from granwave.workflows import load_scan
from tests.documents.pages import ROOT

SAME = 1e-6  # relative: runs of these cases give the same bits; libraries of other versions round otherwise
HOMOGENEOUS = str(ROOT / "reproductions" / "composite_chains" / "homogeneous_chain.py")
SENSOR_CHAIN = str(ROOT / "reproductions" / "square_packing" / "sensor_chain.py")
#: Quick cases and their study.
QUICK = (("homogeneous-chain", HOMOGENEOUS), ("sensor-chain", SENSOR_CHAIN))


def program(name: str) -> ModuleType:
    """Module that stores results and makes the page of them, or runs suites."""
    specification = importlib.util.spec_from_file_location(name, ROOT / "docs" / "_ext" / f"{name}.py")
    assert specification and specification.loader
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    specification.loader.exec_module(module)
    return module


TABLE = program("results_table")
RESULTS = program("results")
STORED = TABLE.read_stored()


@pytest.mark.parametrize(("name", "study"), QUICK)
def test_a_fresh_run_gives_the_stored_rows(tmp_path, name, study):
    run = gw.run(name, directory=tmp_path, progress=False)
    runs = [run] if study.endswith(".py") else [FinishedRun(name, run.directory, run.case, run.summary)]
    (made,) = make_studies({study: runs})
    word = Path(study).stem.replace("_", "-")
    suites = [suite["studies"] for suite in STORED["suites"].values()]
    found = {key.replace("_", "-"): one["rows"] for studies in suites for key, one in studies.items()}
    stored = {one["quantity"]: TABLE.row_of(one) for one in found[word]}
    assert made.rows and {row.quantity for row in made.rows} <= set(stored)
    for row in made.rows:
        before = stored[row.quantity]
        assert row.kind == before.kind, row.quantity
        for ours, theirs in ((row.ours, before.ours), (row.source, before.source), (row.theory, before.theory)):
            assert ours == (None if theirs is None else pytest.approx(theirs, rel=SAME)), row.quantity


def test_the_page_and_the_readme_are_made_of_the_stored_rows():
    assert TABLE.page_of(STORED) == TABLE.PAGE.read_text(encoding="utf-8"), "make results was not run"
    readme = TABLE.README.read_text(encoding="utf-8")
    assert TABLE.with_block(readme, TABLE.readme_table(STORED)) == readme, "make results was not run"


def test_the_readme_has_ten_rows():
    lines = list(TABLE.chosen_rows(STORED))
    assert len(lines) == 10 and all(rows for _, rows in lines)
    assert not any(row.bound for _, rows in lines for row in rows)


def test_the_stored_rows_are_those_of_the_code():
    """A table that is stale names its suite, why, and what to run."""
    found = RESULTS.stale(STORED)
    assert not found, "\n" + "\n".join(f"{name}: {why}" for name, why in found.items())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda one: one.update(versions={"granwave": ["0.0.1"]}), "run by granwave 0.0.1"),
        (lambda one: one.update(complete=False), "not all of its runs are done; run make results"),
        (lambda one: one["digests"].update(runs="0"), "its scans or cases have changed since; run make results"),
        (lambda one: one["digests"].update(studies="0"), "results.py --no-run sphere-contacts"),
    ],
)
def test_what_makes_a_table_stale(change, says):
    version = RESULTS.granwave.__version__
    fresh = {
        "versions": {"granwave": [version]},
        "complete": True,
        "digests": RESULTS.digests(RESULTS.SUITES["sphere-contacts"]),
    }
    assert RESULTS.stale({"suites": {"sphere-contacts": fresh}}, ["sphere-contacts"]) == {}
    change(fresh)
    assert says in RESULTS.stale({"suites": {"sphere-contacts": fresh}}, ["sphere-contacts"])["sphere-contacts"]
    assert RESULTS.stale({"suites": {}}, ["sphere-contacts"]) == {
        "sphere-contacts": "no rows are stored; run make results"
    }


def test_a_suite_is_complete_only_if_every_present_point_is_done():
    """Points of an earlier file, or all but one, do not make it complete."""
    suite = RESULTS.SUITES["sphere-contacts"]
    ids = [point.id for point in load_scan("sphere-contacts", here=False).points]

    def inputs(done: list[str]) -> SimpleNamespace:
        points = [SimpleNamespace(run=True, result=SimpleNamespace(id=one)) for one in done]
        return SimpleNamespace(scans=[SimpleNamespace(points=points)], runs=[])

    assert RESULTS._complete(suite, inputs(ids))
    assert not RESULTS._complete(suite, inputs(ids[1:]))
    assert not RESULTS._complete(suite, inputs(["of an earlier file" for _ in ids]))


def test_a_digest_sees_code_and_no_words(tmp_path):
    texts = '"""Doc."""\nx = 1  \n', '"""Other\nwords."""\n# a remark\nx = 1\n', '"""Doc."""\nx = 2\n'
    files = [tmp_path / f"{n}.py" for n in range(3)]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    first, same, other = map(RESULTS._code, files)
    assert first == same != other


def test_every_study_of_a_source_has_its_rows_stored():
    """Every built-in study belongs to a suite."""
    named = {name for suite in RESULTS.SUITES.values() for name in RESULTS.studies_named(suite)}
    assert set(STUDIES) <= named
    assert set(COMPARISON) <= named


def test_every_row_compares_something():
    """A row has a value of ours, or one of theory beside its source's; a bound has no difference."""
    rows = [
        TABLE.row_of(one)
        for suite in STORED["suites"].values()
        for study in suite["studies"].values()
        for one in study["rows"]
    ]
    assert all(row.ours is not None or row.theory is not None for row in rows)
    assert all(row.deviation is None for row in rows if row.bound)


def test_every_suite_says_when_and_with_what_it_was_run():
    for name, suite in STORED["suites"].items():
        assert suite["date"] and suite["versions"].get("granwave") and suite["command"].startswith("granwave"), name
        for study in suite["studies"].values():
            for record in study["rows"]:
                assert TABLE.row_of(record).kind == record["kind"], record["quantity"]
