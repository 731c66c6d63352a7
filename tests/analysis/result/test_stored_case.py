"""Opening a finished run only reads it: the case is parsed and not checked again."""

from __future__ import annotations

import sys
import tomllib

import pytest

import granwave as gw
from granwave.analysis.figures.run_figures import draw_figures
from granwave.analysis.notebook.run import Run
from granwave.analysis.pipeline import analyse
from granwave.analysis.reports.report import write_report
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import read_run
from granwave.lammps_inputs import files as input_files
from granwave.lammps_inputs import load_case
from granwave.lammps_inputs.case import added_grains
from granwave.lammps_inputs.case.packing import packing
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, stored_case
from granwave.lammps_inputs.run_directory import RESULT_FILE
from tests.helpers.made_up.small_cases import changed
from tests.helpers.made_up.synthetic import make_case, write_run

_RING = [{"at": "tetrahedral", "diameter": 0.002}]
_CHECKS = ("check_together", "check_case", "warn_about")


@pytest.fixture
def poor_machine(monkeypatch):
    """A machine without memory; returns the names of the checks that were made."""
    loading = sys.modules[case_from_dict.__module__]  # the package has a function of that name
    made: list[str] = []

    def noted(name, check):
        def call(*values, **options):
            made.append(name)
            return check(*values, **options)

        return call

    for name in _CHECKS:
        monkeypatch.setattr(loading, name, noted(name, getattr(loading, name)))
    for module in (packing, added_grains, input_files):
        monkeypatch.setattr(module, "available_memory", lambda: 1.0)
    return made


@pytest.fixture
def runs(tmp_path):
    """Two analysed runs, one of them with grains in the holes of its lattice."""
    cases = (make_case(), make_case(size=(4, 4, 3), grains=_RING))
    directories = [tmp_path / f"run-{number}" for number in range(len(cases))]
    for case, directory in zip(cases, directories, strict=True):
        write_run(directory, case)
        analyse(directory, figures=False)
    return directories


def test_every_way_to_open_a_result_checks_nothing(runs, poor_machine, tmp_path):
    write_report(runs, tmp_path / "report.html")
    for directory in runs:
        with Result(directory) as result:
            assert result.assembly.n_spheres == result.n_spheres
        run = gw.load(directory)
        assert isinstance(run, Run) and run.case.name == run.summary["name"]
        assert read_run("r", directory, dict(run.summary)) is not None
        draw_figures(directory, lambda _: None, ("energies",))
        (directory / RESULT_FILE).unlink()
        assert gw.load(directory).case.to_dict()["name"] == run.case.name
        analyse(directory, figures=False)
    assert poor_machine == []


def test_the_same_case_as_input_is_checked(runs, poor_machine):
    with pytest.raises(InputError, match="memory"):
        load_case(runs[0] / "case.toml")
    with_grains = changed(grains=_RING)
    with pytest.raises(InputError, match="memory"):
        case_from_dict(with_grains)
    assert stored_case(with_grains).packing.grains is not None
    assert "check_together" in poor_machine


def test_a_stored_case_equals_the_checked_one(runs):
    for directory in runs:
        path = directory / "case.toml"
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
        assert stored_case(tables, path) == load_case(path)


def test_a_stored_case_that_is_no_case_says_so():
    with pytest.raises(InputError, match=r"packing\.diameter"):
        stored_case(changed(packing={"diameter": "wide"}))
