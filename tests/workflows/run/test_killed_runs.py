"""Runs that are killed half-way and resumed: the results have the bits of a run that was left alone.

The sums of the energy ledger agree to rounding: a restart changes the order of their terms.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.conftest import PLAIN

pytestmark = pytest.mark.validation

_LONGEST = 120.0  # s
_ROUNDING = 1e-14  # of sums, over their largest value
RUNS = {
    "plate": ["lateral-square", "run.end_time=3e-3"],  # strikes cylinders with friction, loss and two [[line]]s
    "driven row": ["driven-row", "run.end_time=8e-3", 'line=[{name = "all", index = "all"}]'],
    "moving floor": [
        "fcc-small", "packing.size=[12,12,8]", "run.end_time=4e-4", "run.energy_tolerance=3e-8", "contact.friction=0.2",
        "boundary.bottom={plate = {mass = 0.1, stiffness = 1e7, damping = 5.0}}", 'line=[{name = "down"}]',
    ],
    "in parts": ["fcc-small", "packing.size=[12,12,8]", "run.end_time=2e-4", "output.parts=true"],
}  # fmt: skip


def start(name: str, directory: Path, *options: str) -> subprocess.Popen[str]:
    """Start a run in a process of its own."""
    case, *settings = RUNS[name]
    words = [case, *(f"--set={one}" for one in settings), "-o", str(directory), "--no-figures", *options]
    command = [sys.executable, "-m", "granwave.workflows", "run", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=PLAIN)


def finish(process: subprocess.Popen[str]) -> None:
    """Wait for the end of a run."""
    _, errors = process.communicate(timeout=_LONGEST)
    assert process.returncode == 0, errors


def time_reached(directory: Path) -> float:
    """Time of the last whole row of the energy ledger, s; 0 before there is one."""
    path = directory / "dumps" / "energy.txt"
    rows = path.read_text(encoding="utf-8").splitlines()[2:-1] if path.exists() else []
    return float(rows[-1].split()[1]) if rows else 0.0


def kill_half_way(process: subprocess.Popen[str], directory: Path, end_time: float) -> None:
    """Kill a run as soon as it has a checkpoint and is half-way."""
    end = time.monotonic() + _LONGEST
    while time_reached(directory) < end_time / 2 or not list(directory.glob("checkpoint-*.restart")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.005)
    process.kill()
    process.communicate(timeout=_LONGEST)


def values(directory: Path) -> dict[str, np.ndarray]:
    """Data sets of result.h5 by name."""
    found = {}
    with h5py.File(directory / "result.h5") as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


@pytest.mark.parametrize("name", RUNS)
def test_a_killed_run_ends_with_the_same_bits(tmp_path: Path, name: str) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    finish(start(name, whole))
    end_time = json.loads((whole / "summary.json").read_text(encoding="utf-8"))["end_time_s"]
    ranks = {"in parts": (3, 2)}.get(name, (1, 1))  # before and after: any number reads what others wrote
    kill_half_way(start(name, killed, "--checkpoint", "0.05", f"--np={ranks[0]}"), killed, end_time)
    assert not (killed / "summary.json").exists()
    step = json.loads((killed / "run.json").read_text(encoding="utf-8"))["checkpoint"]["step"]
    finish(start(name, killed, "--resume", f"--np={ranks[1]}"))
    log = (killed / "log.lammps").read_text(encoding="utf-8")
    assert step > 0 and "read_restart" in log
    expected, found = values(whole), values(killed)
    assert found.keys() == expected.keys()
    for one, value in expected.items():
        if one.startswith("energy/") or (ranks[1] > 1 and one.startswith("walls/")):
            np.testing.assert_allclose(found[one], value, rtol=0, atol=_ROUNDING * np.abs(value).max(), err_msg=one)
        else:
            assert np.array_equal(value, found[one], equal_nan=value.dtype.kind == "f"), one
