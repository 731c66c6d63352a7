"""A striker that hits a layer in its plane: nothing moves towards the bottom."""

from __future__ import annotations

import json

import pytest

from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.results import value_rows
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.run_directory import SUMMARY_FILE
from granwave.workflows import load_case, run_case


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("in-plane")
    run_case(load_case("square-in-plane", {"run.frames": 5}), folder, figures=False)
    return folder


def test_a_wave_in_a_layer_leaves_the_values_of_the_bottom_complete(folder):
    """The bottom is never loaded: its impulse of 0 N s does not grow."""
    summary = json.loads((folder / SUMMARY_FILE).read_text())
    assert summary["incomplete_values"] == []
    assert summary["wall_impulse_Ns"] == 0.0


def test_velocity_of_a_striker_is_along_its_direction(folder):
    """It rebounds along x; the energy record has the velocity along z, which is zero."""
    summary = json.loads((folder / SUMMARY_FILE).read_text())
    with Result(folder) as result:
        (striker,) = result.rows(result.struck)
        velocity = result.frame(result.n_frames - 1, "velocity")[striker]
    assert velocity[0] < -0.01
    assert summary["impactor_velocity_m_s"] == pytest.approx(velocity[0], rel=1e-12)
    (run,) = read_inputs([folder], folder).runs
    labels = [name.text for name, *_ in value_rows(run).rows]
    assert "Impacted sphere or striker at the end" in labels


@pytest.mark.parametrize("sides", ["periodic", "free"])
def test_sides_of_elastic_packings(tmp_path, sides):
    changes = {
        "packing.size": [6, 6, 3],
        "contact.law": "hertz",
        "boundary.sides": sides,
        "run.end_time": 2e-5,
    }
    summary = run_case(load_case("hcp-small", changes), tmp_path, figures=False).summary
    assert summary["sides_periodic"] == (sides == "periodic")
