"""Directories for results, invalid places and full disks, and files that are replaced completely or
not at all.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from granwave.lammps_inputs.directories import check_disk, label_of, results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import naming, plain, read_json, replace_text, replacing
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import RUN

RESULTS = ("case.toml", "summary.json", "figures/a.png", "log")
CASE = {"name": "a", "load": {"velocity": 5.0}}
TEXT = 'name = "a"\n[load]\nvelocity = 5.0\n'


def ask(directory, *, resume=False, force=False, case=CASE, kind=RUN):
    results = ResultDirectory(directory)
    return results.decide(kind, RESULTS, resume=resume, force=force, case=case, read=dict)


@pytest.fixture
def filled(tmp_path):
    """Directory with results of `CASE` and a file of the user."""
    directory = tmp_path / "r"
    (directory / "figures").mkdir(parents=True)
    ResultDirectory(directory).claim(RESULTS, kind=RUN, case=TEXT)
    for name in (*RESULTS, "notes.txt", "figures/mine.png"):
        (directory / name).write_text("{}")
    (directory / "case.toml").write_text(TEXT)
    return directory


def test_results_are_refused_resumed_or_replaced(filled):
    with pytest.raises(InputError) as caught:
        ask(filled)
    assert str(caught.value) == (
        f"{filled}: already holds results (case.toml, summary.json, figures/a.png, ...); "
        "resume=True continues with them, force=True moves the results to r.old first, "
        "or choose another directory with directory=..."
    )
    assert ask(filled, resume=True) is True
    assert ask(filled, force=True) is False
    ResultDirectory(filled).clear()
    assert sorted(path.relative_to(filled).as_posix() for path in filled.rglob("*.*")) == [
        "figures/mine.png",
        "notes.txt",
    ]


def test_results_whose_case_is_known_to_nobody_are_not_resumed(filled):
    ResultDirectory(filled).claim([], case="")
    with pytest.raises(InputError, match="already holds results"):
        ask(filled, resume=True)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", 'the empty name ""'),
        ("~/runs", "the shell did not expand ~"),
        ("~nobody", "the shell did not expand ~nobody"),
        ("/", "is the root directory"),
        ("/..", "is the root directory"),
        (Path.home(), "is your home directory"),
        ("a" * 300, "File name too long"),
        ("a\0b", "null byte"),
    ],
)
def test_places_that_nobody_means(name, message):
    with pytest.raises(InputError, match=message):
        results_directory(name)


def test_results_behind_a_link_are_kept(filled, monkeypatch):
    monkeypatch.chdir(filled)
    assert results_directory(".") == filled and results_directory("new") == filled / "new"
    link = filled.with_name("link")
    link.symlink_to(filled)
    assert results_directory(link) == link
    with pytest.raises(
        InputError,
        match=f"is a link to {filled}, and force=True does not move results through a link",
    ):
        ask(link, force=True)
    link.with_name("circle").symlink_to(link.with_name("circle"))
    with pytest.raises(InputError, match="choose another directory"):
        results_directory(link.with_name("circle"))


def test_disk_that_is_too_small(tmp_path):
    check_disk(tmp_path / "not" / "yet", 1.0)
    check_disk(tmp_path, 0.0, spare=1e30)
    with pytest.raises(
        InputError,
        match=r"the points require about 1e\+21 GB, but only [\d.e+]+ GB are free; choose",
    ):
        check_disk(tmp_path, 1e30, what="the points")
    with pytest.raises(
        InputError,
        match=r"the results require about 1e-06 GB and 1e\+21 GB must stay free, but only "
        r"[\d.e+]+ GB",
    ):
        check_disk(tmp_path, 1e3, spare=1e30)


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.txt"
    replace_text(path, "ä\n")
    with pytest.raises(KeyboardInterrupt), replacing(path) as scratch:
        scratch.write_text("half")
        assert scratch.name.startswith(".") and path.read_text(encoding="utf-8") == "ä\n"
        raise KeyboardInterrupt
    assert path.read_bytes() == "ä\n".encode()
    replace_text(path, "ö")
    assert [file.read_text(encoding="utf-8") for file in tmp_path.iterdir()] == ["ö"]


def test_an_error_of_the_system_names_its_file(tmp_path):
    path = tmp_path / "a.txt"
    with pytest.raises(OSError) as caught, replacing(path), open("/dev/full", "w") as file:
        file.write("x" * 100_000)
    assert caught.value.filename == str(path) and caught.value.strerror == os.strerror(28)
    with pytest.raises(OSError) as caught, naming(path):
        raise OSError(
            "Can't write data (file write failed: errno = 28, error message = ...)"
        )  # as in h5py
    assert (caught.value.errno, caught.value.filename) == (28, str(path))
    with pytest.raises(FileNotFoundError) as caught, naming(path):
        (tmp_path / "b.txt").read_text()
    assert caught.value.filename == str(tmp_path / "b.txt")


@pytest.mark.parametrize("text", [None, "", "{", "[1]", "3", "\xff", "[" * 100_000])
def test_json_that_cannot_be_read_is_none(tmp_path, text):
    path = tmp_path / "a.json"
    if text is not None:
        path.write_bytes(text.encode("latin-1"))
    assert read_json(path) is None


def test_plain_numbers_survive_json(tmp_path):
    found = {
        "a": np.float64(1.5),
        "b": math.nan,
        "c": [np.int64(3), math.inf, "x"],
        "d": {"e": None, "f": np.bool_(True)},
    }
    text = json.dumps(plain(found), allow_nan=False)
    assert json.loads(text) == {
        "a": 1.5,
        "b": None,
        "c": [3, None, "x"],
        "d": {"e": None, "f": True},
    }


def test_messages_of_a_run_name_its_directory(tmp_path):
    """Two runs of one case in different directories are told apart; a run that has the name of its
    case is not named twice.
    """
    assert label_of("fcc-small", tmp_path / "fcc-small") == "fcc-small"
    assert label_of("fcc-small", tmp_path / "brass-10") == "fcc-small in brass-10"


def test_messages_name_the_current_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert label_of("fcc-small", Path()) == f"fcc-small in {tmp_path.name}"
