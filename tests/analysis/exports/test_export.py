"""Exports in all formats: errors, and files that are written completely or not at all."""

from __future__ import annotations

import sys

import pytest

from granwave.analysis import Result
from granwave.analysis.exports import names
from granwave.analysis.exports.export import export
from granwave.analysis.exports.formats import staged
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from tests.helpers.made_up import synthetic_scan
from tests.helpers.made_up.export_inputs import write_walled_run

NEEDS = pytest.mark.needs_extension("pictures")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_walled_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    points = synthetic_scan.grid(load__velocity=[1, 2.5], material=["brass", "steel"])
    return synthetic_scan.write_scan(
        tmp_path_factory.mktemp("scan"), points, failed={2: "it broke"}, missing=[4]
    )


@pytest.mark.parametrize(
    "to, module", [pytest.param("vtp", "vtkmodules.vtkIOXML", marks=NEEDS), ("netcdf", "h5netcdf")]
)
def test_missing_library_is_named(run, tmp_path, monkeypatch, to, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=r'pip install "granwave\[(pictures|export)\]"'):
        export(run, to, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@NEEDS
def test_formats_are_those_that_are_there(run, tmp_path, monkeypatch):
    assert names.export_names() == ("csv", "netcdf", "ovito", "vtp")
    monkeypatch.setattr(names, "added_by_name", lambda _: {})
    with pytest.raises(InputError, match=r"--to vtp: unknown format; expected one of csv, netcdf$"):
        export(run, "vtp", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_failure_leaves_the_old_files_and_nothing_else(run, tmp_path, monkeypatch):
    export(run, "csv", tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.setattr(Result, "frame", lambda *_: (_ for _ in ()).throw(OSError(28, "disk full")))
    with pytest.raises(OSError, match="disk full"):
        export(run, "csv", tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    with pytest.raises(OSError, match="disk full"):
        export(run, "csv", tmp_path / "new" / "below")
    assert not (tmp_path / "new").exists()


def test_outdated_files_go_and_others_stay(run, tmp_path):
    export(run, "csv", tmp_path)
    ResultDirectory(tmp_path).claim(["snapshot_0099.csv", "walls_xlo.csv"])
    for name in (
        "snapshot_0099.csv",
        "snapshot_0098.csv",
        "snapshot_mine.csv",
        "notes.txt",
        "walls_xlo.csv",
    ):
        (tmp_path / name).write_text("old")
    export(run, "csv", tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert {"snapshot_0098.csv", "snapshot_mine.csv", "notes.txt", "snapshot_0003.csv"} <= names
    assert not {"snapshot_0099.csv", "walls_xlo.csv"} & names


def test_files_of_somebody_else_are_not_overwritten(run, tmp_path):
    (tmp_path / "energy.csv").write_text("mine")
    with pytest.raises(
        InputError, match=r"energy\.csv would be overwritten, and granwave did not write it"
    ):
        export(run, "csv", tmp_path)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [
        ("energy.csv", "mine")
    ]


def test_snapshots_are_read_one_at_a_time(run, tmp_path, monkeypatch):
    """No export keeps more than one snapshot of a quantity."""
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    pytest.importorskip("vtkmodules", reason="vtk is not installed")
    read = []
    whole = Result.__getitem__
    monkeypatch.setattr(
        Result, "__getitem__", lambda self, name: read.append(name) or whole(self, name)
    )
    for to in set(names.export_names()) - {"ovito"}:
        export(run, to, tmp_path)
    assert read and not [name for name in read if name.endswith("/value")]


def test_staging_that_is_left_undone_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), staged(tmp_path / "a" / "b") as (path_of, _):
        path_of("half").write_text("half")
        raise KeyboardInterrupt
    assert not list(tmp_path.iterdir())


def test_some_tables_alone(run, scan, tmp_path):
    """Tables of an earlier export are kept; unknown names and other formats are rejected."""
    output = tmp_path / "out"
    export(run, "csv", output, only=["energy"])
    (placed,) = export(run, "csv", output, only=["contacts"])
    assert placed.name == "contacts.csv"
    assert (output / "energy.csv").exists() and not (output / "spheres.csv").exists()
    for to, only, words in (
        ("csv", ["contact"], "did you mean contacts"),
        ("csv", ["chain"], "no such data"),
        ("netcdf", ["contacts"], "use --to csv"),
    ):
        with pytest.raises(InputError, match=words):
            export(run, to, output, only=only)
    with pytest.raises(InputError, match="exported as a single table; remove --only"):
        export(scan, "csv", output, only=["energy"])
