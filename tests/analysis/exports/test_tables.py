"""Exports to CSV and NetCDF: values read by other programs are bitwise identical to those of
result.h5.
"""

from __future__ import annotations

import json
import tomllib
from importlib.metadata import version
from importlib.util import find_spec

import numpy as np
import pytest
from packaging.version import Version

from granwave.analysis import Result, write_result
from granwave.analysis.exports.export import export
from granwave.analysis.scans.table import read_scan
from tests.helpers.made_up import synthetic, synthetic_scan
from tests.helpers.made_up.export_inputs import (
    equal,
    write_chain_run,
    write_periodic_run,
    write_walled_run,
)

TABLES = ("spheres", "contacts", "wall_contacts", "energy")
UNITS = {"J": "_J", "N": "_N", "m": "_m", "s": "_s", "kg": "_kg", "m s-1": "_m_s", "1": ""}
#: Options of pandas.read_csv for exact values; from version 3.1 on its default is exact.
EXACT = (
    {}
    if find_spec("pandas") and Version(version("pandas")) >= Version("3.1")
    else {"float_precision": "round_trip"}
)
TIMES = np.array([0, 250, 500, 1000]) * synthetic.TIMESTEP

pytestmark = pytest.mark.xdist_group("export_tables")  # its fixtures are made once


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_walled_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def periodic(tmp_path_factory):
    return write_periodic_run(tmp_path_factory.mktemp("periodic") / "it's a run")


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    return write_chain_run(tmp_path_factory.mktemp("chain") / "run")


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    points = synthetic_scan.grid(load__velocity=[1, 2.5], material=["brass", "steel"])
    return synthetic_scan.write_scan(
        tmp_path_factory.mktemp("scan"), points, failed={2: "it broke"}, missing=[4]
    )


# ------------------------------------------------------------------------------------------------ csv


def csv_columns(result, group):
    """Expected contents of a table, by column."""
    found = {}
    for name in result.names(group):
        values = result[f"{group}/{name}"]
        suffix = UNITS[result.unit(f"{group}/{name}")]
        parts = (
            {f"{name}_{axis}": values[:, n] for n, axis in enumerate("xyz")}
            if values.ndim == 2
            else {name: values}
        )
        found |= {part + suffix: column for part, column in parts.items()}
    return found


def test_csv_gives_every_bit_back_in_pandas(run, tmp_path):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    files = export(run, "csv", tmp_path / "out")
    with Result(run) as result:
        for group in TABLES:
            table = pandas.read_csv(tmp_path / "out" / f"{group}.csv", **EXACT)
            expected = csv_columns(result, group)
            assert set(table.columns) == set(expected)
            for name, values in expected.items():
                assert equal(table[name].to_numpy(), values), (group, name)
        assert table.columns[:2].tolist() == ["step", "time_s"]
        wall = pandas.read_csv(tmp_path / "out" / "walls_bottom.csv", **EXACT)
        assert equal(wall["force_N"], result["walls/bottom/force"]) and equal(
            wall["time_s"], result["walls/bottom/time"]
        )
    assert {path.name for path in files} == {path.name for path in (tmp_path / "out").glob("[!.]*")}


def test_csv_of_snapshots(run, tmp_path):
    export(run, "csv", tmp_path)
    index = np.genfromtxt(
        tmp_path / "snapshots.csv", delimiter=",", names=True, dtype=None, encoding="utf-8"
    )
    assert index["step"].tolist() == [0, 250, 500, 1000]
    assert np.allclose(index["time_s"], TIMES, rtol=1e-15)
    ids = np.arange(1, 145)
    for m, name in enumerate(index["file_name"]):
        table = np.genfromtxt(tmp_path / name, delimiter=",", names=True)
        assert equal(table["displacement_x_m"], m * ids * 1e-9)
        with Result(run) as result:
            assert equal(table["position_y_m"], result.frame(m, "position")[:, 1])
            assert equal(table["velocity_z_m_s"], result.frame(m, "velocity")[:, 2])
            assert equal(table["peak_force_N"], result.frame(m, "peak_force"))


def test_csv_in_parts_is_the_same(run, tmp_path, monkeypatch):
    whole = [path.read_bytes() for path in export(run, "csv", tmp_path / "whole")]
    monkeypatch.setattr("granwave.analysis.exports.to_tables._ROWS", 7)
    assert [path.read_bytes() for path in export(run, "csv", tmp_path / "parts")] == whole


def test_csv_of_probes_has_units(periodic, tmp_path):
    export(periodic, "csv", tmp_path)
    table = np.genfromtxt(tmp_path / "probes.csv", delimiter=",", names=True)
    with Result(periodic) as result:
        assert equal(table["sphere_12_vz_m_s"], result["probes/sphere_12_vz"])
        assert equal(table["contact_7_23_overlap_m"], result["probes/contact_7_23_overlap"])
    steps = [line.split(",")[0] for line in (tmp_path / "probes.csv").read_text().splitlines()]
    assert steps[0] == "step" and all(step.isdecimal() for step in steps[1:])  # 16, not 16.0


