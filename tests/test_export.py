"""Exports: what other programs read back is what result.h5 holds, to the last bit."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from importlib.metadata import version
from importlib.util import find_spec
from xml.etree import ElementTree

import numpy as np
import pytest
from packaging.version import Version

from granwave.analysis import Result, write_result
from granwave.analysis.exports.export import FORMATS, export
from granwave.analysis.exports.staging import staged
from granwave.analysis.scan_table import read_scan
from granwave.lammps_inputs import write_deck
from granwave.lammps_inputs.errors import InputError
from tests import synthetic, synthetic_scan
from tests.conftest import BIN, PLAIN

TABLES = ("spheres", "contacts", "wall_contacts", "energy")
UNITS = {"J": "_J", "N": "_N", "m": "_m", "s": "_s", "kg": "_kg", "m s-1": "_m_s", "1": ""}
#: Of pandas.read_csv; from 3.1 on its default is exact.
EXACT = (
    {} if find_spec("pandas") and Version(version("pandas")) >= Version("3.1") else {"float_precision": "round_trip"}
)
TIMES = np.array([0, 250, 500, 1000]) * synthetic.TIMESTEP


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run that no LAMMPS made, with one contact with the wall."""
    directory = synthetic.write_run(tmp_path_factory.mktemp("run"), synthetic.make_case())
    row = np.array([[144, 0, 0, 1e-5, 50.0, 2e-4, 1e-5, 2e-5, 1.5e-5]])
    synthetic.write_custom(directory / "dumps" / "wall_bottom.dump", synthetic.WALL_COLUMNS, row, synthetic.STEPS)
    write_result(directory)
    return directory


@pytest.fixture(scope="module")
def periodic(tmp_path_factory):
    """A run of LAMMPS, some of whose contacts go through the sides."""
    directory = tmp_path_factory.mktemp("periodic") / "it's a run"
    case = synthetic.make_case(
        size=(4, 4, 4),
        boundary={"sides": "periodic"},
        run={"end_time": 4e-5, "frames": 3},
        output={"probes": [{"sphere": 12}, {"contact": [7, 23]}]},
    )
    script = write_deck(case, directory).script
    command = [str(BIN / "lmp"), "-in", script.name, "-screen", "none"]
    done = subprocess.run(command, cwd=script.parent, capture_output=True, text=True, timeout=60, env=PLAIN)
    assert done.returncode == 0, done.stdout + done.stderr
    write_result(directory)
    return directory


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    points = synthetic_scan.grid(load__velocity=[1, 2.5], material=["brass", "steel"])
    return synthetic_scan.write_scan(tmp_path_factory.mktemp("scan"), points, failed={2: "it broke"}, missing=[4])


def arrays_of(data):
    """The arrays of a vtkFieldData by name."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return {data.GetArrayName(n): vtk_to_numpy(data.GetArray(n)).copy() for n in range(data.GetNumberOfArrays())}


def read_vtp(path):
    """Points, connectivity, and the arrays of points, cells and the file, as ParaView reads them."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    cells = data.GetLines() if data.GetNumberOfLines() else data.GetVerts()
    assert data.GetNumberOfCells() == cells.GetNumberOfCells() and reader.GetErrorCode() == 0
    ends = vtk_to_numpy(cells.GetConnectivityArray()).reshape(data.GetNumberOfCells(), -1).copy()
    points = vtk_to_numpy(data.GetPoints().GetData()).copy()
    return points, ends, arrays_of(data.GetPointData()), arrays_of(data.GetCellData()), arrays_of(data.GetFieldData())


def equal(found, expected):
    return np.array_equal(found, expected, equal_nan=np.asarray(expected).dtype.kind == "f")


# ------------------------------------------------------------------------------------------------ csv


def csv_columns(result, group):
    """What a table is expected to hold, by column."""
    found = {}
    for name in result.names(group):
        values, suffix = result[f"{group}/{name}"], UNITS[result.unit(f"{group}/{name}")]
        parts = {f"{name}_{axis}": values[:, n] for n, axis in enumerate("xyz")} if values.ndim == 2 else {name: values}
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
    assert {path.name for path in files} == {path.name for path in (tmp_path / "out").iterdir()}


