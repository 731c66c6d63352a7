"""Compatibility: results of 0.1 to 1.0 are read, names of 1.0 exist, results of later formats are
rejected.

The archives contain small runs of these versions: fcc spheres, a chain, a scan of two points;
without dumps, decks and figures. The archive of 1.0 also has the dumps of the fcc spheres, and a
run of two spheres that was killed after a checkpoint. `promised.json` has the names of 1.0:
commands, options and their values, keys, values of summary.json, data sets, columns, names of
Python with their arguments, styles.
"""

from __future__ import annotations

import csv
import json
import shutil
import tarfile
import tomllib
from pathlib import Path

import h5py
import pytest

import granwave as gw
from granwave.analysis import Result
from granwave.lammps_inputs.deck.deck import read_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import FORMAT, MARKER
from granwave.workflows.cli.main import main
from granwave.workflows.run.directory import RunDirectory
from tests.earlier import promised
from tests.helpers.selection import with_every_test

pytestmark = pytest.mark.xdist_group("earlier")  # its fixtures are made once

HERE = Path(__file__).parent
WITH_DUMPS = "1.0.0"
VERSIONS = ("0.1.0", "0.2.0", "0.3.0", WITH_DUMPS)
PROMISED = json.loads(promised.FILE.read_text(encoding="utf-8"))
KNOWN = {"run": "fcc", "chain": "chain"}


@pytest.fixture(params=VERSIONS)
def earlier(request, tmp_path) -> Path:
    """Results of an earlier version."""
    return unpacked(request.param, tmp_path)


@pytest.fixture
def with_dumps(tmp_path) -> Path:
    """Results of the version whose archive has dumps and a checkpoint."""
    return unpacked(WITH_DUMPS, tmp_path)


def unpacked(version: str, place: Path) -> Path:
    with tarfile.open(HERE / f"granwave-{version}.tar.xz") as archive:
        archive.extractall(place, filter="data")
    return place


def test_runs_are_loaded(earlier):
    for name, kind in KNOWN.items():
        summary = json.loads((earlier / name / "summary.json").read_text(encoding="utf-8"))
        run = gw.load(earlier / name)
        assert run.case.packing.kind == kind and run["peak_force_N"] == summary["peak_force_N"] > 0
        assert run["versions"]["granwave"] == summary["versions"]["granwave"] in VERSIONS
        assert run.contacts["peak_force"].max() == pytest.approx(summary["peak_force_N"], rel=1e-9)
        with Result(earlier / name) as result:
            assert result["energy/dissipated"][-1] == pytest.approx(
                summary["energy_dissipated_J"], rel=1e-9
            )


def test_scans_are_loaded(earlier):
    table = gw.load(earlier / "scan").table
    assert list(table["load.velocity"]) == [0.1, 1.0] and list(table["status"]) == ["done", "done"]
    with (earlier / "scan" / "scan.csv").open(encoding="utf-8", newline="") as stream:
        forces = [float(row["peak_force_N"]) for row in csv.DictReader(stream)]
    assert list(table["peak_force_N"]) == pytest.approx(forces, rel=1e-9) and forces[0] < forces[1]


@pytest.mark.parametrize("earlier", with_every_test(VERSIONS, ("0.1.0", WITH_DUMPS)), indirect=True)
def test_report_of_all(earlier):
    report = earlier / "report.html"
    assert (
        main(["report", *(str(earlier / name) for name in (*KNOWN, "scan")), "-o", str(report)])
        == 0
    )
    page = report.read_text(encoding="utf-8")
    assert "impact velocity" in page and "chain of 6" in page and "could not be" not in page


@pytest.mark.parametrize("earlier", with_every_test(VERSIONS, ("0.1.0", WITH_DUMPS)), indirect=True)
def test_figures_film_page_and_tables(earlier):
    for name in ("run", "chain"):
        place = earlier / name
        assert main(["figures", str(place), "--only", "energies"]) == 0
        assert (place / "figures" / "energies.png").stat().st_size > 5000
        assert main(["export", str(place), "--to", "csv", "-o", str(earlier / f"{name}-csv")]) == 0
    film = ["film", str(earlier / "run"), "-o", str(earlier / "run.gif"), "--width", "300"]
    assert main(film) == 0
    assert (earlier / "run.gif").read_bytes()[:3] == b"GIF"
    assert main(["view", str(earlier / "run"), "-o", str(earlier / "view.html")]) == 0


