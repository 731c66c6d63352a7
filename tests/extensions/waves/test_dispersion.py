"""Figure of the transform of a run in space and time, with its bands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.analysis import write_result
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.figures import usual_figure_names
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up import synthetic

CHAIN = {
    "name": "weak",
    "material": "brass",
    "packing": {"kind": "chain", "size": 60, "diameter": 0.01},
    "contact": {"law": "hertz"},
    "precompression": {"kind": "uniaxial", "force": 20.0},
    "load": {"velocity": 0.005},
    "run": {"end_time": 9e-4, "frames": 2},
    "output": {"history": 500},
}


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    """Directory of a run of a chain under 20 N with a weak impact."""
    directory = tmp_path_factory.mktemp("dispersion") / "run"
    run_case(case_from_dict(CHAIN), directory, figures=False)
    return directory


def drawn(directory):
    """The figure of a run."""
    with Result(directory) as result:
        return run_figures()["dispersion"].draw(result)


def test_the_ridge_of_a_run_is_the_band_of_its_static_state(chain):
    """The band is 2 sqrt(k/m) |sin(k D/2)|, with the stiffness of Hertz's law under 20 N. Near
    the edge of the zone the short record bends the ridge by 1.1 %.
    """
    columns = drawn(chain).columns
    k = columns["k_rad_per_m"]
    band = np.interp(k, columns["band_k_rad_per_m"], columns["band1_Hz"])
    modulus = 115e9 / (2 * (1 - 0.3**2))
    radius = 0.0025
    stiffness = (6 * modulus**2 * radius * 20.0) ** (1 / 3)
    mass = 8500 * math.pi * 0.01**3 / 6
    closed = math.sqrt(stiffness / mass) * np.abs(np.sin(k * 0.005)) / math.pi
    assert band == pytest.approx(closed, rel=1e-3)
    ridge = columns["ridge_Hz"]
    seen = np.isfinite(ridge)
    assert np.count_nonzero(seen) > 60
    assert ridge[seen][5:] == pytest.approx(band[seen][5:], rel=0.015)


def test_it_is_drawn_by_name_only():
    assert "dispersion" not in usual_figure_names()


@pytest.mark.parametrize("options", [{"size": (4, 4, 3)}, {"kind": "chain", "size": 6}])
def test_a_packing_without_static_load_has_no_bands(tmp_path, options):
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(**options)))
    assert drawn(tmp_path) is None


def test_a_single_bead_has_no_transform(tmp_path, recwarn):
    single = CHAIN | {"packing": CHAIN["packing"] | {"size": 1}}
    run_case(case_from_dict(single), tmp_path, figures=False)
    with Result(tmp_path) as result:
        assert run_figures()["dispersion"].draw(result) is None
    assert not recwarn.list
