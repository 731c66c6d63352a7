"""Results without extensions: report and loading of a run, messages on files of missing
extensions.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from granwave.lammps_inputs.extensions import WITHOUT
from tests.helpers.made_up.synthetic_report import write_run

LEFT_OUT = f"which {WITHOUT} hides: remove it from {WITHOUT}"


def without(left_out: str, place: Path, text: str) -> str:
    """Output of Python code in a process without some extensions."""
    environment = os.environ | {WITHOUT: left_out}
    done = subprocess.run(
        [sys.executable, "-c", text],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run, and folders with other results."""
    folder = tmp_path_factory.mktemp("results")
    write_run(folder / "run")
    (folder / "empty").mkdir()
    (folder / "notes").mkdir()
    (folder / "notes" / "a.txt").write_text("x")
    for name, kind, file in (
        ("spectra", "spectra", "bands.json"),
        ("design", "design", "design.json"),
        ("other", "acoustics", "modes.json"),
    ):
        (folder / name).mkdir()
        (folder / name / file).write_text("{}")
        marker = {"kind": kind, "version": "1.0.0", "files": {file: None}, "format": 1}
        (folder / name / ".granwave").write_text(json.dumps(marker))
    return folder


def test_a_run_has_its_report_and_is_loaded(place: Path) -> None:
    text = """
import sys
import granwave.analysis.notebook.load as door
from granwave.analysis.reports.report import write_report
for suffix in ("html", "md"):
    write_report(["run"], f"r.{suffix}")
run = door.load("run")
assert type(run).__name__ == "Run" and "case" in repr(run), run
mine = [name for name in sys.modules if name.startswith("granwave.extensions.")]
print(*[name for name in mine if not name.startswith("granwave.extensions.pictures")])
"""
    assert without("all", place, text).split() == []
    assert "Energy balance" in (place / "r.html").read_text(encoding="utf-8")
    assert (place / "r.md").read_text(encoding="utf-8").startswith("# Report: run")


def test_strange_folders_are_described(place: Path) -> None:
    text = """
from pathlib import Path
from granwave.analysis.result.not_a_run import why_no_run
for name in ("run", "empty", "notes", "spectra", "design", "other", "none"):
    print(why_no_run(Path(name)))
"""
    expected = "expected result.h5 in it, written by  granwave run CASE -o"
    assert without("all", place, text).splitlines() == [
        "run/result.h5 is missing: make it with  granwave analyse run",
        f"empty: is no run: it is empty; {expected} empty",
        f"notes: is no run: it holds a.txt; {expected} notes",
        f"spectra: holds bands or modes of the extension waves, {LEFT_OUT}",
        f"design: holds a search for a design of the extension design, {LEFT_OUT}",
        'other: contains results of the kind "acoustics", but the extension that reads them is not '
        "installed",
        "none: no such directory; did you mean notes?; expected the directory of a run",
    ]


@pytest.mark.parametrize("left_out", ["waves", "all"])
def test_a_missing_extension_is_named_by_what_it_left(place: Path, left_out: str) -> None:
    """The message appears in a report, on loading, and when other results would be written into the
    directory.
    """
    text = """
import granwave.analysis.notebook.load as door
from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.result_directory import ResultDirectory
for action in (
    lambda: write_report(["run", "spectra"], "s.md"),
    lambda: door.load("spectra"),
    lambda: ResultDirectory("spectra").refuse_other_kind("run"),
):
    try:
        action()
    except GranwaveError as error:
        print(type(error).__name__, error)
"""
    message = f"spectra: holds bands or modes of the extension waves, {LEFT_OUT}"
    refused = "spectra: holds bands or modes, expected a run or nothing; choose another with"
    errors = without(left_out, place, text).splitlines()
    assert errors[:2] == [f"InputError {message}", f"MissingOutputError {message}"]
    assert errors[2].startswith(f"InputError {refused}")
    assert not (place / "s.md").exists()


def test_studies_of_a_missing_extension_are_left_out(place: Path) -> None:
    text = """
from granwave.analysis.quantities import quantity, report_columns, scan_figures
from granwave.analysis.studies.registry import COMPARISON, STUDIES, find_studies
print(*STUDIES, *COMPARISON)
print("n_elements" in report_columns(), "max_force" in scan_figures(()))
print(find_studies(["bands"], None)[1][0][:12], quantity("speed_m_s").unit)
"""
    studies, shown, unknown = without("all", place, text).splitlines()
    assert studies.split()[0] == "protected-height" and "comparison" not in studies
    assert (shown, unknown) == ("False False", "found bands, m/s")