def test_they_are_kept_and_replaced_as_results_are(earlier, capsys):
    """Their files are recognised as granwave's own: they are rejected without --force, and a
    finished run is not computed again.
    """
    case = str(earlier / "run" / "case.toml")
    before = (earlier / "run" / "summary.json").read_bytes()
    assert main(["run", case, "-o", str(earlier / "run"), "--no-figures"]) == 2
    assert "already holds results" in capsys.readouterr().err
    assert main(["run", case, "-o", str(earlier / "run"), "--no-figures", "--resume"]) == 0
    assert (earlier / "run" / "summary.json").read_bytes() == before
    assert main(["run", case, "-o", str(earlier / "run"), "--no-figures", "--force"]) == 0
    now = json.loads((earlier / "run" / "summary.json").read_text(encoding="utf-8"))
    assert now["peak_force_N"] == pytest.approx(json.loads(before)["peak_force_N"], rel=1e-3)


def test_input_scripts_are_read(earlier):
    for name in KNOWN:
        deck = read_deck(earlier / name)
        assert deck.schedule.n_steps > 0 and len(deck.struck) == 1


def test_dumps_are_analysed(with_dumps):
    """The values are those of the version that wrote the dumps, but for new definitions."""
    before = json.loads((with_dumps / "run" / "summary.json").read_text(encoding="utf-8"))
    assert main(["analyse", str(with_dumps / "run"), "--no-figures"]) == 0
    now = json.loads((with_dumps / "run" / "summary.json").read_text(encoding="utf-8"))
    assert before.keys() <= now.keys()
    redefined = {"base_arrival_s", "ground_peak_reduction", "versions"}
    for name in before.keys() - redefined:
        same = (
            pytest.approx(before[name], rel=1e-9) if type(before[name]) is float else before[name]
        )
        assert now[name] == same, name
    assert now["base_arrival_s"] is now["ground_peak_reduction"] is None  # the force still rises


def test_an_interrupted_run_restarts_from_the_beginning(with_dumps, caplog):
    place = with_dumps / "interrupted"
    case = tomllib.loads((place / "case.toml").read_text(encoding="utf-8"))
    assert case["run"]["end_time"] == 0.03
    assert (
        main(["run", str(place / "case.toml"), "-o", str(place), "--resume", "--no-figures"]) == 0
    )
    assert f"its checkpoint was written by granwave 1.0.0, expected {gw.__version__}" in caplog.text
    assert "the run restarts from the beginning" in caplog.text
    record = json.loads((place / "run.json").read_text(encoding="utf-8"))
    assert record["versions"]["granwave"] == gw.__version__ and record["state"] == "finished"


def test_restart_files_of_1_0_are_rejected_with_both_formats(with_dumps, lammps):
    (file,) = (with_dumps / "interrupted").glob("*.restart")
    engine = lammps()
    with pytest.raises(
        Exception, match=r"contains format 10 .* 12 to 13.*Start the simulation again"
    ):
        engine.command(f"read_restart {file}")


def test_commands_and_options_of_1_0():
    present = promised.actions()
    for name, words in PROMISED["commands"].items():
        assert set(words) <= present[name].keys(), name


def test_values_of_options_of_1_0():
    present = promised.choices()
    for option, values in PROMISED["choices"].items():
        assert set(values) <= set(present[option]), option


def test_keys_and_names_of_1_0():
    assert set(PROMISED["keys"]) <= set(promised.keys())
    assert set(PROMISED["python"]) <= set(gw.__all__)


def test_functions_and_members_of_1_0_in_python():
    """Each function has its arguments, in their order."""
    present = promised.arguments()
    for name, parameters in PROMISED["arguments"].items():
        assert [one for one in present[name] if one in parameters] == parameters, name


def test_styles_of_1_0(lammps):
    engine = lammps()
    for kind, names in PROMISED["styles"].items():
        assert all(engine.has_style(kind, name) for name in names), kind


