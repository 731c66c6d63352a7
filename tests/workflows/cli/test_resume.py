"""Runs that are killed or stopped and resumed, from the point of view of a user: their results
equal those of an uninterrupted run.

The sums of the energy record agree to rounding: a restart changes the order of their terms.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import granwave as gw
from granwave.workflows.run import driver
from granwave.workflows.run.directory import RunDirectory
from tests.conftest import PLAIN
from tests.helpers.made_up.run_files import summary, without_clock
from tests.helpers.programs.processes import wait_for
from tests.helpers.selection import with_every_test

pytestmark = pytest.mark.xdist_group("resume")  # its fixtures are made once

LONG = ["fcc-small", "packing.size=[14,14,8]", "run.end_time=2e-4", "run.frames=5"]
LONG += ["run.energy_tolerance=3e-8"]  # in many steps
#: Cases with their settings, and the ranks before and after the kill: any number reads what others wrote.
KILLED = {
    "one rank": (LONG, 1, 1),
    "two ranks, then one": (LONG, 2, 1),
    # strikes cylinders with friction, loss and two [[line]]s
    "plate": (["lateral-square", "run.end_time=3e-3"], 1, 1),
    "driven row": (["driven-row", "run.end_time=8e-3", 'line=[{name = "all", index = "all"}]'], 1, 1),
    "moving floor": ([
        "fcc-small", "packing.size=[12,12,8]", "run.end_time=4e-4", "run.energy_tolerance=3e-8", "contact.friction=0.2",
        "boundary.bottom={plate = {mass = 0.1, stiffness = 1e7, damping = 5.0}}", 'line=[{name = "down"}]',
    ], 1, 1),
    "initial normals": ([
        "fcc-small", "packing.size=[12,12,8]", "run.end_time=4e-4", "run.energy_tolerance=3e-8",
        "contact.normals=initial",
    ], 2, 1),
    "in parts": (["fcc-small", "packing.size=[12,12,8]", "run.end_time=2e-4", "output.parts=true"], 3, 2),
}  # fmt: skip
ROUNDING = 1e-14  # of sums, over their largest value


def start(directory, *arguments, case=LONG):
    """Start a run of a case and settings in a separate process."""
    words = [
        "run",
        case[0],
        *(f"--set={one}" for one in case[1:]),
        "-o",
        str(directory),
        "--no-figures",
        *arguments,
    ]
    command = [sys.executable, "-m", "granwave.workflows", *words]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=PLAIN
    )


def finish(process: subprocess.Popen[str]) -> None:
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors


def ledger_of(directory: Path, size: int) -> bool:
    """True if the energy record has more than these bytes."""
    path = directory / "dumps" / "energy.txt"
    return path.exists() and path.stat().st_size > size


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    directory = tmp_path_factory.mktemp("whole") / "run"
    finish(start(directory))
    return directory


def values(directory: Path) -> dict[str, np.ndarray]:
    """Data sets of result.h5 by name."""
    found = {}
    with h5py.File(directory / "result.h5") as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None
            )
        )
    return found


def compare(whole, resumed):
    one = without_clock(whole)
    two = without_clock(resumed)
    for key, value in one.items():
        if key == "energy_balance_error":
            assert two[key] == pytest.approx(value, rel=1e-3)
        elif isinstance(value, float):
            assert two[key] == pytest.approx(value, rel=1e-9, abs=1e-14), key
        else:
            assert two[key] == value, key


@pytest.mark.parametrize(
    "name",
    with_every_test(KILLED, ["one rank"]),
)
def test_a_killed_run_ends_with_the_same_bits(request, tmp_path: Path, name: str) -> None:
    case, before, after = KILLED[name]
    whole = tmp_path / "whole"
    killed = tmp_path / "killed"
    if case is LONG:
        whole = request.getfixturevalue("uninterrupted")
    else:
        finish(start(whole, case=case))
    half = (whole / "dumps" / "energy.txt").stat().st_size // 2
    process = start(killed, "--checkpoint", "0.05", f"--np={before}", case=case)
    wait_for(
        lambda: ledger_of(killed, half) and list(killed.glob("checkpoint-*.restart")),
        beside=process,
    )
    process.kill()  # its ranks end with it
    process.communicate(timeout=60)
    assert not (killed / "summary.json").exists()
    assert json.loads((killed / "run.json").read_text())["checkpoint"]["step"] > 0
    finish(start(killed, "--resume", f"--np={after}", case=case))
    assert "read_restart" in (killed / "log.lammps").read_text() and not list(
        killed.glob("checkpoint-*")
    )
    expected = values(whole)
    found = values(killed)
    assert found.keys() == expected.keys()
    for one, value in expected.items():
        if one.startswith("energy/") or (max(before, after) > 1 and one.startswith("walls/")):
            np.testing.assert_allclose(
                found[one], value, rtol=0, atol=ROUNDING * np.abs(value).max(), err_msg=one
            )
        else:
            assert np.array_equal(value, found[one], equal_nan=value.dtype.kind == "f"), one
    compare(whole, killed)


def test_ctrl_c_leaves_what_there_is_and_can_go_on(uninterrupted, tmp_path):
    directory = tmp_path / "stopped"
    process = start(directory)
    wait_for(lambda: ledger_of(directory, 5000), beside=process)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130 and "--resume" in errors, errors
    assert summary(directory)["end_reason"] == "interrupted" and (directory / "result.h5").exists()
    finish(start(directory, "--resume"))
    compare(uninterrupted, directory)


@pytest.mark.validation
def test_automatic_end_is_the_same_after_a_stop(tmp_path):
    """A block interrupted by a checkpoint is counted from its own start."""
    case = ["fcc-small", "packing.size=[12,12,6]", "run.end_time=auto", "run.frames=3"]
    finish(start(tmp_path / "whole", case=case))
    process = start(tmp_path / "cut", case=case)
    wait_for(lambda: ledger_of(tmp_path / "cut", 30000), beside=process)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=120)
    assert process.returncode == 130
    finish(start(tmp_path / "cut", "--resume", case=case))
    compare(tmp_path / "whole", tmp_path / "cut")


@pytest.mark.parametrize("ranks", [1, 2])
def test_ctrl_c_ends_a_static_stage_that_does_not(tmp_path, ranks):
    """If indentations are forgotten immediately, the packing does not reach equilibrium for many
    minutes.
    """
    process = start(
        tmp_path / "run", f"--np={ranks}", case=["preconditioned-fcc", "boundary.forget_gap=1e-9"]
    )
    log = tmp_path / "run" / "log.lammps"
    wait_for(
        lambda: log.exists() and "min_style" in log.read_text(errors="replace"), beside=process
    )
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130, errors
    assert json.loads((tmp_path / "run" / "run.json").read_text())["state"] == "interrupted"


LOST = """
import sys, time, weakref
from granwave.workflows.cli import main

