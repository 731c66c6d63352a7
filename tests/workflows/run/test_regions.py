"""Force at depths and energy in regions of small runs: balances of momentum and energy."""

from __future__ import annotations

import logging
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from granwave.analysis.figures.impact_arrow import impact_arrow
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.measures.depths import forces_at_depths
from granwave.analysis.measures.regions import energy_of_regions, usual_regions
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.small_cases import PULSE, case_of

SIZE = (5, 5, 4)
DIAMETER = 0.010


@pytest.fixture(scope="module")
def packing(tmp_path_factory):
    """Directory of a run of a small packing with friction, whose snapshots contain all forces."""
    directory = tmp_path_factory.mktemp("regions") / "run"
    table = {
        "name": "small",
        "material": "brass",
        "packing": {"kind": "fcc", "size": list(SIZE), "diameter": DIAMETER},
        "contact": {"friction": 0.2},
        "load": {"velocity": 3.0},
        "run": {"end_time": 8e-5, "frames": 161},
        "output": {"contact_forces": True},
    }
    run_case(case_from_dict(table), directory, figures=False)
    return directory


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    """Directory of a run of a chain with a soft middle."""
    directory = tmp_path_factory.mktemp("regions") / "run"
    case = case_of(
        load=PULSE, replace=[{"index": {"first": 5, "last": 7}, "material": "aluminium"}]
    )
    run_case(case, directory, figures=False)
    return directory


def test_the_force_is_what_the_grains_below_gain_and_the_bottom_carries(packing):
    """The impulse of the force through a plane is the momentum below it and the impulse of the
    bottom; by the rule of trapezoids between snapshots.
    """
    with Result(packing) as result:
        depth = result["spheres/position"][:, 2] - result.origin[2]
        mass = result["spheres/mass"]
        velocity = [result.frame(number, "velocity")[:, 2] for number in range(result.n_frames)]
        wall_time = result["walls/bottom/time"]
        wall = result["walls/bottom/force"]
        planes = forces_at_depths(result)
    assert len(planes) == SIZE[2] - 1
    on_wall = np.concatenate([[0.0], np.cumsum(0.5 * (wall[1:] + wall[:-1]) * np.diff(wall_time))])
    for plane in planes:
        below = depth >= plane.depth
        gained = np.array([mass[below] @ speed[below] for speed in velocity])
        carried = np.interp(plane.time, wall_time, on_wall)
        steps = 0.5 * (plane.force[1:] + plane.force[:-1]) * np.diff(plane.time)
        impulse = np.concatenate([[0.0], np.cumsum(steps)])
        largest = np.abs(gained + carried).max()
        assert largest > 0
        assert np.abs(impulse - gained - carried).max() < 0.005 * largest


def test_chosen_depths(packing, caplog):
    """Any depth between the same layers has the same force; one below the packing is left out with
    a warning.
    """
    with Result(packing) as result:
        result.figure_options = replace(result.figure_options, depths=(0.010, 0.012, 0.9))
        with caplog.at_level(logging.WARNING):
            drawing = run_figures()["force_at_depths"].draw(result)
    assert "found 0.9 m, expected depths from" in caplog.text
    assert drawing.columns["force_at_10_mm_N"].tolist() == (
        drawing.columns["force_at_12_mm_N"].tolist()
    )
    names = [text.get_text() for text in drawing.figure.axes[0].get_legend().get_texts()]
    assert names == ["10 mm", "12 mm", "bottom"]


def test_forces_of_a_chain_are_those_of_its_contacts(chain):
    with Result(chain) as result:
        (plane,) = forces_at_depths(result, [2.4 * DIAMETER])
        place = result["chain/contact_position"] - result.origin[2]
        nearest = np.abs(place - 2.4 * DIAMETER).argmin()
        force = result["chain/contact_force"][:, nearest]
        assert plane.depth == pytest.approx(place[nearest])
        assert plane.force.tolist() == force.tolist()
        assert len(forces_at_depths(result)) == 5


@pytest.mark.parametrize(("run", "error"), [("packing", 2e-5), ("chain", 2e-3)])
def test_all_regions_together_hold_the_input(run, error, request):
    """In a chain the largest overlap of a contact is known only at the times of its history."""
    with Result(request.getfixturevalue(run)) as result:
        regions = usual_regions(result, impact_arrow(result).direction)
        energy = energy_of_regions(result, regions)
        given = np.interp(energy.time, result["energy/time"], result["energy/input"])
        total = np.sum(list(energy.share.values()), axis=0)
        assert not energy.kinetic_only
        assert np.abs(total - given / result.energy_input).max() < error


def test_regions_of_a_chain_are_its_materials(chain):
    with Result(chain) as result:
        drawing = run_figures()["energy_by_region"].draw(result)
    assert list(drawing.columns) == [
        "time_s", "dissipated_over_input", "beads_8_to_12_over_input",
        "beads_5_to_7_aluminium_over_input", "beads_1_to_4_over_input",
    ]  # fmt: skip


def test_regions_of_a_packing_are_its_layers(packing):
    with Result(packing) as result:
        regions = usual_regions(result, np.array([0.0, 0.0, 1.0]))
    spacing = 1e3 * DIAMETER * np.sqrt(2 / 3)
    edges = [0.0, *(spacing * (np.arange(3) + 0.5)), 3 * spacing]
    assert list(regions) == [f"{low:.0f} to {high:.0f} mm deep" for low, high in pairwise(edges)]
    assert [len(ids) for ids in regions.values()] == [SIZE[0] * SIZE[1]] * 4
