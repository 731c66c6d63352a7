"""Counts of how often a command reads the marker of a directory of results, and other JSON files in it."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from collections import Counter

import pytest

from granwave.analysis.figures.side_by_side import PROCESSES
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows.cli.main import main

pytestmark = pytest.mark.xdist_group("counters")  # its fixtures are made once

SMALL = ["--set", "packing.size=[4,4,3]", "--set", "run.end_time=1.5e-5", "--set", "run.frames=2"]
_MOST_MARKERS = 2  # reads of the marker of a run
_MOST_OF_A_REPORT = 3  # of each run: by the report, by studies, and by the reader of result.h5
_MOST_JSON = 8  # reads of JSON files, the marker among them
# prints the names of the files that were opened for reading in the working directory
_COUNTED = """
import json, os, sys
from pathlib import Path
opened = []

def note(event, arguments):
    if event != "open" or not isinstance(arguments[0], str):
        return
    path = Path(arguments[0])
    if arguments[2] & (os.O_WRONLY | os.O_RDWR) or Path.cwd() not in path.absolute().parents:
        return
    if path.suffix == ".json" or path.name == ".granwave":
        opened.append(path.name)

sys.addaudithook(note)
from granwave.workflows.cli.main import main
status = main(sys.argv[1:])
print(json.dumps(opened))
sys.exit(status)
"""


def opened(tmp_path, *words: str) -> Counter[str]:
    """Run a command in one process; return how often it opened the marker and JSON files, by
    name.
    """
    done = subprocess.run(
        [sys.executable, "-c", _COUNTED, *words],
        cwd=tmp_path,
        env={**os.environ, PROCESSES: "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    return Counter(json.loads(done.stdout.strip().splitlines()[-1]))


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory):
    """Directory with a run a and a run b, and the files that the first opened."""
    place = tmp_path_factory.mktemp("two")
    first = opened(place, "run", "fcc-small", *SMALL, "-o", "a")
    assert main(["run", "fcc-small", *SMALL, "-o", str(place / "b"), "--no-figures"]) == 0
    return place, first


def test_a_run_reads_its_marker_at_most_twice(two_runs):
    _, files = two_runs
    assert files[MARKER] <= _MOST_MARKERS
    assert files.total() <= _MOST_JSON


@pytest.mark.parametrize("words", [("--resume",), ("--force",)])
def test_so_does_one_where_results_are(two_runs, words):
    place, _ = two_runs
    files = opened(place, "run", "fcc-small", *SMALL, "-o", "a", "--no-figures", *words)
    assert files[MARKER] <= _MOST_MARKERS
    assert files.total() <= _MOST_JSON


def test_a_report_checks_no_case(two_runs, monkeypatch):
    place, _ = two_runs
    files = opened(place, "report", "a", "b", "-o", "report.html")
    assert files[MARKER] <= 2 * _MOST_OF_A_REPORT
    module = importlib.import_module("granwave.lammps_inputs.load_case")
    monkeypatch.setattr(module, "check_case", lambda *_: pytest.fail("a case is checked"))
    monkeypatch.chdir(place)
    assert main(["report", "a", "b", "-o", "other.html"]) == 0
