"""Packings of parallel cylinders stay elastic under a law that yields: figures and words are made for that."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from matplotlib.text import Text

from granwave.analysis.figures.run_figures import FIGURES
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case


def test_a_crystal_of_brass_cylinders(tmp_path: Path) -> None:
    case = {
        "name": "cylinders", "material": "brass", "contact": {"friction": 0.2}, "run": {"end_time": 1e-4, "frames": 2},
        "packing": {"kind": "hexagonal", "size": [4, 4], "shape": "cylinder", "diameter": 0.01, "length": 0.02},
    }  # fmt: skip
    run_case(case_from_dict(case), tmp_path / "run", figures=False)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["plastic_zone_volume_m3"] is None and summary["wave_return_share"] is None
    assert summary["energy_input_normalised"] is None and summary["friction_fraction"] > 0
    with Result(tmp_path / "run") as result:
        assert not result.yields and not np.isfinite(result.law.yield_force)
        drawn = {name: figure.draw(result) for name, figure in FIGURES.items() if not name.startswith("packing_3d")}
        assert drawn["dissipation_ranked"] is drawn["plastic_zone_size"] is drawn["dissipation_parts_principal"] is None
        force = drawn["peak_force_depth"]
        values = [line.get_ydata() for axes in force.figure.axes for line in axes.lines]
        assert any(np.nanmax(one) > 0 for one in values if len(one))
        texts = [text.get_text() for one in drawn.values() if one for text in one.figure.findobj(Text)]
    assert any("cylinder" in text for text in texts) and not any("sphere" in text.lower() for text in texts)
    assert any(r"F_\mathrm{max}" in text for text in texts) and not any(r"F_\mathrm{y}" in text for text in texts)
