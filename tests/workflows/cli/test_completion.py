"""Tab completion, as the shells ask for it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from argcomplete.finders import CompletionFinder
from argcomplete.lexers import split_line

from granwave.workflows import library
from granwave.workflows.cli.completion import with_completers
from granwave.workflows.cli.main import main
from granwave.workflows.cli.parser import make_parser
from granwave.workflows.cli.terminal import SHELLS, SWITCH_ON
from tests.conftest import BIN, PLAIN


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
