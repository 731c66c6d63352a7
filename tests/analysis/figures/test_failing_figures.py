"""Figures that fail: the other figures are drawn, and the failed figure is named with the reason;
axes without a range and without values.
"""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection
from PIL import Image

from granwave.analysis import analyse, draw_figures, write_result
from granwave.analysis.errors import OutputFormatError
from granwave.analysis.figures import run_figures, sections
from granwave.analysis.figures.scales import least_span
from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import RESOLUTION, FigureFolder, style
from granwave.analysis.measures.geometry import own_plane
from granwave.analysis.result.reader import Result
from granwave.analysis.scans import figures as scan_figures
from granwave.analysis.studies import study as studies
from granwave.analysis.studies.registry import STUDIES
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.figures import CutPlane, Figures
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.main import main
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.synthetic_report import build, notes, write_run
from tests.helpers.made_up.synthetic_scan import grid, write_scan

NAMES = ("energies", "impactor_velocity", "bottom_force")


def fails(*_, **__):
    raise ValueError("math domain error")


LINE = fails.__code__.co_firstlineno + 1
REASON = f"ValueError: math domain error (test_failing_figures.py, line {LINE})"
WORDS = f"figure energies could not be made: {REASON}"


@pytest.mark.failing_figures
def test_a_figure_of_a_run_that_fails_costs_no_other(tmp_path, monkeypatch, caplog, capsys):
    run = synthetic.write_run(tmp_path / "run", synthetic.make_case("fcc", (6, 6, 4)))
    write_result(run)
    with monkeypatch.context() as broken:
        figure = run_figures.run_figures()["energies"]
        broken.setitem(
            run_figures.run_figures(), "energies", dataclasses.replace(figure, function=fails)
        )
        assert [path.stem for path in draw_figures(run, names=NAMES)] == [
            "impactor_velocity",
            "bottom_force",
        ]
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
        return (
            fails()
            if quantity.name == "peak_force"
            else drawn(x, others, quantity, *rest, **options)
        )

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
        yield Picture("_first", "fails", fails)
        yield Picture("_second", "drawn", lambda: panels(1.0)[0])

    module = SimpleNamespace(
        TITLE="t", TEXT="text", select=lambda runs: [runs], rows=rows, pictures=pictures
    )
    monkeypatch.setattr(studies.importlib, "import_module", lambda _: module)
    (found,) = studies.make_studies({"tolerance": []})
    assert [row.quantity for row in found.rows] == ["speed"]
    assert [picture.name for picture in found.pictures] == ["tolerance_second"]
    assert [str(one) for one in found.failed] == [
        f"rows of the study tolerance, from number 2 on, could not be made: {REASON}",
        f"figure tolerance_first could not be made: {REASON}",
    ]


@pytest.mark.failing_figures
def test_a_failing_study_of_the_user_names_its_line(tmp_path, caplog):
    """The error is raised in a library; the message names the line of the user's file."""
    run = write_run(tmp_path / "run")
    study = tmp_path / "mine.py"
    study.write_text(
        "import granwave as gw\n\n\ndef rows(runs):\n"
        "    law = gw.measures.power_law([5.0, 5.0], [1.0, 2.0])\n"
        "    yield gw.Row('Exponent', ours=law.exponent)\n"
    )
    command = ["report", str(run), "--study", str(study), "-o", str(tmp_path / "report.md")]
    assert main(command) == 0
    assert "found x = 5 at all points, expected two or more different values" in caplog.text
    assert "(mine.py, line 5)" in caplog.text


def test_a_study_that_does_not_suit_the_runs_is_reported(tmp_path, caplog):
    run = write_run(tmp_path / "run")
    command = ["report", str(run), "-o", str(tmp_path / "report.md"), "--study"]
    assert main([*command, "tolerance"]) == 0
    assert (
        "the report does not contain the study tolerance, which needs packings that differ only "
        "in diameter scatter, vacancies or friction, in at least two settings"
    ) in caplog.text


@pytest.mark.parametrize("name", STUDIES)
def test_every_built_in_study_states_the_runs_that_it_needs(name):
    assert studies.requirement(name) != "other runs"


@pytest.mark.needs_extension("continuum")
def test_one_layer_is_reported(tmp_path, caplog):
    """The plastic zone has no depth, so that a logarithmic axis has no values."""
    settings = ["packing.kind=square", "packing.size=[6,6]", "run.end_time=3e-5"]
    common = ["--no-figures", *(word for setting in settings for word in ("--set", setting))]
    changes = {
        "slow": ["load.velocity=5"],
        "fast": ["load.velocity=10"],
        "rough": ["contact.friction=0.2"],
    }
    runs = [str(tmp_path / name) for name in changes]
    for run, sets in zip(runs, changes.values(), strict=True):
        assert main(["run", "fcc-small", *common, "--set", *sets, "-o", run]) == 0
    assert main(["report", *runs, "-o", str(tmp_path / "report.md")]) == 0
    text = (tmp_path / "report.md").read_text()
    assert "Size of the plastic zone" in text
    assert "all other runs are in the tables above and below: rough (friction)" in text


