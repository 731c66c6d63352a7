"""Pipes in place of the files of a run: each command refuses them, and none waits for a writer."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.files import is_special, regular
from granwave.workflows.cli.main import main
from tests.hostile.rows import faults_in

CASE = ["fcc-small", "--set", "packing.size=[4,4,3]", "--set", "run.end_time=2e-5"]
CASE += ["--set", "run.frames=5"]
COMMANDS = {
    "report": ["report", "out", "-o", "page.html"],
    "export": ["export", "out", "--to", "csv"],
    "resume": ["run", *CASE, "-o", "out", "--no-figures", "--resume"],
    "force": ["run", *CASE, "-o", "out", "--no-figures", "--force"],
    "analyse": ["analyse", "out", "--no-figures"],
}
NAMES = ("summary.json", ".granwave", "case.toml", "run.json", "result.h5")
MORE = ("data.granwave", "dumps/spheres.bin")
LONGEST = 30  # s


def too_long(*_: object) -> None:
    raise TimeoutError(f"longer than {LONGEST} s, perhaps for the writer of a pipe")


@pytest.fixture
def at_once() -> Iterator[None]:
    """Fail a test that waits for the writer of a pipe."""
    before = signal.signal(signal.SIGALRM, too_long)
    signal.alarm(LONGEST)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Directory of a finished run."""
    place = tmp_path_factory.mktemp("finished")
    assert main(["run", *CASE, "-o", str(place / "out"), "--no-figures"]) == 0
    return place / "out"


PAIRS = [(name, command) for name in NAMES for command in ("report", "export", "resume")]
PAIRS += [(".granwave", "force"), ("case.toml", "analyse")]
PAIRS += [(name, command) for name in MORE for command in ("resume", "analyse")]


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(("name", "command"), PAIRS)
def test_pipe(finished: Path, tmp_path: Path, granwave: Any, name: str, command: str) -> None:
    shutil.copytree(finished, tmp_path / "out")
    pipe = tmp_path / "out" / name
    pipe.unlink(missing_ok=True)
    os.mkfifo(pipe)
    done = granwave(*COMMANDS[command], cwd=tmp_path)
    faults = faults_in(done.stderr)
    assert done.returncode == 2
    assert len(faults) == 1
    assert f"out/{name}: is a pipe or a device, expected a file; remove it" in faults[0]
    assert is_special(pipe)


def test_links_to_devices_are_refused_and_links_to_files_are_not(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "link").symlink_to("file")
    (tmp_path / "zeros").symlink_to("/dev/zero")
    assert regular(tmp_path / "link") == tmp_path / "link"
    assert regular(tmp_path / "missing") == tmp_path / "missing"
    with pytest.raises(OSError, match="is a pipe or a device"):
        regular(tmp_path / "zeros")
