"""Square packings that are not ideal: twin sensors, scattered diameters; a chain on a load cell."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.measures.chains.hertz_chain import discrete_width
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.defects import Speeds
from granwave.analysis.studies.square.defects import rows as rows_of_speeds
from granwave.analysis.studies.study import Study, make_studies
from granwave.lammps_inputs.load_case import load_case
from granwave.workflows import run_case

CASES = Path(__file__).parents[3] / "workflows" / "cases"
#: A packing of 8 x 10 that the strikers hit between X1Y5 and X1Y6; sensors beside each other, and at both edges.
SMALL = {
    "packing.size": [8, 10],
    "striker.1.touches": [33, 41],
    "striker.2.touches": 81,
    "sensor": [{"name": name, "id": one} for name, one in (("1A", 36), ("1B", 44), ("2A", 57), ("2B", 17))],
    "run.end_time": 3.2e-4,
    "run.frames": 2,
}


def study(name: str, case: str, directory: Path, *changes: dict[str, Any]) -> Study:
    runs = []
    for n, change in enumerate(changes):
        read = load_case(CASES / f"{case}.toml", change)
        runs.append(
            FinishedRun(str(n), directory / str(n), read, run_case(read, directory / str(n), figures=False).summary)
        )
    (found,) = make_studies({name: runs})
    return found


def test_twin_sensors(tmp_path: Path) -> None:
    scatter = {"striker.2.misalignment": [0, 1e-3, 0]}
    seeds = [SMALL | scatter | {"packing.seed": seed} for seed in range(1, 5)]
    found = study("twin-sensors", "square-in-plane", tmp_path, SMALL, *seeds)
    rows = {row.quantity: row for row in found.rows}
    where = "(central chains, in-plane)"
    delay = rows[f"Scatter of the delay, 1A and 1B {where}: striker off centre within 1 mm"]
    peak = rows[f"Scatter of the peak acceleration, 1A and 1B {where}: striker off centre within 1 mm"]
    assert delay.kind == peak.kind == "alone", "how much strikes miss is ours, not the source's"
    assert "68" in delay.remark and "10" in peak.remark
    assert 0.5 < delay.ours < 5 and 3 < peak.ours < 10
    mean = rows[f"Mean delay, 1A and 1B {where}"]
    assert (mean.source, mean.ours, mean.theory) == (-21, None, 0) and "1.2 standard errors" in mean.remark
    (table,) = found.tables
    ideal = [row for row in table.rows if row[1].text == "ideal"]  # type: ignore[union-attr]
    assert len(ideal) == 2 and all(abs(float(row[4].value or 0)) < 1e-3 for row in ideal)
    assert len(found.pictures) == 1 and len(found.verdict) == 2


@pytest.mark.validation
def test_scattered_diameters_slow_weak_waves_more(tmp_path: Path) -> None:
    thin = SMALL | {"packing.size": [12, 2], "striker.1.touches": [1, 13], "striker.2.touches": 25, "sensor": []}
    changes = [
        thin
        | {"packing.diameter_scatter": scatter, "striker.2.velocity": [v, 0, 0], "run.end_time": end, "run.frames": 161}
        for scatter in (0.0, 2e-6)
        for v, end in ((0.03, 1.9e-3), (0.3, 8e-4), (3.0, 4e-4))
    ]
    found = study("defects-speed", "square-in-plane", tmp_path, *changes)
    kinds = {row.kind: row for row in found.rows}
    assert kinds["verification"].ours == pytest.approx(1 / 6, abs=2e-3)
    assert kinds["source"].source == 0.25 and kinds["source"].ours > 0.2
    assert kinds["alone"].ours > 0.3  # where gaps are large beside the overlaps


def test_powers_of_speed_are_those_of_neighbouring_loads() -> None:
    load = np.array([1.0, 10.0, 100.0])
    one = Speeds("fcc under pressure", 1e-5, load, 200 * np.array([1.0, 10**0.25, 10 ** (0.25 + 1 / 6)]), static=True)
    np.testing.assert_allclose(one.local, [0.25, 1 / 6])
    assert [row.ours for row in rows_of_speeds([one])] == pytest.approx([5 / 24, 0.25, 1 / 6])


def test_lighter_spheres_hardly_change_what_a_load_cell_reads(tmp_path: Path) -> None:
    light = {"material": {"preset": "stainless-steel-316", "density": 7369.2}}
    short = {"packing.size": 10, "run.end_time": 7e-4}
    half = light | {"material": light["material"] | {"density": 4000}}
    changes = [short, *(short | {"replace": [one | {"index": [6]}]} for one in (light, half))]
    found = study("load-cell", "load-cell-chain", tmp_path, *changes)
    rows = {row.quantity: row.ours for row in found.rows}
    assert rows["First peak, like spheres, load cell"] == pytest.approx(337, rel=0.01)  # as of 20 spheres
    assert abs(rows["Change of the first peak, load cell, 0.921 of the mass: sphere 6"]) < 0.3
    assert abs(rows["Change of its width, load cell, 0.921 of the mass: sphere 6"]) < 0.3
    assert rows["Change of the first peak, load cell, 0.5 of the mass: sphere 6"] < -1


def test_width_of_the_wave_of_the_chain_itself() -> None:
    assert discrete_width() == pytest.approx(1.5791, abs=1e-4)  # runs of chains give 1.579
