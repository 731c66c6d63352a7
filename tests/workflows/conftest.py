"""A finished run of two spheres, made once."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from granwave.workflows import run_case
from tests.helpers.made_up.small_cases import TWO_SPHERES


@pytest.fixture(scope="session")
def whole(tmp_path_factory) -> Path:
    """Finished run."""
    directory = tmp_path_factory.mktemp("whole") / "r"
    run_case(TWO_SPHERES, directory, figures=False)
    return directory


@pytest.fixture
def run(whole: Path, tmp_path: Path) -> Path:
    """Copy of the finished run, to be damaged."""
    return shutil.copytree(whole, tmp_path / "r")
