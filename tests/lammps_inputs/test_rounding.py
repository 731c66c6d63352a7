"""Values of a summary that are due to rounding are zero wherever a summary is read."""

from __future__ import annotations

import json

from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.inputs import read_inputs
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.rounding import without_rounding
from tests.helpers.made_up.synthetic_report import write_run


def test_values_below_the_scale_of_their_kind_are_zero():
    summary = {
        "energy_input_J": 0.128, "energy_dissipated_friction_J": 1.7e-35,
        "friction_fraction": 1.35e-34, "plastic_fraction": 1e-9, "peak_force_N": 3e3,
        "wall_peak_force_N": -1e-12, "peak_overlap_m": 1e-15, "zone_cut": ["bottom"],
        "absorbed_fraction": None, "zone_resolved": True, "n_spheres": 0,
    }  # fmt: skip
    changed = {"energy_dissipated_friction_J": 0.0, "friction_fraction": 0.0}
    assert without_rounding(summary) == summary | changed | {"wall_peak_force_N": 0.0}
    assert without_rounding({}) == {}


def test_friction_by_rounding_is_no_result(tmp_path):
    """It has neither a value nor a ratio, in the summary and in comparisons."""
    folders = [
        write_run(tmp_path / name, figures=False, friction_fraction=value)
        for name, value in (("steel", 1.3543e-34), ("brass", 1.3459e-34))
    ]
    assert json.loads((folders[0] / "summary.json").read_text())["friction_fraction"] > 0
    assert ResultDirectory(folders[0]).summary()["friction_fraction"] == 0
    runs = list(read_inputs(folders, tmp_path).results())
    assert [run.summary["friction_fraction"] for run in runs] == [0, 0]
    assert "friction_fraction" not in [value.name for value in compare_runs(runs).values]
