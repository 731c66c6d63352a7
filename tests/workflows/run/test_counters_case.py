"""Counts of how often a run reads, checks and assembles its case, and a report of finished runs;
and of how often a scan makes its studies.
"""

from __future__ import annotations

import importlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.reports import studies as report_studies
from granwave.analysis.studies.study import make_studies
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows import load_case, run_case
from granwave.workflows.scanning.driver import publish
from tests.helpers.made_up.synthetic_scan import grid, write_scan

PARSED = "parsed"
ASSEMBLED = "assembled"
CHECKED = "checked"
AFFORDED = "afforded"
# names of modules, since packages have functions of the same names
LOAD = importlib.import_module("granwave.lammps_inputs.load_case")
PLAN = importlib.import_module("granwave.lammps_inputs.planning.plan")
FILES = importlib.import_module("granwave.lammps_inputs.files")
DIRECTORIES = importlib.import_module("granwave.lammps_inputs.directories")


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Calls of the functions that read, check and assemble cases and test resources, in this
    process.
    """
    counter: Counter[str] = Counter()

    def count(owner: Any, name: str, what: str) -> None:
        function = getattr(owner, name)

        def counted(*args: Any, **options: Any) -> Any:
            counter[what] += 1
            return function(*args, **options)

        monkeypatch.setattr(owner, name, counted)

    count(LOAD, "parse_case", PARSED)
    count(Assembly, "__init__", ASSEMBLED)
    count(LOAD, "check_together", CHECKED)
    count(LOAD, "check_case", CHECKED)
    count(PLAN, "check_memory", AFFORDED)
    count(PLAN, "check_disk", AFFORDED)
    count(DIRECTORIES, "check_disk", AFFORDED)
    count(FILES, "available_memory", AFFORDED)
    return counter


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are drawn in this process."""
    monkeypatch.setenv("GRANWAVE_FIGURE_PROCESSES", "1")


@pytest.mark.usefixtures("alone")
def test_a_run_parses_and_assembles_its_case_once(
    granwave: Any, tmp_path: Path, counts: Counter[str]
) -> None:
    done = granwave("run", "fcc-small", "-o", "run", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run/figures/energies.png").exists()
    assert counts[PARSED] == 1
    assert counts[CHECKED] == 2  # keys of different tables, and the whole case
    assert counts[ASSEMBLED] == 1


def test_a_deck_parses_and_assembles_its_case_once(
    granwave: Any, tmp_path: Path, counts: Counter[str]
) -> None:
    assert granwave("write", "fcc-small", "-o", "deck", cwd=tmp_path).returncode == 0
    assert counts[PARSED] == 1
    assert counts[ASSEMBLED] == 1


def test_a_check_parses_its_case_once(granwave: Any, counts: Counter[str]) -> None:
    assert granwave("check", "precompressed-chain").returncode == 0
    assert counts[PARSED] == 1
    assert counts[ASSEMBLED] <= 2


def test_an_analysis_parses_and_assembles_its_case_once(
    granwave: Any, run: Path, counts: Counter[str]
) -> None:
    assert granwave("analyse", run, "--no-figures").returncode == 0
    assert counts[PARSED] == 1
    assert counts[ASSEMBLED] == 1
    assert counts[CHECKED] == 0


def test_a_report_of_finished_runs_checks_and_affords_nothing(
    granwave: Any, tmp_path: Path, whole: Path, counts: Counter[str]
) -> None:
    other = tmp_path / "other"
    run_case(load_case("two-spheres", {"load.velocity": 2.0}), other, figures=False)
    counts.clear()
    done = granwave("report", whole, other, "-o", tmp_path / "report.html")
    assert done.returncode == 0, done.stderr
    assert counts[PARSED] > 0
    assert counts[CHECKED] == 0
    assert counts[AFFORDED] == 0


def test_an_assembly_travels_as_its_case() -> None:
    """Other processes assemble the case again; values kept by the assembly are not transferred."""
    import pickle

    from granwave.lammps_inputs.packing.assembly import assemble
    from granwave.lammps_inputs.packing.walls import walls

    assembly = assemble(load_case("fcc-small"))
    assert walls(assembly) is walls(assembly)
    sent = pickle.dumps(assembly)
    assert len(sent) < 20_000
    received = pickle.loads(sent)
    assert received.case == assembly.case and walls(received) == walls(assembly)


def test_studies_of_a_scan_are_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For its figures, its rows and its report."""
    made = Counter[str]()

    def counted(groups: Mapping[str, Any], *others: Any) -> Any:
        made.update(list(groups))
        return make_studies(groups, *others)

    monkeypatch.setattr(report_studies, "make_studies", counted)
    points = grid(contact__friction=[0.0, 0.1])
    scan = write_scan(tmp_path / "scan", points, study=["tolerance"])
    publish(ResultDirectory(scan), ["tolerance"])
    assert made["tolerance"] == 1
    assert set(made.values()) == {1}
    assert (scan / "report.html").is_file()
