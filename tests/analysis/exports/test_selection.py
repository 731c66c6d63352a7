"""Selected rows of exports and tables: by spheres, layers, depth, region and time."""

from __future__ import annotations

import numpy as np
import pytest

import granwave as gw
from granwave.analysis import Result, analyse
from granwave.analysis.exports.export import export
from granwave.analysis.exports.selection import selection
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import is_scan
from tests.helpers.made_up import synthetic, synthetic_scan
from tests.helpers.made_up.export_inputs import write_chain_run, write_walled_run

TIME = synthetic.TIMESTEP

NEEDS = pytest.mark.needs_extension("pictures")
pytestmark = pytest.mark.xdist_group("export_selection")  # its fixtures are made once


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    place = write_walled_run(tmp_path_factory.mktemp("run"))
    analyse(place, figures=False)
    return place


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    return write_chain_run(tmp_path_factory.mktemp("chain") / "run")


def rows(path):
    return np.atleast_1d(
        np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    )


def names(paths):
    return {path.name for path in paths}


def test_rows_by_sphere_and_layer(run, tmp_path):
    export(run, "csv", tmp_path, selected=selection(spheres=[3, 20]))
    assert rows(tmp_path / "spheres.csv")["id"].tolist() == [3, 20]
    contacts = rows(tmp_path / "contacts.csv")
    with Result(run) as result:
        touching = np.isin(result["contacts/i"], [3, 20]) | np.isin(result["contacts/j"], [3, 20])
        assert touching.any() and np.array_equal(contacts["i"], result["contacts/i"][touching])
        depth = np.unique(result["spheres/position"][:, 2].round(9))
        second = result["spheres/position"][:, 2].round(9) == depth[1]
        in_layer = result["spheres/id"][second]
    export(run, "csv", tmp_path, only=["spheres"], selected=selection(layers=2))
    assert rows(tmp_path / "spheres.csv")["id"].tolist() == in_layer.tolist()


def test_only_tables_with_a_selection_are_written(run, tmp_path):
    placed = export(run, "csv", tmp_path / "place", selected=selection(layers=[1]))
    assert "energy.csv" not in names(placed) and "snapshot_0001.csv" in names(placed)
    assert len(rows(tmp_path / "place" / "snapshot_0001.csv")) < 144
    placed = export(run, "csv", tmp_path / "time", selected=selection(time=(0, 250.0 * TIME)))
    assert "contacts.csv" not in names(placed) and "walls_bottom.csv" in names(placed)
    assert rows(tmp_path / "time" / "snapshots.csv")["frame"].tolist() == [0, 1]
    assert rows(tmp_path / "time" / "energy.csv")["time_s"].max() <= 250.0 * TIME * (1 + 1e-9)
    placed = export(run, "csv", tmp_path / "both", ["energy", "spheres"], selection(layers=[1]))
    assert names(placed) == {"energy.csv", "spheres.csv"}


def test_snapshots_of_an_earlier_export_go(run, tmp_path):
    export(run, "csv", tmp_path)
    export(run, "csv", tmp_path, selected=selection(time=(0, 0)))
    assert names(tmp_path.glob("snapshot_*.csv")) == {"snapshot_0000.csv"}
    assert (tmp_path / "contacts.csv").exists()


def test_places_are_those_of_the_contacts(run):
    loaded = gw.load(run)
    contacts = loaded.contacts
    low, high = contacts["depth"].quantile([0.2, 0.6])
    by_depth = loaded.select("contacts", depth=(low, high))
    assert by_depth.equals(contacts[contacts["depth"].between(low - 1e-12, high + 1e-12)])
    x, y, z = loaded.spheres.loc[40, ["position_x", "position_y", "position_z"]]
    near = loaded.select("spheres", region=f"sphere {x} {y} {z} 0.0101")
    places = loaded.spheres[["position_x", "position_y", "position_z"]]
    inside = np.linalg.norm(places - [x, y, z], axis=1) <= 0.0101
    assert near.index.tolist() == loaded.spheres.index[inside].tolist() and len(near) > 1


