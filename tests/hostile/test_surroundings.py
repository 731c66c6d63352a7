"""Processes without standard streams, terminals that close, processes that are killed, and
directories that are removed while a run is at work.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from granwave.workflows.run import leftovers
from tests.conftest import BIN, PLAIN
from tests.helpers.selection import with_every_test
from tests.hostile.rows import faults_in

TINY = ["fcc-small", "--set", "packing.size=[4,4,3]", "--set", "run.end_time=2e-5"]
TINY += ["--set", "run.frames=5", "--no-figures"]
LONG = ["fcc-impact", "--set", "packing.size=[30,30,12]", "--no-figures"]
SHARED = Path("/dev/shm")


def start(place: Path, *words: str) -> subprocess.Popen[str]:
    """Start a command whose temporary files are in the folder ``temporary``."""
    (place / "temporary").mkdir(exist_ok=True)
    environment = {**PLAIN, "TMPDIR": str(place / "temporary")}
    return subprocess.Popen(
        [BIN / "granwave", *words],
        cwd=place,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_until(holds: Callable[[], object]) -> None:
    end = time.monotonic() + 60
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.05)


def at_work(place: Path) -> bool:
    """True if LAMMPS has done some steps of the run ``out``."""
    energies = place / "out" / "dumps" / "energy.txt"
    return energies.exists() and energies.read_text().count("\n") > 4


WITHOUT = """
import json, sys
sys.stdout = sys.stderr = None
import granwave as gw
keys = {"packing.size": [4, 4, 3], "run.end_time": 2e-5, "run.frames": 5}
keys["figures.only"] = ["energies", "peak_force_principal"]
run = gw.run("fcc-small", keys, directory="run", figures=True)
ranks = gw.run("fcc-small", keys, directory="ranks", ranks=2)
from granwave.workflows.cli.main import main
status = main(["check", "fcc-small"])
open("outcome.json", "w").write(json.dumps([run["n_spheres"], ranks["n_ranks"], status]))
"""


@pytest.mark.parametrize("closed", [pytest.param(False, marks=pytest.mark.validation), True])
def test_without_standard_streams(tmp_path: Path, closed: bool) -> None:
    script = f"exec {sys.executable} -c '{WITHOUT}'" + " <&- >&- 2>&-" * closed
    subprocess.run(["/bin/sh", "-c", script], cwd=tmp_path, env=PLAIN, timeout=120, check=False)
    assert json.loads((tmp_path / "outcome.json").read_text()) == [48, 2, 0]


@pytest.mark.parametrize("ranks", with_every_test([1, 2], [2]))
def test_what_a_killed_run_leaves_goes_with_the_next(tmp_path: Path, ranks: int) -> None:
    process = start(tmp_path, "run", *LONG, "-o", "out", "--np", str(ranks))
    temporary = tmp_path / "temporary"
    wait_until(lambda: at_work(tmp_path))
    notes = list(temporary.glob("*.segments"))
    segments = [SHARED / name for note in notes for name in note.read_text().split()]
    assert len(notes) == ranks
    assert segments
    process.kill()
    process.communicate(timeout=30)
    wait_until(
        lambda: not subprocess.run(["pgrep", "-f", str(tmp_path)], capture_output=True).stdout
    )
    _, errors = start(tmp_path, "run", *TINY, "-o", "next").communicate(timeout=60)
    assert not list(temporary.iterdir()), errors
    assert not [path for path in segments if path.exists()]


def test_what_others_use_or_made_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(leftovers.tempfile, "tempdir", str(tmp_path))
    (tmp_path / "granwave-of-others").mkdir()
    (tmp_path / "granwave-0-1.segments").write_text("../../etc/passwd mpich_shm_none\n")
    (tmp_path / "granwave-link").symlink_to(tmp_path / "granwave-of-others")
    with leftovers.scratch_directory() as scratch:
        (scratch / "file").touch()
        leftovers.clear()
        assert (scratch / "file").exists()
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"granwave-of-others", "granwave-link"}


@pytest.mark.parametrize("ranks", with_every_test([1, 2], [2]))
def test_a_terminal_that_closes_stops_a_run_with_a_checkpoint(tmp_path: Path, ranks: int) -> None:
    process = start(tmp_path, "run", *LONG, "-o", "out", "--np", str(ranks))
    wait_until(lambda: at_work(tmp_path))
    process.send_signal(signal.SIGHUP)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "UCX" not in errors
    state = json.loads((tmp_path / "out" / "run.json").read_text())
    assert state["state"] == "interrupted"
    assert state["checkpoint"]


@pytest.mark.parametrize("name", ["out", "out/dumps", "out/dumps/energy.txt"])
def test_what_is_removed_during_a_run(tmp_path: Path, name: str) -> None:
    process = start(tmp_path, "run", *LONG, "-o", "out")
    wait_until(lambda: at_work(tmp_path))
    place = tmp_path / name
    place.unlink() if place.is_file() else shutil.rmtree(place)
    _, errors = process.communicate(timeout=60)
    (fault,) = faults_in(errors)
    assert process.returncode == 1
    assert f"{name}: was removed or moved during the run" in fault
    assert "make room" not in fault
    assert "Traceback" not in errors


def test_a_value_of_two_dashes(tmp_path: Path) -> None:
    process = start(tmp_path, "run", *TINY, "-o=--")
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert (tmp_path / "--" / "summary.json").is_file()
    assert not os.path.exists(tmp_path / "fcc-small")
