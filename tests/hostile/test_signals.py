"""Runs stopped or killed at any time: a one-line message, and the same result after they are
resumed.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.conftest import PLAIN
from tests.hostile.rows import faults_in

CASE = [
    "fcc-small",
    "--set",
    "packing.size=[14,14,8]",
    "--set",
    "run.end_time=2e-4",
    "--set",
    "run.frames=5",
]
CASE += ["--set", "run.energy_tolerance=3e-8"]  # in many steps
CLOCK = ("wall_time_s", "sphere_steps_per_s")  # values of the summary that differ between all runs
MOMENTS = (
    0.2,
    0.5,
    1.0,
    1.5,
    2.0,
    3.0,
    4.0,
)  # s after the start: imports, deck, integration, analysis

pytestmark = pytest.mark.validation


def start(directory: Path, *options: str) -> subprocess.Popen[str]:
    """Start the run in a separate process."""
    command = [
        sys.executable,
        "-m",
        "granwave.workflows",
        "run",
        *CASE,
        "-o",
        str(directory),
        "--no-figures",
        *options,
    ]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=PLAIN
    )


def finish(directory: Path) -> None:
    """Resume the run until its end."""
    process = start(directory, "--resume")
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    assert not list(directory.glob("checkpoint-*")) and not list(directory.glob(".*lock"))


def result_of(directory: Path) -> dict[str, Any]:
    """All data sets of result.h5, and the summary."""
    summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    found: dict[str, Any] = {key: value for key, value in summary.items() if key not in CLOCK}
    with h5py.File(directory / "result.h5") as file:
        names: list[str] = []
        file.visititems(
            lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None
        )
        return found | {name: file[name][()] for name in names}


def compare(found: dict[str, Any], expected: dict[str, Any]) -> None:
    """Assert that fields are bitwise identical; sums over the packing, whose order a restart
    changes, agree to rounding.
    """
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        if name.startswith(("spheres/", "contacts/", "wall_contacts/")) or isinstance(value, str):
            assert np.array_equal(
                found[name], value, equal_nan=np.asarray(value).dtype.kind == "f"
            ), name
        elif name == "energy_balance_error":  # a difference of sums
            assert found[name] == pytest.approx(value, rel=1e-2)
        elif isinstance(value, float | np.ndarray) and np.asarray(value).dtype.kind == "f":
            scale = np.nanmax(np.abs(value), initial=0.0)
            np.testing.assert_allclose(
                found[name], value, rtol=1e-9, atol=1e-9 * scale, err_msg=name
            )
        else:
            assert np.array_equal(found[name], value), name


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Result of an uninterrupted run."""
    directory = tmp_path_factory.mktemp("undisturbed") / "run"
    process = start(directory)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    return result_of(directory)


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGKILL"])
def test_any_moment(undisturbed: dict[str, Any], tmp_path: Path, name: str, moment: float) -> None:
    process = start(tmp_path / "run", "--checkpoint", "0.3")
    time.sleep(moment)
    process.send_signal(signal.Signals[name])
    printed, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors
    had_ended = "results in" in printed and not faults_in(errors)
    if name == "SIGINT" and not had_ended:
        assert process.returncode == 130 and len(faults_in(errors)) == 1, errors
    finish(tmp_path / "run")
    compare(result_of(tmp_path / "run"), undisturbed)


def test_again_and_again(undisturbed: dict[str, Any], tmp_path: Path) -> None:
    for moment in (1.2, 1.4, 1.6, 1.8):
        process = start(tmp_path / "run", "--checkpoint", "0.2", "--resume")
        time.sleep(moment)
        process.kill()
        process.communicate(timeout=60)
    finish(tmp_path / "run")
    compare(result_of(tmp_path / "run"), undisturbed)