class Thing: pass

def interrupted(_):
    raise KeyboardInterrupt  # as if a signal came while an object is cleared up

def wait(_):
    thing = Thing()
    weakref.ref(thing, interrupted)
    kept = weakref.ref(thing, interrupted)
    del thing
    time.sleep(20)

main._set_up_logging = lambda: None
class Options:
    class command: run = staticmethod(wait)
main.make_parser = lambda *_: type("P", (), {"parse_args": lambda self, words: Options()})()
sys.exit(main.main([]))
"""


def test_ctrl_c_while_python_clears_up_is_not_lost():
    """Errors in callbacks of weak references are printed and dropped."""
    done = subprocess.run(
        [sys.executable, "-c", LOST], capture_output=True, text=True, timeout=15, env=PLAIN
    )
    assert (done.returncode, done.stderr) == (130, "granwave: stopped\n")


def test_the_record_shows_the_time_reached_while_a_run_advances(tmp_path, monkeypatch):
    monkeypatch.setattr(driver, "_NOTED", -1.0)
    monkeypatch.setattr(driver, "_PIECE", 1e-3)
    ends = []
    write = RunDirectory.write_record

    def noting(directory, content):
        write(directory, content)
        stored = json.loads((directory.path / "run.json").read_text())
        if stored["state"] == "running":
            ends.append(stored["end_time_s"])
            assert (
                stored["wall_time_s"] == 0.0
            )  # counted up to checkpoints, of which there are none

    monkeypatch.setattr(RunDirectory, "write_record", noting)
    changes = {"packing.size": [6, 6, 4], "run.end_time": 1e-4}
    run = gw.run("fcc-small", changes, directory=tmp_path / "run", figures=False)
    assert len(ends) > 5
    assert np.all(np.diff(ends) > 0) and 0 < ends[-1] < run.summary["end_time_s"]