@pytest.mark.parametrize(("scale", "low", "high"), [("linear", 1.81, 1.996), ("log", 0.634, 5.7)])
def test_equal_values_leave_a_span(scale, low, high):
    """Packing and block with the equal input that `granwave check` prints, equal to six digits."""
    with style():
        figure, axes = panels(2.0)
    axes.plot([1.900830, 1.900834], [3.0, 5.0], "o")
    axes.set_xscale(scale)
    least_span(figure)
    assert axes.get_xlim() == pytest.approx((low, high), rel=5e-3)
    assert axes.get_ylim() == pytest.approx((2.9, 5.1))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    directory = synthetic.write_run(tmp_path_factory.mktemp("run"), synthetic.make_case())
    write_result(directory)
    return directory


@pytest.fixture
def result(run):
    with Result(run) as found, style():
        yield found


@pytest.mark.parametrize(
    "normal", [(1, 0, 0), (0, 2, 0), (0, 0, -1), (1, 1, 0), (1, 2, 3), (-1, 0, 2)]
)
def test_axes_of_a_plane(normal):
    """The axes are orthonormal and in the plane; depth points down, or y if the plane has no
    depth.
    """
    plane = own_plane(normal, None)
    assert plane.across @ plane.across == pytest.approx(
        1
    ) and plane.down @ plane.down == pytest.approx(1)
    assert abs(plane.across @ plane.down) < 1e-12
    assert np.allclose(np.cross(plane.normal, normal), 0, atol=1e-12)
    assert plane.down[1 if normal[:2] == (0, 0) else 2] > 0
    assert plane.across[np.argmax(np.abs(plane.across))] > 0


def test_discs_of_a_plane_are_the_cuts_of_the_spheres(result):
    """All spheres that the plane x = const cuts, with the radii of their sections."""
    middle = float(result.origin[0]) + 0.001
    result.figure_options = Figures(plane=CutPlane((1.0, 0.0, 0.0), (middle, 0.0, 0.0)))
    drawing = sections.peak_force_section(result, "section")
    away = np.abs(result["spheres/position"][:, 0] - middle)
    inside = away < synthetic.DIAMETER / 2
    assert set(drawing.columns["id"]) >= set(result["spheres/id"][inside])
    (discs,) = [
        one for one in drawing.figure.axes[0].collections if isinstance(one, EllipseCollection)
    ]
    shown = result.rows(drawing.columns["id"])
    radius = np.sqrt(np.maximum((synthetic.DIAMETER / 2) ** 2 - away[shown] ** 2, 0))
    assert np.allclose(np.asarray(discs.get_widths()), 0.96 * 2 * radius * 1e3, atol=1e-6)
    assert drawing.figure.axes[0].get_xlabel() == "y, from the impact axis (mm)"


def test_no_section_without_a_plane_or_where_it_misses(result):
    assert sections.peak_force_section(result, "section") is None
    result.figure_options = Figures(plane=CutPlane((1.0, 0.0, 0.0), (9.0, 0.0, 0.0)))
    assert sections.peak_force_section(result, "section") is None


def test_colours_and_limits(result):
    result.figure_options = Figures(
        colour_map="plasma", force_limits=(0.1, 90.0), dissipation_limits=(1e-4, 0.5)
    )
    force = sections.peak_force_colouring(result)
    loss = sections.dissipation_colouring(result)
    assert (force.map, force.low, force.high) == ("plasma", 0.1, 90.0)
    assert (loss.map, loss.low, loss.high) == ("plasma", 1e-4, 0.5)


def test_width_and_formats(run):
    (path,) = draw_figures(run, names=("energies",), options=Figures(width=0.127, formats=("svg",)))
    with Image.open(path) as image:
        assert image.width == 5 * RESOLUTION
    assert {found.suffix for found in path.parent.glob("energies.*")} == {".png", ".svg", ".csv"}
    first = path.with_suffix(".svg").read_bytes()
    draw_figures(run, names=("energies",), options=Figures(width=0.127, formats=("svg",)))
    assert path.with_suffix(".svg").read_bytes() == first
    draw_figures(run, names=("energies",), options=Figures(formats=()))
    assert {found.suffix for found in path.parent.glob("energies.*")} == {".png", ".csv"}


def test_the_case_file_says_how_and_may_be_edited(tmp_path):
    case = synthetic.make_case(
        "chain", 3, figures={"only": ["energies", "bottom_force"], "formats": []}
    )
    analyse(synthetic.write_run(tmp_path, case))
    assert {path.name for path in (tmp_path / "figures").glob("*.p*")} == {
        "energies.png",
        "bottom_force.png",
    }
    path = tmp_path / "case.toml"
    text = path.read_text()
    path.write_text(text.replace('    "bottom_force",\n', ""))
    assert path.read_text() != text
    analyse(tmp_path)  # the results are those of the case that was run
    assert {found.name for found in (tmp_path / "figures").glob("*.p*")} == {"energies.png"}
    path.write_text(text.replace("bottom_force", "bottom_farce"))
    with pytest.raises(
        (InputError, OutputFormatError), match=r"figures\.only: .*did you mean bottom_force"
    ):
        draw_figures(tmp_path)
