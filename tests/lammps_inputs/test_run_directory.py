"""Files of granwave in a directory of results: files that it may overwrite, remove and move, and
the number of reads of the marker that lists them.
"""

from __future__ import annotations

import json
import os
import pickle
import shutil

import pytest

from granwave.analysis import analyse, draw_figures, summarise
from granwave.analysis.result.reader import Result
from granwave.extensions.waves.files import SPECTRA
from granwave.lammps_inputs import own_files
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import MARKER, POINT_FILES, RUN, SCAN
from tests.helpers.made_up import synthetic


def fill(directory, *names):
    for name in names:
        (directory / name).parent.mkdir(parents=True, exist_ok=True)
        (directory / name).write_text("mine")


def tree(directory):
    return sorted(
        path.relative_to(directory).as_posix() for path in directory.rglob("*") if not path.is_dir()
    )


# ---------------------------------------------------------------------- the marker


def test_what_is_claimed_is_ours_and_nothing_else(tmp_path):
    fill(tmp_path, "figures/mine.png", "summary.json")
    with pytest.raises(
        InputError, match=r"summary\.json would be overwritten, and granwave did not write it"
    ):
        ResultDirectory(tmp_path).claim(["run.json", "summary.json"], kind=RUN)
    assert not (tmp_path / MARKER).exists()
    ResultDirectory(tmp_path).claim(
        ["run.json", "figures/a.png", "figures/a.csv", "dumps/a.txt"], kind=RUN
    )
    fill(tmp_path, "run.json", "figures/a.png", "dumps/a.txt", "dumps/mine.txt")
    assert ResultDirectory(tmp_path).result_names() == ["run.json", "figures/a.png", "dumps/a.txt"]
    ResultDirectory(tmp_path).clear(["dumps/a.txt", "dumps/mine.txt"])
    assert tree(tmp_path) == [
        MARKER,
        "dumps/mine.txt",
        "figures/a.png",
        "figures/mine.png",
        "run.json",
        "summary.json",
    ]
    ResultDirectory(tmp_path).clear()
    assert tree(tmp_path) == ["dumps/mine.txt", "figures/mine.png", "summary.json"]
    assert not ResultDirectory(tmp_path).marker.kind


def test_folders_that_are_empty_go_and_scratch_files_with_them(tmp_path):
    ResultDirectory(tmp_path).claim(["figures/a.png", "a/b/c.txt", "result.h5"], kind=RUN)
    fill(tmp_path, "figures/a.png", "a/b/c.txt", ".result.h5.123", "figures/.a.png.77")
    (tmp_path / "figures" / "theirs").mkdir()
    fill(tmp_path, ".result.h5.bak", ".mine.123")
    ResultDirectory(tmp_path).clear()
    assert tree(tmp_path) == [".mine.123", ".result.h5.bak"]
    assert (tmp_path / "figures" / "theirs").is_dir() and not (tmp_path / "a").exists()


def test_links_are_not_followed(tmp_path):
    outside = tmp_path / "outside"
    directory = tmp_path / "r"
    fill(outside, "a.png", "log", "case.toml")
    directory.mkdir()
    ResultDirectory(directory).claim(["figures/a.png", "log", "case.toml"], kind=RUN)
    (directory / "figures").symlink_to(outside)
    (directory / "log").symlink_to(outside / "log")
    fill(directory, "case.toml")
    assert ResultDirectory(directory).foreign(["figures/a.png", "log", "case.toml"]) == [
        "figures (a link)",
        "log (a link)",
    ]
    assert ResultDirectory(directory).foreign(["case.toml/a", "../outside"]) == [
        "case.toml (a file)",
        "../outside (a folder)",
    ]
    with pytest.raises(
        InputError, match=r"figures \(a link\), log \(a link\) would be overwritten"
    ):
        ResultDirectory(directory).claim(["figures/a.png", "log"])
    ResultDirectory(directory).clear()
    assert tree(outside) == ["a.png", "case.toml", "log"] and tree(directory) == ["log"]
    assert (directory / "figures").is_symlink() and (directory / "log").is_symlink()


def test_a_marker_leads_nowhere_else(tmp_path):
    """A downloaded marker may contain arbitrary names."""
    fill(tmp_path, "precious", "r/case.toml")
    names = {
        "../precious": None,
        str(tmp_path / "precious"): None,
        "a/../../precious": 3,
        "case.toml": None,
        "": None,
    }
    (tmp_path / "r" / MARKER).write_text(json.dumps({"kind": "run", "files": names}))
    ResultDirectory(tmp_path / "r").clear()
    assert tree(tmp_path) == ["precious"]