def test_csv_gives_every_bit_back_in_numpy(run, tmp_path):
    export(run, "csv", tmp_path)
    for group in ("spheres", "contacts"):
        path = tmp_path / f"{group}.csv"
        table = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
        with Result(run) as result:
            for name, values in csv_columns(result, group).items():
                assert equal(table[name], values), name


def test_csv_of_snapshots(run, tmp_path):
    export(run, "csv", tmp_path)
    index = np.genfromtxt(tmp_path / "snapshots.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
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
    monkeypatch.setattr("granwave.analysis.exports.to_csv._ROWS", 7)
    assert [path.read_bytes() for path in export(run, "csv", tmp_path / "parts")] == whole


def test_csv_of_probes_has_units(periodic, tmp_path):
    export(periodic, "csv", tmp_path)
    table = np.genfromtxt(tmp_path / "probes.csv", delimiter=",", names=True)
    with Result(periodic) as result:
        assert equal(table["sphere_12_vz_m_s"], result["probes/sphere_12_vz"])
        assert equal(table["contact_7_23_overlap_m"], result["probes/contact_7_23_overlap"])


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
        groups = {"spheres": "sphere", "contacts": "contact", "wall_contacts": "wall_contact", "energy": "energy"}
        own = {"sphere_id": "sphere", "energy_time": "time"}
        for group, prefix in groups.items():
            for name in result.names(group):
                found = data[own.get(f"{prefix}_{name}", f"{prefix}_{name}")]
                expected = result[f"{group}/{name}"]
                assert equal(found.to_numpy(), expected), name
                assert expected.dtype == object or found.dtype == expected.dtype
                assert found.attrs["long_name"]
                assert expected.dtype == object or found.attrs["units"] == result.unit(f"{group}/{name}")
        for name in ("displacement", "velocity", "contact_force", "peak_force", "dissipated_energy"):
            assert equal(data[f"frame_{name}"], result.file[f"particles/spheres/{name}/value"][()])
        assert data["frame_displacement"].dims == ("frame", "sphere", "axis")
        assert data["frame_displacement"].dtype == np.float64 and data["frame_velocity"].attrs["units"] == "m s-1"
        assert equal(data["frame_time"], result.frame_times) and data["frame_time"].attrs["units"] == "s"
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


def test_netcdf_of_a_run_without_walls(tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    case = synthetic.make_case("chain", 5, boundary={"bottom": "free"})
    write_result(synthetic.write_run(tmp_path, case))
    with xarray.open_dataset(*export(tmp_path, "netcdf")) as data:
        assert data.sizes["contact"] == 4 and data.sizes["wall_contact"] == 0 and "wall_time" not in data.sizes


# ------------------------------------------------------------------------------------------------ vtp


def test_vtp_holds_spheres_and_contacts(run, tmp_path):
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    export(run, "vtp", tmp_path)
    with Result(run) as result:
        i, j = result["contacts/i"], result["contacts/j"]
        toward = result["spheres/position"][j - 1] - result["spheres/position"][i - 1]
        for m in range(4):
            points, cells, values, _, field = read_vtp(tmp_path / f"spheres_{m:04d}.vtp")
            assert equal(points, result.frame(m, "position")) and equal(cells[:, 0], np.arange(144))
            assert equal(values["id"], result["spheres/id"]) and equal(values["radius"], np.full(144, 0.005))
            for name in ("displacement", "velocity", "contact_force", "peak_force", "dissipated_energy"):
                assert equal(values[name], result.frame(m, name)), name
            assert field["TimeValue"].tolist() == [result.frame_times[m]]

            points, lines, _, values, field = read_vtp(tmp_path / f"contacts_{m:04d}.vtp")
            assert equal(lines, np.stack([i, j], axis=1) - 1) and equal(points, result.frame(m, "position"))
            assert equal(values["i"], i) and equal(values["j"], j)
            for name in ("peak_force", "peak_overlap", "dissipated_energy"):
                assert equal(values[name], result[f"contacts/{name}"])
            # sphere n has moved by (m n, 0, m) nm
            closer = -m * (j - i) * 1e-9 * toward[:, 0] / np.linalg.norm(toward, axis=1)
            assert np.allclose(values["overlap"], closer, rtol=0, atol=2e-12)
            assert equal(values["loaded"], result["contacts/time_first"] <= result.frame_times[m])
        assert equal(values["yielded"], result["contacts/yielded"])
        spheres = read_vtp(tmp_path / "spheres_0003.vtp")[2]
        assert equal(spheres["contacts_yielded"], result["spheres/contacts_yielded"])
        assert not read_vtp(tmp_path / "spheres_0000.vtp")[2]["contacts_yielded"].any()


def test_vtp_collections_have_times_in_seconds(run, tmp_path):
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    files = export(run, "vtp", tmp_path)
    with Result(run) as result:
        times = result.frame_times.tolist()
    for what in ("spheres", "contacts"):
        sets = ElementTree.parse(tmp_path / f"{what}.pvd").getroot().findall("Collection/DataSet")
        assert [float(entry.get("timestep")) for entry in sets] == times
        assert all((tmp_path / entry.get("file")) in files for entry in sets)


def test_vtp_of_a_periodic_packing(periodic, tmp_path):
    """No contact crosses the packing, and overlaps are those that LAMMPS had at the end."""
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    export(periodic, "vtp", tmp_path)
    points, lines, _, values, _ = read_vtp(tmp_path / "contacts_0002.vtp")
    assert np.linalg.norm(points[lines[:, 1]] - points[lines[:, 0]], axis=1).max() < 1.01 * synthetic.DIAMETER
    with Result(periodic) as result:
        assert len(points) > result.n_spheres
        pressed = result["contacts/force"] > 0
        assert np.count_nonzero(pressed) > 20
        assert np.allclose(values["overlap"][pressed], result["contacts/overlap"][pressed], rtol=0, atol=1e-16)
        assert np.all(values["loaded"][pressed] == 1)


# ---------------------------------------------------------------------------------------------- ovito


def test_ovito_opens_spheres_and_contacts(periodic, tmp_path):
    pytest.importorskip("ovito", reason="ovito is not installed")
    (script,) = export(periodic, "ovito")
    done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    with Result(periodic) as result:
        n_loaded = int(np.count_nonzero(result["contacts/peak_overlap"] > 0))
        loaded = [int(np.count_nonzero(result["contacts/time_first"] <= time)) for time in result.frame_times]
        strongest = float(result["contacts/peak_force"].max())
        positions = result.frame(2, "position")
    assert f"{len(positions)} spheres, {n_loaded} contacts, 3 snapshots" in done.stdout

    look = """
import json, sys
import numpy as np
import ovito
ovito.scene.load(sys.argv[1])
pipeline = ovito.scene.pipelines[0]
frames = [pipeline.compute(n) for n in range(pipeline.num_frames)]
last, bonds = frames[-1].particles, frames[-1].particles.bonds
ends = bonds["Topology"][...]
step = last["Position"][ends[:, 1]] - last["Position"][ends[:, 0]] + bonds["Periodic Image"][...] @ frames[-1].cell[:3, :3].T
print(json.dumps({
    "bonds": [frame.particles.bonds.count for frame in frames], "spheres": [frame.particles.count for frame in frames],
    "radius": last["Radius"][...].tolist(), "id": last["Particle Identifier"][...].tolist(),
    "strongest": bonds["peak_force"][...].max(), "longest": np.linalg.norm(step, axis=1).max(),
    "z": last["Position"][...][:, 2].tolist(), "steps": [frame.attributes["Timestep"] for frame in frames],
}))
"""
    scene = periodic / "export" / "scene.ovito"
    done = subprocess.run([sys.executable, "-c", look, str(scene)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert seen["bonds"] == loaded and seen["spheres"] == [64] * 3 and seen["steps"][0] == 0 < seen["steps"][2]
    assert np.allclose(seen["radius"], 0.005, rtol=1e-6)  # which OVITO keeps in single precision
    assert seen["strongest"] == strongest
    assert seen["longest"] < 1.01 * synthetic.DIAMETER
    assert np.allclose(np.array(seen["z"])[np.argsort(seen["id"])], positions[:, 2], rtol=0, atol=1e-11)


def test_ovito_script_finds_the_run_from_elsewhere(run, tmp_path):
    (script,) = export(run, "ovito", tmp_path / "a" / "b")
    (line,) = [line for line in script.read_text().splitlines() if line.startswith("RUN = ")]
    where = json.loads(line.removeprefix("RUN = ").partition("  #")[0])
    assert (script.parent / where).resolve() == run.resolve()


# ----------------------------------------------------------------------------------------------- scan


def test_scan_as_csv_and_netcdf(scan, tmp_path):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    (path,) = export(scan, "csv", tmp_path)
    table = pandas.read_csv(path, **EXACT)
    data = read_scan(scan)
    assert table["load.velocity_m_s"].tolist() == [1, 1, 2.5, 2.5]
    assert table["status"].tolist() == ["done", "failed", "done", "missing"] and table["reason"][1] == "it broke"
    assert equal(table["peak_force_N"], data["peak_force_N"]) and np.isnan(table["peak_force_N"][1])

    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    with xarray.open_dataset(*export(scan, "netcdf", tmp_path)) as points:
        assert points.sizes == {"point": 4} and set(points.coords) == {"point", "load.velocity", "material"}
        assert points["load.velocity"].attrs["units"] == "m/s" and points["peak_force_N"].attrs["units"] == "N"
        assert equal(points["peak_force_N"], data["peak_force_N"])
        assert points["material"].to_numpy().tolist() == ["brass", "steel"] * 2


@pytest.mark.parametrize("to", ["vtp", "ovito"])
def test_scan_in_space_is_refused(scan, tmp_path, to):
    with pytest.raises(InputError, match=f"is a scan, and --to {to} shows a single run.*points/ID.*csv or netcdf"):
        export(scan, to, tmp_path / "out")
    assert not (tmp_path / "out").exists()


# --------------------------------------------------------------------------------------- what is wrong


@pytest.mark.parametrize(
    "to, hint", [("vtk", "did you mean vtp?"), ("CSV", "did you mean csv?"), ("x", "expected one of")]
)
def test_unknown_form_is_refused(run, tmp_path, to, hint):
    with pytest.raises(InputError) as error:
        export(run, to, tmp_path / "out")
    assert hint in str(error.value) and not (tmp_path / "out").exists()


@pytest.mark.parametrize("to", FORMATS)
def test_directory_without_result_is_refused(tmp_path, to):
    with pytest.raises(InputError, match=r"data\.granwave" if to == "ovito" else "granwave analyse"):
        export(tmp_path, to)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="no such directory"):
        export(tmp_path / "nowhere", to)


@pytest.mark.parametrize("to", FORMATS)
def test_unwritable_output_is_refused(run, tmp_path, to):
    (tmp_path / "file").write_text("mine")
    for output in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match=r"cannot be written to.*-o"):
            export(run, to, output)
    assert (tmp_path / "file").read_text() == "mine" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("to, module", [("vtp", "vtkmodules.vtkIOXML"), ("netcdf", "h5netcdf")])
def test_missing_library_is_named(run, tmp_path, monkeypatch, to, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=r"pip install (vtk|h5netcdf)"):
        export(run, to, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_failure_leaves_the_old_files_and_nothing_else(run, tmp_path, monkeypatch):
    before = {path: path.read_bytes() for path in export(run, "csv", tmp_path)}
    monkeypatch.setattr(Result, "frame", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        export(run, "csv", tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    with pytest.raises(OSError, match="disk full"):
        export(run, "csv", tmp_path / "new" / "below")
    assert not (tmp_path / "new").exists()


def test_outdated_files_go_and_others_stay(run, tmp_path):
    export(run, "csv", tmp_path)
    for name in ("snapshot_0099.csv", "snapshot_mine.csv", "notes.txt", "walls_xlo.csv"):
        (tmp_path / name).write_text("old")
    export(run, "csv", tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert {"snapshot_mine.csv", "notes.txt", "snapshot_0003.csv"} <= names
    assert not {"snapshot_0099.csv", "walls_xlo.csv"} & names


def test_snapshots_are_read_one_at_a_time(run, tmp_path, monkeypatch):
    """No export keeps more than one snapshot of a quantity."""
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    read = []
    whole = Result.__getitem__
    monkeypatch.setattr(Result, "__getitem__", lambda self, name: read.append(name) or whole(self, name))
    for to in ("csv", "netcdf", "vtp"):
        export(run, to, tmp_path)
    assert read and not [name for name in read if name.endswith("/value")]


def test_staging_that_is_left_undone_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), staged(tmp_path / "a" / "b") as staging:
        staging.path("half").write_text("half")
        raise KeyboardInterrupt
    assert not list(tmp_path.iterdir())
