"""Options of figures: planes of one's own, colours, limits, sizes, formats, and which are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection
from PIL import Image

from granwave.analysis import analyse, draw_figures, write_result
from granwave.analysis.errors import OutputFormatError
from granwave.analysis.figures import packing3d, sections
from granwave.analysis.figures.style import RESOLUTION, style
from granwave.analysis.measures.geometry import own_plane
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.run import CutPlane, Figures
from granwave.lammps_inputs.errors import InputError
from tests.helpers import synthetic


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    directory = synthetic.write_run(tmp_path_factory.mktemp("run"), synthetic.make_case())
    write_result(directory)
    return directory


@pytest.fixture
def result(run):
    with Result(run) as found, style():
        yield found


@pytest.mark.parametrize("normal", [(1, 0, 0), (0, 2, 0), (0, 0, -1), (1, 1, 0), (1, 2, 3), (-1, 0, 2)])
def test_axes_of_a_plane(normal):
    """They are orthonormal, lie in the plane, and depth goes down, or y where there is none."""
    plane = own_plane(normal, None)
    assert plane.across @ plane.across == pytest.approx(1) and plane.down @ plane.down == pytest.approx(1)
    assert abs(plane.across @ plane.down) < 1e-12
    assert np.allclose(np.cross(plane.normal, normal), 0, atol=1e-12)
    assert plane.down[1 if normal[:2] == (0, 0) else 2] > 0
    assert plane.across[np.argmax(np.abs(plane.across))] > 0


def test_discs_of_a_plane_are_the_cuts_of_the_spheres(result):
    """Every sphere that the plane x = const cuts, with the radius of its cut."""
    middle = float(result.origin[0]) + 0.001
    result.figure_options = Figures(plane=CutPlane((1.0, 0.0, 0.0), (middle, 0.0, 0.0)))
    drawing = sections.peak_force_section(result, "section")
    away = np.abs(result["spheres/position"][:, 0] - middle)
    inside = away < synthetic.DIAMETER / 2
    assert set(drawing.columns["id"]) >= set(result["spheres/id"][inside])
    (discs,) = [one for one in drawing.figure.axes[0].collections if isinstance(one, EllipseCollection)]
    shown = result.rows(drawing.columns["id"])
    radius = np.sqrt(np.maximum((synthetic.DIAMETER / 2) ** 2 - away[shown] ** 2, 0))
    assert np.allclose(np.asarray(discs.get_widths()), 0.96 * 2 * radius * 1e3, atol=1e-6)
    assert drawing.figure.axes[0].get_xlabel() == "y (mm)"


def test_no_section_without_a_plane_or_where_it_misses(result):
    assert sections.peak_force_section(result, "section") is None
    result.figure_options = Figures(plane=CutPlane((1.0, 0.0, 0.0), (9.0, 0.0, 0.0)))
    assert sections.peak_force_section(result, "section") is None


def test_colours_and_limits(result):
    result.figure_options = Figures(colour_map="plasma", force_limits=(0.1, 90.0), dissipation_limits=(1e-4, 0.5))
    force, loss = sections.peak_force_colouring(result, 4), sections.dissipation_colouring(result)
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


def test_the_case_file_says_how_and_may_be_edited(tmp_path, monkeypatch):
    monkeypatch.setattr(packing3d, "_PIXELS", 120)
    case = synthetic.make_case("chain", 3, figures={"only": ["energies", "bottom_force"], "formats": []})
    analyse(synthetic.write_run(tmp_path, case))
    assert {path.name for path in (tmp_path / "figures").glob("*.p*")} == {"energies.png", "bottom_force.png"}
    path = tmp_path / "case.toml"
    text = path.read_text()
    path.write_text(text.replace('    "bottom_force",\n', ""))
    assert path.read_text() != text
    analyse(tmp_path)  # the results are those of the case that was run
    assert {found.name for found in (tmp_path / "figures").glob("*.p*")} == {"energies.png"}
    path.write_text(text.replace("bottom_force", "bottom_farce"))
    with pytest.raises((InputError, OutputFormatError), match=r"figures\.only: .*did you mean bottom_force"):
        draw_figures(tmp_path)


def test_film_and_page_come_with_the_figures(tmp_path):
    case = synthetic.make_case("square", (4, 4), figures={"only": ["energies"], "film": "gif", "view": True},
                               run={"end_time": 1e-4, "timestep": 1e-7, "frames": 5})  # fmt: skip
    directory = synthetic.write_run(tmp_path, case)
    parts: list[str] = []
    analyse(directory, parts.append)
    assert parts[-2:] == ["film.gif", "view.html"] and (directory / "view.html").exists()
    analyse(directory, figures=False)
    assert (directory / "view.html").exists()
