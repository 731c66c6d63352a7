"""Sensors, misaligned strikers and scattered diameters in square packings; lighter spheres in chains: small runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import granwave as gw
from tests.helpers.scripts import row, study_of

#: A packing of 8 x 10 that the strikers hit between X1Y5 and X1Y6; sensors beside each other, and at both edges.
SMALL = {
    "packing.size": [8, 10],
    "striker.1.touches": [33, 41],
    "striker.2.touches": 81,
    "sensor": [{"name": name, "id": one} for name, one in (("1A", 36), ("1B", 44), ("2A", 57), ("2B", 17))],
    "run.end_time": 3.2e-4,
    "run.frames": 2,
}


def runs(name: str, directory: Path, *changes: dict[str, Any]) -> list[gw.Run]:
    return [gw.run(name, one, directory=directory / str(n), progress=False) for n, one in enumerate(changes)]


def test_twin_sensors(tmp_path: Path) -> None:
    scatter = {"striker.2.misalignment": [0, 1e-3, 0]}
    seeds = [SMALL | scatter | {"packing.seed": seed} for seed in range(1, 5)]
    found = study_of("square_packing/twin_sensors.py", runs("square-in-plane", tmp_path, SMALL, *seeds))
    where = "1A and 1B (central chains, in-plane)"
    delay, peak = (row(found, f"Scatter of the {name}, {where}") for name in ("delay", "peak acceleration"))
    assert delay.kind == peak.kind == "alone", "how much strikes miss is ours, not the source's"
    assert "68" in delay.remark and "10" in peak.remark
    assert 0.5 < delay.ours < 5 and 3 < peak.ours < 10
    mean = row(found, f"Mean delay, {where}")
    assert (mean.source, mean.ours, mean.theory) == (-21, None, 0) and "1.2 standard errors" in mean.remark
    (picture,) = found.pictures
    data = picture.drawing.columns
    ideal = [n for n, setting in enumerate(data["setting"]) if setting == "ideal"]
    assert len(ideal) == 2 and all(abs(data["delay_us"][n]) < 1e-3 for n in ideal)
    assert len(found.verdict) == 2


def test_lighter_spheres_with_sensors(tmp_path: Path) -> None:
    lighter = {"index": [36, 44, 57, 17], "material": {"preset": "stainless-steel-316", "density": 6000}}
    changes = [SMALL, SMALL | {"replace": [lighter]}]
    sensors = [{"name": "2C", "id": 9}, {"name": "1C", "id": 38}, {"name": "1D", "id": 40}]
    made = runs("square-in-plane", tmp_path, *(one | {"sensor": [*SMALL["sensor"], *sensors]} for one in changes))
    found = study_of("square_packing/sensors_in_square.py", made)
    first, twin = (
        row(found, f"Change of peak velocity, sensor {name}, 0.75 of the others' mass").ours for name in ("1A", "1B")
    )
    assert first == pytest.approx(twin, rel=1e-3) and 0 < first < 25, "a lighter sphere is faster"
    assert len(found.pictures) == 1


@pytest.mark.validation
def test_scattered_diameters_slow_weak_waves_more(tmp_path: Path) -> None:
    thin = SMALL | {"packing.size": [12, 2], "striker.1.touches": [1, 13], "striker.2.touches": 25, "sensor": []}
    changes = [
        thin
        | {"packing.diameter_scatter": scatter, "striker.2.velocity": [v, 0, 0], "run.end_time": end, "run.frames": 161}
        for scatter in (0.0, 2e-6)
        for v, end in ((0.03, 1.9e-3), (0.3, 8e-4), (3.0, 4e-4))
    ]
    found = study_of("square_packing/defects.py", runs("square-in-plane", tmp_path, *changes))
    kinds = {row.kind: row for row in found.rows}
    assert kinds["verification"].ours == pytest.approx(1 / 6, abs=2e-3)
    assert kinds["source"].source == 0.25 and kinds["source"].ours > 0.2
    assert kinds["alone"].ours > 0.3  # where gaps are large beside the overlaps


def test_lighter_spheres_hardly_change_what_a_load_cell_reads(tmp_path: Path) -> None:
    steel = {"preset": "stainless-steel-316"}
    short = {"packing.size": 10, "run.end_time": 7e-4}
    others = [short | {"replace": [{"index": [6], "material": steel | {"density": one}}]} for one in (7369.2, 4000)]
    wall = {"boundary.bottom": {"material": steel}}
    made = runs("load-cell-chain", tmp_path, short, *others, short | wall, others[0] | wall)
    found = study_of("square_packing/load_cell.py", made)
    assert row(found, "First peak, like spheres, load cell").ours == pytest.approx(337, rel=0.01)  # as of 20 spheres
    for end in ("load cell", "rigid wall"):
        assert abs(row(found, f"Change of the first peak, {end}, 0.921 of the mass: sphere 6").ours) < 0.3
        assert abs(row(found, f"Change of its width, {end}, 0.921 of the mass: sphere 6").ours) < 0.3
    assert row(found, "Change of the first peak, load cell, 0.5 of the mass: sphere 6").ours < -1


def test_a_lighter_sphere_in_a_chain_reflects_little(tmp_path: Path) -> None:
    found = study_of("square_packing/sensor_chain.py", runs("sensor-chain", tmp_path, {}))
    solid, sensor, ratio, reflected = found.rows
    assert (solid.source, sensor.source, ratio.source) == (28.79, 26.52, 92.0)
    assert ratio.ours == pytest.approx(92.1, abs=0.05)
    assert reflected.source == 1.2 and 0.5 < reflected.ours < 1.2
    assert reflected.bound and reflected.deviation is None, "the source: less than 1.2 %"
