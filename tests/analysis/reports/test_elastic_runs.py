"""Reports of runs in which nothing was dissipated, and of runs of different packings."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from granwave.analysis.document.model import DocumentTable, Gallery, Note
from granwave.analysis.reports import figures
from granwave.analysis.reports.answer import _of_runs_in_words
from granwave.analysis.reports.inputs import read_inputs
from tests.helpers.made_up.synthetic_report import blocks, build, write_run


@pytest.fixture
def elastic(tmp_path):
    """Two runs of which no contact dissipates."""
    directories = []
    for name, force in (("soft", 10.0), ("hard", 25.0)):
        run = write_run(
            tmp_path / name,
            figures=False,
            contact__law="hertz",
            energy_input_J=2.0,
            dissipated_fraction=0.0,
            peak_force_N=force,
            peak_force_with_walls_N=2 * force,
            n_plastic_contacts=0,
            n_plastic_spheres=0,
        )
        with h5py.File(run / "result.h5", "r+") as file:
            kinetic = 2.0 * np.cos(file["energy/time"][()] / 1e-3) ** 2
            file["energy/dissipated"][...] = 0.0
            file["energy/kinetic"][...] = kinetic
            file["energy/elastic"][...] = 2.0 - kinetic
        directories.append(run)
    return directories


def test_two_elastic_runs_do_not_lead_with_zero(elastic, tmp_path):
    report = build(elastic, tmp_path)
    lead = blocks(report, "short")[0]
    assert isinstance(lead, Note)
    assert lead.text == "Largest force of all contacts: 20 N (soft), 50 N (hard)."
    (table,) = [block for block in blocks(report, "short") if isinstance(block, DocumentTable)]
    headings = [column.heading for column in table.columns]
    assert "Dissipated fraction" not in headings
    assert "Yielded contacts" not in headings
    assert "Peak contact force, walls included" in headings


def test_the_figure_of_elastic_runs_is_not_empty(elastic, tmp_path, monkeypatch):
    drawn = []
    draw = figures._draw

    def noted(curves, what):
        drawn.append((curves, what))
        return draw(curves, what)

    monkeypatch.setattr(figures, "_draw", noted)
    report = build(elastic, tmp_path)
    ((curves, what),) = drawn
    assert what == "Kinetic share of the input"
    for _, time, share in curves:
        assert share == pytest.approx(np.cos(time / 1e-3) ** 2)
    (gallery,) = [block for block in blocks(report, "short") if isinstance(block, Gallery)]
    assert gallery.figures[0].caption.startswith("Kinetic share of the input against time.")


def test_an_elastic_run_and_another_are_compared_by_dissipation(elastic, tmp_path):
    plastic = write_run(tmp_path / "plastic", figures=False, dissipated_fraction=0.8)
    runs = list(read_inputs([elastic[0], plastic], tmp_path).results())
    assert _of_runs_in_words(runs) == "Dissipated of the input: 0 % (soft), 80 % (plastic)."
