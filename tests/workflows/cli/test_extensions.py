"""The command line without extensions, with an extension whose package is missing, and with entries
of other packages.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import granwave as gw
from granwave.lammps_inputs import extensions as registry
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import Extension, extensions, with_added
from granwave.workflows import library
from granwave.workflows.cli.commands import LOOK, Command, option
from granwave.workflows.cli.installation import doctor
from granwave.workflows.cli.main import main
from granwave.workflows.cli.parser import commands, make_parser
from granwave.workflows.file_kinds import file_kinds
from granwave.workflows.solvers import GRANULAR, case_kinds
from tests.conftest import BIN, PLAIN

WITHOUT_ALL = PLAIN | {registry.WITHOUT: registry.ALL}
CORE = {command.name for command in commands() if command.function.startswith("granwave.workflows")}
OF_EXTENSIONS = {command.name for command in commands()} - CORE
BLOCK = "[block]\n[punch]\n"


def bare(*words: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command without any extension."""
    return subprocess.run(
        [BIN / "granwave", *words],
        env=WITHOUT_ALL,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


NEEDS_ALL = pytest.mark.needs_extension("continuum", "design", "inference", "pictures", "waves")

#: Entries of the extension `other`.
OTHERS: list[Command] = []


def other(**fields: Any) -> Extension:
    return Extension(name="other", title="another extension", **fields)


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Extension]]:
    """List of the extensions that are installed, to be changed by a test."""
    listed = list(extensions())
    monkeypatch.setattr(registry, "extensions", lambda: listed)
    yield listed


# ----------------------------------------------------------------------------- without extensions


@NEEDS_ALL
def test_the_core_has_its_own_commands():
    assert {"run", "scan", "check", "report", "law", "doctor"} <= CORE
    assert {"bands", "infer", "design", "continuum", "film"} <= OF_EXTENSIONS


@pytest.mark.parametrize(
    "words",
    [["--help"], ["keys"], ["cases"], ["check", "fcc-small"], ["doctor"]],
    ids=lambda words: words[0],
)
def test_commands_work_and_name_none_of_an_extension(words):
    done = bare(*words)
    assert done.returncode == 0, done.stderr
    for name in OF_EXTENSIONS:
        assert f"granwave {name}" not in done.stdout
        assert f"\n  {name} " not in done.stdout


def test_check_has_no_parts_of_extensions():
    values = json.loads(bare("check", "fcc-small", "--json").stdout)
    assert values["energy_input_normalised"] > 0
    assert not {"counterpart", "small_waves"} & set(values)


def test_there_are_the_cases_and_keys_of_the_core():
    listed = json.loads(bare("cases", "--json").stdout)
    assert {entry["group"] for entry in listed} == {
        "Packings",
        "Chains and single contacts",
        "Scans",
        "Suites of scans",
    }
    tables = json.loads(bare("keys", "--json").stdout)
    assert {table["file"] for table in tables} == {"case", "scan", "suite", "profile"}


def test_a_command_of_an_extension_is_not_known():
    done = bare("bands", "fcc-small")
    assert done.returncode == 2 and 'found "bands", expected one of cases, ' in done.stderr
    assert "it belongs to the extension waves, which GRANWAVE_WITHOUT hides" in done.stderr


@pytest.mark.parametrize("command", ["run", "check", "write"])
def test_a_case_of_an_extension_that_is_left_out(command, tmp_path):
    (tmp_path / "block.toml").write_text(BLOCK, encoding="utf-8")
    words = [command, "block.toml", *(["-o", "deck"] if command == "write" else [])]
    done = bare(*words, folder=tmp_path)
    assert done.returncode == 2
    words = "block.toml: unknown kind of case; it belongs to the extension continuum"
    assert words in done.stderr and "which GRANWAVE_WITHOUT hides" in done.stderr
    assert os.listdir(tmp_path) == ["block.toml"]


@NEEDS_ALL
@pytest.mark.parametrize("words", [("run", "half-space"), ("scan", "sphere-contacts", "--plan")])
def test_a_built_in_study_of_an_extension_that_is_left_out(words):
    done = bare(*words)
    assert done.returncode == 2
    assert f"{words[1]}: it belongs to the extension continuum" in done.stderr


def test_a_file_of_an_extension_that_is_left_out(tmp_path):
    (tmp_path / "design.toml").write_text('base = "fcc-small"\n[variables]\n', encoding="utf-8")
    done = bare("check", "design.toml", folder=tmp_path)
    words = "design.toml: unknown kind of file; it belongs to the extension design"
    assert done.returncode == 2 and words in done.stderr


