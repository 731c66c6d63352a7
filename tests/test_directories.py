"""Output directories that may hold results, and files that are replaced whole or not at all."""

from __future__ import annotations

import json
import math
import tomllib

import numpy as np
import pytest

from granwave.lammps_inputs.directories import check_disk, clear, decide
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import plain, read_json, replace_text, replacing

RESULTS = ("case.toml", "summary.json", "figures", "log")
CASE = {"name": "a", "load": {"velocity": 5.0}}


def ask(directory, *, resume=False, force=False, case=CASE):
    return decide(
        directory, RESULTS, resume=resume, force=force, case=case, read=lambda path: tomllib.loads(path.read_text())
    )


@pytest.fixture
def filled(tmp_path):
    """A directory with results of `CASE`, and with something of the user's."""
    directory = tmp_path / "r"
    (directory / "figures").mkdir(parents=True)
    (directory / "case.toml").write_text('name = "a"\n[load]\nvelocity = 5.0\n')
    for name in ("summary.json", "log", "notes.txt", "figures/a.png"):
        (directory / name).write_text("{}")
    return directory


@pytest.mark.parametrize("words", [{}, {"resume": True}, {"force": True}])
def test_where_nothing_is_a_start_is_allowed(tmp_path, words):
    (tmp_path / "notes.txt").write_text("mine")
    for directory in (tmp_path, tmp_path / "new"):
        assert ask(directory, **words) is False
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_results_are_refused_resumed_or_replaced(filled):
    with pytest.raises(InputError) as caught:
        ask(filled)
    assert str(caught.value) == (
        f"{filled}: already holds results (case.toml, summary.json, figures, ...); "
        "--resume goes on with them, --force replaces them, or choose another directory with -o"
    )
    assert ask(filled, resume=True) is True
    assert ask(filled, force=True) is False
    clear(filled, RESULTS)
    assert [path.name for path in filled.iterdir()] == ["notes.txt"]


def test_another_case_is_not_resumed(filled):
    other = {"name": "a", "load": {"velocity": 6.0}, "run": {}}
    with pytest.raises(InputError, match=r"holds another case \(different: load, run\); --force replaces it"):
        ask(filled, resume=True, case=other)
    assert ask(filled, force=True, case=other) is False


def test_results_without_a_case_are_not_resumed(filled):
    (filled / "case.toml").unlink()
    with pytest.raises(InputError, match=r"already holds results \(summary\.json, figures, log\);"):
        ask(filled, resume=True)


def test_words_and_places_that_make_no_sense(filled):
    with pytest.raises(InputError, match="exclude each other"):
        ask(filled, resume=True, force=True)
    with pytest.raises(InputError, match="is a file, expected a directory"):
        ask(filled / "log", force=True)


def test_disk_that_is_too_small(tmp_path):
    check_disk(tmp_path / "not" / "yet", 1.0)
    check_disk(tmp_path, 0.0, spare=1e30)
    for needed, spare in ((1e30, 0.0), (1.0, 1e30)):
        with pytest.raises(InputError, match=r"the points need about .* GB, .* GB are free there"):
            check_disk(tmp_path, needed, what="the points", spare=spare)


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
    assert json.loads(text) == {"a": 1.5, "b": None, "c": [3, None, "x"], "d": {"e": None, "f": True}}