@pytest.fixture(scope="module")
def now(tmp_path_factory) -> Path:
    """A present run and scan like those in the archives."""
    place = tmp_path_factory.mktemp("now")
    promised.make_runs(place)
    (place / "pair.toml").write_text(
        'case = "two-spheres"\nset = {run.end_time = 4e-5}\ngrid = {load.velocity = [0.1]}\n'
    )
    (place / "suite.toml").write_text('name = "suite"\nscans = ["pair.toml"]\n')
    assert main(["scan", str(place / "suite.toml"), "-o", str(place / "suite"), "--jobs", "1"]) == 0
    assert main(["bands", "precompressed-chain", "-o", str(place / "bands"), "--no-figures"]) == 0
    return place


def test_values_data_sets_and_columns_of_1_0(now):
    assert set(PROMISED["summary"]) <= set(promised.summary_values(now))
    assert PROMISED["result"].items() <= promised.data_sets(now).items()  # with their units
    assert set(PROMISED["scan_csv"]) <= set(promised.columns(now / "suite" / "pair"))


def test_every_file_tells_its_version(now):
    expected = {"granwave": gw.__version__, "results_format": str(FORMAT)}
    scan = now / "suite" / "pair"
    for path in (
        now / "run" / "summary.json",
        now / "run" / "run.json",
        scan / "scan.json",
        now / "suite" / "suite.json",
    ):
        assert (
            expected.items() <= json.loads(path.read_text(encoding="utf-8"))["versions"].items()
        ), path
    for path in (now / "run" / "result.h5", scan / "scan.h5", now / "bands" / "spectra.h5"):
        with h5py.File(path) as file:
            assert expected.items() <= json.loads(file.attrs["versions"]).items(), path
    for place in (now / "run", scan, now / "suite", now / "bands"):
        marker = json.loads((place / MARKER).read_text(encoding="utf-8"))
        assert (marker["version"], marker["format"]) == (gw.__version__, FORMAT)
    with (scan / "scan.csv").open(encoding="utf-8", newline="") as stream:
        assert {row["versions.granwave"] for row in csv.DictReader(stream)} == {gw.__version__}


@pytest.mark.parametrize("command", ["report {} -o out.md", "analyse {}", "run fcc-small -o {} --force", "export {} --to csv"])  # fmt: skip
def test_results_of_a_later_format_are_refused(now, tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    place = shutil.copytree(now / "run", tmp_path / "later")
    marker = json.loads((place / MARKER).read_text(encoding="utf-8"))
    (place / MARKER).write_text(json.dumps(marker | {"format": FORMAT + 1, "version": "9.0"}))
    before = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    assert main(command.format(place).split()) == 2
    said = capsys.readouterr().err
    assert (
        f"found results of format {FORMAT + 1}, of granwave 9.0, expected at most {FORMAT}" in said
    )
    assert {path: path.read_bytes() for path in place.rglob("*") if path.is_file()} == before


def test_a_result_alone_of_a_later_format_is_refused(now, tmp_path):
    path = Path(shutil.copy(now / "run" / "result.h5", tmp_path))
    with h5py.File(path, "a") as file:
        made = json.loads(file.attrs["versions"]) | {"results_format": str(FORMAT + 1)}
        file.attrs["versions"] = json.dumps(made)
    with pytest.raises(gw.OutputFormatError, match="format 2"):
        Result(path)


@pytest.mark.parametrize(
    ("version", "named"), [(None, "cannot be read"), ("0.2.9", "by granwave 0.2.9")]
)
def test_a_checkpoint_of_another_minor_version_is_not_used(tmp_path, version, named):
    checkpoint = {"file": "checkpoint-1.restart", "whole": {}, "sizes": {}}
    assert RunDirectory(tmp_path).checkpoint_fault(checkpoint | {"version": gw.__version__}) == ""
    assert named in RunDirectory(tmp_path).checkpoint_fault(
        checkpoint | ({"version": version} if version else {})
    )


def test_a_removed_name_is_rejected_with_the_new_one():
    error = InputError("wrong")
    with pytest.raises(AttributeError, match="is now called errors"):
        _ = error.faults
    assert error.errors == ["wrong"]
    assert not hasattr(error, "faults")
    with pytest.raises(AttributeError, match="'InputError' object has no attribute 'fault'"):
        _ = error.fault