PYTHON = """
import granwave
from granwave import *
print(*granwave.__all__)
print(hasattr(granwave, "run"), hasattr(granwave, "bands"))
"""


def test_python_has_the_names_of_the_core():
    done = subprocess.run(
        [sys.executable, "-c", PYTHON],
        env=WITHOUT_ALL,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    names, found = done.stdout.splitlines()
    assert set(names.split()) == set(gw.__all__) - set(registry.added_by_name("python"))
    assert found == "True False"


# ----------------------------------------------------------------------------- with extensions


@NEEDS_ALL
def test_all_commands_have_their_place():
    """Groups are in the order of the list, and the commands of extensions follow those of the core."""
    groups = list(dict.fromkeys(command.group for command in commands()))
    assert groups == [
        "find and check a case",
        "run",
        "look at results",
        "small waves",
        "contacts",
        "the installation",
    ]
    of_run = [command.name for command in commands() if command.group == "run"]
    assert of_run == ["run", "scan", "design", "continuum", "write", "analyse"]


def test_kinds_of_cases_name_their_kind_of_file():
    names = {kind.name for kind in file_kinds()}
    assert {kind.file_kind for kind in case_kinds()} <= names
    assert case_kinds()[0] is GRANULAR
    headings = {entry.group for entry in library.entries()}
    assert {kind.heading for kind in case_kinds() if kind is not GRANULAR} <= headings


@pytest.mark.needs_extension("design")
def test_a_missing_package_is_named_with_its_extra(monkeypatch, capsys):

    def fail(*_: object) -> int:
        raise ModuleNotFoundError("No module named 'sklearn'", name="sklearn")

    monkeypatch.setattr(Command, "run", fail)
    assert main(["doctor"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    words = "scikit-learn is not installed, but the extension design requires it"
    assert line == f'granwave: {words}: pip install "granwave[design]"'


def test_a_missing_package_is_named_in_python(installed):
    installed[:] = [
        other(packages={"absent": "absent-1"}, extra="mine", python={"own": "absent.module:own"})
    ]
    words = (
        r"absent-1 is not installed, but the extension other requires it: pip install "
        r'"granwave\[mine\]"'
    )
    with pytest.raises(InputError, match=words):
        _ = gw.own


def test_any_other_missing_module_is_an_error(monkeypatch):
    def fail(*_: object) -> int:
        raise ModuleNotFoundError("No module named 'nothing'", name="nothing")

    monkeypatch.setattr(Command, "run", fail)
    with pytest.raises(ModuleNotFoundError):
        main(["doctor"])


@pytest.mark.needs_extension("inference")
def test_the_doctor_lists_extensions_and_what_they_lack(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "examine", lambda profile: [])
    assert main(["doctor", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["extensions"]
    assert [one["name"] for one in listed] == [one.name for one in extensions()]
    assert all(one["title"] and one["distribution"].startswith("granwave ") for one in listed)
    monkeypatch.setattr(doctor, "find_spec", lambda name: None if name == "clarabel" else name)
    assert main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    place = next(n for n, line in enumerate(lines) if line.startswith("lack  extension inference"))
    assert 'require clarabel: pip install "granwave[inference]"' in lines[place + 1]


# ----------------------------------------------------------------------------- entries of others


def test_a_command_from_outside(installed, capsys):
    function = f"{__name__}:print_word"
    OTHERS[:] = [Command("mine", LOOK, "what I want", function, (option("word"),), after="figures")]
    installed.append(other(commands=f"{__name__}:OTHERS"))
    names = [command.name for command in commands()]
    assert names.index("mine") == names.index("figures") + 1
    assert main(["mine", "hello"]) == 0
    assert capsys.readouterr().out == "hello\n"


def print_word(options) -> int:
    print(options.word)
    return 0


def test_a_name_that_is_taken(installed, capsys):
    OTHERS[:] = [Command("run", LOOK, "another run", f"{__name__}:print_word")]
    installed.append(other(commands=f"{__name__}:OTHERS"))
    with pytest.raises(
        InputError, match="commands run: both granwave itself and the extension other"
    ):
        make_parser()
    assert main(["cases"]) == 2
    assert "commands run: both granwave itself" in capsys.readouterr().err


def test_entries_stand_behind_those_that_they_name(installed):
    installed[:] = [other(file_kinds=f"{__name__}:OTHERS")]
    first = Command("first", LOOK, "", "")
    last = Command("last", LOOK, "", "")
    OTHERS[:] = [
        Command("second", LOOK, "", "", after="first"),
        Command("end", LOOK, "", "", after="nothing"),
    ]
    listed = with_added([first, last], "file_kinds")
    assert [entry.name for entry in listed] == ["first", "second", "last", "end"]