def test_results_within_results_go_by_their_own_marker(tmp_path):
    point = tmp_path / "points" / "0a"
    point.mkdir(parents=True)
    ResultDirectory(point).claim([*POINT_FILES, "case.toml"], kind=RUN)
    fill(point, "point.json", "case.toml", "notes")
    ResultDirectory(tmp_path).claim(["scan.json", "points/0a/", "unfinished/0a/"], kind=SCAN)
    fill(
        tmp_path,
        "scan.json",
        "points/mine",
        ".scan/batches/x.json",
        ".scan/logs/a/b.log",
        ".scan/mine",
    )
    assert ResultDirectory(point).result_names() == [
        "case.toml"
    ]  # files that a scan stores next to a run are not results
    ResultDirectory(point).clear()
    assert tree(point) == [MARKER, "notes", "point.json"]
    ResultDirectory(tmp_path).clear()
    assert tree(tmp_path) == [".scan/mine", "points/0a/notes", "points/mine"]


# ---------------------------------------------------------------------- writers


def test_an_analysis_leaves_files_of_somebody_else(tmp_path, caplog):
    synthetic.write_run(tmp_path, synthetic.make_case("chain", 3))
    fill(
        tmp_path,
        "figures/energies.csv",
        "figures/packing_3d.png",
        "dumps/wall_mine.dump",
        ".result.h5.mine",
    )
    analyse(tmp_path)
    assert (tmp_path / "figures" / "energies.csv").read_text() == "mine"
    assert not (tmp_path / "figures" / "energies.png").exists()
    assert (
        "energies: not drawn" in caplog.text
        and "figures/energies.csv would be overwritten" in caplog.text
    )
    assert (tmp_path / ".result.h5.mine").exists()
    (tmp_path / "summary.json").rename(tmp_path / "kept.json")
    ResultDirectory(tmp_path).clear()
    assert tree(tmp_path) == [
        ".result.h5.mine", "dumps/wall_mine.dump", "figures/energies.csv", "figures/packing_3d.png", "kept.json",
        "run.json",  # of the test
    ]  # fmt: skip


# ---------------------------------------------------------------------- without a marker


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """Run with results and a figure."""
    directory = synthetic.write_run(
        tmp_path_factory.mktemp("analysed") / "r", synthetic.make_case("chain", 3)
    )
    analyse(directory, figures=False)
    draw_figures(directory, names=("energies",))
    return directory


@pytest.mark.parametrize("marker", [None, "", "{", "[]", '{"kind": 3}', '{"kind": "run"}'])
def test_without_a_marker_nothing_is_granwaves(analysed, tmp_path, marker):
    """Neither names nor contents identify files of granwave; the run can nevertheless be read."""
    place = tmp_path / "r"
    shutil.copytree(analysed, place)
    (place / MARKER).unlink()
    if marker is not None:
        (place / MARKER).write_text(marker)
    before = tree(place)
    results = ResultDirectory(place)
    assert not results.marker.kind
    assert results.result_names() == []
    results.clear()
    assert results.set_aside() == ""
    assert tree(place) == before
    with pytest.raises(InputError, match=r"summary\.json would be overwritten"):
        summarise(place)
    with Result(place) as result:
        assert result.n_spheres == 3


# ---------------------------------------------------------------------- the marker, read once


def test_the_marker_is_read_once(tmp_path, monkeypatch):
    results = ResultDirectory(tmp_path)
    results.claim(["run.json", "result.h5"], kind=RUN)
    reads = []
    read = own_files.read_marker
    monkeypatch.setattr(own_files, "read_marker", lambda path: reads.append(path) or read(path))
    fill(tmp_path, "run.json")
    results.claim(["summary.json"])
    assert results.result_names() == ["run.json"]
    results.note_files(["run.json"])
    assert results.changed_file() == ""
    assert reads == []
    other = ResultDirectory(tmp_path)
    assert other.marker == results.marker
    assert other.kind.content == "a run"
    assert len(reads) == 1


def test_what_another_process_enters_is_kept(tmp_path):
    ours = ResultDirectory(tmp_path)
    theirs = ResultDirectory(tmp_path)
    ours.claim(["run.json"], kind=RUN)
    assert "run.json" in theirs.marker.files
    theirs.claim(["export/"])
    ours.claim(["result.h5"])
    assert set(ResultDirectory(tmp_path).marker.files) == {"run.json", "export/", "result.h5"}
    theirs.clear()
    assert not ours.marker.kind


