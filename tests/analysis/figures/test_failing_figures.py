"""Figures that fail: each costs itself alone, and is named with its reason; axes without a span and without values."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import pytest

from granwave.analysis import draw_figures, write_result
from granwave.analysis.figures import run_figures
from granwave.analysis.figures.scales import least_span
from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import FigureFolder, style
from granwave.analysis.scans import figures as scan_figures
from granwave.analysis.studies import study as studies
from granwave.analysis.studies.study import Row, Sketch
from granwave.workflows.cli.main import main
from tests.helpers import synthetic
from tests.helpers.synthetic_report import build, notes, write_run
from tests.helpers.synthetic_scan import grid, write_scan

NAMES = ("energies", "impactor_velocity", "bottom_force")
REASON = "ValueError: math domain error (test_failing_figures.py, line 29)"
WORDS = f"figure energies could not be made: {REASON}"


def fails(*_, **__):
    raise ValueError("math domain error")


@pytest.mark.failing_figures
def test_a_figure_of_a_run_that_fails_costs_no_other(tmp_path, monkeypatch, caplog, capsys):
    run = synthetic.write_run(tmp_path / "run", synthetic.make_case("fcc", (6, 6, 4)))
    write_result(run)
    with monkeypatch.context() as broken:
        figure = run_figures.FIGURES["energies"]
        broken.setitem(run_figures.FIGURES, "energies", dataclasses.replace(figure, function=fails))
        assert [path.stem for path in draw_figures(run, names=NAMES)] == ["impactor_velocity", "bottom_force"]
        assert main(["figures", str(run), "--only", "energies"]) == 1
    assert WORDS in caplog.text
    assert (run / "figures" / "energies.txt").read_text() == f"{REASON}\n"
    assert not (run / "figures" / "energies.png").exists()
    draw_figures(run, names=NAMES)
    assert not FigureFolder(run).not_drawn() and (run / "figures" / "energies.png").exists()


@pytest.mark.failing_figures
def test_a_report_names_figures_that_failed(tmp_path, caplog):
    run = write_run(tmp_path / "run")
    FigureFolder(run).draw(fails, "energies")
    assert f"The {WORDS}." in [note.text for note in notes(build([run], tmp_path), "figures")]


@pytest.mark.failing_figures
def test_a_figure_of_a_scan_that_fails_costs_no_other(tmp_path, monkeypatch):
    scan = write_scan(tmp_path, grid(load__velocity=[1, 2]))
    whole = {path.stem for path in scan_figures.draw_scan_figures(scan, pdf=False)}
    drawn = scan_figures._curves

    def some(x, others, quantity, *rest, **options):
        return fails() if quantity.name == "peak_force" else drawn(x, others, quantity, *rest, **options)

    monkeypatch.setattr(scan_figures, "_curves", some)
    left = {path.stem for path in scan_figures.draw_scan_figures(scan, pdf=False)}
    assert left == whole - {"peak_force_vs_load_velocity"}
    assert list(FigureFolder(scan).not_drawn()) == ["peak_force_vs_load_velocity"]


@pytest.mark.failing_figures
def test_a_part_of_a_study_that_fails_costs_no_other(monkeypatch):
    def rows(_):
        yield Row("speed", "m/s", None, 1.0, "here")
        fails()

    def pictures(_):
        yield Sketch("_first", "fails", fails)
        yield Sketch("_second", "drawn", lambda: panels(1.0))

    module = SimpleNamespace(TITLE="t", TEXT="text", select=lambda runs: [runs], rows=rows, pictures=pictures)
    monkeypatch.setattr(studies.importlib, "import_module", lambda _: module)
    (found,) = studies.make_studies({"tolerance": []})
    assert [row.quantity for row in found.rows] == ["speed"]
    assert [picture.name for picture in found.pictures] == ["tolerance_second"]
    assert [str(one) for one in found.failed] == [
        f"rows of the study tolerance, from number 2 on, could not be made: {REASON}",
        f"figure tolerance_first could not be made: {REASON}",
    ]


def test_one_layer_is_reported(tmp_path, caplog):
    """Its plastic zone has no depth, so that there is nothing to draw on a logarithmic axis."""
    common = [
        "--set",
        "packing.kind=square",
        "--set",
        "packing.size=[6,6]",
        "--set",
        "run.end_time=3e-5",
        "--no-figures",
    ]
    changes = {"slow": ["load.velocity=5"], "fast": ["load.velocity=10"], "rough": ["contact.friction=0.2"]}
    runs = [str(tmp_path / name) for name in changes]
    for run, sets in zip(runs, changes.values(), strict=True):
        assert main(["run", "fcc-small", *common, "--set", *sets, "-o", run]) == 0
    assert main(["report", *runs, "-o", str(tmp_path / "report.md")]) == 0
    text = (tmp_path / "report.md").read_text()
    assert "Size of the plastic zone" in text
    assert "Left out here: rough (friction)" in text.replace("\\", "")


@pytest.mark.parametrize(("scale", "low", "high"), [("linear", 1.81, 1.996), ("log", 0.634, 5.7)])
def test_equal_values_leave_a_span(scale, low, high):
    """Packing and block of the equal input that `granwave check` prints, equal to six digits."""
    with style():
        figure, axes = panels(2.0)
    axes.plot([1.900830, 1.900834], [3.0, 5.0], "o")
    axes.set_xscale(scale)
    least_span(figure)
    assert axes.get_xlim() == pytest.approx((low, high), rel=5e-3)
    assert axes.get_ylim() == pytest.approx((2.9, 5.1))
