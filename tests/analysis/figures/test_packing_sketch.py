"""Sketch of a packing, by ``granwave check --picture``."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from granwave.analysis.figures.packing_sketch import packing_drawing
from granwave.lammps_inputs.load_case import load_assembly
from granwave.workflows.cli.main import main
from granwave.workflows.library import find_for


def test_each_view_has_all_grains() -> None:
    assembly = load_assembly(find_for("intruder", "run"))
    drawing = packing_drawing(assembly)
    for axes in drawing.figure.axes:
        (discs,) = axes.collections
        assert len(discs.get_offsets()) == assembly.n_spheres
    side, above = drawing.figure.axes
    assert side.yaxis_inverted()  # depth points down
    assert not above.yaxis_inverted()


def test_the_option_writes_the_picture_and_its_grains(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check", "two-spheres", "--picture", "pair.png"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"pair.png", "pair.pdf", "pair.csv"}
    table = pd.read_csv("pair.csv")
    assert list(table) == ["x_m", "y_m", "z_m", "diameter_m", "material"]
    assert len(table) == 2
    capsys.readouterr()
    assert main(["check", "two-spheres", "--picture", "pair.gif"]) == 2
    assert "pair.gif: found the suffix .gif, expected .png or .pdf" in capsys.readouterr().err
    (tmp_path / "mine.png").write_text("mine")
    assert main(["check", "two-spheres", "--picture", "mine.png"]) == 2
    assert (tmp_path / "mine.png").read_text() == "mine"
    assert main(["check", "sphere-contact", "--picture", "new.png"]) == 2
    assert not (tmp_path / "new.png").exists()
