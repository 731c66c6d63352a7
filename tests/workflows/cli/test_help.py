"""Help, options, completion of words, start-up, and memory that a command may need."""

from __future__ import annotations

import dataclasses
import json
import os
import pty
import subprocess
import sys
import tomllib
from types import SimpleNamespace

import pytest

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.case import case_keys
from granwave.lammps_inputs.case.loads.registry import load_section, read_load
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.extensions import load
from granwave.workflows import library
from granwave.workflows.cli import package
from granwave.workflows.cli.keys import reference
from granwave.workflows.cli.main import FAILED, main
from granwave.workflows.cli.parser import make_parser
from granwave.workflows.cli.terminal import BOLD, SHELLS, SWITCH_ON, coloured
from granwave.workflows.file_kinds import CASE_FILE, file_kinds
from granwave.workflows.run.lammps_engine import Engine
from tests.conftest import BIN, PLAIN
from tests.helpers.programs.completion import completed


def on_terminal(*words: str) -> str:
    """Output of a command that writes to a terminal."""
    ours, theirs = pty.openpty()
    environment = {name: value for name, value in PLAIN.items() if name != "NO_COLOR"} | {
        "TERM": "xterm"
    }
    process = subprocess.Popen(
        [BIN / "granwave", *words], stdout=theirs, stderr=theirs, env=environment
    )
    os.close(theirs)
    found = b""
    try:
        while chunk := os.read(ours, 65536):
            found += chunk
    except OSError:  # the end, under Linux
        pass
    os.close(ours)
    process.wait(timeout=60)
    return found.decode()


def test_cases_in_one_screen_and_by_words(granwave):
    entries = library.entries()
    brief = granwave("cases").stdout
    assert brief.count("\n") <= 40 and {entry.name for entry in entries} <= set(brief.split())
    listed = granwave("cases", "--all").stdout.splitlines()
    assert all(
        any(line.startswith(f"{one.kind}  {one.name} ") and one.title in line for line in listed)
        for one in entries
    )
    groups = [line for line in listed if line.endswith(":")]
    assert (
        groups[0] == "Packings:"
        and len(groups) >= 4
        and listed.index("Suites of scans:") > listed.index("Scans:")
    )
    few = granwave("cases", "chain", "bilinear").stdout.splitlines()
    assert any(line.startswith("case  bilinear-pulse ") for line in few) and not any(
        "fcc" in line for line in few
    )
    everything = json.loads(granwave("cases", "--json").stdout)
    assert len(everything) == len(entries) and set(everything[0]) == {
        "kind",
        "name",
        "group",
        "title",
    }
    done = granwave("cases", "nonsense")
    assert (
        done.returncode == 2
        and "nonsense: no built-in case or scan contains these words" in done.stderr
    )


def test_help_in_groups(capsys):
    assert main(["help"]) == 0
    shown = capsys.readouterr().out
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    assert capsys.readouterr().out == shown
    places = [
        shown.index(text) for text in ("\nrun:", "  scan ", "\nlook at results:", "  report ")
    ]
    assert places == sorted(places)
    assert main(["help", "report"]) == 0
    assert capsys.readouterr().out.startswith("usage: granwave report ")
    with pytest.raises(SystemExit, match="2"):
        main(["help", "reprot"])
    assert "did you mean report?" in capsys.readouterr().err


def test_colours_on_terminals_alone(granwave, monkeypatch):
    assert "\033[31mgranwave:\033[0m" in on_terminal("show", "no-such-case")
    assert "\033[" not in granwave("cases").stdout
    terminal = SimpleNamespace(isatty=lambda: True)
    for name, value, shown in (
        ("TERM", "xterm", "\033[1mx\033[0m"),
        ("NO_COLOR", "1", "x"),
        ("TERM", "dumb", "x"),
    ):
        with monkeypatch.context() as patch:
            patch.delenv("NO_COLOR", raising=False)
            patch.setenv(name, value)
            assert coloured("x", BOLD, terminal) == shown


SCRIPT = """
import sys
from granwave.workflows.cli.main import main
status = main(["check", "fcc-small"])
loaded = {name.partition(".")[0] for name in sys.modules}
print("loaded:", *sorted(loaded & {"scipy", "h5py", "matplotlib", "mpi4py", "lammps", "pandas", "tqdm"}))
sys.exit(status)
"""


