"""Exports to ParaView and OVITO: their values are bitwise identical to result.h5."""

from __future__ import annotations

import json
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from granwave.analysis import Result, write_result
from granwave.analysis.exports.export import export
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.export_inputs import equal, write_periodic_run, write_walled_run

pytestmark = pytest.mark.xdist_group("export_scenes")  # its fixtures are made once


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_walled_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def periodic(tmp_path_factory):
    return write_periodic_run(tmp_path_factory.mktemp("periodic") / "it's a run")


def arrays_of(data):
    """Arrays of a vtkFieldData by name."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return {
        data.GetArrayName(n): vtk_to_numpy(data.GetArray(n)).copy()
        for n in range(data.GetNumberOfArrays())
    }


def read_vtp(path):
    """Points, connectivity, and the arrays of points, cells and the file, in the form that ParaView
    reads.
    """
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
    return (
        points,
        ends,
        arrays_of(data.GetPointData()),
        arrays_of(data.GetCellData()),
        arrays_of(data.GetFieldData()),
    )


# ------------------------------------------------------------------------------------------------ vtp


def test_vtp_holds_spheres_and_contacts(run, tmp_path):
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    export(run, "vtp", tmp_path)
    with Result(run) as result:
        i = result["contacts/i"]
        j = result["contacts/j"]
        toward = result["spheres/position"][j - 1] - result["spheres/position"][i - 1]
        for m in range(4):
            points, cells, values, _, field = read_vtp(tmp_path / f"spheres_{m:04d}.vtp")
            assert equal(points, result.frame(m, "position")) and equal(cells[:, 0], np.arange(144))
            assert equal(values["id"], result["spheres/id"]) and equal(
                values["radius"], np.full(144, 0.005)
            )
            for name in (
                "displacement",
                "velocity",
                "contact_force",
                "peak_force",
                "dissipated_energy",
            ):
                assert equal(values[name], result.frame(m, name)), name
            assert field["TimeValue"].tolist() == [result.frame_times[m]]

            points, lines, _, values, field = read_vtp(tmp_path / f"contacts_{m:04d}.vtp")
            assert equal(lines, np.stack([i, j], axis=1) - 1) and equal(
                points, result.frame(m, "position")
            )
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


def test_vtp_of_a_packing_with_missing_spheres(tmp_path):
    """Lines connect the spheres with their IDs."""
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    case = synthetic.make_case(packing={"vacancies": [7, 60]}, contact={"friction": 0.1})
    write_result(synthetic.write_run(tmp_path, case))
    export(tmp_path, "vtp", tmp_path / "out")
    points, lines, _, values, _ = read_vtp(tmp_path / "out" / "contacts_0003.vtp")
    _, _, spheres, _, _ = read_vtp(tmp_path / "out" / "spheres_0003.vtp")
    assert len(points) == 142 and not np.isin(spheres["id"], [7, 60]).any()
    assert equal(spheres["id"][lines], np.stack([values["i"], values["j"]], axis=1))
    lost = np.bincount(lines.ravel(), np.repeat(0.5 * values["friction_energy"], 2), minlength=142)
    assert np.allclose(spheres["friction_energy"], lost, rtol=1e-12)


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
    """No contact crosses the packing, and overlaps are those of LAMMPS at the end of the run."""
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    export(periodic, "vtp", tmp_path)
    points, lines, _, values, _ = read_vtp(tmp_path / "contacts_0002.vtp")
    assert (
        np.linalg.norm(points[lines[:, 1]] - points[lines[:, 0]], axis=1).max()
        < 1.01 * synthetic.DIAMETER
    )
    with Result(periodic) as result:
        assert len(points) > result.n_spheres
        pressed = result["contacts/force"] > 0
        assert np.count_nonzero(pressed) > 20
        assert np.allclose(
            values["overlap"][pressed], result["contacts/overlap"][pressed], rtol=0, atol=1e-16
        )
        assert np.all(values["loaded"][pressed] == 1)


# ---------------------------------------------------------------------------------------------- ovito


def test_ovito_opens_spheres_and_contacts(periodic, tmp_path):
    pytest.importorskip("ovito", reason="ovito is not installed")
    (script,) = export(periodic, "ovito")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    with Result(periodic) as result:
        n_loaded = int(np.count_nonzero(result["contacts/peak_overlap"] > 0))
        loaded = [
            int(np.count_nonzero(result["contacts/time_first"] <= time))
            for time in result.frame_times
        ]
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
    done = subprocess.run(
        [sys.executable, "-c", look, str(scene)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert (
        seen["bonds"] == loaded
        and seen["spheres"] == [64] * 3
        and seen["steps"][0] == 0 < seen["steps"][2]
    )
    assert np.allclose(seen["radius"], 0.005, rtol=1e-6)  # stored in single precision by OVITO
    assert seen["strongest"] == strongest
    assert seen["longest"] < 1.01 * synthetic.DIAMETER
    assert np.allclose(
        np.array(seen["z"])[np.argsort(seen["id"])], positions[:, 2], rtol=0, atol=1e-11
    )


def test_ovito_script_finds_the_run_from_elsewhere(run, tmp_path):
    (script,) = export(run, "ovito", tmp_path / "a" / "b")
    (line,) = [line for line in script.read_text().splitlines() if line.startswith("RUN = ")]
    where = json.loads(line.removeprefix("RUN = ").partition("  #")[0])
    assert (script.parent / where).resolve() == run.resolve()