def test_an_open_directory_serves_as_a_path(tmp_path):
    results = ResultDirectory(tmp_path)
    assert ResultDirectory.at(results) is results
    assert ResultDirectory.at(tmp_path).path == tmp_path
    assert (os.fspath(results), str(results)) == (str(tmp_path), str(tmp_path))
    assert results / "a" == tmp_path / "a"
    copy = pickle.loads(pickle.dumps(results))
    assert copy.path == tmp_path


# ---------------------------------------------------------------------- what is set aside


def test_results_are_moved_and_files_of_others_stay(tmp_path):
    place = tmp_path / "r"
    results = ResultDirectory(place)
    place.mkdir()
    results.claim(["run.json", "figures/a.png", "dumps/a.txt"], kind=RUN, case="a = 1")
    fill(place, "run.json", "figures/a.png", "dumps/a.txt", "notes", "figures/mine", ".run.json.7")
    assert results.set_aside() == str(tmp_path / "r.old")
    assert tree(place) == ["figures/mine", "notes"]
    assert tree(tmp_path / "r.old") == [MARKER, "dumps/a.txt", "figures/a.png", "run.json"]
    old = ResultDirectory(tmp_path / "r.old")
    assert (old.marker.case, old.kind.content) == ("a = 1", "a run")
    assert len(old.result_names()) == 3
    assert results.set_aside() == ""
    results.claim(["run.json"], kind=RUN)
    fill(place, "run.json")
    assert results.by_force.startswith("force=True moves the results to r.old2 first")
    assert results.set_aside() == str(tmp_path / "r.old2")
    assert tree(tmp_path / "r.old") == [MARKER, "dumps/a.txt", "figures/a.png", "run.json"]


def test_chosen_results_are_moved(tmp_path):
    place = tmp_path / "r"
    place.mkdir()
    results = ResultDirectory(place)
    results.claim(["bands.csv", "modes.csv", "bands.json"], kind=SPECTRA)
    fill(place, "bands.csv", "modes.csv")
    assert results.set_aside(["bands.csv", "bands.json", "other"]) == str(tmp_path / "r.old")
    assert tree(place) == [MARKER, "modes.csv"]
    assert set(results.marker.files) == {"modes.csv"}
    assert tree(tmp_path / "r.old") == [MARKER, "bands.csv"]


def test_points_of_a_scan_are_moved_with_what_is_theirs(tmp_path):
    place = tmp_path / "s"
    for point in ("0a", "0b"):
        folder = place / "points" / point
        folder.mkdir(parents=True)
        ResultDirectory(folder).claim([*POINT_FILES, "case.toml", "figures/a.png"], kind=RUN)
        fill(folder, "point.json", "case.toml", "figures/a.png")
    fill(place, "points/0b/notes", ".scan/batches/x.json", ".scan/logs/a/b.log", ".scan/mine")
    results = ResultDirectory(place)
    results.claim(["scan.json", "points/0a/", "points/0b/", "unfinished/0a/"], kind=SCAN)
    fill(place, "scan.json")
    assert results.set_aside() == str(tmp_path / "s.old")
    assert tree(place) == [".scan/mine", "points/0b/notes"]
    assert tree(tmp_path / "s.old") == [
        MARKER,
        ".scan/batches/x.json",
        ".scan/logs/a/b.log",
        *(f"points/0a/{name}" for name in (MARKER, "case.toml", "figures/a.png", "point.json")),
        *(f"points/0b/{name}" for name in (MARKER, "case.toml", "figures/a.png", "point.json")),
        "scan.json",
    ]
    moved = ResultDirectory(tmp_path / "s.old" / "points" / "0b")
    assert moved.result_names() == ["case.toml", "figures/a.png"]


def test_results_that_cannot_be_moved(tmp_path, monkeypatch):
    place = tmp_path / "r"
    place.mkdir()
    results = ResultDirectory(place)
    results.claim(["run.json"], kind=RUN)
    fill(place, "run.json")
    link = tmp_path / "link"
    link.symlink_to(place)
    with pytest.raises(
        InputError, match=f"is a link to {place}, and force=True does not move results"
    ):
        ResultDirectory(link).check(force=True)
    monkeypatch.setattr(type(place), "is_mount", lambda self: self == place)
    with pytest.raises(InputError, match=r"cannot move the results to .*r\.old: .*another disk"):
        results.check(force=True)
    assert tree(place) == [MARKER, "run.json"]