def test_check_loads_no_large_library():
    """Each of these modules takes about as long to load as the rest of the command."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=60, env=PLAIN
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].split() == ["loaded:"]


@pytest.mark.parametrize(
    "error",
    [
        MemoryError("cannot allocate 3 GiB"),
        ImportError("libx.so: failed to map segment from shared object"),
        ImportError("libx.so: cannot allocate memory in static TLS block"),
    ],
)
def test_one_line_and_the_status_of_a_failure(monkeypatch, capsys, error):
    def fail(*_):
        raise error

    monkeypatch.setattr(package, "keys", fail)
    assert main(["keys"]) == FAILED
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and "not enough memory" in lines[0] and str(error) in lines[0]


def test_a_missing_module_is_not_taken_for_it(monkeypatch):
    def fail(*_):
        raise ImportError("no module named x")

    monkeypatch.setattr(package, "keys", fail)
    with pytest.raises(ImportError):
        main(["keys"])


def test_in_lammps():
    class Lammps:
        def commands_string(self, text):
            raise Exception(
                "ERROR on proc 0: Failed to reallocate 192282624 bytes for array atom:v (src/memory.cpp:102)"
            )

    with pytest.raises(RunError, match=r"not enough memory .*192282624 bytes"):
        Engine(Lammps()).commands("run 1")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("granwave ch", ["check"]),
        ("granwave run --re", ["--resume"]),
        ("granwave run fcc-sm", ["fcc-small"]),
        ("granwave run half", []),
        ("granwave scan velocity-f", ["velocity-fcc"]),
        ("granwave show velocity-f", ["velocity-fcc"]),
        ("granwave run fcc-small --set load.vel", ["load.velocity="]),
        ("granwave run fcc-small --set packing.kind=hc", ["packing.kind=hcp"]),
        ("granwave run fcc-small --set run.end_time=", ["run.end_time=auto"]),
        ("granwave run fcc-small --set load.spheres=", ["load.spheres=1", "load.spheres=3", "load.spheres=7"]),
        ("granwave run fcc-small --set replace.1.mat", ["replace.1.material="]),
        ("granwave run fcc-small --set material=steel", ["material=steel"]),
        (
            "granwave run fcc-small --set contact.loss.ti",
            ["contact.loss.time=", "contact.loss.times="],
        ),
        ("granwave run fcc-small --set contact.cohesion.kind=d", ["contact.cohesion.kind=dmt"]),
        ("granwave run fcc-small --set grains.1.ring.g", ["grains.1.ring.gap="]),
        ("granwave run fcc-small --set output.probes.1.s", ["output.probes.1.sphere="]),
        ("granwave run fcc-small --set figures.view=", ["figures.view=true", "figures.view=false"]),
        ("granwave law --material steel", ["steel"]),
        ("granwave keys load.vel", ["load.velocity"]),
        ("granwave export run --to c", ["csv"]),
        ("granwave report run --study tol", ["tolerance"]),
        ("granwave bench --parts styles,ra", ["styles,ranks"]),
        ("granwave scan velocity-fcc --executor sl", ["slurm"]),
        ("granwave completion z", ["zsh"]),
    ],
)  # fmt: skip
def test_words(line, words, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert completed(line) == words


def test_case_files_and_names_without_options(monkeypatch, tmp_path):
    (tmp_path / "mine.toml").touch()
    (tmp_path / "mine.txt").touch()
    monkeypatch.chdir(tmp_path)
    found = completed("granwave check ")
    assert set(found) == {*library.names(), "mine.toml"}


@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_has_its_code(shell, capsys):
    assert main(["completion", shell]) == 0
    assert "granwave" in capsys.readouterr().out
    assert f"granwave completion {shell}" in SWITCH_ON[shell][0]


def test_bash_completes(tmp_path):
    """The complete path: the line of the start page, and a TAB as in bash."""
    words = """
