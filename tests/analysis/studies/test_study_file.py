"""Studies of one's own: files that a scan or a report names by path."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import write_report
from granwave.analysis.reports.studies import studies_of
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_scan, run_scan
from granwave.workflows.scanning.suite import load_suite
from tests.helpers.synthetic_report import write_run
from tests.helpers.synthetic_scan import grid, write_scan

STUDY = '''"""Force against velocity.

Two velocities
of one packing."""
import granwave as gw


def rows(runs):
    for run in runs:
        yield gw.Row(f"Peak force at {run.case.load.velocity:g} m/s", "N", ours=run["peak_force_N"], theory=100.0)


def pictures(runs):
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().plot([run["peak_force_N"] for run in runs])
    yield gw.Picture("my_forces", "Forces", figure, {"force_N": [run["peak_force_N"] for run in runs]})
'''
SCAN = """case = "fcc-small"
study = "study.py"
set = {"packing.size" = [3, 3, 2], "run.end_time" = 1e-5}
grid = {"load.velocity" = [1, 2]}
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """File of the study."""
    path = tmp_path / "study.py"
    path.write_text(STUDY)
    return path


def test_a_report_makes_it_of_all_runs(tmp_path: Path, study: Path) -> None:
    """Title and text from the docstring, rows and pictures from the functions."""
    runs = [write_run(tmp_path / f"run{v}", load__velocity=v, figures=False) for v in (1, 2)]
    text = write_report(runs, tmp_path / "r.md", [str(study)]).read_text(encoding="utf-8")
    assert "Force against velocity" in text and "Two velocities of one packing." in text
    assert "Peak force at 1 m/s" in text and "Peak force at 2 m/s" in text and "Forces" in text


def test_a_scan_names_it_relative_to_its_own_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, study: Path) -> None:
    """Rows, figure and data are in the directory of the scan, wherever it was started."""
    (tmp_path / "scan.toml").write_text(SCAN)
    monkeypatch.chdir("/")
    assert run_scan(load_scan(tmp_path / "scan.toml"), tmp_path / "out").complete
    with (tmp_path / "out" / "study_rows.csv").open() as file:
        assert [row["quantity"] for row in csv.DictReader(file)] == ["Peak force at 1 m/s", "Peak force at 2 m/s"]
    assert {"my_forces.png", "my_forces.csv"} <= {path.name for path in (tmp_path / "out" / "figures").iterdir()}
    assert "Force against velocity" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_a_later_report_loads_no_code_unasked(tmp_path: Path, study: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The path that a scan's directory holds is not enough: it may come from someone else."""
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2]), study=[str(study)])
    assert studies_of(read_inputs([scan], tmp_path)) == []
    assert f"--study {study}" in caplog.text
    assert [one.name for one in studies_of(read_inputs([scan], tmp_path, [str(study)]))] == ["study"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 +", "cannot be loaded: SyntaxError"),
        ("import no_such_module", "No module named 'no_such_module'"),
        ("def row(runs): ...", "found neither rows(runs), pictures(runs) nor tables(runs)"),
        (None, "no such file, expected the Python file of a study"),
    ],
)
def test_a_file_that_is_no_study_is_refused_before_anything_runs(tmp_path: Path, text: str | None, says: str) -> None:
    """By scans, suites and reports alike."""
    if text is not None:
        (tmp_path / "study.py").write_text(text)
    (tmp_path / "scan.toml").write_text(SCAN)
    (tmp_path / "suite.toml").write_text('scans = ["velocity-fcc"]\nstudy = "study.py"\n')
    run = write_run(tmp_path / "run", figures=False)
    for call in (
        lambda: load_scan(tmp_path / "scan.toml"),
        lambda: load_suite(tmp_path / "suite.toml"),
        lambda: write_report([run], tmp_path / "r.md", [str(tmp_path / "study.py")]),
    ):
        with pytest.raises(InputError) as caught:
            call()
        assert says in str(caught.value) and "study.py" in str(caught.value)


def test_studies_without_rows_stand_in_a_report(tmp_path: Path) -> None:
    """Two of the same text, of which the second has nothing to show."""
    paths = [tmp_path / "one.py", tmp_path / "two.py"]
    for path in paths:
        path.write_text(f'"""Study {path.stem}.\n\nNothing was found."""\n\ndef rows(runs):\n    return []\n')
    run = write_run(tmp_path / "run")
    text = write_report([run], tmp_path / "r.html", [str(path) for path in paths]).read_text(encoding="utf-8")
    assert "Study one" in text and "Study two" in text and text.count("Nothing was found.") == 2


@pytest.mark.failing_figures
def test_a_study_that_fails_costs_no_report(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """It is named with the line of its fault."""
    (tmp_path / "bad.py").write_text('"""Bad."""\ndef rows(runs):\n    return [1 / 0]\n')
    (tmp_path / "misspelt.py").write_text('"""Misspelt."""\ndef rows(runs):\n    yield runs[0]["peak_forc_N"]\n')
    run = write_run(tmp_path / "run", figures=False)
    text = write_report([run], tmp_path / "r.md", [str(tmp_path / "bad.py"), str(tmp_path / "misspelt.py")])
    fault = "rows of the study bad, from number 1 on, could not be made: ZeroDivisionError: division by zero (bad.py, line 3)"
    assert fault in text.read_text(encoding="utf-8") and fault in caplog.text
    assert "did you mean peak_force_N?" in caplog.text
