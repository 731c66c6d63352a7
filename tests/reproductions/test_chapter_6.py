"""Confined rows of the thesis, chapter 6: sizes, equations of symmetric motion beside LAMMPS, asymptotic theory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.study_file import load_study
from tests.helpers.scripts import FOLDER, study_of

CHAPTER = FOLDER / "thesis" / "chapter_6"
waves, theory, yielding = (
    load_study(str(CHAPTER / f"confined_{name}.py")) for name in ("waves", "asymptotics", "yielding")
)


def run_of(case: str, directory: Path, beads: int, **changes: Any) -> gw.Run:
    keys = {"packing.size": beads, "grains.1.repeat.times": beads - 1, "hold.1.index": [1, beads]} | changes
    return gw.run(case, keys, directory=directory, progress=False)


def test_sizes_constants_and_balance() -> None:
    """Check values of an independent program; legends follow from a balance without rings, but for 12.5 and 18.4."""
    study = study_of("thesis/chapter_6/confined_sizes.py", [None])  # type: ignore[list-item]
    checked = [row for row in study.rows if row.verification]
    assert len(checked) == 4 * 7 + 4 and all(abs(row.deviation or 0.0) < 3e-4 for row in checked)
    legends = [row for row in study.rows if row.quantity.startswith("a of the legends")]
    assert sum(f"{row.theory:.2g}" != f"{row.source:.2g}" for row in legends) == 2
    assert "printed balance needs 0.00191, the right one 0.00134" in legends[7].remark


def test_small_spheres_in_balance() -> None:
    row = waves.Rows.fitting([8, 6], 1.9e-3)
    assert (row.inward > 0).all() and (row.inward < row.shrinks).all()
    assert np.abs(row.outward(row.inward)) == pytest.approx(0, abs=1e-9)


def test_waves_of_an_independent_program() -> None:
    """Forces at contacts 21 and 51, and a decay that similarity of the wave makes uniform."""
    row = waves.Rows.fitting([8, 8, 9], [0.0, 1.9e-3, 1.2e-3])
    force, time = waves.leading_wave(row, 1.0, struck=10, last=51)
    scaled = 1e4 * force / waves.FORCE
    assert scaled[:, [20, 50]] == pytest.approx(np.array([[3.208, 2.499], [1.316, 1.266], [1.587, 1.547]]), abs=1.5e-3)
    assert -np.diff(np.log(scaled[0, [30, 40, 50]])) / 10 == pytest.approx(8.33e-3, rel=0.01)
    assert 10 * 0.015 / np.diff(time[1:, [40, 50]]).ravel() == pytest.approx([637.6, 676.5], rel=2e-3)


def test_similar_rows() -> None:
    """Velocity, precompression and force that go together, in the equations."""
    row = waves.Rows.fitting([8, 8], [4.8e-4, 4.8e-4 * 2**0.8])
    force, _ = waves.leading_wave(row, [1.0, 2.0], struck=10, last=40)
    assert np.log2(force[1, 39] / force[0, 39]) == pytest.approx(1.2, abs=3e-3)


def test_a_run_beside_the_equations(tmp_path: Path) -> None:
    changes = {"load.index": [4], "precompression": {"kind": "walls", "tube": 9e-6}, "run.end_time": 6e-4}
    run = waves.ConfinedRun(run_of("confined-row", tmp_path, 32, **changes))
    assert (run.n, run.struck) == (8, 4) and run.a == pytest.approx(1.2e-3) and run.passed > 20
    assert run.inward == pytest.approx(run.rows.inward[0], rel=1e-4)
    force, time = waves.waves_of([run])
    assert run.peaks[7:20] == pytest.approx(force[0, 7:20], rel=1e-3)
    assert run.times[19] - run.times[9] == pytest.approx(time[0, 19] - time[0, 9], rel=1e-3)


def test_asymptotic_theory() -> None:
    """Values of an independent program, and tails that vanish with precompression."""
    limit = theory.LightSpheres(waves.Rows.fitting(8))
    assert limit.eta_hat == pytest.approx(0.5286, abs=1e-4)
    low, high = (theory.Travelling(limit, one) for one in (0.2, 0.4))
    coefficients, speed = low.series()
    assert coefficients == pytest.approx([2.0988, 0.1587, -0.0037], abs=2e-4)
    assert speed == pytest.approx(1.0217, abs=1e-4) and speed == pytest.approx(low.speed, rel=3e-4)
    z = np.linspace(-3, 3, 31)
    assert theory.series_at(z, coefficients) == pytest.approx(low.displacement(z), abs=4e-3)
    assert low.tails == pytest.approx([1.91, 0.154], rel=0.01) and high.tails == pytest.approx([1.15, 0.042], rel=0.02)
    assert low.energy_decay > 2 * high.energy_decay > 0


def test_rows_that_yield(tmp_path: Path) -> None:
    pushes = [[0, 0], [1e-5, 3467], [2e-5, 0], [2e-4, 0], [2.1e-4, 3467], [2.2e-4, 0]]
    changes = {
        "load.table": pushes, "load.index": [4], "run.end_time": 4.2e-4, "run.timestep": 5e-8, "contact.law": "hertz",
        "output.probes": [{"contact": [8, 9]}, {"contact": [12, 13]}],
    }  # fmt: skip
    plastic = run_of("confined-steel", tmp_path / "plastic", 24, **changes | {"contact.law": "elastoplastic"})
    elastic = run_of("confined-steel", tmp_path / "elastic", 24, **changes)
    (found,) = yielding.select([plastic, elastic])
    assert [run.words for run in found] == ["elastic, a = 0", "yielding, a = 0"]
    assert all((run.contacts == [8, 12]).all() for run in found)
    first, second = (np.array([run.pulses[k] for run in found]) for k in (0, 1))
    assert (first[1] < 0.6 * first[0]).all() and (second > 0).all()
