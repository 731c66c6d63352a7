"""Lists that fit on a screen, help in groups, search in keys, colours on terminals."""

from __future__ import annotations

import os
import pty
import subprocess

import pytest

from granwave.workflows import library
from granwave.workflows.cli.main import main
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