def test_region_outside(run):
    loaded = gw.load(run)
    outside = loaded.select("spheres", region="sphere 0 0 0 0.0201 side out")
    inside = loaded.select("spheres", region="sphere 0 0 0 0.0201")
    assert len(outside) + len(inside) == len(loaded.spheres) and len(inside)
    upper = loaded.select("spheres", region="block INF INF INF INF INF 0.001")
    assert upper["position_z"].eq(0).all() and len(upper) < len(loaded.spheres)


def test_walls_by_time(run):
    loaded = gw.load(run)
    last = loaded.walls["time"].max()
    part = loaded.select("walls", time=(last / 2, last))
    assert part["time"].min() >= last / 2 * (1 - 1e-9) and len(part) < len(loaded.walls)


def test_history_of_a_chain(chain, tmp_path):
    export(chain, "csv", tmp_path, ["chain"], selection(spheres=[2, 3]))
    with Result(chain) as result:
        column = result["chain/id"].tolist().index(3)
        velocity = rows(tmp_path / "chain_velocity.csv")
        assert velocity.dtype.names == ("time_s", "bead_2_m_s", "bead_3_m_s")
        assert np.array_equal(velocity["bead_3_m_s"], result["chain/velocity"][:, column])
    assert "contact_2_3_N" in rows(tmp_path / "chain_contact_force.csv").dtype.names


def test_netcdf_has_selected_rows(run, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    wanted = selection(spheres=[3, 20], time=(250 * TIME, 500 * TIME))
    export(run, "netcdf", tmp_path, selected=wanted)
    with xarray.open_dataset(tmp_path / "result.nc") as data, Result(run) as result:
        assert data["sphere"].values.tolist() == [3, 20]
        assert data["frame"].values.tolist() == [1, 2]
        expected = result.frame(2, "displacement")[[2, 19]]
        assert np.array_equal(data["frame_displacement"].values[1], expected)


@NEEDS
def test_paraview_has_selected_spheres(run, tmp_path):
    io = pytest.importorskip("vtkmodules.vtkIOXML", reason="VTK is not installed")
    placed = export(run, "vtp", tmp_path, selected=selection(spheres=[3, 20], time=(0, 0)))
    assert "spheres_0000.vtp" in names(placed) and "spheres_0001.vtp" not in names(placed)
    reader = io.vtkXMLPolyDataReader()
    reader.SetFileName(str(tmp_path / "spheres_0000.vtp"))
    reader.Update()
    assert reader.GetOutput().GetNumberOfPoints() == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"layers": 99}, "layers: found 99, expected numbers from 1 to"),
        ({"spheres": [1, 9999]}, "spheres: found 9999, expected ids"),
        ({"spheres": []}, "expected whole numbers from 1 up"),
        ({"layers": 1.5}, "expected whole numbers from 1 up"),
        ({"depth": (0.02, 0.01)}, "expected the lower and the upper bound"),
        ({"depth": (5.0, 6.0)}, "no sphere and no contact is there"),
        ({"time": (5.0, 6.0)}, "expected times between 0 and"),
        ({"region": "ball 0 0 0 1"}, "arguments of the LAMMPS region command"),
        ({"only": "energy", "layers": 1}, "layers: does not apply to energy, only to spheres"),
        pytest.param({"to": "ovito", "layers": 1}, "exports a run as a whole", marks=NEEDS),
    ],
)
def test_wrong_selections(run, tmp_path, words, message):
    with pytest.raises(InputError, match=message):
        gw.export(run, words.pop("to", "csv"), tmp_path / "out", **words)
    assert not list(tmp_path.rglob("*.csv"))


def test_scans_have_no_rows_to_select(tmp_path):
    points = synthetic_scan.grid(load__velocity=[1, 2.5])
    scan = synthetic_scan.write_scan(tmp_path / "scan", points)
    assert is_scan(scan)
    with pytest.raises(InputError, match="is exported as a single table; remove layers"):
        gw.export(scan, "csv", layers=1)
