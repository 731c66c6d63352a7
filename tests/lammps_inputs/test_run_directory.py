"""Files of granwave in a directory of results, files that it may overwrite and remove, and results
without a marker.
"""

from __future__ import annotations

import json
import shutil

import pytest

from granwave.analysis import analyse, draw_figures, summarise
from granwave.analysis.exports.export import export
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.ownership import claim, clear, foreign, read_marker, results_in
from granwave.lammps_inputs.run_directory import (
    CONTINUUM,
    FIT,
    MARKER,
    POINT_FILES,
    RUN,
    SCAN,
    SUITE,
)
from tests.helpers import synthetic
from tests.helpers.synthetic_scan import grid, write_scan


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
        claim(tmp_path, ["run.json", "summary.json"], kind=RUN)
    assert not (tmp_path / MARKER).exists()
    claim(tmp_path, ["run.json", "figures/a.png", "figures/a.csv", "dumps/a.txt"], kind=RUN)
    fill(tmp_path, "run.json", "figures/a.png", "dumps/a.txt", "dumps/mine.txt")
    assert results_in(tmp_path) == ["run.json", "figures/a.png", "dumps/a.txt"]
    clear(tmp_path, ["dumps/a.txt", "dumps/mine.txt"])
    assert tree(tmp_path) == [
        MARKER,
        "dumps/mine.txt",
        "figures/a.png",
        "figures/mine.png",
        "run.json",
        "summary.json",
    ]
    clear(tmp_path)
    assert tree(tmp_path) == ["dumps/mine.txt", "figures/mine.png", "summary.json"]
    assert not read_marker(tmp_path).kind


def test_folders_that_are_empty_go_and_scratch_files_with_them(tmp_path):
    claim(tmp_path, ["figures/a.png", "a/b/c.txt", "result.h5"], kind=RUN)
    fill(tmp_path, "figures/a.png", "a/b/c.txt", ".result.h5.123", "figures/.a.png.77")
    (tmp_path / "figures" / "theirs").mkdir()
    fill(tmp_path, ".result.h5.bak", ".mine.123")
    clear(tmp_path)
    assert tree(tmp_path) == [".mine.123", ".result.h5.bak"]
    assert (tmp_path / "figures" / "theirs").is_dir() and not (tmp_path / "a").exists()


def test_links_are_not_followed(tmp_path):
    outside = tmp_path / "outside"
    directory = tmp_path / "r"
    fill(outside, "a.png", "log", "case.toml")
    directory.mkdir()
    claim(directory, ["figures/a.png", "log", "case.toml"], kind=RUN)
    (directory / "figures").symlink_to(outside)
    (directory / "log").symlink_to(outside / "log")
    fill(directory, "case.toml")
    assert foreign(directory, ["figures/a.png", "log", "case.toml"]) == [
        "figures (a link)",
        "log (a link)",
    ]
    assert foreign(directory, ["case.toml/a", "../outside"]) == [
        "case.toml (a file)",
        "../outside (a folder)",
    ]
    with pytest.raises(
        InputError, match=r"figures \(a link\), log \(a link\) would be overwritten"
    ):
        claim(directory, ["figures/a.png", "log"])
    clear(directory)
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
    clear(tmp_path / "r")
    assert tree(tmp_path) == ["precious"]


def test_results_within_results_go_by_their_own_marker(tmp_path):
    point = tmp_path / "points" / "0a"
    point.mkdir(parents=True)
    claim(point, [*POINT_FILES, "case.toml"], kind=RUN)
    fill(point, "point.json", "case.toml", "notes")
    claim(tmp_path, ["scan.json", "points/0a/", "unfinished/0a/"], kind=SCAN)
    fill(
        tmp_path,
        "scan.json",
        "points/mine",
        ".scan/batches/x.json",
        ".scan/logs/a/b.log",
        ".scan/mine",
    )
    assert results_in(point) == [
        "case.toml"
    ]  # files that a scan stores next to a run are not results
    clear(point)
    assert tree(point) == [MARKER, "notes", "point.json"]
    clear(tmp_path)
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
    clear(tmp_path)
    assert tree(tmp_path) == [
        ".result.h5.mine", "dumps/wall_mine.dump", "figures/energies.csv", "figures/packing_3d.png", "kept.json",
        "run.json",  # of the test
    ]  # fmt: skip


# ---------------------------------------------------------------------- results of version 0.1.0


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """Run with results and a figure."""
    directory = synthetic.write_run(
        tmp_path_factory.mktemp("earlier") / "r", synthetic.make_case("chain", 3)
    )
    analyse(directory, figures=False)
    draw_figures(directory, names=("energies",))
    return directory


