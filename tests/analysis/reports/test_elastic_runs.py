"""Reports of runs in which nothing was dissipated, and of runs of different packings."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from granwave.analysis.document.model import DocumentTable, Gallery, Note
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.inputs import read_inputs
from tests.helpers.made_up.synthetic_report import blocks, build, write_run


@pytest.fixture
def elastic(tmp_path):
    """Two runs in which no contact dissipates energy."""
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
    lead, values, *_ = blocks(build(elastic, tmp_path), "short")
    assert isinstance(lead, Note)
    assert lead.text == (
        "The main results differ most in peak contact force, excluding walls, 10 N (soft) and "
        "25 N (hard), a ratio of 2.5."
    )
    assert isinstance(values, DocumentTable)
    labels = [row[0].text for row in values.rows]
    assert "Dissipated fraction" not in labels
    assert "Yielded contacts" not in labels
    assert "Peak contact force, including walls" in labels


def test_the_figure_of_elastic_runs_is_not_empty(elastic, tmp_path):
    """The figure shows kinetic and elastic energy, and has no panel of dissipation."""
    comparison = compare_runs(read_inputs(elastic, tmp_path).runs)
    drawing = comparison.drawing("energies")
    panels = [axes.get_ylabel() for axes in drawing.figure.axes]
    assert panels == ["Kinetic", "Elastic"]
    time = drawing.columns["soft_time_s"]
    share = drawing.columns["soft_kinetic_over_input"]
    assert share == pytest.approx(np.cos(time / 1e-3) ** 2)
    (gallery,) = [b for b in blocks(build(elastic, tmp_path), "short") if isinstance(b, Gallery)]
    captions = [figure.caption for figure in gallery.figures]
    assert any(caption.startswith("Kinetic, elastic and dissipated") for caption in captions)


def test_an_elastic_run_and_another_are_compared_by_dissipation(elastic, tmp_path):
    """A value that is zero in one run is in the table, without a ratio."""
    plastic = write_run(tmp_path / "plastic", figures=False, dissipated_fraction=0.8)
    comparison = compare_runs(read_inputs([elastic[0], plastic], tmp_path).runs)
    row = comparison.table.loc["dissipated_fraction"]
    assert row["soft"] == 0 and row["plastic"] == 0.8 and np.isnan(row["ratio"])
