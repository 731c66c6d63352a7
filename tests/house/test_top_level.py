"""Files and folders at the top of the repository."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TOP = {
    ".ci",
    ".clang-format",
    ".gitignore",
    ".pre-commit-config.yaml",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "LICENSE",
    "Makefile",
    "NOTICE.md",
    "README.md",
    "README.png",
    "README.webp",
    "analysis",
    "docs",
    "extensions",
    "lammps_inputs",
    "plugins",
    "pyproject.toml",
    "reproductions",
    "tests",
    "workflows",
}


def test_nothing_else_at_the_top() -> None:
    """Directories of runs are not added to the repository."""
    listing = subprocess.run(
        ["git", "-C", str(ROOT), "ls-files"], capture_output=True, text=True, check=False
    )
    if listing.returncode:
        pytest.skip("no git repository")
    assert {line.split("/")[0] for line in listing.stdout.splitlines()} == TOP
