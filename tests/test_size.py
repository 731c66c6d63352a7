"""Size of the rooms: what was made smaller stays small. Whoever makes one smaller still lowers its number here."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STATEMENTS = {"analysis": 17070, "lammps_inputs": 8050, "workflows": 9595}
FILES = 284  # of these together
TOP = {
    ".ci", ".clang-format", ".gitignore", ".pre-commit-config.yaml", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE",
    "Makefile", "NOTICE.md", "README.md", "README.png", "README.webp", "analysis", "docs", "lammps_inputs", "plugins",
    "pyproject.toml", "reproductions", "tests", "workflows",
}  # fmt: skip
LINES = {"reproductions": 8985, "plugins": 11475, "tests": 35534}


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


def test_nothing_else_at_the_top() -> None:
    """Directories of runs that were made here do not get into the repository."""
    tracked = subprocess.run(["git", "-C", str(ROOT), "ls-files"], capture_output=True, text=True, check=False)
    if tracked.returncode:
        pytest.skip("no git repository")
    assert {line.split("/")[0] for line in tracked.stdout.splitlines()} == TOP
