"""Figures that are drawn by default."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from granwave.analysis import Result, write_result
from granwave.analysis.figures.run_figures import chosen_figures, run_figures
from granwave.lammps_inputs.case.figures import (
    FIGURES_BY_DEFAULT,
    Figures,
    figure_names,
    usual_figure_names,
)
from granwave.lammps_inputs.extensions import extensions
from tests.helpers.made_up import synthetic

PACKING = {
    "peak_force_principal",
    "peak_force_depth",
    "plastic_zone_size",
    "energies",
    "bottom_force",
}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Directory of an analysed synthetic run of FCC."""
    directory = tmp_path_factory.mktemp("run")
    write_result(synthetic.write_run(directory, synthetic.make_case(size=(6, 6, 4))))
    return directory


def test_five_figures_of_the_core_answer_for_a_packing(run):
    with Result(run) as result:
        chosen = set(chosen_figures(result, Figures())) & set(FIGURES_BY_DEFAULT)
        assert {name for name in chosen if run_figures()[name].draw(result)} == PACKING


def test_all_and_only(run):
    every = Figures(all=True)
    with Result(run) as result:
        assert chosen_figures(result, every) == figure_names()
        assert chosen_figures(result, replace(every, only=("energies",))) == ("energies",)
        assert chosen_figures(result, Figures(only=("target",))) == ("target",)


def test_an_extension_says_which_of_its_figures_wait_for_their_name():
    for extension in extensions():
        waiting = set(extension.figures_on_request)
        assert waiting <= extension.figures.keys()
        assert not waiting & set(usual_figure_names())


def test_a_small_error_does_not_widen_its_axis(run):
    """The axis of the energy balance error spans four decades, whatever the smallest error."""
    with Result(run) as result:
        drawing = run_figures()["energies"].draw(result)
    residual = np.asarray(drawing.columns["residual_over_input"])
    low, high = drawing.figure.axes[1].get_ylim()
    assert high >= residual.max() > 0
    assert high / low < 1e5


def test_the_orthogonal_plane_shows_the_spheres_behind_it(run):
    """The data file contains only the spheres on the plane; pale spheres fill the gaps between
    them.
    """
    with Result(run) as result:
        drawing = run_figures()["peak_force_orthogonal"].draw(result)
        principal = run_figures()["peak_force_principal"].draw(result)
    behind, on_it = drawing.figure.axes[0].collections[:2]
    assert len(on_it.get_offsets()) == len(drawing.columns["id"])
    places = np.concatenate([behind.get_offsets(), on_it.get_offsets()])
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    nearest = np.sort(apart, axis=1)[:, 1]
    assert nearest.max() <= 1e3 * synthetic.DIAMETER * 1.01
    assert len(principal.figure.axes[0].collections[0].get_offsets()) == len(
        principal.columns["id"]
    )
