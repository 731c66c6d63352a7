"""Rows of spheres with cylinders between walls, beside equations of symmetric motion and their check values."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.summary_table import summary_table
from granwave.measures import GrainRow, first_peak, largest_of_pulses, push_starts
from granwave.workflows import load_case
from tests.helpers.symmetric_row import SymmetricRow, elliptic_stiffness, line_force

N = 20
SHORT = {
    "packing.size": N, "hold.1.index": [1, N], "guide.1.index": {"first": 2, "last": N - 1}, "load.index": [4],
    "run.end_time": 2.2e-4,
}  # fmt: skip


def run(name: str, directory: Path, **changes: Any) -> GrainRow:
    found = gw.run(name, changes, directory=directory, figures=False, progress=False)
    assert found["energy_balance_error"] < 3e-6
    return GrainRow(found)


def wall_force(row: GrainRow) -> float:
    """Force of a wall on a cylinder before the wave, N."""
    return float(row.array("walls/xlo/force")[0] / (len(row.beside) / 2))


def of_sensor(row: GrainRow) -> float:
    """First peak of the sensor in sphere 21, which reads the mean of its two contact forces, N."""
    before, behind = (row.contact_forces[contact] for contact in (20, 21))
    return first_peak(row.array("probes/time"), (before + behind) / 2, floor=0.05)[1]


def compare(row: GrainRow, tolerance: float) -> None:
    """Peaks of all contacts that the wave has passed, against the second solver."""
    peaks, arrivals = SymmetricRow.of(row.case).struck(3, 1.0, 2.2e-4)
    last = int(np.flatnonzero(arrivals < 2e-4).max())
    assert last > 10
    assert row.of_contacts("peak_force")[3:last] == pytest.approx(peaks[3:last], rel=tolerance)


def test_check_values_of_the_source() -> None:
    brass = 115e9 / (1 - 0.3**2)
    assert line_force(1e-6, 1 / (math.pi * brass), 9.525e-3, 4.76e-3) == pytest.approx(266.272, rel=1e-6)
    assert line_force(1e-26, 1 / (math.pi * brass), 9.525e-3, 4.76e-3) == 0.0
    assert elliptic_stiffness(brass / 2, 1 / 4.7625e-3, 1 / 4.7625e-3 + 1 / 2.38e-3) == pytest.approx(
        4.528092e9, rel=1e-6
    )


def test_row_between_pressed_walls(tmp_path: Path) -> None:
    """Other cylinders, and another approach of the walls."""
    changes = SHORT | {"grains.1.diameter": 4.0e-3, "grains.1.length": 7e-3, "precompression.x": 5e-6}
    row = run("filter-row", tmp_path, **changes)
    assert wall_force(row) == pytest.approx(SymmetricRow.of(row.case).wall_force()[N // 2], rel=1e-6)
    compare(row, 1e-3)


@pytest.mark.validation
def test_row_between_walls_that_just_touch(tmp_path: Path) -> None:
    """The foot of the wave is far below the rounding of places: the line law must not fail there."""
    compare(run("filter-row-touching", tmp_path, **SHORT), 2e-3)


def test_static_state_between_walls(tmp_path: Path) -> None:
    """Force of a wall on a cylinder, shift of a cylinder and its overlap with the wall."""
    row = run("filter-row", tmp_path, **SHORT | {"run.end_time": 2e-6})
    found = (wall_force(row), row.inward, 3.81e-6 - row.inward)
    assert found == pytest.approx((29.668, 3.60653e-6, 2.0347e-7), rel=2e-5)
    law = row.law_between(1, N + 1)
    assert 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius) == pytest.approx(4.198584e9, rel=1e-6)


def test_open_gap_that_cylinders_bridge(tmp_path: Path) -> None:
    """First peak behind one open gap, of an independent solver; friction takes a fifth of it."""
    smooth, rubbed = (
        run("gap-switch", tmp_path / str(f), **{"run.end_time": 3.45e-4, "boundary.friction": f}) for f in (0.0, 0.185)
    )
    assert of_sensor(smooth) == pytest.approx(85.73, rel=5e-3)
    assert of_sensor(rubbed) == pytest.approx(66.72, rel=2e-2)
    summary = rubbed.run.summary
    assert summary["energy_dissipated_wall_J"] >= 0
    assert summary["n_cylinders"] == 2 and "grains                      29" in summary_table(summary)


@pytest.mark.validation
@pytest.mark.parametrize(("upstream", "peak"), [(True, 87.77), (False, 103.69)])
def test_loose_cylinders(tmp_path: Path, upstream: bool, peak: float) -> None:
    grains = load_case("gap-switch-loose").packing.grains
    assert grains is not None
    x, y, z = grains.position[-2]
    z = z if upstream else 27 * 9.5e-3 - z  # the other sphere of the same gap
    row = run("gap-switch-loose", tmp_path, **{"grains.1.at": [[x, y, z], [-x, y, z]], "run.end_time": 3.45e-4})
    assert of_sensor(row) == pytest.approx(peak, rel=1e-3)


def test_row_between_walls_after_a_strong_pulse(tmp_path: Path) -> None:
    """Dents of a strong pulse let more of a weak one through, and slacken the walls."""
    weak = [[0, 0], [1e-4, 0], [1.05e-4, 706], [1.1e-4, 0]]
    changes = SHORT | {
        "load": {"kind": "force", "index": [4], "shape": "table", "table": weak}, "contact.law": "elastoplastic",
        "output.probes": [{"contact": [5, 6]}, {"contact": [8, 9]}], "output.probe_interval": 1e-6,
    }  # fmt: skip
    del changes["load.index"]
    whole = run("filter-row", tmp_path / "whole", **changes)
    changes["load"] |= {"table": [[0, 0], [5e-6, 3530], [1e-5, 0], *weak[1:]]}
    after = run("filter-row", tmp_path / "after", **changes)
    assert (push_starts(whole.load.table), push_starts(after.load.table)) == ([1e-4], [0.0, 1e-4])
    _, dented = largest_of_pulses(after.array("probes/time"), after.contact_forces[8], 1e-4)
    assert 0.0 < whole.contact_forces[8].max() < 0.5 * dented
    for row, low, high in ((whole, 1 - 1e-6, 1 + 1e-6), (after, 0.0, 0.98)):
        time, force = row.array("walls/xlo/time"), row.array("walls/xlo/force")
        before = force[(time >= 8e-5) & (time <= 1e-4)].mean() / force[0]
        assert low < before < high