def test_csv_of_a_chain_and_its_bar(chain, tmp_path):
    export(chain, "csv", tmp_path)

    def table(name):
        return np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True)

    with Result(chain) as result:
        velocity = table("chain_velocity")
        force = table("chain_contact_force")
        for n, bead in enumerate(result["chain/id"]):
            assert equal(velocity[f"bead_{bead}_m_s"], result["chain/velocity"][:, n])
        pairs = list(
            zip(result["chain/contact_i"].tolist(), result["chain/contact_j"].tolist(), strict=True)
        )
        assert equal(
            force["contact_{}_{}_N".format(*pairs[2])], result["chain/contact_force"][:, 2]
        )
        assert equal(velocity["time_s"], result["chain/time"])
        assert equal(table("chain_beads")["position_m"], result["chain/position"])
        assert table("chain_contacts")[["i", "j"]].tolist() == pairs
        assert equal(table("bar_bar_force")["element_3_N"], result["bars/bar/force"][:, 2])
        assert equal(table("bar_bar_velocity")["node_1_m_s"], result["bars/bar/velocity"][:, 0])
        assert len(table("bar_bar_nodes")) == 21


# --------------------------------------------------------------------------------------------- netcdf


def test_netcdf_opens_in_xarray(run, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    (path,) = export(run, "netcdf", tmp_path)
    with xarray.open_dataset(path) as data, Result(run) as result:
        assert dict(data.sizes) == {
            "sphere": 144, "contact": len(result["contacts/i"]), "wall_contact": 1, "time": 251,
            "wall_time": 201, "frame": 4, "axis": 3,
        }  # fmt: skip
        groups = {
            "spheres": "sphere",
            "contacts": "contact",
            "wall_contacts": "wall_contact",
            "energy": "energy",
        }
        own = {"sphere_id": "sphere", "energy_time": "time"}
        for group, prefix in groups.items():
            for name in result.names(group):
                found = data[own.get(f"{prefix}_{name}", f"{prefix}_{name}")]
                expected = result[f"{group}/{name}"]
                assert equal(found.to_numpy(), expected), name
                assert expected.dtype == object or found.dtype == expected.dtype
                assert found.attrs["long_name"]
                assert expected.dtype == object or found.attrs["units"] == result.unit(
                    f"{group}/{name}"
                )
        for name in (
            "displacement",
            "velocity",
            "contact_force",
            "peak_force",
            "dissipated_energy",
        ):
            assert equal(data[f"frame_{name}"], result.file[f"particles/spheres/{name}/value"][()])
        assert data["frame_displacement"].dims == ("frame", "sphere", "axis")
        assert (
            data["frame_displacement"].dtype == np.float64
            and data["frame_velocity"].attrs["units"] == "m s-1"
        )
        assert (
            equal(data["frame_time"], result.frame_times)
            and data["frame_time"].attrs["units"] == "s"
        )
        assert set(data.coords) >= {
            "frame_time",
            "contact_i",
            "contact_j",
            "wall_contact_wall",
            "sphere",
            "time",
            "axis",
        }
        assert tomllib.loads(data.attrs["case"])["packing"]["kind"] == "fcc"
        assert json.loads(data.attrs["versions"]) == result.versions
        start = data["sphere_position"].sel(sphere=144, axis="z").item()
        moved = data["frame_displacement"].isel(frame=3).sel(sphere=144, axis="z").item()
        assert start + moved == result.frame(3, "position")[143, 2]


def test_netcdf_opens_with_the_netcdf_library(run, tmp_path):
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    (path,) = export(run, "netcdf", tmp_path)
    with netcdf.Dataset(path) as data, Result(run) as result:
        assert equal(data["contact_peak_force"][:].filled(np.nan), result["contacts/peak_force"])
        assert data["wall_contact_wall"][:].tolist() == ["bottom"]


def test_netcdf_of_a_chain_and_its_bar(chain, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    case = synthetic.make_case("chain", 5, boundary={"bottom": "free"})
    write_result(synthetic.write_run(tmp_path / "free", case))
    with xarray.open_dataset(*export(tmp_path / "free", "netcdf")) as data:
        assert (
            data.sizes["contact"] == 4
            and data.sizes["wall_contact"] == 0
            and "wall_time" not in data.sizes
        )
    (path,) = export(chain, "netcdf", tmp_path)
    with xarray.open_dataset(path) as data, Result(chain) as result:
        assert {"bead": 6, "chain_contact": 6, "bar_node": 21, "bar_element": 20}.items() <= dict(
            data.sizes
        ).items()
        assert equal(data["bead"], result["chain/id"]) and equal(
            data["chain_time"], result["chain/time"]
        )
        assert (
            equal(data["bead_velocity"], result["chain/velocity"])
            and data["bead_velocity"].units == "m s-1"
        )
        assert equal(data["chain_contact_force"], result["chain/contact_force"])
        assert equal(data["bar_element_force"], result["bars/bar/force"])
        assert equal(data["bar_node_position"], result["bars/bar/position"])


# ----------------------------------------------------------------------------------------------- scan


def test_scan_as_csv_and_netcdf(scan, tmp_path):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    (path,) = export(scan, "csv", tmp_path)
    table = pandas.read_csv(path, **EXACT)
    data = read_scan(scan)
    assert table["load.velocity_m_s"].tolist() == [1, 1, 2.5, 2.5]
    assert (
        table["status"].tolist() == ["done", "failed", "done", "missing"]
        and table["reason"][1] == "it broke"
    )
    assert equal(table["peak_force_N"], data["peak_force_N"]) and np.isnan(table["peak_force_N"][1])

    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    with xarray.open_dataset(*export(scan, "netcdf", tmp_path)) as points:
        assert points.sizes == {"point": 4} and set(points.coords) == {
            "point",
            "load.velocity",
            "material",
        }
        assert (
            points["load.velocity"].attrs["units"] == "m/s"
            and points["peak_force_N"].attrs["units"] == "N"
        )
        assert equal(points["peak_force_N"], data["peak_force_N"])
        assert points["material"].to_numpy().tolist() == ["brass", "steel"] * 2
