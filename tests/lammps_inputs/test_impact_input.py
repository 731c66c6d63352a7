"""Normalised inputs of impacts."""

from __future__ import annotations

import pytest

from granwave.lammps_inputs.case.material import material
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.impact_input import energy_unit, inputs_of_packing
from granwave.workflows import load_case, run_case


def test_inputs_are_those_of_the_summary(tmp_path):
    case = load_case(
        "fcc-small", {"packing.size": [4, 4, 3], "run.end_time": 2e-5, "load.spheres": 3}
    )
    inputs = inputs_of_packing(assemble(case))
    summary = run_case(case, tmp_path, figures=False).summary
    assert inputs.energy == pytest.approx(summary["energy_input_J"], rel=1e-12)
    assert inputs.energy_normalised == pytest.approx(summary["energy_input_normalised"], rel=1e-12)
    assert inputs.velocity_normalised == pytest.approx(summary["velocity_normalised"], rel=1e-12)
    # brass, 10 mm: sigma_y^2 D^3/E = (550e6)^2 1e-6 / 115e9 J
    assert energy_unit(material("brass"), 0.01) == pytest.approx(2.6304347826)
