"""Scans, and results of every kind, as functions and attributes give them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray
from matplotlib import pyplot
from matplotlib.axes import Axes

import granwave as gw
from granwave.analysis import read_scan
from granwave.analysis.errors import MissingDataError, OutputFormatError
from granwave.analysis.notebook.load import load
from granwave.lammps_inputs.files import plain
from tests.helpers.synthetic_scan import grid, write_scan


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    points = grid(load__velocity=[1.0, 5.0, 20.0], material=["brass", "steel"])
    return write_scan(tmp_path_factory.mktemp("scan"), points, failed={3: "a <b>rank</b> died"}, missing=[6])


@pytest.fixture
def scan(directory):
    return load(directory)


def test_table(scan, directory):
    table, data = scan.table, read_scan(directory)
    assert table.index.tolist() == [1, 2, 3, 4, 5, 6] and table.index.name == "point"
    for name in ("load.velocity", "peak_force_N"):
        np.testing.assert_array_equal(table[name], data[name])
        assert table.attrs["units"][name] == data.unit(name)
    assert set(table.attrs["units"]) == {"point", *table.columns}
    assert table.groupby("status").size().to_dict() == {"done": 4, "failed": 1, "missing": 1}
    assert table.loc[3, "reason"] == "a <b>rank</b> died" and table.loc[1, "material"] == "brass"
    assert scan.means is None and scan.varied == ("load.velocity", "material")


def test_points_are_runs(scan):
    runs = list(scan)
    assert len(runs) == len(scan) == 4
    assert [run.labels["load.velocity"] for run in runs] == [1.0, 1.0, 5.0, 20.0]
    assert scan[4]["peak_force_N"] == scan.table.loc[4, "peak_force_N"] == runs[2]["peak_force_N"]
    assert scan[4].labels == {"load.velocity": 5.0, "material": "steel"}
    for number, message in ((0, "has no point 0; it has 1 to 6"), (3, "point 3 is failed: a <b>"), (6, "is missing$")):
        with pytest.raises(MissingDataError, match=message):
            scan[number]


def test_text_and_html(scan, directory):
    text = repr(scan)
    assert text.startswith("scan synthetic: 6 points, 4 done") and "dissipated_fraction" in text
    assert f"{scan[1]['plastic_zone_volume_m3']:.5g}" in text and "NaN" not in text  # small values have their digits
    assert text.endswith(f"results in {directory}")
    page = scan._repr_html_()
    assert "<th>dissipated_fraction</th>" in page and "failed" in page


def test_html_is_escaped(tmp_path):
    write_scan(tmp_path, [{"name": "<u>1"}, {"name": "<u>2"}])
    page = load(tmp_path)._repr_html_()
    assert "&lt;u&gt;1" in page and "<u>" not in page


def test_figures(scan):
    assert "peak_force_vs_load_velocity" in scan.figures
    axes = scan.figure("peak_force_vs_load_velocity")
    assert isinstance(axes, Axes) and pyplot.gcf() is axes.figure and len(pyplot.get_fignums()) == 1
    pyplot.close("all")
    with pytest.raises(MissingDataError, match=r"has no figure x; figures are .*peak_force_vs_load_velocity"):
        scan.figure("x")


def test_means_over_seeds(tmp_path):
    write_scan(tmp_path, grid(load__velocity=[1.0, 5.0], packing__diameter_scatter=[1e-5], packing__seed=[1, 2, 3]))
    scan = load(tmp_path)
    means = scan.means.set_index("load.velocity")
    found = scan.table.groupby("load.velocity")["peak_force_N"].mean()
    np.testing.assert_allclose(means["peak_force_N.mean"], found, rtol=1e-12)
    assert means["n"].tolist() == [3, 3] and scan.means.attrs["units"]["peak_force_N.ci95"] == "N"


def test_grid(tmp_path):
    write_scan(tmp_path, grid(load__velocity=[1.0, 5.0], material=["brass", "steel"]))
    assert dict(load(tmp_path).to_xarray().sizes) == {"load.velocity": 2, "material": 2}


def test_damaged_index(tmp_path):
    (tmp_path / "scan.json").write_text("[")
    with pytest.raises(OutputFormatError, match=r"scan\.json cannot be read"):
        load(tmp_path)


DISC = "id,x_m,y_m,radius_m,sxx,syy,sxy\n1,0,0.005,0.005,0,-1e5,0\n"
CASE = "[material]\ndensity = 1130\n[infer]\nfriction = 0.3\nthickness = 0.02\nwalls = {floor = 0.0, top = 0.01}\n"


def test_small_waves(tmp_path):
    row, place = {"packing__size": 6}, tmp_path / "waves"
    bands = gw.bands("precompressed-chain", directory=place, **row)
    xarray.testing.assert_identical(gw.load(place), bands)
    modes = gw.modes("precompressed-chain", directory=place, **row)
    through = gw.transmission(
        "precompressed-chain", directory=place, drive=1, sensors=[3, 5], frequencies=[1e3, 2e3], **row
    )
    found = gw.load(place)
    assert list(found) == ["bands", "modes", "transmission"]
    for name, made in (("bands", bands), ("modes", modes), ("transmission", through)):
        xarray.testing.assert_identical(found[name], made)
    (place / "modes.json").write_text("{")
    with pytest.raises(OutputFormatError, match=r"modes\.json .* damaged .*granwave modes CASE"):
        gw.load(place)


def test_inferred_forces(tmp_path):
    (tmp_path / "disc.csv").write_text(DISC)
    (tmp_path / "disc.toml").write_text(CASE)
    made = gw.infer(tmp_path / "disc.csv", tmp_path / "disc.toml", directory=tmp_path / "found")
    found = gw.load(tmp_path / "found")
    assert isinstance(found, gw.InferredForces) and dict(found) == plain(dict(made))
    assert np.array_equal(found.forces["normal_force_N"], made.forces["normal_force_N"]) and found.measurement is None
    assert "2 of them bear a force" in repr(found)
    (tmp_path / "found" / "forces.csv").unlink()
    with pytest.raises(OutputFormatError, match=r"forces\.csv or grains\.csv cannot be read"):
        gw.load(tmp_path / "found")
