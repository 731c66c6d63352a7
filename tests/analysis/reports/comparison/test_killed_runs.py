"""Runs that were killed or interrupted, in comparisons and in the advice of commands."""

from __future__ import annotations

import fcntl
import json
import shutil

import pytest
from matplotlib import pyplot

import granwave as gw
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.figures.axes import show_times_up_to
from granwave.analysis.reports.inputs import read_inputs
from granwave.lammps_inputs.run_directory import LOCK_FILE, MARKER
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.main import main
from tests.analysis.reports.comparison.runs import in_one_line
from tests.helpers.made_up.synthetic_report import write_run

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


def test_a_killed_run_without_summary_is_left_out_by_name(place, tmp_path, capsys):
    killed = tmp_path / "killed"
    killed.mkdir()
    (killed / "case.toml").write_bytes((place / "fcc" / "case.toml").read_bytes())
    (killed / "run.json").write_text('{"state": "running", "end_time_s": 0.0015}')
    output = tmp_path / "page.html"
    words = [str(place / "fcc"), str(killed), str(place / "hcp"), "-o", str(output)]
    assert main(["compare", *words]) == 0
    shown = in_one_line(capsys.readouterr().out)
    assert "Left out: " in shown and "reached 1.5 ms; the run is not finished (killed)" in shown
    assert "Left out: " in output.read_text()
    assert len(gw.compare([place / "fcc", killed, place / "hcp"]).runs) == 2
    assert main(["compare", str(place / "fcc"), str(killed), "-o", str(output)]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert "is not finished" in first and "resume with  granwave run" in first
    assert "found 1 run with results (fcc), expected two or more to compare" in second


def test_a_running_run_is_told_from_a_killed_one(place, tmp_path, capsys):
    """The lock of the directory is held by its process."""
    running = tmp_path / "running"
    running.mkdir()
    (running / "case.toml").write_bytes((place / "fcc" / "case.toml").read_bytes())
    (running / "run.json").write_text('{"state": "running", "end_time_s": 0.0015}')
    with (running / LOCK_FILE).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert main(["report", str(running)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
    assert "reached 1.5 ms; the run is not finished (still running)" in line
    assert line.endswith("; wait for its end") and "resume" not in line


def test_a_killed_run_with_a_summary_is_named_as_killed(tmp_path):
    runs = [write_run(tmp_path / name, figures=False) for name in ("whole", "part")]
    (runs[1] / "run.json").write_text(json.dumps({"state": "running", "attempts": []}))
    comparison = compare_runs(read_inputs(runs, tmp_path).runs)
    assert any(
        note.startswith("Unfinished") and "part (killed" in note for note in comparison.notes
    )


def test_a_run_killed_before_its_first_output_is_resumed(place, tmp_path, capsys):
    """It has no record yet; report, compare and analyse advise the same."""
    killed = tmp_path / "killed"
    killed.mkdir()
    for name in ("case.toml", MARKER):
        (killed / name).write_bytes((place / "fcc" / name).read_bytes())
    for words in (["compare", str(place / "fcc"), str(killed)], ["analyse", str(killed)]):
        assert main(words) == 2
        assert f"granwave run {killed}/case.toml -o {killed} --resume" in capsys.readouterr().err


def test_a_killed_run_with_part_of_its_output_is_resumed(place, tmp_path, capsys):
    """The first output is written later than the record; report and analyse advise the same."""
    killed = tmp_path / "killed"
    shutil.copytree(place / "fcc", killed)
    (killed / "run.json").write_text('{"state": "running", "end_time_s": 1e-05}')
    for name in ("summary.json", "result.h5", "dumps/wall_bottom.dump"):
        (killed / name).unlink()
    advice = f"resume with  granwave run {killed}/case.toml -o {killed} --resume"
    for words in (["report", str(killed)], ["analyse", str(killed)], ["figures", str(killed)]):
        assert main(words) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.endswith(advice) and "--force" not in line
    assert run_case(load_case(killed / "case.toml"), killed, resume=True, figures=False).summary


def test_an_unfinished_run_is_named(tmp_path):
    runs = [write_run(tmp_path / name, figures=False) for name in ("whole", "part")]
    (runs[1] / "run.json").write_text(json.dumps({"state": "interrupted", "attempts": []}))
    comparison = compare_runs(read_inputs(runs, tmp_path).runs)
    assert any(note.startswith("Unfinished") and "part (" in note for note in comparison.notes)


@pytest.mark.parametrize(("state", "scale"), [("interrupted", "linear"), ("finished", "log")])
def test_a_stopped_run_makes_no_axis_of_times_logarithmic(tmp_path, state, scale):
    """The axis follows the finished runs."""
    runs = [write_run(tmp_path / name, figures=False) for name in ("one", "two", "short")]
    (runs[2] / "run.json").write_text(json.dumps({"state": state, "attempts": []}))
    compared = compare_runs(read_inputs(runs, tmp_path).runs).runs
    ends = dict(zip(compared, [1e-3, 1e-3, 1e-5], strict=True))
    figure, axes = pyplot.subplots()
    show_times_up_to(axes, ends)
    assert axes.get_xscale() == scale
    assert axes.get_xlim()[1] == pytest.approx(1e3)
    pyplot.close(figure)
