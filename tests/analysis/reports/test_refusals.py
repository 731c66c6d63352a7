"""Errors of the report command: inputs and output places that are not accepted."""

from __future__ import annotations

from pathlib import Path

import pytest

from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs.errors import InputError, RunError
from tests.helpers.synthetic_report import write_inputs
from tests.helpers.synthetic_scan import write_json


@pytest.fixture
def runs(tmp_path):
    """Two runs and a scan in which points failed and are missing."""
    return write_inputs(tmp_path)


def refused(directories, output) -> list[str]:
    with pytest.raises(InputError) as error:
        write_report(directories, output)
    return error.value.errors


def test_studies_that_do_not_exist(runs, tmp_path):
    with pytest.raises(InputError, match=r"--study: found tolerence, expected one of: .*tolerance") as error:
        write_report(runs, tmp_path / "r.md", ["tolerence", "protected-height"])
    assert len(error.value.errors) == 1
    assert not list(tmp_path.glob("r*"))


def test_all_faults_at_once_and_nothing_written(runs, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("x")
    (runs[1] / "summary.json").unlink()
    (runs[0] / "summary.json").write_text("{")
    before = sorted(tmp_path.rglob("*"))
    given = [tmp_path / "nowhere", tmp_path / "empty", tmp_path / "other", *runs[:2], tmp_path, runs[0] / "case.toml"]
    errors = refused(given, tmp_path / "there" / "r.doc")
    assert len(errors) == 9
    for part in (
        "found the suffix .doc, expected .html, .pdf or .md",
        "there is no directory",
        "nowhere: no such directory",
        "empty: is neither a run nor a scan: it is empty",
        "it holds notes.txt; expected summary.json or scan.json",
        f"cannot be read (Expecting property name enclosed in double quotes: line 1 column 2 (char 1)); make it anew with  granwave analyse {runs[0]}",
        f"a run without summary.json; make it with  granwave analyse {runs[1]}",
        "but holds some (first, scan, second); give those",
        "is a file, expected the directory",
    ):
        assert any(part in fault for fault in errors), part
    assert sorted(tmp_path.rglob("*")) == before


def test_output_that_cannot_be_written(runs, tmp_path):
    (tmp_path / "d.html").mkdir()
    assert "is a directory" in refused(runs, tmp_path / "d.html")[0]
    assert "no suffix" in refused(runs, tmp_path / "report")[0]
    (tmp_path / "r_files").write_text("mine")
    assert "is a file, but pictures" in refused(runs, tmp_path / "r.md")[0]
    assert "no directory was given" in refused([], tmp_path / "r.html")[0]


def test_unfinished_run_and_damaged_scans(runs, tmp_path):
    (runs[0] / "summary.json").unlink()
    write_json(runs[0] / "run.json", {"state": "interrupted"})
    assert "--resume" in refused([runs[0]], tmp_path / "r.html")[0]
    for content in ("{", "[]", '{"name": "a", "case": "b", "varied": [], "points": [{}]}', '{"name": 1}'):
        (runs[2] / "scan.json").write_text(content)
        assert "scan.json" in refused([runs[2]], tmp_path / "r.html")[0]


def test_failure_while_writing_keeps_the_old_report(runs, tmp_path, monkeypatch):
    output = write_report(runs[:1], tmp_path / "r.html")
    before = output.read_bytes()

    def full(self, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(RunError, match="No space left"):
        write_report(runs, output)
    monkeypatch.undo()
    assert output.read_bytes() == before
    assert not list(tmp_path.glob(".r.html*"))


def test_a_report_of_runs_that_share_nothing_is_written_anew(runs, tmp_path):
    report = tmp_path / "r.md"
    report.write_text("# Report: bar, chain, driven and 5 more\n\n8 runs.\n\n")
    assert "8 runs." not in write_report(runs, report).read_text()
