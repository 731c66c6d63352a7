"""The table [figures] of a case: values, faults, and what it leaves alone."""

from __future__ import annotations

from granwave.analysis.figures.run_figures import FIGURES
from granwave.lammps_inputs.case.run import FIGURE_NAMES, FRAMES_OF_A_FILM, CutPlane, Figures
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.planning.schedule import make_schedule
from tests.helpers.synthetic import make_case

BASE = {"packing": {"kind": "fcc", "size": [4, 4, 2], "diameter": 0.01}, "material": "brass"}


def case_of(**figures):
    return case_from_dict({**BASE, "figures": figures})


def test_names_are_those_of_the_figures_that_are_drawn():
    assert tuple(FIGURES) == FIGURE_NAMES


def test_values_and_their_way_through_a_file():
    case = case_of(plane={"normal": [1, 1, 0], "through": [0.1, 0, 0]}, colour_map="plasma", force_limits=[1, 50],
                   formats=["svg", "png"], only=["energies"], width=0.1, view=True)  # fmt: skip
    assert case.figures.plane == CutPlane((1.0, 1.0, 0.0), (0.1, 0.0, 0.0))
    assert case.figures.formats == ("svg",) and case.figures.force_limits == (1.0, 50.0)
    assert case_from_dict(case.to_dict()) == case
    assert case_of(plane="y").figures.plane == CutPlane((0.0, 1.0, 0.0))


def test_a_case_without_the_table_has_none():
    assert "figures" not in case_from_dict(BASE).to_dict()
    assert case_from_dict(BASE).figures == Figures()


def test_a_film_has_enough_frames_unless_they_are_given():
    assert case_of(film="mp4").run.frames == FRAMES_OF_A_FILM
    assert case_from_dict({**BASE, "figures": {"film": "gif"}, "run": {"frames": 5}}).run.frames == 5
    assert case_of(view=True).run.frames == 20
    short = make_case(run={"end_time": 3e-6, "timestep": 1e-7}, figures={"film": "gif"})
    assert make_schedule(short).n_frames == 31  # one a step, at most
