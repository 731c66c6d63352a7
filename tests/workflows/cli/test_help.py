"""Help, options, completion of words, start-up, and memory that a command may need."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from argcomplete.finders import CompletionFinder
from argcomplete.lexers import split_line

from granwave.lammps_inputs.case.contact import LAWS
from granwave.lammps_inputs.errors import RunError
from granwave.workflows import library
from granwave.workflows.__main__ import run
from granwave.workflows.cli import package
from granwave.workflows.cli.completion import with_completers
from granwave.workflows.cli.main import FAILED, main
from granwave.workflows.cli.parser import make_parser
from granwave.workflows.cli.terminal import SHELLS, SWITCH_ON
from granwave.workflows.run.lammps_engine import Engine
from tests.conftest import BIN, PLAIN


def on_terminal(*words: str, **variables: str) -> str:
    """Output of a command that writes to a terminal."""
    ours, theirs = pty.openpty()
    environment = {name: value for name, value in PLAIN.items() if name != "NO_COLOR"} | {"TERM": "xterm"} | variables
    process = subprocess.Popen([BIN / "granwave", *words], stdout=theirs, stderr=theirs, env=environment)
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


def test_cases_in_one_screen(capsys):
    assert main(["cases"]) == 0
    found = capsys.readouterr().out
    assert found.count("\n") <= 40
    assert {entry.name for entry in library.entries()} <= set(found.split())
    assert main(["cases", "--all"]) == 0
    everything = capsys.readouterr().out.splitlines()
    assert all(any(entry.title in line for line in everything) for entry in library.entries())
    assert main(["cases", "switch"]) == 0
    assert "cylinders between plates open its gaps" in capsys.readouterr().out


def test_help_in_groups(capsys):
    assert main(["help"]) == 0
    shown = capsys.readouterr().out
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    assert capsys.readouterr().out == shown
    places = [shown.index(text) for text in ("\nrun:", "  continuum ", "\nlook at results:", "  film ")]
    assert places == sorted(places)
    assert main(["help", "film"]) == 0
    assert capsys.readouterr().out.startswith("usage: granwave film ")
    with pytest.raises(SystemExit, match="2"):
        main(["help", "flim"])
    assert "did you mean film?" in capsys.readouterr().err


def test_keys_by_words_of_choices_and_descriptions(capsys):
    assert main(["keys", "gravity"]) == 0
    found = capsys.readouterr().out
    assert found.startswith("[precompression]") and 'expects one of "uniaxial", "uniform", "gravity"' in found
    assert main(["keys", "random", "share"]) == 0
    assert "[[replace]]" in capsys.readouterr().out


def test_colours_on_terminals_alone():
    assert "\033[1mPackings:\033[0m" in on_terminal("cases")
    assert "\033[31mgranwave:\033[0m" in on_terminal("show", "no-such-case")
    assert "\033[" not in on_terminal("cases", NO_COLOR="1") + on_terminal("cases", TERM="dumb")
    done = subprocess.run([BIN / "granwave", "cases"], capture_output=True, text=True, env=PLAIN)
    assert "\033[" not in done.stdout


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["check", "fcc-small", "--np", "two"], "--np: found two, expected a number"),
        (["check", "fcc-small", "--np", "0"], "--np: found 0, expected a whole number, 1 or more"),
        (["run", "fcc-small", "--np", "1.5"], "--np: found 1.5, expected a whole number, 1 or more"),
        (["run", "fcc-small", "--np", "nan"], "--np: found nan, expected a whole number, 1 or more"),
        (["run", "fcc-small", "--checkpoint", "-5"], "--checkpoint: found -5, expected a number above 0 (s)"),
        (["run", "fcc-small", "--checkpoint", "inf"], "--checkpoint: found inf, expected a number above 0 (s)"),
        (["run", "fcc-small", "--checkpoint", "soon"], "--checkpoint: found soon, expected a number"),
        (["run", "fcc-small", "-o", ""], '-o: found the empty name'),
        (["scan", "restitution", "--jobs", "x"], "--jobs: found x, expected a number"),
        (["scan", "restitution", "--jobs", ""], "--jobs: found nothing, expected a number"),
        (["scan", "restitution", "--profile", " "], "--profile: is for --executor slurm; leave it out"),
        (["bench", "--repeats", "0"], "--repeats: found 0, expected a whole number, 1 or more"),
        (["bench", "--parts", "styles,speed"], "--parts: found speed, expected some of styles,sizes,ranks,study"),
        (["law", "--radius", "x"], "--radius: found x, expected a number"),
        (["law", "--radius", "1e300"], "--radius: found 1e300, expected a length from 1e-18 to 1e+06 m"),
        (["law", "--radius", "nan"], "--radius: found nan, expected a length from 1e-18 to 1e+06 m"),
        (["law", "--max-overlap", "1e300"], "--max-overlap: found 1e300, expected a number above 0 and at most 1e+06"),
        (["law", "--law", "hertzz"], f'--law: found "hertzz", expected one of {", ".join(LAWS)}; did you mean hertz?'),
        (["rn", "fcc-small"], "did you mean run?"),
        (["run"], "the following arguments are required: CASE; granwave run --help tells more"),
        (["run", "fcc-small", "--velocity", "3"], "unrecognized arguments: --velocity 3; keys of a case are set by --set"),
        (["run", "fcc-small", "--resume", "--force"], "--force: not allowed with argument --resume"),
        (["check", "fcc-small", "--set", "packing.size=4,4,3"], "expected a TOML value or a bare word; a list is [4,4,3]"),
        (["check", "fcc-small", "--set", "velocity"], 'found "velocity", expected KEY=VALUE such as load.velocity=10'),
        (["check", "fcc-small", "--set", "replace.1.index=2"], "found no [[replace]] tables, expected 1 or more"),
        (["check", "fcc-small", "--set", "name=-rf"], 'name: found "-rf", expected a plain name'),
        (["check", "fcc-small", "--set", 'name=" x"'], 'name: found " x", expected a plain name'),
        (["check", "./-x.toml"], "from the name of the file: give the case a name of its own"),
        (["scan", "./-scan.toml", "--plan"], 'name: found "-scan", expected a plain name'),
    ],
)  # fmt: skip
def test_one_line_says_what_is_wrong(
    words: list[str], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "-x.toml").write_text('material = "brass"\n[packing]\nkind = "chain"\nsize = 2\ndiameter = 0.01\n')
    (tmp_path / "-scan.toml").write_text('case = "fcc-small"\n[grid]\nload.velocity = [1]\n')
    before = sorted(tmp_path.rglob("*"))
    try:
        status = main(words)
    except SystemExit as end:
        status = int(end.code or 0)
    said = capsys.readouterr().err
    assert status == 2 and said.count("\n") == 1 and said.startswith("granwave: ") and expected in said
    assert sorted(tmp_path.rglob("*")) == before


SCRIPT = """
import sys
from granwave.workflows.cli.main import main
status = main(["check", "fcc-small"])
loaded = {name.partition(".")[0] for name in sys.modules}
print("loaded:", *sorted(loaded & {"scipy", "h5py", "matplotlib", "mpi4py", "lammps", "pandas", "tqdm"}))
sys.exit(status)
"""


def test_check_loads_no_large_library():
    """Each takes about as long to load as all the rest of the command."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=60, env=PLAIN)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].split() == ["loaded:"]


