"""Products that cannot be made on this machine are reported before the run, and do not affect its
results.
"""

from __future__ import annotations

import pytest

from granwave.analysis import pipeline
from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.checks import products
from granwave.lammps_inputs.checks.products import missing_products
from granwave.lammps_inputs.extensions import WITHOUT
from granwave.workflows.cli.main import main
from tests.helpers.made_up import synthetic

BOTH = Figures(film="mp4", view=True)
INSTALL = 'not installed, but the extension pictures requires it: pip install "granwave[pictures]"'


def test_files_that_a_case_asks_for():
    assert Figures().products == {}
    assert BOTH.products == {"film": "film.mp4", "view": "view.html"}
    assert missing_products(BOTH) == []


def test_missing_packages_name_their_extra(monkeypatch):
    """GIF needs no ffmpeg."""
    monkeypatch.setattr(products, "find_spec", lambda name: None)
    assert missing_products(BOTH) == [
        f"figures.film: film.mp4 is not made: imageio-ffmpeg is {INSTALL}",
        f"figures.view: view.html is not made: k3d is {INSTALL}",
    ]
    assert missing_products(Figures(film="gif")) == []


def test_a_missing_extension_is_a_warning(monkeypatch, caplog):
    monkeypatch.setattr(products, "added_by_key", lambda *_: {})
    monkeypatch.delenv(WITHOUT, raising=False)
    text = "figures.film: film.mp4 is not made: the extension that makes it is not installed"
    assert missing_products(Figures(film="mp4")) == [
        f"{text}; granwave doctor lists what is installed"
    ]
    monkeypatch.setenv(WITHOUT, "pictures")
    assert main(["check", "fcc-small", "--set", "figures.film=mp4"]) == 0
    assert f"fcc-small: {text}, or {WITHOUT}=pictures hides it" in caplog.text


@pytest.mark.failing_figures
def test_the_analysis_goes_on_without_it(tmp_path, monkeypatch, caplog):
    case = synthetic.make_case("fcc", (6, 6, 4), figures={"film": "gif", "only": ["energies"]})
    run = synthetic.write_run(tmp_path / "run", case)
    monkeypatch.setattr(pipeline, "added_by_key", lambda *_: {})
    pipeline.analyse(run)
    assert "film.gif: not made: the extension that makes it is not installed" in caplog.text
    assert (run / "summary.json").is_file() and (run / "figures" / "energies.png").is_file()
    assert not (run / "film.gif").exists()


def test_film_and_page_come_with_the_figures(tmp_path):
    case = synthetic.make_case("square", (4, 4), figures={"only": ["energies"], "film": "gif", "view": True},
                               run={"end_time": 1e-4, "timestep": 1e-7, "frames": 5})  # fmt: skip
    directory = synthetic.write_run(tmp_path, case)
    parts: list[str] = []
    pipeline.analyse(directory, parts.append)
    assert parts[-2:] == ["film.gif", "view.html"] and (directory / "view.html").exists()
    pipeline.analyse(directory, figures=False)
    assert (directory / "view.html").exists()
