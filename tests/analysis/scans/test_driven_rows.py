"""Scans of loads that oscillate: the transmission leads them, and the amplitude has the unit of what is prescribed."""

from __future__ import annotations

import json

import pytest

from granwave.analysis.scans.figures import drawings
from granwave.analysis.scans.keys import key_of, means_of
from granwave.analysis.scans.result import ScanResult
from granwave.analysis.scans.table import read_scan
from tests.helpers.synthetic_scan import grid, write_scan


@pytest.fixture
def scan(tmp_path, request):
    directory = write_scan(tmp_path / "scan", grid(load__velocity=[1, 4], contact__friction=[0.3, 0.5]))
    index = json.loads((directory / "scan.json").read_text())
    index["varied"] = ["load.amplitude", "load.frequency"]
    for point in index["points"]:
        velocity, friction = point["labels"].values()
        point["labels"] = {"load.amplitude": 1e-8 * velocity, "load.frequency": 1e4 * friction}
    (directory / "scan.json").write_text(json.dumps(index))
    for point in ScanResult(directory).points:
        folder = directory / "points" / point.id
        (folder / "case.toml").write_text(f'[load]\nkind = "{request.param}"\n')
        path = folder / "summary.json"
        more = {"transmission": 1 - 1e6 * point.labels["load.amplitude"]}
        path.write_text(json.dumps(json.loads(path.read_text()) | more))
    return ScanResult(directory)


@pytest.mark.parametrize(
    ("scan", "unit", "setting"),
    [("displacement", "m", "amplitude of the load 40 nm"), ("force", "N", "amplitude of the load 4e-8 N")],
    indirect=["scan"],
)
def test_amplitude_and_transmission(scan, unit, setting):
    assert scan.units["load.amplitude"] == unit and read_scan(scan.directory).unit("load.amplitude") == unit
    means = means_of(scan)
    assert means.quantities()[0] == ("transmission", "transmission")
    assert setting in means.sentence("transmission") and "falls with amplitude" in means.sentence("transmission")
    columns = drawings(scan)["transmission_vs_load_amplitude"].columns
    assert f"load.amplitude_{unit}" in columns


@pytest.mark.parametrize(
    ("labels", "expected"),
    [([2e-3], ("mm", 2.0)), ([5e-6], ("µm", 5.0)), ([5e-9, 2e-6], ("µm", 0.005)), ([3e-10], ("nm", 0.3))],
)
def test_unit_by_size(labels, expected):
    key = key_of("load.amplitude", labels, "m")
    assert (key.naming.unit, key.values[0]) == expected
