"""Runs that are killed or stopped and resumed, from the point of view of a user."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time

import pytest

from tests.conftest import PLAIN
from tests.helpers.processes import wait_for
from tests.helpers.run_files import summary, without_clock

LONG = ["--set", "packing.size=[14,14,8]", "--set", "run.end_time=4e-4", "--set", "run.frames=5"]
LONG += ["--set", "run.energy_tolerance=3e-8"]  # in many steps


def start(directory, *arguments, sets=LONG, name="fcc-small"):
    words = ["run", name, "-o", str(directory), *sets, "--no-figures", *arguments]
    command = [sys.executable, "-m", "granwave.workflows", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=PLAIN)


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    directory = tmp_path_factory.mktemp("whole") / "run"
    process = start(directory)
    assert process.wait(300) == 0
    return directory


def compare(whole, resumed):
    one, two = without_clock(whole), without_clock(resumed)
    for key, value in one.items():
        if key == "energy_balance_error":
            assert two[key] == pytest.approx(value, rel=1e-3)
        elif isinstance(value, float):
            assert two[key] == pytest.approx(value, rel=1e-9, abs=1e-14), key
        else:
            assert two[key] == value, key


@pytest.mark.parametrize("ranks", [1, 2])
def test_killed_run_goes_on_from_its_checkpoint(uninterrupted, granwave, tmp_path, ranks):
    """On one processor, whether it was begun on one or two."""
    directory = tmp_path / "killed"
    process = start(directory, "--checkpoint", "0.2", "--np", str(ranks))
    snapshots = directory / "dumps" / "spheres.bin"
    wait_for(lambda: list(directory.glob("checkpoint-*.restart")) and snapshots.stat().st_size > 2e5, beside=process)
    time.sleep(0.3)
    if ranks == 1:
        process.send_signal(signal.SIGKILL)
    else:  # the ranks themselves are killed, as in a node failure
        subprocess.run(["pkill", "-KILL", "-f", f"granwave.workflows run fcc-small -o {directory}"], check=False)
    process.wait(60)
    assert not (directory / "summary.json").exists()
    done = granwave("run", "fcc-small", "-o", directory, *LONG, "--no-figures", "--resume")
    assert done.returncode == 0, done.stderr
    compare(uninterrupted, directory)
    assert not list(directory.glob("checkpoint-*"))


def test_ctrl_c_leaves_what_there_is_and_can_go_on(uninterrupted, granwave, tmp_path):
    directory = tmp_path / "stopped"
    process = start(directory)
    ledger = directory / "dumps" / "energy.txt"
    wait_for(lambda: ledger.exists() and ledger.stat().st_size > 5000, beside=process)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert "--resume" in errors
    assert summary(directory)["end_reason"] == "interrupted" and (directory / "result.h5").exists()
    done = granwave("run", "fcc-small", "-o", directory, *LONG, "--no-figures", "--resume")
    assert done.returncode == 0, done.stderr
    compare(uninterrupted, directory)


def test_automatic_end_is_the_same_after_a_stop(granwave, tmp_path):
    """A block interrupted by a checkpoint is counted from its own start."""
    sets = ["--set", "packing.size=[12,12,6]", "--set", "run.end_time=auto", "--set", "run.frames=3"]
    whole = granwave("run", "fcc-small", "-o", tmp_path / "whole", *sets, "--no-figures")
    assert whole.returncode == 0, whole.stderr
    process = start(tmp_path / "cut", sets=sets)
    ledger = tmp_path / "cut" / "dumps" / "energy.txt"
    wait_for(lambda: ledger.exists() and ledger.stat().st_size > 30000, beside=process)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=120)
    assert process.returncode == 130
    assert granwave("run", "fcc-small", "-o", tmp_path / "cut", *sets, "--no-figures", "--resume").returncode == 0
    compare(tmp_path / "whole", tmp_path / "cut")


@pytest.mark.parametrize("ranks", [1, 2])
def test_ctrl_c_ends_a_static_stage_that_does_not(tmp_path, ranks):
    """Dents that are forgotten at once keep the packing from balance for many minutes."""
    sets = ["--set", "boundary.forget_gap=1e-9", "--np", str(ranks)]
    process = start(tmp_path / "run", *sets, name="preconditioned-fcc", sets=[])
    log = tmp_path / "run" / "log.lammps"
    wait_for(lambda: log.exists() and "min_style" in log.read_text(errors="replace"), beside=process)
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
main.make_parser = lambda: type("P", (), {"parse_args": lambda self, words: Options()})()
sys.exit(main.main([]))
"""


def test_ctrl_c_while_python_clears_up_is_not_lost():
    """Errors in callbacks of weak references are printed and dropped."""
    done = subprocess.run([sys.executable, "-c", LOST], capture_output=True, text=True, timeout=15, env=PLAIN)
    assert (done.returncode, done.stderr) == (130, "granwave: stopped\n")