eval "$(granwave completion bash)"
COMP_LINE="granwave run fcc-sm" COMP_POINT=19 COMP_TYPE=9 COMP_WORDS=(granwave run fcc-sm) COMP_CWORD=2
_python_argcomplete granwave fcc-sm run
echo "${COMPREPLY[@]}"
"""
    path = tmp_path / "granwave"
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m granwave.workflows "$@"\n')
    path.chmod(0o755)
    environment = PLAIN | {"PATH": f"{tmp_path}{os.pathsep}{BIN}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-c", words], capture_output=True, text=True, env=environment, timeout=120
    )
    assert done.stdout.split() == ["fcc-small"], done.stderr


SECTIONS: dict[tuple[str, str], type] = {}
for kind in file_kinds():
    for heading, (section, _) in load(kind.sections)().items():
        SECTIONS[kind.name, heading.strip("[]") or kind.name] = section
# tables and words that code other than the validator of the field reads
ELSEWHERE = {("boundary", "bottom"), ("load", "file")}


def example(key: reference.Key) -> object:
    (value,) = tomllib.loads(key.example).values()
    return value


def test_every_key_that_is_read_is_listed():
    listed = {
        f"{table.name}.{key.name}"
        for table in reference.tables()
        if table.file == CASE_FILE.name
        for key in table.keys
    }
    known = {key.replace(".1.", ".") for key in case_keys() if "." in key}
    assert known <= listed
    assert {field.name for field in dataclasses.fields(load_section())} <= {
        key.name for key in reference.find("load")[0].keys
    }


@pytest.mark.parametrize(
    "table", reference.tables(), ids=lambda table: f"{table.file}-{table.name}"
)
def test_every_key_has_what_a_reader_needs(table):
    assert table.description and table.keys
    for key in table.keys:
        assert key.description and key.accepts != "any value", key.name
        assert not (key.required and key.default), key.name
        assert key.example.split(" = ", 1)[1], f"{key.name}: give an example in key_examples.toml"
        example(key)  # is TOML


@pytest.mark.parametrize(("file", "name"), SECTIONS)
def test_examples_are_valid(file, name):
    """The example of a key is read, and the value written again is read as the same value."""
    (table,) = [table for table in reference.tables() if (table.file, table.name) == (file, name)]
    fields = {field.name: field for field in dataclasses.fields(SECTIONS[file, name])}
    for key in table.keys:
        if key.name not in fields or (name, key.name) in ELSEWHERE:
            continue
        info = schema.info_of(fields[key.name])
        if info.reader is None:
            value = info.type.read(example(key))
            assert value is not None
            assert info.type.read(example(key)) == value


def test_no_example_of_a_key_that_does_not_exist():
    for file, tables in reference._examples().items():
        for name, examples in tables.items():
            (table,) = [
                table for table in reference.tables() if (table.file, table.name) == (file, name)
            ]
            assert set(examples) <= {key.name for key in table.keys}, (file, name)


def test_a_load_knows_its_file():
    errors = ErrorList("case")
    read_load({"kind": "force", "file": "no-such-file"}, errors)
    assert "cannot be read" in errors.lines[0]


def test_keys_by_name_and_by_words(granwave):
    """Tables, keys (whose words may be separate), and words of choices and descriptions."""
    shown = granwave("keys").stdout
    assert all(f"  {table.name} " in shown for table in reference.tables())
    assert (
        "diameter  m  required\n    diameter of the spheres; with a file"
        in granwave("keys", "packing").stdout
    )
    assert (
        granwave("keys", "run.end_time").stdout.count("end_time  s  default") >= 1
    )  # of kinds of files that have it
    assert granwave("keys", "[[replace]]").returncode == 0
    apart = granwave("keys", "load", "velocity").stdout
    assert granwave("keys", "load.velocity").stdout == apart and "m/s" in apart
    wrong = granwave("keys", "load", "velocty")
    assert (
        wrong.returncode == 2
        and "load.velocty: no such table or key; did you mean load.velocity?" in wrong.stderr
    )
    found = granwave("keys", "gravity").stdout
    assert (
        found.startswith("[precompression]")
        and 'expects one of "uniaxial", "uniform", "gravity"' in found
    )
    assert "[[replace]]" in granwave("keys", "random", "share").stdout


def test_usual_magnitudes_are_those_that_messages_name():
    """For bodies that represent rigid ones, warnings begin at far larger values, and the text
    states the limit.
    """
    found = {
        key.name: key.usual
        for table in reference.tables()
        for key in table.keys
        if table.name in ("material", "packing")
    }
    assert found["diameter"] == "usual: 1e-6 to 1 m; other values give a warning"
    assert (
        found["youngs_modulus"]
        == "usual: 1e6 to 1e12 Pa; below, and above 1e14 Pa, a warning is given"
    )


@pytest.mark.parametrize("text", ["-12e-6", "-1.5E3", "-.5", "-3"])
def test_negative_numbers_with_exponents_are_values_of_options(text):
    words = ["compare", "a", "b", "--shift", text]
    assert make_parser(words).parse_args(words).shift == float(text)
