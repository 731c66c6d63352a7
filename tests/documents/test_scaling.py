"""Estimates of `granwave check` that the page on scaling shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.plan import plan
from granwave.workflows import library

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "scaling.md"
ROW = re.compile(r"^\| (\d[\d ]*) \| (\d) \| (\d+) MB \| (\d+) MB \| ([\d.]+) s \| ([\d.]+) s \|")
SIZES = {10368: (24, 24, 18), 101376: (64, 66, 24)}
STEPS = 586  # of both, in the runs of the table
ROWS = [match.groups() for match in map(ROW.match, PAGE.read_text("utf-8").splitlines()) if match]


def test_the_table_has_its_rows() -> None:
    assert len(ROWS) == 8
    for _, _, told, used, told_time, used_time in ROWS:
        assert int(used) == pytest.approx(int(told), rel=0.3)
        assert 0.5 < float(used_time) / float(told_time) < 2


@pytest.mark.parametrize("row", ROWS[:4], ids=lambda row: f"{row[0]}, {row[1]} ranks")
def test_estimates_are_those_of_check(row: tuple[str, ...]) -> None:
    n_spheres = int(row[0].replace(" ", ""))
    changes = {"packing.size": list(SIZES[n_spheres]), "run.frames": 2, "run.end_time": 1.5e-5}
    case = load_case(library.find("fcc-impact"), changes)
    found = plan(assemble(case), n_ranks=int(row[1]))
    expected_steps = found.schedule.n_steps / found.schedule.first_step
    steps = found.times.steps * STEPS / expected_steps
    total = steps + found.times.rest + found.times.figures
    assert found.memory / 1e6 == pytest.approx(int(row[2]), rel=0.02)
    assert total == pytest.approx(float(row[4]), abs=0.3)


def test_disk_space_is_that_of_the_files_at_the_end() -> None:
    """The page compares the estimate with the files of the run of 101 376 spheres."""
    match = re.search(
        r"([\d.]+) MB for\s+the run of 101 376 spheres, whose files took ([\d.]+) MB",
        PAGE.read_text("utf-8"),
    )
    assert match is not None
    told, used = map(float, match.groups())
    changes = {"packing.size": list(SIZES[101376]), "run.frames": 2, "run.end_time": 1.5e-5}
    found = plan(assemble(load_case(library.find("fcc-impact"), changes)))
    assert found.disk / 1e6 == pytest.approx(told, abs=0.1)
    assert found.disk / 1e6 == pytest.approx(used, rel=0.1)
    whole = plan(assemble(load_case(library.find("fcc-impact"), changes | {"run.end_time": 1e-3})))
    assert whole.disk - found.disk > 50e6  # all contacts have touched
    assert whole.disk_reserve == pytest.approx(found.disk_reserve)
