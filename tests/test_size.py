"""Size of the rooms: what was made smaller stays small. Whoever makes one smaller still lowers its number here."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STATEMENTS = {"analysis": 19100, "lammps_inputs": 8600, "workflows": 7650}
FILES = 300  # of these together
LINES = {"reproductions": 9000, "plugins": 9500}


def sources(room: str) -> Iterator[str]:
    for path in sorted((ROOT / room).rglob("*.*")):
        if path.suffix in (".py", ".cpp", ".h") and (room != "plugins" or path.suffix != ".py"):
            yield path.read_text(encoding="utf-8")


@pytest.mark.parametrize("room", STATEMENTS)
def test_statements(room: str) -> None:
    assert (
        sum(isinstance(node, ast.stmt) for text in sources(room) for node in ast.walk(ast.parse(text)))
        <= STATEMENTS[room]
    )


@pytest.mark.parametrize("room", LINES)
def test_lines(room: str) -> None:
    assert sum(text.count("\n") for text in sources(room)) <= LINES[room]


def test_files() -> None:
    assert sum(1 for room in STATEMENTS for _ in sources(room)) <= FILES