def test_a_timestep_that_is_too_long(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    changes = ["packing.size=[4,4,3]", "run.end_time=4e-5", "run.timestep=4e-7"]
    words = [word for change in changes for word in ("--set", change)]
    monkeypatch.setattr(sys, "argv", ["granwave", "run", "fcc-small", *words, "-o", "long", "--no-figures"])
    assert run() == 1
    error = capsys.readouterr().err
    assert "the energy balance was refused: it misses by" in error and "leave out run.timestep" in error
    assert (tmp_path / "long" / "summary.json").is_file()


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
    assert len(lines) == 1 and "there is not enough memory" in lines[0] and str(error) in lines[0]


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

    with pytest.raises(RunError, match=r"there is not enough memory .*192282624 bytes"):
        Engine(Lammps()).commands("run 1")


def completed(line: str) -> list[str]:
    """Return what a line is completed by; a shell cuts what stands before "=" itself."""
    quote, prefix, _, words, _ = split_line(line)
    finder = CompletionFinder(with_completers(make_parser()), always_complete_options=False)
    return [word.strip() for word in finder._get_completions(words, prefix, quote, None)]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("granwave ch", ["check"]),
        ("granwave run --re", ["--resume"]),
        ("granwave run fcc-sm", ["fcc-small"]),
        ("granwave continuum half", ["half-space"]),
        ("granwave run half", []),
        ("granwave scan velocity-f", ["velocity-fcc"]),
        ("granwave show velocity-f", ["velocity-fcc"]),
        ("granwave run fcc-small --set load.vel", ["load.velocity="]),
        ("granwave run fcc-small --set packing.kind=hc", ["packing.kind=hcp"]),
        ("granwave run fcc-small --set run.end_time=", ["run.end_time=auto"]),
        ("granwave run fcc-small --set load.spheres=", ["load.spheres=1", "load.spheres=3", "load.spheres=7"]),
        ("granwave run fcc-small --set replace.1.mat", ["replace.1.material="]),
        ("granwave run fcc-small --set material=steel", ["material=steel"]),
        ("granwave continuum half-space --set punch.v", ["punch.velocity="]),
        ("granwave continuum sphere-contact --set run.max", ["run.max_overlap="]),
        ("granwave law --material steel", ["steel"]),
        ("granwave keys load.vel", ["load.velocity"]),
        ("granwave export run --to v", ["vtp"]),
        ("granwave report run --study tol", ["tolerance"]),
        ("granwave bench --parts styles,ra", ["styles,ranks"]),
        ("granwave scan velocity-fcc --executor s", ["slurm"]),
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
    """The whole way: the line of the start page, and a TAB as bash makes it."""
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
    done = subprocess.run(["bash", "-c", words], capture_output=True, text=True, env=environment, timeout=120)
    assert done.stdout.split() == ["fcc-small"], done.stderr