@pytest.fixture
def earlier(analysed, tmp_path):
    """Run with results and a figure as written by version 0.1.0."""
    shutil.copytree(analysed, tmp_path / "r")
    (tmp_path / "r" / MARKER).unlink()
    return tmp_path / "r"


def test_a_run_without_a_marker_is_recognised(analysed, earlier):
    fill(
        earlier,
        "figures/mine.png",
        "figures/mine.csv",
        "dumps/mine.txt",
        "notes.txt",
        "points/x",
        "export/mine.csv",
    )
    found = read_marker(earlier)
    marker = read_marker(analysed)
    assert found.kind == RUN and found.case == marker.case
    assert set(found.files) == {name for name in marker.files if (analysed / name).exists()} | {
        "run.json"
    }
    assert not (earlier / MARKER).exists()  # listing changes nothing
    clear(earlier)
    assert tree(earlier) == [
        "dumps/mine.txt", "export/mine.csv", "figures/mine.csv", "figures/mine.png", "notes.txt", "points/x",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "damaged", ["result.h5", "summary.json", "run.json", "case.toml", "in.granwave", MARKER]
)
def test_one_damaged_file_does_not_hide_the_others(earlier, damaged):
    (earlier / damaged).write_text("")
    found = read_marker(earlier)
    names = {
        "result.h5",
        "summary.json",
        "run.json",
        "case.toml",
        "in.granwave",
        "dumps/energy.txt",
    }
    assert found.kind == RUN and names <= set(found.files) and found.case


def test_what_an_earlier_version_left_is_replaced_and_noted(earlier):
    summarise(earlier)
    draw_figures(earlier, names=("energies",))
    assert {"summary.json", "figures/energies.png", "dumps/energy.txt"} <= set(
        read_marker(earlier).files
    )
    assert (earlier / MARKER).exists()


def test_an_export_of_an_earlier_version_is_replaced(earlier):
    fill(
        earlier,
        "export/energy.csv",
        "export/snapshot_0077.csv",
        "export/mine.csv",
        "export/walls_mine.txt",
    )
    export(earlier, "csv")
    assert (earlier / "export" / "energy.csv").read_text() != "mine"
    assert not (earlier / "export" / "snapshot_0077.csv").exists()
    clear(earlier)
    assert tree(earlier / "export") == ["mine.csv", "walls_mine.txt"]


def test_names_alone_are_no_results(tmp_path):
    """Files of the user, with names also used by granwave."""
    fill(
        tmp_path,
        "case.toml",
        "summary.json",
        "result.h5",
        "run.json",
        "scan.toml",
        "scan.json",
        "fit.toml",
    )
    fill(
        tmp_path,
        "figures/energies.png",
        "dumps/energy.txt",
        "points/a/case.toml",
        "log.lammps",
        "report.html",
    )
    (tmp_path / "case.toml").write_text(
        'name = "mine"\nmaterial = "brass"\n[packing]\nkind = "fcc"\n'
    )
    (tmp_path / "summary.json").write_text('{"name": "mine"}')
    assert not read_marker(tmp_path).kind and results_in(tmp_path) == []


def test_a_result_that_was_copied_makes_nobodys_case_ours(earlier, tmp_path):
    fill(tmp_path, "case.toml", "log.lammps", "dumps/energy.txt")
    shutil.copy(earlier / "result.h5", tmp_path)
    assert list(read_marker(tmp_path).files) == ["result.h5"]


def test_a_scan_without_a_marker_is_recognised(tmp_path):
    write_scan(tmp_path, grid(load__velocity=[1, 2]))
    points = {f"points/{path.name}/" for path in (tmp_path / "points").iterdir()}
    for point in points:
        fill(tmp_path, f"{point}point.json")
    fill(tmp_path, "points/mine/case.toml", "scan.csv", "figures/mine.png")
    found = read_marker(tmp_path)
    assert found.kind == SCAN and set(found.files) == {"scan.json", "scan.csv", *points}


@pytest.mark.parametrize(
    ("name", "text", "kind"),
    [
        ("suite.json", '{"name": "a", "scans": []}', SUITE),
        ("fit.toml", "# Elasto-plastic contact law fitted to law.csv (3 rows).\n", FIT),
        ("summary.json", '{"n_elements": 3, "versions": {"granwave": "0.1.0"}}', CONTINUUM),
    ],
)
def test_other_kinds_without_a_marker_are_recognised(tmp_path, name, text, kind):
    (tmp_path / name).write_text(text)
    found = read_marker(tmp_path)
    assert found.kind == kind and list(found.files) == [name]
