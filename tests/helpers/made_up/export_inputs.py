"""Runs to export, and the comparison of exported values."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis import write_result
from granwave.lammps_inputs import Case, write_deck
from tests.conftest import BIN, PLAIN
from tests.helpers.made_up import synthetic


def write_walled_run(directory: Path) -> Path:
    """Synthetic run with one contact with the wall."""
    synthetic.write_run(directory, synthetic.make_case())
    row = np.array([[144, 0, 0, 1e-5, 50.0, 2e-4, 1e-5, 2e-5, 1.5e-5]])
    synthetic.write_custom(
        directory / "dumps" / "wall_bottom.dump", synthetic.WALL_COLUMNS, row, synthetic.STEPS
    )
    write_result(directory)
    return directory


def write_periodic_run(directory: Path) -> Path:
    """Run of LAMMPS with some contacts across periodic sides."""
    case = synthetic.make_case(
        size=(4, 4, 4),
        boundary={"sides": "periodic"},
        run={"end_time": 4e-5, "frames": 3},
        output={"probes": [{"sphere": 12}, {"contact": [7, 23]}]},
    )
    return _run(case, directory)


def write_chain_run(directory: Path) -> Path:
    """LAMMPS run of a chain in front of a bar, with output over time."""
    bar = {"length": 0.1, "area": 1e-4, "elements": 20, "material": "steel"}
    return _run(
        synthetic.make_case("chain", 6, run={"end_time": 1e-4, "frames": 2}, output={}, bar=bar),
        directory,
    )


def _run(case: Case, directory: Path) -> Path:
    script = write_deck(case, directory).script
    command = [str(BIN / "lmp"), "-in", script.name, "-screen", "none"]
    done = subprocess.run(
        command, cwd=script.parent, capture_output=True, text=True, timeout=60, env=PLAIN
    )
    assert done.returncode == 0, done.stdout + done.stderr
    write_result(directory)
    return directory


def equal(found: ArrayLike, expected: ArrayLike) -> bool:
    """True if arrays are bitwise identical."""
    return np.array_equal(found, expected, equal_nan=np.asarray(expected).dtype.kind == "f")
